"""Windows against scans of the motion, scipy, and crossings known in closed form."""

import json

import astropy.units as u
import numpy as np
import pytest
from astropy.coordinates import get_body_barycentric
from astropy.time import Time
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from attitude import InputError, RegimeError, RigidBody, Scene, TorqueFreeMotion
from attitude.windows import above_plane, angle, in_shadow, parse_condition

EPOCH = Time("2024-03-01T12:00:00", scale="utc")
END = 1e-9  # s, to which ends are refined
DEG = np.pi / 180.0
ORBIT = {"altitude": {"value": 500.0, "unit": "km"}, "inclination": {"value": 60.0, "unit": "deg"}}


def spinner(rate=0.1, epoch=EPOCH):
    """About z, which points to x of the frame at no time; its x axis turns in the plane of x and y."""
    return TorqueFreeMotion(RigidBody([1.0, 1.0, 2.0]), [1, 0, 0, 0], [0, 0, rate], epoch, "wxyz", "GCRF")


def tumbler(seed, epoch=None):
    rng = np.random.default_rng(seed)
    moments = np.sort(rng.uniform(1.0, 2.0, 3))
    rate = rng.normal(size=3) * 10.0 ** rng.uniform(-3, 0)
    return TorqueFreeMotion(RigidBody(moments), Rotation.random(rng=rng), rate, epoch)


def document(**changed):
    scene = {
        "body": {"moments": [1.0, 1.6, 2.1], "unit": "kg m2"},
        "epoch": {"time": "2024-03-01T12:00:00", "scale": "utc"},
        "frame": "GCRF",
        "attitude": {"quaternion": [1.0, 0.0, 0.0, 0.0], "order": "wxyz"},
        "angular_velocity": {"value": [0.3, -0.2, 0.5], "unit": "deg/s"},
        "times": {"start": 0, "stop": 3, "count": 2, "unit": "h"},
        "orbit": ORBIT,
    }
    return Scene.model_validate(scene | changed)


def scanned(holds):
    """Number of runs of true, and their share, of a sampled condition."""
    edges = np.diff(np.concatenate([[False], holds, [False]]).astype(int))
    return int((edges == 1).sum()), float(holds.mean())


# -- crossings known in closed form ---------------------------------------------------------------


def test_ends_of_a_spinners_windows_are_those_of_the_closed_form():
    windows = spinner().crossings(angle("x", to=[1.0, 0.0, 0.0]) < 20 * u.deg, 0.0, 1000.0)
    turn = 2.0 * np.pi / 0.1
    centres = turn * np.arange(16)
    assert len(windows) == 16
    np.testing.assert_allclose(windows.stop.seconds, centres + 200 * DEG, rtol=0, atol=END)
    np.testing.assert_allclose(windows.start.seconds[1:], centres[1:] - 200 * DEG, rtol=0, atol=END)
    assert windows.begins_before.tolist() == [True] + 15 * [False]
    assert not windows.ends_after.any()


def test_ends_keep_a_nanosecond_after_thirty_years():
    """A double counts 30 years in steps of 1.2e-7 s: ends have a second part."""
    start = 9.5e8
    windows = spinner().crossings(angle("x", to=[1.0, 0.0, 0.0]) < 20 * u.deg, start, start + 100.0)
    from mpmath import mp, mpf

    mp.dps = 40
    turn, half = 2 * mp.pi / mpf(0.1), mpf(20 * DEG) / mpf(0.1)
    for high, low, sign in (
        *((h, r, -1) for h, r in zip(windows.start.seconds, windows.start.seconds_low, strict=True)),
        *((h, r, 1) for h, r in zip(windows.stop.seconds, windows.stop.seconds_low, strict=True)),
    ):
        if start < high < start + 100.0:
            at = mpf(float(high)) + mpf(float(low)) - sign * half
            assert abs(at - mp.nint(at / turn) * turn) < 2e-9


def test_windows_shorter_than_any_scan_are_found():
    """The axis comes within 1e-9 rad of the target: open for 2e-8 rad of a turn."""
    motion = spinner()
    tilted = [1.0, 0.0, 1e-3]
    grazing = np.arctan(1e-3)
    assert len(motion.crossings(angle("x", to=tilted) < grazing - 1e-9, 0.0, 1000.0)) == 0
    windows = motion.crossings(angle("x", to=tilted) < grazing + 1e-9, 1.0, 1000.0, width=1e-6)
    assert len(windows) == 15
    half = np.sqrt((grazing + 1e-9) ** 2 - grazing**2) / 0.1
    np.testing.assert_allclose(windows.duration, 2.0 * half, rtol=1e-2)


def test_planes_are_crossed_twice_a_turn():
    windows = spinner().crossings(above_plane("y", [1.0, 0.0, 0.0]), 0.0, 62.0)
    np.testing.assert_allclose(windows.start.seconds, [10.0 * np.pi], rtol=0, atol=END)
    np.testing.assert_allclose(windows.stop.seconds, [62.0])
    assert windows.ends_after.tolist() == [True]


def test_shadow_of_a_cylinder_opens_where_geometry_says():
    """Orbit in the plane of the Sun: behind the Earth over 2 asin(R/a) of it."""
    scene = document(
        orbit={"altitude": {"value": 700.0, "unit": "km"}},
        times={"start": 0, "stop": 3, "count": 2, "unit": "h"},
    )
    windows = scene.crossings(in_shadow("cylinder"))
    assert len(windows) == 2
    data = scene.run().resampled(windows.start)
    sun = (get_body_barycentric("sun", data.time) - get_body_barycentric("earth", data.time)).xyz.value.T
    along = (data.position * sun).sum(axis=1) / np.linalg.norm(sun, axis=1)
    across = np.sqrt((data.position**2).sum(axis=1) - along**2)
    np.testing.assert_allclose(across, 6378100.0, rtol=1e-6)


# -- against scans --------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
def test_no_window_of_a_scan_is_missed(seed):
    motion = tumbler(seed)
    rng = np.random.default_rng(100 + seed)
    condition = (angle("z", to=rng.normal(size=3)) < rng.uniform(2, 60) * u.deg) | (
        angle(rng.normal(size=3), to=rng.normal(size=3)) > rng.uniform(120, 178) * u.deg
    )
    rate = float(np.linalg.norm(motion.at(0.0).angular_velocity))
    span = 60.0 * 2.0 * np.pi / rate
    t = np.linspace(0.0, span, 60_001)
    ephemeris = motion.at(t)
    holds = condition.holds(lambda each: ephemeris.angle(each.axis, json.loads(each.target)) < each.threshold)
    count, share = scanned(holds)
    windows = motion.crossings(condition, 0.0, span)
    assert len(windows) >= count
    assert sum(windows.duration > t[1]) == pytest.approx(count, abs=len(windows) - count)
    assert windows.duration.sum() / span == pytest.approx(share, abs=2e-4)
    assert inside(windows, t[holds]).all()
    assert not inside(windows, t[~holds]).any()


def inside(windows, t):
    begun = np.searchsorted(windows.start.seconds, t, side="right")
    return begun > np.searchsorted(windows.stop.seconds, t, side="left")


def test_ends_are_roots_by_scipy_of_the_same_motion():
    motion = tumbler(3, EPOCH)
    windows = motion.crossings(angle("-y", to="sun") < 50 * u.deg, 0.0, 20_000.0)
    assert len(windows) > 20

    def value(t):
        return float(motion.at(t).angle("-y", "sun")) - 50 * DEG

    for t in (*windows.start.seconds, *windows.stop.seconds):
        if 0.0 < t < 20_000.0:
            assert brentq(value, t - 1e-3, t + 1e-3, xtol=1e-13) == pytest.approx(t, abs=END)


TARGETS = ("sun", "earth", "velocity", "orbit_normal", "momentum", "magnetic_field", [1.0, -2.0, 0.5])
TARGETS += ({"body_axis": [1.0, 1.0, 0.0]}, {"position": [0.0, 0.0, 6378137.0]})
ELLIPSE = {"eccentricity": 0.2, "semi_major_axis": {"value": 9000.0, "unit": "km"}}
GRADIENT = {"type": "gravity_gradient"}
TORQUE = {
    "type": "constant_torque",
    "torque": {"value": [1e-5, -2e-5, 3e-5], "unit": "N m"},
    "frame": "body",
}


@pytest.mark.parametrize("effects", [[], [GRADIENT, TORQUE]], ids=["free", "under torques"])
@pytest.mark.parametrize("to", TARGETS, ids=str)
def test_bounds_hold_for_every_target(to, effects, monkeypatch):
    """Between any two instants the angle changes by no more than the bound says, and not by far less."""
    from attitude.windows import bounded_functions, window_table

    kept = {}
    monkeypatch.setattr(window_table, "find_windows", lambda motion, *_: kept.setdefault("motion", motion))
    scene = document(effects=effects, orbit=ELLIPSE)
    scene.crossings(angle("z", to=to) < 1.0)
    (condition,) = (angle("z", to=to) < 1.0).elementary()
    function = bounded_functions.bounded_function(kept["motion"], condition)
    step = 2.0
    t = np.arange(0.0, 6000.0, step)
    sample = function(t, np.zeros_like(t))
    reach = function.max_rate(sample.state, np.full(t.size, step)) * step
    changes = np.abs(np.diff(sample.values))
    assert (changes <= reach[:-1]).all()
    if to not in ("momentum", {"body_axis": [1.0, 1.0, 0.0]}):
        assert (changes / reach[:-1]).max() > 0.2


@pytest.mark.parametrize("kind", ["umbra", "penumbra", "cylinder"])
def test_shadow_windows_are_those_of_a_scan(kind):
    scene = document(times={"start": 0, "stop": 1, "count": 20_001, "unit": "d"})
    windows = scene.crossings(in_shadow(kind))
    ephemeris = scene.run()
    from attitude.frames.celestial import shadow_heights, sun_at

    side = {"umbra": -1.0, "penumbra": 1.0, "cylinder": 0.0}[kind]
    heights, _ = shadow_heights(ephemeris.position, sun_at(ephemeris.instants), 6378100.0, side)
    assert len(windows) == scanned(heights < 0.0)[0] == 15
    assert inside(windows, ephemeris.elapsed[heights < 0.0]).all()


# -- motions with jumps ---------------------------------------------------------------------------


def test_windows_across_an_impulse_are_those_of_the_scan():
    kick = {"type": "impulse", "frame": "body", "time": {"value": 1000.0, "unit": "s"}}
    kick["angular_impulse"] = {"value": [0.0, 0.4, 0.0], "unit": "N m s"}
    scene = document(effects=[kick], times={"start": 0, "stop": 3000, "count": 300_001, "unit": "s"})
    condition = angle("x", to="sun") < 30 * u.deg
    holds = scene.run().angle("x", "sun") < 30 * DEG
    windows = scene.crossings(condition)
    t = scene.run().elapsed
    assert len(windows) == scanned(holds)[0] > 20
    assert inside(windows, t[holds]).all()


SPIN_UP = {
    "torque": {
        "type": "constant_torque",
        "frame": "body",
        "torque": {"value": [0.0, 0.0, 1e-3], "unit": "N m"},
    },
    "impulse": {
        "type": "impulse",
        "frame": "body",
        "time": {"value": 10.0, "unit": "s"},
        "angular_impulse": {"value": [0.0, 0.0, 0.2], "unit": "N m s"},
    },
}


@pytest.mark.parametrize("effect", SPIN_UP.values(), ids=SPIN_UP)
def test_windows_of_a_body_that_is_spun_up_are_those_of_the_scan(effect):
    """A millionth of its turn at the start would be hours."""
    scene = document(
        angular_velocity={"value": [0.0, 1e-10, 1e-9], "unit": "rad/s"},
        effects=[effect],
        times={"start": 0, "stop": 400, "count": 40_001, "unit": "s"},
    )
    windows, ephemeris = scene.crossings(angle("x", to=[0.0, 1.0, 0.0]) < 60 * u.deg), scene.run()
    holds = ephemeris.angle("x", [0.0, 1.0, 0.0]) < 60 * DEG
    assert len(windows) == scanned(holds)[0] > 5
    assert inside(windows, ephemeris.elapsed[holds]).all()


def test_impulse_at_the_epoch_turns_the_momentum_then_and_once():
    kick = {"type": "impulse", "frame": "body", "time": {"value": 0.0, "unit": "s"}}
    kick["angular_impulse"] = {"value": [40.0, 40.0, 0.0], "unit": "N m s"}
    times = {"start": -1000, "stop": 1000, "count": 2, "unit": "s"}
    scene = document(effects=[kick], times=times)
    before, after = (float(scene.run().resampled([t]).angle("x", "momentum")[0]) for t in (-1e-6, 0.0))
    windows = scene.crossings(angle("x", to="momentum") < 0.5 * (before + after))
    assert 0.0 in [*windows.start.seconds, *windows.stop.seconds]


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("seconds", [1000.0, 3000.0], ids=["within", "last instant"])
def test_window_of_the_momentum_that_an_impulse_ends_is_found_up_to_it(seconds, sign):
    """The body's axis nears its momentum, whose direction the impulse changes at once."""
    kick = {"type": "impulse", "frame": "body", "time": {"value": seconds, "unit": "s"}}
    kick["angular_impulse"] = {"value": [sign * 40.0, sign * 40.0, 0.0], "unit": "N m s"}
    times = {"start": 0, "stop": 3000, "count": 300_001, "unit": "s"}
    free = document(effects=[], times=times).run()
    nutation, t = free.angle("x", "momentum"), free.elapsed
    last = int(np.searchsorted(t, seconds)) - 1
    rising = nutation[last] > nutation[last - 1]
    limit = float(nutation[last - 20])  # crossed 0.2 s before the impulse
    condition = angle("x", to="momentum")
    condition = condition > limit if rising else condition < limit
    windows = document(effects=[kick], times=times).crossings(condition)
    expected = t[last - 19 : last + 1]
    assert inside(windows, expected).all()
    assert not inside(windows, t[last - 25 : last - 20]).any()


def test_windows_of_a_bouncing_body_end_where_it_comes_to_rest():
    scene = Scene.builtin("drop")
    windows = scene.crossings(angle("z", to=[0.0, 0.0, 1.0]) < 60 * u.deg)
    ephemeris = scene.run()
    holds = ephemeris.angle("z", [0.0, 0.0, 1.0]) < 60 * DEG
    assert len(windows) >= scanned(holds)[0]
    assert windows.span[1] <= ephemeris.elapsed[-1] + 1.0


# -- combination ----------------------------------------------------------------------------------


def test_conditions_combine_as_sets():
    motion = tumbler(5, EPOCH)
    a, b = angle("z", to=[0.0, 0.0, 1.0]) < 60 * u.deg, angle("x", to=[1.0, 0.0, 0.0]) < 70 * u.deg

    def total(condition):
        return motion.crossings(condition, 0.0, 3000.0).duration.sum()

    assert total(a) + total(~a) == pytest.approx(3000.0, abs=1e-6)
    assert total(a) + total(b) == pytest.approx(total(a & b) + total(a | b), abs=1e-6)
    assert total(~(a & b)) == pytest.approx(total(~a | ~b), abs=1e-9)
    assert total(a | ~a) == 3000.0
    assert len(motion.crossings(a | ~a, 0.0, 3000.0)) == 1
    assert len(motion.crossings(a & ~a, 0.0, 3000.0)) == 0
    both = {"axis": "z", "to": [0.0, 0.0, 1.0], "above": {"value": 20, "unit": "deg"}}
    between = motion.crossings(both | {"below": {"value": 60, "unit": "deg"}}, 0.0, 3000.0)
    assert between.duration.sum() == pytest.approx(
        total(a) - total(angle("z", to=[0.0, 0.0, 1.0]) < 20 * u.deg), abs=1e-6
    )


def test_crossings_that_two_functions_share_leave_no_slivers():
    motion = tumbler(5)
    same = above_plane("z", [1.0, 2.0, 3.0])
    mirrored = angle("-z", to=[1.0, 2.0, 3.0]) > 90 * u.deg
    assert len(motion.crossings(same & ~mirrored, 0.0, 500.0)) == 0
    assert len(motion.crossings(same | ~mirrored, 0.0, 500.0)) == 1


def test_document_and_expression_are_the_same_condition():
    condition = (angle("z", to="sun") < 10 * u.deg) & ~in_shadow() | above_plane("x", "orbit_normal")
    assert parse_condition(json.loads(json.dumps(condition.document()))) == condition


def test_positions_take_units():
    one = angle("z", to={"position": [7000.0, 0.0, 0.0] * u.km}) < 1.0
    other = angle("z", to={"position": [7e6, 0.0, 0.0]}) < 1.0
    assert list(one.elementary()) == list(other.elementary())


# -- results --------------------------------------------------------------------------------------


def test_table_has_dates_seconds_and_what_the_span_cuts_off():
    windows = document().crossings(in_shadow())
    columns = windows.columns()
    assert list(columns) == [
        "start",
        "stop",
        "start_s",
        "stop_s",
        "duration_s",
        "begins_before",
        "ends_after",
    ]
    since = (Time(columns["start"][1], scale="utc") - EPOCH).sec
    assert since == pytest.approx(columns["start_s"][1], abs=1e-9)
    plain = windows.to_dict()
    assert json.loads(windows.to_json()) == plain
    assert parse_condition(plain["condition"]) == in_shadow()
    lines = windows.to_csv().splitlines()
    assert lines[2].split(",") == list(columns)
    assert len(lines) == 3 + len(windows)
    assert windows.text().splitlines()[-1].startswith(f"{len(windows)} windows, ")


def test_windows_without_dates_have_seconds_alone():
    windows = spinner(epoch=None).crossings(angle("x", to=[1.0, 0.0, 0.0]) < 1.0, -5.0, 100.0)
    assert "start" not in windows.columns()
    assert windows.begins_before[0]


def test_never_is_no_window_and_always_is_one():
    motion = spinner()
    assert len(motion.crossings(angle("z", to=[0.0, 0.0, -1.0]) < 1.0, 0.0, 1e5)) == 0
    always = motion.crossings(angle("z", to=[0.0, 0.0, -1.0]) > 1.0, 0.0, 1e5)
    assert (always.duration.tolist(), always.begins_before[0], always.ends_after[0]) == ([1e5], True, True)


def test_a_body_at_rest_has_windows_of_what_moves():
    scene = document(angular_velocity={"value": [0.0, 0.0, 0.0], "unit": "deg/s"})
    windows = scene.crossings(angle("x", to="earth") < 60 * u.deg)
    period = 2.0 * np.pi * np.sqrt(6878100.0**3 / 3.986004e14)
    assert windows.start.seconds[1] - windows.start.seconds[0] == pytest.approx(period, rel=1e-6)
    nadir = scene.crossings(angle("x", to="nadir") < 60 * u.deg)
    assert (nadir.start.seconds == windows.start.seconds).all()


# -- refusals -------------------------------------------------------------------------------------


def test_value_that_stays_at_its_threshold_is_refused(monkeypatch):
    monkeypatch.setattr("attitude.windows.root_search.MAX_OPEN_INTERVALS", 1 << 16)
    motion = TorqueFreeMotion(RigidBody([1.0, 1.0, 2.0]), [1, 0, 0, 0], [0.1, 0, 0.1], order="wxyz")
    nutation = float(motion.at(0.0).angle("z", "momentum"))
    with pytest.raises(RegimeError, match="stays so close to the threshold"):
        motion.crossings(angle("z", to="momentum") < nutation, 0.0, 1e6)


REFUSED = {
    "no condition": ("sun", "condition: a JSON object"),
    "empty": ({}, "condition: one of axis, shadow, and, or, not; got nothing"),
    "two": ({"axis": "z", "to": "sun", "shadow": "umbra"}, "one of axis, shadow, and, or, not"),
    "unknown key": ({"axis": "z", "to": "sun", "belw": 1}, "did you mean 'below'"),
    "axis": ({"axis": "w", "to": "sun", "below": {"value": 1, "unit": "deg"}}, 'condition.axis: "x", "y"'),
    "target": ({"axis": "z", "to": "mars", "below": {"value": 1, "unit": "deg"}}, "condition.to: one of sun"),
    "no limit": ({"axis": "z", "to": "sun"}, "condition.below: an angle"),
    "no target": ({"axis": "z", "below": {"value": 1, "unit": "deg"}}, "exactly one of to, above_plane"),
    "limit": ({"axis": "z", "to": "sun", "below": {"value": 181, "unit": "deg"}}, "180 deg; got .181.* deg"),
    "unit": ({"axis": "z", "to": "sun", "below": {"value": 1, "unit": "m"}}, "condition.below.unit: a unit"),
    "number": ({"axis": "z", "to": "sun", "below": 10}, "condition.below: a JSON object"),
    "shadow": ({"shadow": "umbre"}, "did you mean 'umbra'"),
    "zero vector": (
        {"axis": "z", "to": [0, 0, 0], "below": {"value": 1, "unit": "deg"}},
        "condition.to: one",
    ),
    "inner": ({"and": [{"shadow": "umbra"}, {"not": {"axis": "q", "to": "sun"}}]}, r"condition.and\[1\].not"),
    "empty list": ({"or": []}, r"condition.or: 1 elements"),
    "deep": (json.loads('{"not":' * 30 + '{"shadow":"umbra"}' + "}" * 30), "in 20 levels"),
    "many": ({"or": [{"shadow": "umbra"}] * 101}, "at most 100 conditions"),
}


@pytest.mark.parametrize(("condition", "message"), REFUSED.values(), ids=REFUSED)
def test_faults_of_a_condition_are_named(condition, message):
    with pytest.raises(InputError, match=message):
        spinner().crossings(condition, 0.0, 1.0)


CONDITION = {"axis": "z", "to": [1.0, 0.0, 0.0], "below": {"value": 1.0, "unit": "rad"}}


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: spinner().crossings(CONDITION, 1.0, 1.0), InputError, "stop: an instant after start"),
        (lambda: spinner().crossings(CONDITION, [0.0, 1.0], 2.0), InputError, "start: one instant"),
        (lambda: spinner().crossings(CONDITION, 0.0, 2.0, 0.0), InputError, "width: a time above 0"),
        (
            lambda: spinner().crossings(in_shadow(), 0.0, 2.0),
            RegimeError,
            "shadow: this motion is of no scene",
        ),
        (lambda: spinner(epoch=None).crossings(angle("z", "sun") < 1.0, 0.0, 2.0), InputError, "epoch"),
        (lambda: spinner().crossings(angle("z", "earth") < 1.0, 0.0, 2.0), RegimeError, "orbit"),
        (lambda: angle("z", "sun") < 10 * u.m, InputError, "below: a unit of angle"),
        (lambda: two_bodies().crossings(CONDITION, 0.0, 1.0), InputError, "one body, such as"),
        (
            lambda: document(times={"elapsed": [5.0], "unit": "s"}).crossings(CONDITION),
            InputError,
            "times: instants that span a time",
        ),
        (
            lambda: document(orbit=AROUND_MARS).crossings(in_shadow()),
            RegimeError,
            "central body of this orbit is not the Earth",
        ),
    ],
    ids=["span", "list", "width", "orbit", "epoch", "nadir", "unit", "batch", "instant", "mars"],
)
def test_what_a_motion_lacks_is_named(call, error, message):
    with pytest.raises(error, match=message):
        call()


AROUND_MARS = {
    "semi_major_axis": {"value": 9000.0, "unit": "km"},
    "mu": {"value": 42828.0, "unit": "km3/s2"},
    "radius": {"value": 3396.0, "unit": "km"},
}


def two_bodies():
    return TorqueFreeMotion(
        RigidBody([[1.0, 1.5, 2.0], [1.0, 1.2, 2.0]]), [1, 0, 0, 0], [0, 0, 1], order="wxyz"
    )
