"""Gaps filled by dynamics: exact between, within sigma at the ends, or a warning."""

import warnings

import numpy as np
import pytest
from astropy.time import Time
from scipy.integrate import solve_ivp
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

    def attitudes(seconds):
        turns = np.outer(np.where(gap[0] < seconds, manoeuvre, 0.0), (1.0, 0.0, 0.0))
        return Rotation.from_rotvec(turns) * simulated.motion().at(seconds).rotation

    return without(path, attitudes, gap, random)


def without(path, attitudes, gap=GAP, random=None, seconds=SECONDS):
    """A file of these attitudes, with errors, without the instants of a gap."""
    seconds = seconds[(gap[0] >= seconds) | (gap[1] <= seconds)]
    q = attitudes(seconds)
    if random is not None:
        q = q * Rotation.from_rotvec(SIGMA * random.normal(size=(len(seconds), 3)))
    q = rotations.sign_continuous(q.as_quat(scalar_first=True))
    Ephemeris(q, Instants(seconds, None, EPOCH), "ICRF").write(path)
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


def integrated(torque=0.0, rate_jump=0.0, at=260.0):
    """Attitudes by Euler's equations with a constant torque about body x, N m, and a jump of the rate."""
    inertia, torques = np.array(MOMENTS), np.array([torque, 0.0, 0.0])

    def slope(_t, state):
        q, w = state[:4], state[4:]
        turn = np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)])
        return np.concatenate([0.5 * turn, (np.cross(inertia * w, w) + torques) / inertia])

    def attitudes(seconds):
        before, tolerances = seconds < at, {"method": "DOP853", "rtol": 1e-11, "atol": 1e-13}
        state = np.array([1.0, 0.0, 0.0, 0.0, *simulated.RATE])
        first = solve_ivp(slope, (0.0, at), state, t_eval=[*seconds[before], at], **tolerances).y
        jumped = first[:, -1] + np.array([0.0, 0.0, 0.0, 0.0, rate_jump, 0.0, 0.0])
        second = solve_ivp(slope, (at, 600.0), jumped, t_eval=seconds[~before], **tolerances).y
        return Rotation.from_quat(np.concatenate([first[:4, :-1], second[:4]], axis=1).T, scalar_first=True)

    return attitudes


def shaken(amplitude):
    """The motion with an oscillation about it of 30 s, rad."""
    return lambda seconds: (
        simulated.motion().at(seconds).rotation
        * Rotation.from_rotvec(amplitude * np.sin(seconds / 30.0 * 2.0 * np.pi)[:, None] * (1.0, 1.0, 0.0))
    )


def scattered(part, before=600.0):
    """The motion, of whose attitudes up to an instant a part is at random."""

    def attitudes(seconds):
        random = np.random.default_rng(3)
        q = simulated.motion().at(seconds).quaternion("wxyz").copy()
        is_random = (random.random(len(seconds)) < part) & (seconds <= before)
        q[is_random] = Rotation.random(int(is_random.sum()), random).as_quat(scalar_first=True)
        return Rotation.from_quat(q, scalar_first=True)

    return attitudes


NOT_ONE, FAR_OFF, NO_MOTION = "not of one free motion", "far off and were left out", "they show no motion"
NOT_RANDOM = "depart from a free motion by more than random errors"


@pytest.mark.parametrize(
    ("attitudes", "body", "doubt"),
    [
        pytest.param(integrated(rate_jump=1e-5), MOMENTS, NOT_ONE, id="impulse"),
        pytest.param(integrated(rate_jump=1e-4, at=190.0), MOMENTS, NOT_ONE, id="impulse before the gap"),
        pytest.param(integrated(torque=1e-6), MOMENTS, NOT_ONE, id="slow torque"),
        pytest.param(shaken(1e-4), MOMENTS, NOT_RANDOM, id="oscillation"),
        pytest.param(integrated(), (10.0, 13.01, 17.0), NOT_ONE, id="other moments"),
        pytest.param(integrated(), (10.0, 17.0, 13.0), NOT_ONE, id="moments in another order"),
        pytest.param(scattered(0.1), MOMENTS, FAR_OFF, id="some at random"),
        pytest.param(scattered(1.0, GAP[0]), MOMENTS, NO_MOTION, id="all before the gap at random"),
        pytest.param(scattered(1.0), MOMENTS, NO_MOTION, id="all at random"),
    ],
)
def test_what_is_no_free_motion_is_doubted(tmp_path, attitudes, body, doubt):
    data = without(tmp_path / "gappy.csv", attitudes, random=np.random.default_rng(1))
    with pytest.warns(AttitudeWarning, match=rf"gap from 200 to 320 s .* sigma .* deg: .*{doubt}"):
        filled, (gap,) = fill_gaps(data, RigidBody(body))
    assert not gap.is_consistent
    assert [event.kind for event in filled.events] == ["gap"]
    if doubt == FAR_OFF:
        assert gap.doubts == (gap.doubts[0],)
        assert off(filled, np.arange(GAP[0] + 1.0, GAP[1])).max() < SIGMA


@pytest.mark.parametrize("size", [3, 10, 100])
def test_free_motion_with_random_errors_is_not_doubted(tmp_path, size):
    """One in a thousand gaps is: `python -m tests.benchmarks.fit_truth gaps`."""
    seconds = np.concatenate([SECONDS[GAP[0] >= SECONDS][-size:], SECONDS[GAP[1] <= SECONDS][:size]])
    for seed in range(8):
        attitudes, random = (lambda t: simulated.motion().at(t).rotation), np.random.default_rng(seed)
        data = without(tmp_path / "gappy.csv", attitudes, random=random, seconds=seconds)
        _, (gap,) = fill_gaps(data, RigidBody(MOMENTS))
        assert gap.doubts == ()


def test_turns_of_the_body_in_a_long_gap_are_doubted(tmp_path):
    """The rate is known to 2e-7 rad/s."""
    for length, is_uncertain in ((2e5, False), (1e8, True)):
        seconds = np.concatenate([SECONDS[:100], length + SECONDS[:100]])
        attitudes, random = (lambda t: simulated.motion().at(t).rotation), np.random.default_rng(1)
        data = without(tmp_path / "gappy.csv", attitudes, (198.0, length), random, seconds)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", AttitudeWarning)
            _, (gap,) = fill_gaps(data, RigidBody(MOMENTS))
        assert any("how many turns" in text for text in gap.doubts) == is_uncertain


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
    assert gap.is_consistent == has_rate
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
