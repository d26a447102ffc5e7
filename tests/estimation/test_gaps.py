"""Gaps filled by dynamics: exact between, within sigma at the ends, or a warning."""

import warnings

import numpy as np
import pytest
from astropy.time import Time
from scipy.spatial.transform import Rotation

from attitude import AttitudeWarning, Ephemeris, InputError, RegimeError, RigidBody
from attitude.cli.command import main
from attitude.estimation.gaps import fill_gaps
from attitude.frames import rotations
from attitude.times.instants import Instants
from tests.estimation import simulated
from tests.estimation.simulated import MOMENTS

SIGMA = 1e-5
SECONDS = np.arange(0.0, 600.0, 2.0)
GAP = (200.0, 320.0)
EPOCH = Time("2026-01-01T00:00:00", scale="utc")


def gappy(path, random=None, manoeuvre=0.0, gap=GAP):
    """A file without the instants of a gap, with errors, and after the gap turned."""
    seconds = np.concatenate([SECONDS[gap[0] >= SECONDS], SECONDS[gap[1] <= SECONDS]])
    q = simulated.motion().at(seconds).rotation
    if random is not None:
        q = q * Rotation.from_rotvec(SIGMA * random.normal(size=(len(seconds), 3)))
    turns = np.outer(np.where(gap[0] < seconds, manoeuvre, 0.0), (1.0, 0.0, 0.0))
    q = (Rotation.from_rotvec(turns) * q).as_quat(scalar_first=True)
    Ephemeris(rotations.sign_continuous(q), Instants(seconds, None, EPOCH), "ICRF").write(path)
    return Ephemeris.read(path)


def off(filled, seconds):
    truth = simulated.motion().at(seconds).quaternion("wxyz")
    return rotations.angle_between(filled.resampled(seconds).quaternion("wxyz"), truth)


@pytest.mark.parametrize("name", ["gappy.csv", "gappy.aem", "gappy.a"])
def test_gap_follows_the_motion_of_its_sides(tmp_path, name):
    data = gappy(tmp_path / name, np.random.default_rng(1))
    filled, (gap,) = fill_gaps(data, RigidBody(MOMENTS))
    assert (gap.start, gap.stop) == GAP
    assert gap.is_consistent
    assert gap.sigma == pytest.approx(SIGMA, rel=0.2)
    inside = np.arange(GAP[0] + 1.0, GAP[1])
    assert off(filled, inside).max() < SIGMA  # sigma over the root of 200 attitudes, grown by 60 s
    outside = np.array([50.0, 100.0])
    assert (filled.resampled(outside).quaternion("wxyz") == data.resampled(outside).quaternion("wxyz")).all()


def test_each_of_several_gaps_follows_its_own_sides(tmp_path):
    path, gaps = tmp_path / "gappy.csv", [(100.0, 130.0), (260.0, 300.0), (450.0, 520.0)]
    is_kept = np.all([(first >= SECONDS) | (last <= SECONDS) for first, last in gaps], axis=0)
    seconds = SECONDS[is_kept]
    q = simulated.motion().at(seconds).quaternion("wxyz")
    Ephemeris(q, Instants(seconds, None, EPOCH), "ICRF").write(path)
    filled, found = fill_gaps(Ephemeris.read(path), RigidBody(MOMENTS))
    assert [(gap.start, gap.stop) for gap in found] == gaps
    instants = np.arange(0.0, 598.0, 0.5)
    inside = np.any([(first < instants) & (instants < last) for first, last in gaps], axis=0)
    assert off(filled, instants[inside]).max() < 1e-10
    assert off(filled, seconds).max() < 1e-10
    whole, data = filled.resampled(instants), Ephemeris.read(path)
    elsewhere = data.resampled(instants[~inside]).quaternion("wxyz")
    assert (np.abs((whole.quaternion("wxyz")[~inside] * elsewhere).sum(1)) > 1 - 1e-15).all()


def test_attitudes_without_errors_leave_none_in_the_gap(tmp_path):
    filled, (gap,) = fill_gaps(gappy(tmp_path / "gappy.csv"), RigidBody(MOMENTS))
    assert gap.is_consistent
    assert off(filled, np.arange(GAP[0] + 1.0, GAP[1])).max() < 1e-10


def test_manoeuvre_within_a_gap_is_named(tmp_path):
    data = gappy(tmp_path / "gappy.csv", np.random.default_rng(1), manoeuvre=1e-3)
    with pytest.warns(
        AttitudeWarning, match=r"gap from 200 to 320 s by free rotation; .* not of one free motion"
    ):
        filled, (gap,) = fill_gaps(data, RigidBody(MOMENTS))
    assert not gap.is_consistent
    assert [event.kind for event in filled.events] == ["gap"]


def test_other_inertia_is_named(tmp_path):
    data = gappy(tmp_path / "gappy.csv", np.random.default_rng(1))
    with pytest.warns(AttitudeWarning, match="not of one free motion"):
        fill_gaps(data, RigidBody((10.0, 12.0, 17.0)))


def test_ephemeris_without_gaps_stays(tmp_path):
    data = gappy(tmp_path / "whole.csv", gap=(200.0, 202.0))
    with pytest.warns(AttitudeWarning, match="no gaps: every instant"):
        filled, gaps = fill_gaps(data, RigidBody(MOMENTS))
    assert not gaps
    assert (filled.resampled([3.0]).quaternion("wxyz") == data.resampled([3.0]).quaternion("wxyz")).all()


@pytest.mark.parametrize("gap", [(0.0, 300.0), (2.0, 300.0), (200.0, 598.0)], ids=["one", "two", "last"])
@pytest.mark.parametrize("manoeuvre", [0.0, 1e-3])
def test_few_attitudes_on_one_side_are_met_or_named(tmp_path, gap, manoeuvre):
    data = gappy(tmp_path / "gappy.csv", np.random.default_rng(1), manoeuvre, gap)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        filled, (found,) = fill_gaps(data, RigidBody(MOMENTS))
    assert found.is_consistent == (manoeuvre == 0.0)
    assert bool(caught) == (manoeuvre != 0.0)
    if not manoeuvre:
        assert off(filled, np.arange(gap[0] + 1.0, gap[1])).max() < 10.0 * SIGMA


def test_few_attitudes_on_both_sides_are_refused(tmp_path):
    data = gappy(tmp_path / "gappy.csv", gap=(2.0, 594.0))[[0, 1, 2, 3]]
    with pytest.raises(InputError, match=r"2 and 2 attitudes beside the gap at 2 s"):
        fill_gaps(data, RigidBody(MOMENTS))


@pytest.mark.parametrize("has_rate", [True, False])
def test_turns_that_attitudes_may_have_missed_are_named_unless_rates_tell_them(tmp_path, has_rate):
    """3.4 rad between neighbours, or 2.9 the other way; the gap is of whole steps."""
    truth = simulated.motion(rate=(0.0, 0.0, 1.7))
    seconds = SECONDS[(GAP[0] >= SECONDS) | (GAP[1] <= SECONDS)]
    rate = truth.at(seconds).angular_velocity if has_rate else None
    q = rotations.sign_continuous(truth.at(seconds).quaternion("wxyz"))
    Ephemeris(q, Instants(seconds, None, EPOCH), "ICRF", rate=rate).write(tmp_path / "gappy.aem")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        filled, (gap,) = fill_gaps(Ephemeris.read(tmp_path / "gappy.aem"), RigidBody(MOMENTS))
    said = [str(each.message) for each in caught]
    assert any("another motion fits as well: turns" in text for text in said) == (not has_rate)
    assert gap.is_ambiguous == (not has_rate)
    if has_rate:
        inside = np.arange(GAP[0] + 1.0, GAP[1])
        expected = truth.at(inside).quaternion("wxyz")
        assert rotations.angle_between(filled.resampled(inside).quaternion("wxyz"), expected).max() < 1e-7


def test_instants_that_do_not_increase_are_refused(tmp_path):
    data = gappy(tmp_path / "gappy.csv")
    with pytest.raises(RegimeError, match="whose instants increase"):
        fill_gaps(Ephemeris(data.attitude[::-1].copy(), data.instants[::-1], "ICRF"), RigidBody(MOMENTS))


@pytest.mark.parametrize("body", ["10,13,17", "document"])
def test_command_fills_gaps(tmp_path, body):
    gappy(tmp_path / "gappy.csv")
    if body == "document":
        body = str(tmp_path / "body.json")
        (tmp_path / "body.json").write_text('{"body": {"moments": [10, 13, 17], "unit": "kg m2"}}')
    files = [str(tmp_path / name) for name in ("gappy.csv", "whole.csv")]
    assert (
        main(["convert", files[0], "-o", files[1], "--by", "dynamics", "--body", body, "--step", "1s"]) == 0
    )
    whole = Ephemeris.read(files[1])
    assert (np.diff(whole.elapsed) == 1.0).all()
    inside = (whole.elapsed > GAP[0]) & (whole.elapsed < GAP[1])
    truth = simulated.motion().at(whole.elapsed[inside]).quaternion("wxyz")
    assert rotations.angle_between(whole.quaternion("wxyz")[inside], truth).max() < 1e-10
    assert rotations.sign_changes(whole.quaternion("wxyz")) == 0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--by", "dynamics"], "--by: --times or --step beside it"),
        (["--by", "dynamics", "--step", "1s"], "--body: the body's inertia, which the file does not hold"),
        (["--body", "1,2,2.5", "--step", "1s"], "--body: --by dynamics beside it"),
        (["--by", "dynamics", "--body", "1,2,9", "--step", "1s"], "no principal moment greater than the sum"),
        (["--by", "dynamics", "--body", "nowhere.json", "--step", "1s"], "no such file"),
    ],
)
def test_command_refuses(tmp_path, capsys, options, message):
    gappy(tmp_path / "gappy.csv")
    assert main(["convert", str(tmp_path / "gappy.csv"), *options]) == 2
    assert message in capsys.readouterr().err
