"""`attitude ensemble`: what it prints and stores (refused flags: tests/tables/command_refusals.json)."""

import io
import json
import re
import sys

import numpy as np
import pytest
from astropy.table import QTable
from tqdm import tqdm

from attitude import Scene, TorqueFreeMotion
from attitude.cli import main
from attitude.ensemble import Ensemble, storage

TOUTATIS = Scene.builtin("toutatis")
SPREADS = {"moments": "2 %", "angular_velocity": "0.1 deg/d", "attitude": "1 deg"}
FLAGS = ["--bodies", 300, "--seed", 7]
FLAGS += ["--moments", "2 %", "--angular-velocity", "0.1 deg/d", "--attitude", "1 deg"]


@pytest.fixture
def answer(capfd, monkeypatch):
    """Exit code, standard output and standard error; a terminal has a person before it."""

    def run(*arguments, terminal=False):
        with monkeypatch.context() as patch:
            patch.setattr(sys.stderr, "isatty", lambda: terminal)
            code = main(["ensemble", *(str(argument) for argument in arguments)])
        return code, *capfd.readouterr()

    return run


@pytest.fixture(scope="module")
def expected():
    return Ensemble.sample(TOUTATIS, 300, 7, **SPREADS)


def rows(out):
    return np.array([line.split() for line in out.splitlines() if not line.startswith("#")][1:], dtype=float)


def document(tmp_path, **changes):
    path = tmp_path / "ensemble.json"
    whole = {"scene": "toutatis", "bodies": 300, "seed": 7, **SPREADS} | changes
    path.write_text(json.dumps({name: value for name, value in whole.items() if value is not None}))
    return path


# -- statistics -------------------------------------------------------------------------------------


def test_statistics_are_printed_for_every_instant(answer, expected):
    code, out, err = answer("toutatis", *FLAGS)
    assert (code, err) == (0, "")
    result = expected.statistics()
    assert out.startswith("# 300 bodies in ECLIPJ2000: long_axis 100.0000%\n")
    table = rows(out)
    assert table.shape == (TOUTATIS.times.samples, 11)
    np.testing.assert_allclose(table[:, 0], result.seconds, rtol=1e-8)
    np.testing.assert_allclose(table[:, 1:5], result.mean, atol=1e-6)
    np.testing.assert_allclose(table[:, 5:8], np.degrees(result.deviation), rtol=1e-6)
    np.testing.assert_allclose(table[:, 8:], result.resultants, rtol=1e-6)


def test_statistics_are_written_as_ecsv(answer, expected, tmp_path):
    path = tmp_path / "statistics.ecsv"
    assert answer("toutatis", *FLAGS, "--statistics", path) == (0, "", "")
    table = QTable.read(path)
    np.testing.assert_array_equal(table["covariance"].to_value("rad2"), expected.statistics().covariance)
    assert table.meta["count"] == 300


def test_statistics_are_written_as_json(answer, expected, tmp_path):
    path = tmp_path / "statistics.json"
    assert answer("toutatis", *FLAGS, "--statistics", path) == (0, "", "")
    code, out, _ = answer("toutatis", *FLAGS, "--statistics", "-")
    assert (code, out) == (0, path.read_text())
    result = json.loads(out)
    assert (result["kind"], result["count"]) == ("attitude-ensemble-statistics/1", 300)
    assert result["columns"]["elapsed_s"] == expected.statistics().seconds.tolist()
    assert result["columns"]["covariance_rad2"] == expected.statistics().covariance.tolist()
    assert result["columns"]["time"][0].startswith("1992-11-09T17:49:47")


def test_picture_is_drawn_beside_the_statistics(answer, tmp_path):
    path = tmp_path / "a.svg"
    flags = ["--bodies", 300, "--angular-velocity", "1e-3 deg/s", "--axis", "middle"]
    code, out, err = answer("intermediate-axis", *flags, "--plot", path)
    assert (code, err) == (0, "")
    assert out.startswith("# 300 bodies in INERTIAL")
    drawn = path.read_text()
    texts = ("where the middle-moment axis points 10 min", "how the spread grows", "when they flip", "flip 3")
    assert all(text in drawn for text in texts)


def test_picture_of_bodies_that_do_not_flip_has_no_flips(answer, tmp_path):
    path = tmp_path / "a.svg"
    assert answer("toutatis", "--bodies", 300, "--attitude", "1 deg", "--plot", path)[0] == 0
    assert "where the least-moment axis points" in path.read_text()


# -- documents --------------------------------------------------------------------------------------


def test_document_of_an_ensemble_is_equal_to_flags(answer, tmp_path):
    assert answer(document(tmp_path)) == answer("toutatis", *FLAGS)


def test_document_may_hold_a_whole_scene(answer, tmp_path):
    assert answer(document(tmp_path, scene=TOUTATIS.document())) == answer("toutatis", *FLAGS)


def test_flags_go_before_the_document(answer, tmp_path):
    path = document(tmp_path, bodies=5, seed=1, moments="10 %")
    assert answer(path, *FLAGS) == answer("toutatis", *FLAGS)


def test_document_is_read_from_standard_input(answer, tmp_path, monkeypatch):
    text = document(tmp_path).read_bytes()
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text)))
    assert answer("-") == answer("toutatis", *FLAGS)


def test_seed_is_zero_if_none_is_given(answer):
    drawn = ["toutatis", "--bodies", 10, "--attitude", "1 deg"]
    assert answer(*drawn) == answer(*drawn, "--seed", 0) != answer(*drawn, "--seed", 1)


@pytest.mark.parametrize("flags", [["--moments", "60 %"], []], ids=["flag", "document"])
def test_relative_spread_above_a_half_is_one_line_on_standard_error(answer, tmp_path, flags):
    path = document(tmp_path, moments="60 %", bodies=5)
    code, out, err = answer(path, *flags, "-q")
    assert (code, out[:9]) == (0, "# 5 bodie")
    assert err.startswith("attitude: moments: a relative standard deviation of 60 %, above 50 %: ")
    assert sum("above 50 %" in line for line in err.splitlines()) == 1
    assert all(line.startswith("attitude: moments ") for line in err.splitlines()[1:])


# -- tables -----------------------------------------------------------------------------------------


@pytest.fixture
def table(expected, tmp_path):
    """Of states, one of which is none."""
    rows = expected.to_table()
    rows["quaternion"][17] = 0.0
    return rows


@pytest.mark.parametrize("ending", ["ecsv", "fits"])
def test_rows_of_a_table_are_bodies(answer, expected, tmp_path, ending):
    rows_of = expected.to_table()
    rows_of.meta.clear()  # a header of FITS does not hold an epoch
    rows_of.write(tmp_path / f"rows.{ending}")
    code, out, _ = answer("toutatis", "--table", tmp_path / f"rows.{ending}")
    assert code == 0
    np.testing.assert_array_equal(rows(out), rows(answer("toutatis", *FLAGS)[1]))


def test_bad_row_stops_the_command(answer, table, tmp_path):
    table.write(tmp_path / "rows.ecsv")
    code, out, err = answer("toutatis", "--table", tmp_path / "rows.ecsv")
    assert (code, out) == (2, "")
    assert re.match(r"attitude: table\[17\]\.quaternion: .*\n$", err)


def test_bad_rows_are_left_out_and_listed(answer, table, tmp_path):
    table.write(tmp_path / "rows.ecsv")
    code, out, err = answer("toutatis", "--table", tmp_path / "rows.ecsv", "--leave-out-bad-rows")
    assert code == 0
    assert out.startswith("# 299 bodies")
    assert "1 bad rows" in err
    assert "table[17].quaternion" in err


# -- stores -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("ending", ["zarr", "parquet"])
def test_attitudes_are_stored(answer, expected, tmp_path, ending):
    to = tmp_path / f"out.{ending}"
    code, out, err = answer("toutatis", *FLAGS, "-o", to, "--chunk", 100, "--workers", 2)
    assert (code, err) == (0, "")
    count = TOUTATIS.times.samples
    written = rf"{to}: 300 bodies x {count} instants in 3 chunks, [\d.]+ MB written in [\d.]+ s\n"
    assert re.fullmatch(written, out)
    states = expected.states()
    motion = TorqueFreeMotion(states.body, states.attitude, states.angular_velocity, order="wxyz")
    ephemeris = motion.ephemeris(expected.instants())
    result = storage.read(to)
    quaternion, rate = result.part(0, 300)
    np.testing.assert_array_equal(quaternion, ephemeris.quaternion("wxyz"))
    np.testing.assert_array_equal(rate, ephemeris.angular_velocity)
    assert result.head["scene"]["name"] == TOUTATIS.name


def test_interrupted_run_says_how_to_go_on_and_does(answer, tmp_path, monkeypatch):
    to = tmp_path / "out.zarr"

    class Interrupt(tqdm):
        def update(self, n):
            super().update(n)
            if self.n > 50.0:  # %
                raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("tqdm.tqdm", Interrupt)
        code, _, err = answer("toutatis", *FLAGS, "-o", to, "--chunk", 30, "--workers", 1, terminal=True)
    assert code == 130
    assert err.endswith(f"attitude: {to}: interrupted; the same command goes on from there\n")
    code, out, _ = answer("toutatis", *FLAGS, "-o", to)
    assert code == 0
    assert re.search(r"in 10 chunks \([6-9] of them there already\)", out)


def test_existing_store_needs_overwrite(answer, tmp_path):
    to = tmp_path / "out.zarr"
    assert answer("toutatis", *FLAGS, "-o", to, "-q") == (0, "", "")
    message = f"attitude: {to}: store exists and is complete; pass overwrite=True to replace it\n"
    assert answer("toutatis", *FLAGS, "-o", to) == (2, "", message)
    assert answer("toutatis", *FLAGS, "-o", to, "-q", "--overwrite") == (0, "", "")


def test_stored_and_statistics_at_once(answer, tmp_path):
    code, out, _ = answer("toutatis", *FLAGS, "-o", tmp_path / "out.zarr", "--statistics", "-")
    assert code == 0
    assert json.loads(out)["count"] == 300
    assert storage.read(tmp_path / "out.zarr").bodies == 300


# -- progress ---------------------------------------------------------------------------------------


def test_progress_is_for_terminals(answer, tmp_path):
    to = tmp_path / "out.zarr"
    _, _, err = answer("toutatis", *FLAGS, "-o", to, "--chunk", 30, "--workers", 1, terminal=True)
    assert "10% |" in err
    assert err.endswith("\r")
    code, _, err = answer("toutatis", *FLAGS, "-o", to, "--overwrite", "-q", terminal=True)
    assert (code, err) == (0, "")


# -- what is wrong ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "error"),
    [
        ({"scene": "nowhere"}, "scene: unknown scene 'nowhere'; known: basilisk, "),
        ({"scene": 5}, "scene: a JSON object"),
        ({"scene": {"frame": "ICRF"}}, "scene.body: a value (the field is required)"),
        ({"scene": TOUTATIS.document() | {"frame": "x"}}, "scene.frame: "),
        ({"bodies": "many"}, "bodies: a whole number of bodies"),
        ({"seed": -1}, "seed: "),
        ({"color": "red"}, "color: unknown key 'color'; known: scene, bodies"),
        ({"attitude": "1 kg"}, "attitude: "),
        ({"moments": 2}, 'moments: a percentage, such as "2 %", or a ratio below 1'),
        ({"moments": ["2 %", 2, 0]}, "moments[1]: a percentage"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_fault_of_a_document_is_named_by_its_field(answer, tmp_path, changes, error):
    code, out, err = answer(document(tmp_path, **changes))
    assert (code, out) == (2, "")
    assert err.startswith(f"attitude: {error}")
    assert err.count("\n") == 1
