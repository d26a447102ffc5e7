"""The command: what it writes, where it speaks, and one line for whatever is wrong."""

import argparse
import io
import json
import os
import re
import shutil
import stat
import subprocess
import sys

import numpy as np
import pytest

from attitude import Ephemeris, Scene, __version__
from attitude.cli import console, main
from attitude.documents import fields
from attitude.formats import FORMATS, schema
from attitude.rigid_body.constants_of_motion import Batch
from attitude.runtime import compiled, kernel_cache
from attitude.samples import chunks
from attitude.scene.builtin_scenes import builtin_names
from tests.tables import table

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


def put_on_standard_input(text, monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))


# -- run ----------------------------------------------------------------------------------------


def test_built_in_scene_is_run_by_its_name(answer, written):
    assert answer("run", "toutatis") == (0, written(TOUTATIS, "csv"), "")


@pytest.mark.parametrize("name", ["toutatis", "toutatis.json"])
def test_document_is_parsed_once(name, answer, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "toutatis.json").write_text(TOUTATIS.to_json())
    parse, calls = fields.parse_json, []
    monkeypatch.setattr(fields, "parse_json", lambda *text: calls.append(text) or parse(*text))
    monkeypatch.setattr(Scene, "to_json", None)  # nor is it printed
    assert answer("run", name)[0] == 0
    assert len(calls) == 1


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
    put_on_standard_input(TOUTATIS.to_json(), monkeypatch)
    assert answer("run", "-") == (0, written(TOUTATIS, "csv"), "")


@pytest.mark.parametrize("format", ["ecsv", "csv", "json"])
def test_every_format_goes_to_standard_output_and_to_a_file_of_its_ending(format, answer, written, tmp_path):
    content, path = written(TOUTATIS, format), tmp_path / f"out.{format}"
    assert answer("run", "toutatis", "-f", format) == (0, content, "")
    assert answer("run", "toutatis", "-o", "-", "--format", format.upper()) == (0, content, "")
    assert answer("run", "toutatis", "-o", path) == (0, b"", "")
    assert path.read_bytes() == content


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


def test_compilation_is_announced_on_a_terminal(answer, tmp_path, monkeypatch):
    """As on a new machine: no code is kept, until the compilers have run."""
    answer("run", "toutatis", "-o", tmp_path / "out.csv")  # whatever is missing is compiled
    is_kept = kernel_cache.is_kept
    monkeypatch.setattr(
        kernel_cache, "run_compilers", lambda *_: monkeypatch.setattr(kernel_cache, "is_kept", is_kept)
    )
    for _ in range(2):
        monkeypatch.setattr(Batch, "sample_kernel", compiled.Kernel("cayley_klein.sample"))
        monkeypatch.setattr(kernel_cache, "is_kept", lambda signature: False)
        code, _, err = answer("run", "toutatis", "-o", tmp_path / "out.csv", terminal=True)
        assert code == 0
        lines = [line for line in err.splitlines() if "compiling" in line]
        assert lines == ["attitude: compiling 15 kernels for this processor, once: about ten seconds"]


def test_scene_and_regime_are_reported_on_a_terminal(answer, tmp_path):
    code, out, err = answer("run", "toutatis", "-o", tmp_path / "out.csv", terminal=True)
    assert (code, out) == (0, b"")
    assert "attitude: 4179 Toutatis: 161 samples\n" in err
    assert "attitude: long axis regime, polhode period 463841.0" in err


def test_long_run_shows_its_progress_on_a_terminal(answer, monkeypatch, tmp_path):
    monkeypatch.setattr(chunks, "CHUNK_INSTANTS", 40)
    _, _, err = answer("run", "toutatis", "-o", tmp_path / "out.csv", terminal=True)
    assert "\r 25% |" in err
    assert err.endswith("\r")  # nothing of the bar is left
    assert "|" not in answer("run", "toutatis", "-o", tmp_path / "out.csv")[2]
    monkeypatch.undo()
    assert "|" not in answer("run", "toutatis", "-o", tmp_path / "out.csv", terminal=True)[2]


def test_search_for_windows_shows_its_progress_on_a_terminal(answer, tmp_path):
    asked = ("windows", "envisat", "--axis", "-y", "--to", "sun", "--below", "12", "deg")
    _, _, err = answer(*asked, "-o", tmp_path / "out.csv", terminal=True)
    assert "\r  0% |" in err
    assert "%/s, " in err
    assert "|" not in answer(*asked)[2]
    fractions = []
    near = {"axis": "z", "to": "sun", "below": {"value": 60, "unit": "deg"}}
    Scene.builtin("envisat").crossings({"and": [near, {"shadow": "umbra"}]}, progress=fractions.append)
    assert sorted(set(fractions)) == fractions
    assert fractions[0] == 0.0
    assert 0.3 < fractions[-2] <= 1.0


def test_time_left_of_a_resumed_run_counts_from_where_it_resumed(capsys, monkeypatch):
    now = 0.0
    monkeypatch.setattr("tqdm.std.time", lambda: now)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    with console.progress_bar(argparse.Namespace(quiet=False)) as progress:
        progress(0.5)  # stored already
        now = 20.0
        progress(0.75)
    assert " 75% |" in capsys.readouterr().err.rpartition("00:20 left")[0]


def test_progress_is_drawn_on_a_terminal_that_reports_no_size(monkeypatch):
    ours, theirs = os.openpty()  # of 0 columns and rows
    os.set_blocking(ours, False)
    with open(theirs, "w") as terminal:
        monkeypatch.setattr(sys, "stderr", terminal)
        with console.progress_bar(argparse.Namespace(quiet=False)) as progress:
            progress(0.5)
        terminal.flush()
        assert b" 50% |" in os.read(ours, 4096)
    os.close(ours)


def test_quiet_run_says_nothing(answer, tmp_path):
    assert answer("run", "toutatis", "-q", "-o", tmp_path / "out.csv", terminal=True) == (0, b"", "")


# -- effects --------------------------------------------------------------------------------------

DROP = Scene.builtin("drop")
# Gravity gradient and eddy currents on Envisat could turn it by 4e4 and 20 rad in its day.
DROPPED = "as asked, less than 1.0e+03 rad over the span"


def test_scene_with_effects_is_run_as_the_library_runs_it(answer, written):
    assert answer("run", "thruster-plan") == (0, written(Scene.builtin("thruster-plan"), "csv"), "")


def test_effects_and_solver_are_reported_on_a_terminal(answer, tmp_path):
    _, _, err = answer("run", "envisat", "-o", tmp_path / "out.csv", terminal=True)
    assert "attitude: simulated: gravity_gradient, eddy_damping\n" in err
    assert re.search(r"gauss, order 32: \d+ steps, \d+ sweeps; error estimated at [\d.]+e-1\d rad\n", err)
    assert "regime" not in err  # which a free motion has


def test_effects_left_out_are_reported_on_a_terminal_only(answer, tmp_path):
    gravity = {"type": "uniform_gravity", "acceleration": {"value": [0, 0, -9.81], "unit": "m/s2"}}
    (tmp_path / "in.json").write_text(json.dumps(TOUTATIS.document() | {"effects": [gravity]}))
    arguments = ("run", tmp_path / "in.json", "-o", tmp_path / "out.csv")
    _, _, err = answer(*arguments, terminal=True)
    assert "attitude: simulated: nothing but free rotation\n" in err
    assert "attitude: left out: uniform_gravity: uniform gravity makes no torque" in err
    assert "error below 3.7e-15 rad" in err
    assert answer(*arguments) == (0, b"", "")


def test_tolerance_of_torques_is_set_on_the_command_line(answer, tmp_path):
    errors = {}
    for tolerance in ("best", "1e-6", "1e-3 rad"):
        target = tmp_path / "out.csv"
        _, _, err = answer("run", "envisat", "-o", target, "--set", f"tolerance={tolerance}", terminal=True)
        errors[tolerance] = float(re.search(r"error estimated at ([\d.e-]+) rad", err)[1])
    assert errors["best"] < 1e-9
    assert errors["best"] < errors["1e-6"] <= errors["1e-3 rad"] < 1e-3
    _, out, _ = answer("plan", "envisat", "--set", "tolerance=1e-5")
    assert b"(asked for: 1.0e-05)" in out
    for value in ("tolerance=-1", "clock=3"):
        code, _, err = answer("plan", "envisat", "--set", value)
        assert (code, err.count("--set")) == (2, 1)


@pytest.mark.parametrize("tolerance", ["1000 rad", "1e3", "57295.78deg", " 1e3  rad "])
def test_effects_dropped_on_request_are_always_reported(tolerance, answer, tmp_path):
    arguments = ("run", "envisat", "-o", tmp_path / "out.csv", "--drop-below", tolerance)
    assert answer(*arguments) == (0, b"", f"attitude: left out: eddy_damping: {DROPPED}\n")
    Scene.builtin("envisat").run(drop_below=1e3).write(tmp_path / "expected.csv")
    assert (tmp_path / "out.csv").read_bytes() == (tmp_path / "expected.csv").read_bytes()
    assert answer(*arguments, "--quiet") == (0, b"", "")


def test_step_alone_is_over_the_span_of_the_document(answer, tmp_path):
    document = Scene.builtin("envisat").document()
    document |= {"times": {"elapsed": [-30, 10, 100], "unit": "s"}, "effects": []}
    (tmp_path / "in.json").write_text(json.dumps(document))
    code, _, err = answer("run", tmp_path / "in.json", "--step", "20 s", "-o", tmp_path / "out.csv")
    assert (code, err) == (0, "")
    assert Ephemeris.read(tmp_path / "out.csv").elapsed.tolist() == [-30, -10, 10, 30, 50, 70, 90]
    code, _, err = answer("run", "envisat", "--stop", "1 h")
    assert (code, err[:17]) == (2, "attitude: --step:")
    (tmp_path / "a.apm").write_text("CCSDS_APM_VERS = 2.0\n")
    assert "--stop: a time above 0" in answer("run", tmp_path / "a.apm", "--step", "1 s")[2]


@pytest.mark.parametrize("quiet", [[], ["--quiet"]])
def test_ephemeris_that_ends_early_is_always_reported(quiet, answer, tmp_path):
    times = {"start": 0, "stop": 20, "step": 0.01, "unit": "s"}
    (tmp_path / "in.json").write_text(json.dumps(DROP.document() | {"times": times}))
    code, _, err = answer("run", tmp_path / "in.json", "-o", tmp_path / "out.csv", *quiet)
    assert code == 0
    assert re.fullmatch(r"attitude: at 2\.8\d+ s bounces accumulate: .* the ephemeris ends\n", err)
    assert Ephemeris.read(tmp_path / "out.csv").elapsed[-1] == pytest.approx(2.83)


# -- windows --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "document"),
    [
        (
            ["--axis", "-y", "--to", "sun", "--below", "12", "deg"],
            {"axis": "-y", "to": "sun", "below": {"value": 12.0, "unit": "deg"}},
        ),
        (
            ["--axis", "-1,0,0.5", "--above-plane", "-1,2,0"],
            {"axis": [-1.0, 0.0, 0.5], "above_plane": [-1.0, 2.0, 0.0]},
        ),
        (["--shadow", "umbra", "--width", "0.5"], {"shadow": "umbra"}),
        (["--condition", '{"not": {"shadow": "penumbra"}}'], {"not": {"shadow": "penumbra"}}),
    ],
    ids=["angle", "plane", "shadow", "condition"],
)
def test_windows_are_the_librarys(arguments, document, answer, tmp_path):
    width = 0.5 if "--width" in arguments else None
    windows = Scene.builtin("envisat").crossings(document, width)
    assert answer("windows", "envisat", *arguments) == (0, windows.text().encode(), "")
    assert answer("windows", "envisat", *arguments, "-o", tmp_path / "a.csv") == (0, b"", "")
    assert (tmp_path / "a.csv").read_text() == windows.to_csv()
    code, out, _ = answer("windows", "envisat", *arguments, "-f", "json")
    assert (code, json.loads(out)) == (0, windows.to_dict())


def test_condition_is_read_from_a_file_and_windows_are_drawn(answer, tmp_path):
    (tmp_path / "light.json").write_text(
        '{"or": [{"shadow": "umbra"}, {"axis": "z", "above_plane": [0, 0, 1]}]}'
    )
    arguments = ["--condition", tmp_path / "light.json", "--plot", tmp_path / "a.svg"]
    code, out, err = answer("windows", "envisat", *arguments, "--quiet")
    assert (code, err) == (0, "")
    assert out.endswith(b" of 86400 s\n")
    assert "(in the umbra) or (z above the plane of [0, 0, 1])" in (tmp_path / "a.svg").read_text()


# -- plan -----------------------------------------------------------------------------------------


def test_plan_is_the_librarys_own(answer):
    for scene in (TOUTATIS, DROP, Scene.builtin("gyrostat")):
        name = next(name for name in builtin_names() if Scene.builtin(name) == scene)
        assert answer("plan", name) == (0, scene.plan().text().encode(), "")
        code, out, _ = answer("plan", name, "--json")
        assert code == 0
        assert json.loads(out) == json.loads(json.dumps(scene.plan().to_dict()))


@pytest.mark.parametrize("name", builtin_names())
def test_plan_reads_well(name, answer):
    """A line has room on a screen, and each effect is named where the eye looks for it."""
    _, out, _ = answer("plan", name)
    title, *lines = out.decode().splitlines()
    assert title.startswith(f"{Scene.builtin(name).name}: attitude")
    assert max(map(len, lines)) <= 100
    named = [line.split()[0] for line in lines if line[2] != " "]
    scene = Scene.builtin(name)
    orbit = (
        ["orbit"] if scene.orbit is not None and any(effect.uses_orbit for effect in scene.effects) else []
    )
    assert named == [*(effect.type for effect in scene.effects), *orbit, "solver", "predicted"]


def test_plan_names_dropped_effects(answer):
    _, out, err = answer("plan", "envisat", "--drop-below", "1e3")
    assert err == ""
    assert f"  eddy_damping     left out: {DROPPED}\n" in out.decode()
    assert "  gravity_gradient simulated, acts on attitude: " in out.decode()


# -- plot -----------------------------------------------------------------------------------------


def test_drop_is_drawn_with_three_curves(answer, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert answer("plot", "drop") == (0, b"", "")
    svg = (tmp_path / "drop.svg").read_text()
    for curve in ("model: the closed form", "simulation with gravity", "simulation without gravity"):
        assert curve in svg


def test_any_other_scene_is_drawn_as_it_runs(answer, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert answer("plot", "thruster-plan", "-o", "plan.png")[0] == 0
    assert (tmp_path / "plan.png").read_bytes().startswith(b"\x89PNG")
    put_on_standard_input(Scene.builtin("thruster-plan").to_json(), monkeypatch)
    assert answer("plot", "-", terminal=True) == (0, b"", "attitude: drawn: scene.svg\n")
    assert "impulse (4)" in (tmp_path / "scene.svg").read_text()
    (tmp_path / "my.json").write_text(Scene.builtin("thruster-plan").to_json())
    assert answer("plot", tmp_path / "my.json")[0] == 0
    assert (tmp_path / "my.svg").read_bytes() == (tmp_path / "scene.svg").read_bytes()


# -- what is wrong ------------------------------------------------------------------------------


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
    bad = {"type": "dissipation", "coefficient": {"value": -1, "unit": "1/(N m s)"}}
    (tmp_path / "effect.json").write_text(json.dumps({**document, "effects": [bad]}))
    (tmp_path / "cut.json").write_text(json.dumps(document)[:-9])
    return tmp_path


@pytest.mark.filterwarnings("default")  # as a user has it: a warning would be a second line
@pytest.mark.parametrize(("arguments", "message"), table("command_refusals"), ids=str)
def test_bad_input_is_one_line_and_exit_code_2(arguments, message, answer, folder, recwarn):
    before = sorted(folder.iterdir())
    code, out, err = answer(*arguments)
    assert (code, out) == (2, b"")
    assert err.startswith("attitude: " + message.replace("{NAMES}", ", ".join(builtin_names())))
    assert err.count("\n") == 1
    assert err.endswith("\n")
    assert [str(warning.message) for warning in recwarn] == []
    assert sorted(folder.iterdir()) == before


def test_bad_standard_input_is_named(answer, monkeypatch):
    put_on_standard_input("{", monkeypatch)
    code, out, err = answer("run", "-")
    assert (code, out) == (2, b"")
    assert err.startswith("attitude: standard input, line 1: not JSON")


@pytest.mark.parametrize(
    "arguments", [["fly"], ["run"], ["run", "toutatis", "--fast"], ["serve", "--fast"]], ids=" ".join
)
def test_wrong_usage_is_one_line_and_exit_code_2(arguments, capfd):
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    out, err = capfd.readouterr()
    assert (caught.value.code, out) == (2, "")
    assert err.startswith("attitude: ")
    assert err.count("\n") == 1


def test_interruption_by_the_user_is_one_word_and_leaves_no_file(answer, monkeypatch, tmp_path):
    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(schema, "rows", interrupted)
    assert answer("run", "toutatis", "-o", tmp_path / "out.csv") == (130, b"", "attitude: interrupted\n")
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


def test_cost_reports_its_progress_on_a_terminal(answer):
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


def test_scenes_are_folded_for_a_person_beside_their_names(answer, monkeypatch):
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", "90")
    _, out, _ = answer("scenes")
    lines = out.decode().splitlines()
    assert max(map(len, lines)) <= 90
    assert [line.split()[0] for line in lines if line[0] != " "] == builtin_names()
    assert {re.match(" *", line).end() for line in lines if line[0] == " "} == {26}
    for name in builtin_names():
        assert " ".join(Scene.builtin(name).description.split())[-20:] in " ".join(out.decode().split())


def test_version_is_the_librarys(capfd):
    with pytest.raises(SystemExit) as caught:
        main(["--version"])
    assert caught.value.code == 0
    assert capfd.readouterr().out == f"attitude {__version__}\n"


def test_plot_without_matplotlib_says_what_to_install(answer, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    message = "attitude: the picture needs matplotlib: pip install 'attitude[plot]'\n"
    assert answer("plot", "drop") == (2, b"", message)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("missing", ["fastapi", "uvicorn", "pydantic_settings"])
def test_service_without_its_packages_says_what_to_install(missing, answer, monkeypatch):
    for name in [
        name for name in sys.modules if name.split(".")[0] in ("service", "prometheus_client", missing)
    ]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, missing, None)
    message = f"attitude: the service needs {missing}: pip install 'attitude[service]'\n"
    assert answer("serve") == (2, b"", message)


def test_service_is_served_at_the_host_and_port_of_the_flags(answer, monkeypatch):
    service = pytest.importorskip("service")
    asked = []
    monkeypatch.setattr(service, "serve", lambda **flags: asked.append(flags))
    assert answer("serve", "--host", "::1", "--port", "8080", "--workers", "2") == (0, b"", "")
    assert answer("serve") == (0, b"", "")
    named = [{name: value for name, value in flags.items() if value is not None} for flags in asked]
    assert named == [{"host": "::1", "port": "8080", "workers": "2"}, {}]


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
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([*COMMAND, "run", "spinner"], **pipes) as process:
        # the whole is more than a pipe holds, so the command is still writing when its reader leaves
        assert process.stdout.read(20).startswith(b"# q rotates body")
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 0


# -- formats of other tools ----------------------------------------------------------------------


def test_frame_tolerance_and_options_reach_the_file(answer, tmp_path):
    path = tmp_path / "out.aem"
    more = ("--frame", "EME2000", "--interpolation-error", "0.2 arcsec", "--set", "object_id=25544")
    assert answer("run", "toutatis", "-o", path, *more) == (0, b"", "")
    text = path.read_text()
    assert "OBJECT_ID = 25544\n" in text  # text although it is a number
    assert "REF_FRAME_A = EME2000\n" in text
    assert re.search(r"interpolation \(Lagrange, degree 7\) is at most [4-9]\.\de-07 rad", text)


def test_error_of_interpolation_is_reported_on_a_terminal(answer, tmp_path):
    _, _, err = answer("run", "toutatis", "-o", tmp_path / "out.aem", terminal=True)
    assert re.search(r"161 attitudes; interpolation between them errs by at most 6\.\de-06 rad", err)


def test_file_is_converted(answer, tmp_path):
    assert answer("run", "toutatis", "-o", tmp_path / "a.aem") == (0, b"", "")
    assert answer("convert", tmp_path / "a.aem", "-o", tmp_path / "b.bc") == (0, b"", "")
    assert answer("convert", tmp_path / "b.bc", "-o", tmp_path / "c.npz", "--frame", "EME2000")[0] == 0
    back, expected = Ephemeris.read(tmp_path / "c.npz"), Scene.builtin("toutatis").run().in_frame("EME2000")
    assert back.frame == "EME2000"
    assert np.abs(back.quaternion("wxyz") - expected.quaternion("wxyz")).max() < 1e-15
    assert np.abs(back.angular_velocity - expected.angular_velocity).max() < 1e-18
    code, out, _ = answer("convert", "--from", "aem", tmp_path / "a.aem", "-f", "ndjson")
    assert (code, out.count(b"\n")) == (0, 162)


def test_help_names_every_format(capsys):
    with pytest.raises(SystemExit):
        main(["run", "--help"])
    text = " ".join(capsys.readouterr().out.split())
    assert all(re.search(rf"\b{name}\b", text) for name in FORMATS)


def test_samples_are_computed_piece_by_piece(tmp_path):
    """3e6 instants from the shell: no more memory than for 3e5."""
    peaks = [peak_of_a_run(count, tmp_path) for count in (300_000, 3_000_000)]
    assert peaks[1] - peaks[0] < 40 * 1024  # KiB; the samples themselves grow by 190 MB


def peak_of_a_run(count, folder):
    times = {"start": 0, "stop": 40, "count": count, "unit": "d"}
    (folder / "many.json").write_text(json.dumps(TOUTATIS.document() | {"times": times}))
    program = (
        "import resource; from attitude.cli import main; main(['run', 'many.json', '-o', 'many.npz']);"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
    )
    command = [sys.executable, "-c", program]
    return int(subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout)


# -- help and completion -----------------------------------------------------------------


@pytest.mark.parametrize("arguments", [[], ["help"], ["--help"]])
def test_command_alone_explains_itself(arguments, capsys):
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 0
    assert "simulate a scene" in capsys.readouterr().out


@pytest.mark.parametrize("arguments", [["help", "plot"], ["plot", "--help"]])
def test_help_explains_one_command(arguments, capsys):
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 0
    assert "--what LIST" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("shell", "ask"),
    [
        (
            "bash",
            "COMP_WORDS=(attitude plot {0}); COMP_CWORD=2; _shtab_attitude '' {0}; echo ${{COMPREPLY[@]}}",
        ),
        ("fish", "complete -C 'attitude plot {}' | cut -f1"),
    ],
)
def test_shell_completes_options_and_files(shell, ask, tmp_path, capsys):
    pytest.importorskip("shtab")
    if shutil.which(shell) is None:
        pytest.skip(f"no {shell} here")
    assert main(["completion", shell]) == 0
    (tmp_path / "script").write_text(capsys.readouterr().out)
    (tmp_path / "my.aem").touch()
    for word, whole in {"--wh": "--what", "my": "my.aem"}.items():
        command = [shell, "-c", f"source ./script; {ask.format(word)}"]
        run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        assert run.stdout.split() == [whole]


def test_file_of_attitudes_is_plotted_as_its_scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("a.aem", "a.json"):
        assert main(["run", "spinner", "-o", name]) == 0
        assert main(["plot", name, "--what", "quaternion,direction:z", "-o", f"{name}.svg"]) == 0
        assert "direction z" in (tmp_path / f"{name}.svg").read_text()
