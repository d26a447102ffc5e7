"""The command: what it writes, where it speaks, and one line for whatever is wrong."""

import io
import json
import os
import stat
import subprocess
import sys

import numpy as np
import pytest

from attitude import Ephemeris, Scene, __version__, compiled
from attitude.cli import main
from attitude.formats import csv
from attitude.scene import builtin_names

TOUTATIS = Scene.builtin("toutatis")


@pytest.fixture
def written(tmp_path):
    """What the library itself writes of a scene in a format."""

    def write(scene, format):
        scene.run().write(tmp_path / f"expected.{format}")
        return (tmp_path / f"expected.{format}").read_bytes()

    return write


@pytest.fixture
def answer(capfdbinary, monkeypatch):
    """Exit code, standard output and standard error of the command; a terminal has a person before it."""

    def run(*arguments, terminal=False):
        with monkeypatch.context() as patch:
            patch.setattr(sys.stderr, "isatty", lambda: terminal)
            code = main([str(argument) for argument in arguments])
        out, err = capfdbinary.readouterr()
        return code, out, err.decode()

    return run


def given(text, monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))


# -- run ----------------------------------------------------------------------------------------


def test_built_in_scene_is_run_by_its_name(answer, written):
    assert answer("run", "toutatis") == (0, written(TOUTATIS, "csv"), "")


def test_scene_is_run_by_its_path(answer, written, tmp_path):
    path = tmp_path / "my scene.json"
    path.write_text(TOUTATIS.to_json())
    assert answer("run", path) == (0, written(TOUTATIS, "csv"), "")


def test_file_wins_over_a_built_in_scene_of_that_name(answer, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "toutatis").write_text(Scene.builtin("halley").to_json())
    code, out, _ = answer("run", "toutatis")
    assert code == 0
    assert b"1P/Halley" in out


def test_scene_is_run_from_standard_input(answer, written, monkeypatch):
    given(TOUTATIS.to_json(), monkeypatch)
    assert answer("run", "-") == (0, written(TOUTATIS, "csv"), "")


@pytest.mark.parametrize("format", ["ecsv", "csv", "json"])
def test_every_format_goes_to_standard_output(format, answer, written):
    expected = (0, written(TOUTATIS, format), "")
    assert answer("run", "toutatis", "-f", format) == expected
    assert answer("run", "toutatis", "-o", "-", "--format", format.upper()) == expected


@pytest.mark.parametrize("format", ["ecsv", "csv", "json"])
def test_file_is_written_in_the_format_of_its_ending(format, answer, written, tmp_path):
    path = tmp_path / f"out.{format}"
    assert answer("run", "toutatis", "-o", path) == (0, b"", "")
    assert path.read_bytes() == written(TOUTATIS, format)


def test_format_named_wins_over_the_ending(answer, written, tmp_path):
    path = tmp_path / "out.csv"
    assert answer("run", "toutatis", "--output", path, "-f", "json") == (0, b"", "")
    assert path.read_bytes() == written(TOUTATIS, "json")


def test_named_pipe_is_written_to_and_stays_a_pipe(answer, written, tmp_path):
    path = tmp_path / "pipe.csv"
    os.mkfifo(path)
    # opened without waiting for a writer; the whole of it is less than a pipe holds
    with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK), "rb") as reader:
        assert answer("run", "toutatis", "-o", path) == (0, b"", "")
        assert reader.read() == written(TOUTATIS, "csv")
    assert stat.S_ISFIFO(path.stat().st_mode)


# -- remarks ------------------------------------------------------------------------------------


def test_person_at_a_terminal_is_told_of_a_compilation(answer, tmp_path, monkeypatch):
    """As on a new machine: no code is kept, until the compilers have run."""
    kept = compiled._kept
    monkeypatch.setattr(compiled, "sample", compiled.Kernel("cayley_klein", "sample"))
    monkeypatch.setattr(compiled, "_kept", lambda name: None)
    monkeypatch.setattr(compiled, "_run_compilers", lambda *_: monkeypatch.setattr(compiled, "_kept", kept))
    for _ in range(2):
        code, _, err = answer("run", "toutatis", "-o", tmp_path / "out.csv", terminal=True)
        assert code == 0
        told = [line for line in err.splitlines() if "compiling" in line]
        assert told == ["attitude: compiling 15 kernels for this processor, once: about ten seconds"]
        monkeypatch.setattr(compiled, "sample", compiled.Kernel("cayley_klein", "sample"))
        monkeypatch.setattr(compiled, "_kept", lambda name: None)


def test_person_at_a_terminal_is_told_what_is_run(answer, tmp_path):
    code, out, err = answer("run", "toutatis", "-o", tmp_path / "out.csv", terminal=True)
    assert (code, out) == (0, b"")
    assert "attitude: 4179 Toutatis: 161 samples\n" in err
    assert "attitude: long axis regime, polhode period 463841.0" in err


def test_progress_of_a_long_run_is_told_by_tenths(answer, monkeypatch, tmp_path):
    monkeypatch.setattr(csv, "BLOCK", 4)
    _, _, err = answer("run", "toutatis", "-o", tmp_path / "out.csv", terminal=True)
    told = [line for line in err.splitlines() if "written" in line]
    assert told == [f"attitude: written {done} %" for done in range(10, 101, 10)]


def test_short_run_tells_no_progress(answer, tmp_path):
    _, _, err = answer("run", "toutatis", "-o", tmp_path / "out.csv", terminal=True)
    assert "written" not in err


def test_quiet_run_says_nothing(answer, tmp_path):
    assert answer("run", "toutatis", "-q", "-o", tmp_path / "out.csv", terminal=True) == (0, b"", "")


# -- what is wrong ------------------------------------------------------------------------------

NAMES = ", ".join(builtin_names())
KNOWN = "this version knows ecsv, csv, json"

BAD = {
    "unknown scene": (["run", "pluto"], f"SCENE: a file, or a built-in scene ({NAMES}); got 'pluto'"),
    "scene of two lines": (["run", "a\nb"], "SCENE: a file, or a built-in scene"),
    "no such file": (["run", "pluto.json"], "pluto.json: no such file"),
    "no such folder": (["run", "missing/pluto"], "missing/pluto: no such file"),
    "no such file of two lines": (["run", "a\nb.json"], ""),
    "folder": (["run", "folder"], "folder: cannot be read (Is a directory)"),
    "name without end": (["run", "x" * 300], ""),
    "not JSON": (["run", "cut.json"], "cut.json, line 1: not JSON"),
    "fault in the document": (["run", "fault.json"], "body.moments[2]: no principal moment greater than"),
    "overflow in the document": (["run", "huge.json"], "body.moments[0]: "),
    "more samples than memory": (["run", "count.json"], "times"),
    "unknown format": (["run", "toutatis", "-f", "xml"], f"-: format 'xml'; {KNOWN}"),
    "unknown ending": (["run", "toutatis", "-o", "out.xml"], f"out.xml: format 'xml'; {KNOWN}"),
    "no ending": (["run", "toutatis", "-o", "out"], f"out: no format and no file ending; {KNOWN}"),
    "no folder to write to": (
        ["run", "toutatis", "-o", "missing/out.csv"],
        "missing/out.csv: cannot be written",
    ),
    "folder to write to": (["run", "toutatis", "-o", "folder", "-f", "csv"], "folder: cannot be written"),
    "unknown method": (
        ["cost", "toutatis", "--method", "ours", "--method", "rk5"],
        "method: one of ours, plain, published, rk4, dop853, lsoda, heyoka, orekit; got 'rk5'",
    ),
    "unknown scene of cost": (
        ["cost", "pluto"],
        f"SCENE: a file, or a built-in scene ({NAMES}); got 'pluto'",
    ),
    "no folder for the JSON": (["cost", "toutatis", "--json", "missing/x"], "missing/x: cannot be written"),
    "folder for the CSV": (["cost", "toutatis", "--csv", "folder"], "folder: cannot be written (Is a dir"),
    "no folder for the picture": (
        ["cost", "toutatis", "--plot", "missing/x.svg"],
        "missing/x.svg: cannot be",
    ),
    "picture of another kind": (
        ["cost", "toutatis", "--plot", "x.pdf"],
        "x.pdf: a picture's ending is svg or png",
    ),
    "two on standard output": (
        ["cost", "toutatis", "--json", "-", "--csv", "-"],
        "--json/--csv/--markdown: one of them",
    ),
    "budget that is none": (["cost", "toutatis", "--budget", "nan"], "budget: a number of seconds greater"),
    "budget too small": (["cost", "toutatis", "--method", "ours", "--budget", "1e-9"], "budget: at least "),
    "one sample": (["cost", "toutatis", "--samples", "1"], "samples: a whole number from 2 to 10000000"),
    "negative seed": (["cost", "toutatis", "--seed", "-1"], "seed: a whole number, not negative; got -1"),
    "unknown built-in scene": (["scenes", "pluto"], f"scene: a built-in scene, one of {NAMES}; got 'pluto'"),
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Here: some documents that are wrong."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    document = TOUTATIS.document()
    faults = {
        "fault": {"body": {"moments": [1, 1, 3], "unit": "kg m2"}},
        "huge": {"body": {"moments": [1e300, 1e300, 1e300], "unit": "1e300 kg m2"}},
        "count": {"times": {"start": 0, "stop": 1, "count": 2**60, "unit": "s"}},
    }
    for name, fault in faults.items():
        (tmp_path / f"{name}.json").write_text(json.dumps({**document, **fault}))
    (tmp_path / "cut.json").write_text(json.dumps(document)[:-9])
    return tmp_path


@pytest.mark.filterwarnings("default")  # as a user has it: a warning would be a second line
@pytest.mark.parametrize(("arguments", "message"), BAD.values(), ids=BAD)
def test_bad_input_is_one_line_and_exit_code_2(arguments, message, answer, folder, recwarn):
    before = sorted(folder.iterdir())
    code, out, err = answer(*arguments)
    assert (code, out) == (2, b"")
    assert err.startswith(f"attitude: {message}")
    assert err.count("\n") == 1
    assert err.endswith("\n")
    assert [str(warning.message) for warning in recwarn] == []
    assert sorted(folder.iterdir()) == before


def test_bad_standard_input_is_called_so(answer, monkeypatch):
    given("{", monkeypatch)
    code, out, err = answer("run", "-")
    assert (code, out) == (2, b"")
    assert err.startswith("attitude: standard input, line 1: not JSON")


@pytest.mark.parametrize(
    "arguments", [[], ["fly"], ["run"], ["run", "toutatis", "--fast"], ["serve", "--port", "x"]], ids=" ".join
)
def test_wrong_usage_is_one_line_and_exit_code_2(arguments, capfd):
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    out, err = capfd.readouterr()
    assert (caught.value.code, out) == (2, "")
    assert err.startswith("attitude: ")
    assert err.count("\n") == 1


def test_interruption_by_the_user_is_quiet_and_leaves_no_file(answer, monkeypatch, tmp_path):
    def interrupted(table, names):
        raise KeyboardInterrupt

    monkeypatch.setattr(csv, "_rows", interrupted)
    assert answer("run", "toutatis", "-o", tmp_path / "out.csv") == (130, b"", "")
    assert list(tmp_path.iterdir()) == []


# -- cost ---------------------------------------------------------------------------------------

QUICK = ("cost", "toutatis", "--method", "Ours", "--method", "published", "--samples", 200, "--budget", 100)


def test_cost_is_a_table(answer):
    code, out, err = answer(*QUICK)
    assert (code, err) == (0, "")
    lines = out.decode().splitlines()
    assert lines[0].startswith("4179 Toutatis: long axis regime")
    assert sum(line.startswith("closed form  ") for line in lines) == 5  # four horizons, and growth


def test_cost_goes_to_files_beside_the_table(answer, tmp_path):
    json_file, csv_file, picture = (tmp_path / f"cost.{ending}" for ending in ("json", "csv", "svg"))
    code, out, _ = answer(*QUICK, "--json", json_file, "--csv", csv_file, "--plot", picture, "--seed", 3)
    assert code == 0
    assert out.startswith(b"4179 Toutatis")
    document = json.loads(json_file.read_text())
    assert (document["samples"], document["budget_s"], document["seed"]) == (200, 100.0, 3)
    rows = [line for line in csv_file.read_text().splitlines() if not line.startswith("#")]
    assert len(rows) == 1 + len(document["cells"])
    assert b"4179 Toutatis: what accuracy costs in time" in picture.read_bytes()


STARTS = {
    "json": b'{\n "kind": "attitude-cost/1"',
    "csv": b"# 4179 Toutatis",
    "markdown": b"| error in rad, ns",
}


@pytest.mark.parametrize("format", STARTS)
def test_cost_on_standard_output_stands_for_the_table(format, answer):
    code, out, _ = answer(*QUICK, f"--{format}", "-")
    assert code == 0
    assert out.startswith(STARTS[format])
    assert b"growth, as horizon" not in out


def test_cost_for_a_document_has_a_row_a_family(answer):
    _, out, _ = answer(*QUICK, "--markdown", "-")
    title, rule, *rows = out.decode().splitlines()
    assert {line.count("|") for line in (title, rule, *rows)} == {6}
    assert [row.split("|")[1].strip() for row in rows] == ["closed form", "van Zon & Schofield (SciPy)"]


def test_hard_ladders_as_a_table_and_for_a_document(answer, tmp_path):
    code, out, err = answer("cost", "--hard", "--method", "ours", "--markdown", tmp_path / "hard.md")
    assert (code, err) == (0, "")
    rows = (tmp_path / "hard.md").read_text().splitlines()[2:]
    assert len(rows) > 60
    assert all(0.0 < float(row.split("|")[3]) <= 4e-15 for row in rows)
    assert "huge times" in out.decode()


def test_cost_tells_a_person_what_is_under_way(answer):
    _, _, err = answer(*QUICK, terminal=True)
    assert "attitude: truth to fifty digits\n" in err
    assert answer(*QUICK, "--quiet", terminal=True)[2] == ""


@pytest.mark.parametrize(
    ("missing", "option", "message"),
    [
        ("mpmath", "--quiet", "the cost needs mpmath for its truth: pip install 'attitude[cost]'"),
        ("matplotlib", "--plot=x.svg", "the picture needs matplotlib: pip install 'attitude[plot]'"),
    ],
)
def test_cost_without_its_packages_says_what_to_install(missing, option, message, answer, monkeypatch):
    for name in [name for name in sys.modules if name.startswith(("attitude.oracle", f"{missing}."))]:
        monkeypatch.delitem(sys.modules, name)
    import attitude

    monkeypatch.delattr(attitude, "oracle", raising=False)
    monkeypatch.setitem(sys.modules, missing, None)
    assert answer(*QUICK, option) == (2, b"", f"attitude: {message}\n")


# -- the other commands -------------------------------------------------------------------------


def test_scenes_are_listed_with_what_they_are(answer):
    code, out, err = answer("scenes")
    assert (code, err) == (0, "")
    lines = out.decode().splitlines()
    assert [line.split()[0] for line in lines] == builtin_names()
    for line, name in zip(lines, builtin_names(), strict=True):
        assert Scene.builtin(name).name in line


@pytest.mark.parametrize("name", builtin_names())
def test_scene_that_is_printed_is_a_document_to_begin_with(name, answer, monkeypatch):
    code, out, _ = answer("scenes", name)
    assert code == 0
    assert Scene.from_json(out) == Scene.builtin(name)


def test_version_is_the_librarys(capfd):
    with pytest.raises(SystemExit) as caught:
        main(["--version"])
    assert caught.value.code == 0
    assert capfd.readouterr().out == f"attitude {__version__}\n"


@pytest.mark.parametrize("missing", ["fastapi", "uvicorn"])
def test_service_without_its_packages_says_what_to_install(missing, answer, monkeypatch):
    for name in [name for name in sys.modules if name.split(".")[0] in ("service", missing)]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, missing, None)
    message = f"attitude: the service needs {missing}: pip install 'attitude[service]'\n"
    assert answer("serve") == (2, b"", message)


def test_service_is_served_where_it_is_told(answer, monkeypatch):
    app = pytest.importorskip("service.app")
    asked = []
    monkeypatch.setattr(app, "serve", lambda *where: asked.append(where))
    assert answer("serve", "--host", "::1", "--port", "8080") == (0, b"", "")
    assert answer("serve") == (0, b"", "")
    assert asked == [("::1", 8080), (None, None)]


# -- in a process of its own --------------------------------------------------------------------

COMMAND = [sys.executable, "-m", "attitude.cli"]


def test_command_runs_as_a_process(tmp_path):
    path = tmp_path / "out.json"
    process = subprocess.run(
        [*COMMAND, "run", "-", "-o", path], input=TOUTATIS.to_json().encode(), capture_output=True
    )
    assert (process.returncode, process.stdout, process.stderr) == (0, b"", b"")
    read = Ephemeris.read(path)
    assert np.array_equal(read.quaternion("wxyz"), TOUTATIS.run().quaternion("wxyz"))


def test_reader_that_has_seen_enough_is_no_error():
    with subprocess.Popen(
        [*COMMAND, "run", "spinner"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        # the whole is more than a pipe holds, so the command is still writing when its reader leaves
        assert process.stdout.read(20).startswith(b"# q rotates body")
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 0
