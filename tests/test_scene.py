"""The scene document: what it means, and every fault refused with path, value and what would be right."""

import contextlib
import copy
import gc
import json
import weakref
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from astropy.time import Time
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from attitude import (
    AttitudeError,
    FormatError,
    InputError,
    RigidBody,
    Scene,
    ToleranceError,
    TorqueFreeMotion,
)
from attitude.scene.document import builtin_names
from attitude.times.instants import Instants
from tests.bodies import ATTITUDE, ATTITUDE_TOLERANCE

DOCUMENT = {
    "name": "debris",
    "body": {"moments": [1.0, 1.6, 2.1], "unit": "kg m2"},
    "epoch": {"time": "2020-01-01T00:00:00", "scale": "utc"},
    "frame": "GCRF",
    "attitude": {"quaternion": list(ATTITUDE), "order": "wxyz"},
    "angular_velocity": {"value": [0.3, -0.5, 0.9], "unit": "rad/s"},
    "times": {"start": 0, "stop": 60, "step": 0.5, "unit": "s"},
    "effects": [],
}
GONE = object()
# One product of a value with its unit, rounded; one part in 2^100 where both parts are kept.
UNIT_ROUNDING = 2.0**-52
TWO_PART_TOLERANCE = 2.0**-100


def changed(**parts):
    """The document with members replaced, or taken away where they are GONE."""
    document = {**copy.deepcopy(DOCUMENT), **parts}
    return {name: part for name, part in document.items() if part is not GONE}


def run(**parts):
    return Scene.model_validate(changed(**parts)).run()


def at_epoch(**parts):
    """R of the attitude at the epoch."""
    return run(times={"elapsed": [0], "unit": "s"}, **parts).rotation[0].as_matrix()


# -- what a document means ----------------------------------------------------------------------


def test_scene_is_the_motion_it_describes():
    ephemeris = run()
    motion = TorqueFreeMotion(
        RigidBody((1.0, 1.6, 2.1)), ATTITUDE, (0.3, -0.5, 0.9), Time("2020-01-01", scale="utc"), order="wxyz"
    )
    expected = motion.at(np.arange(121) * 0.5)
    assert np.array_equal(ephemeris.quaternion("wxyz"), expected.quaternion("wxyz"))
    assert np.array_equal(ephemeris.angular_velocity, expected.angular_velocity)
    assert (ephemeris.name, ephemeris.frame) == ("debris", "GCRF")
    assert ephemeris.epoch == motion.epoch


def test_euler_angles_carry_inertial_axes_onto_body_axes_one_after_another():
    # a quarter turn about Z carries X onto Y; one about the new X then carries Z onto the old X
    R = at_epoch(attitude={"euler": [90, 90, 0], "sequence": "ZXZ", "unit": "deg"})
    x_body, y_body, z_body = R.T
    assert np.allclose([x_body, y_body, z_body], [[0, 1, 0], [0, 0, 1], [1, 0, 0]], atol=ATTITUDE_TOLERANCE)


SEQUENCES = ["".join(axes) for axes in product("XYZ", repeat=3) if axes[0] != axes[1] != axes[2]]


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_euler_angles_of_any_sequence_are_scipys_intrinsic_ones(sequence):
    for angles in ([20.0, -75.0, 130.0], [-179.0, 181.0, 361.0], [0.0, 90.0, 0.0], [0.0, 0.0, 0.0]):
        R = at_epoch(attitude={"euler": angles, "sequence": sequence, "unit": "deg"})
        expected = Rotation.from_euler(sequence, angles, degrees=True).as_matrix()
        assert np.abs(R - expected).max() <= 4 * ATTITUDE_TOLERANCE


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1.0, 3.0, 3.2, 6.0])
def test_every_form_of_one_attitude_is_the_same_attitude(angle):
    rotation = Rotation.from_rotvec(angle * np.array([2.0, -1.0, 2.0]) / 3)
    forms = [
        {"quaternion": rotation.as_quat().tolist(), "order": "xyzw"},
        {"quaternion": rotation.as_quat(scalar_first=True).tolist(), "order": "wxyz"},
        {"matrix": rotation.as_matrix().tolist()},
        {"mrp": rotation.as_mrp().tolist()},
        {
            "mrp": (np.tan(angle / 4) * np.array([2.0, -1.0, 2.0]) / 3).tolist()
        },  # beyond half a turn: longer than 1
        {"euler": rotation.as_euler("ZXZ" if angle > 1e-3 else "XYZ").tolist(), "unit": "rad"},
    ]
    forms[-1]["sequence"] = "ZXZ" if angle > 1e-3 else "XYZ"
    for form in forms:
        assert np.abs(at_epoch(attitude=form) - rotation.as_matrix()).max() <= 4 * ATTITUDE_TOLERANCE


@pytest.mark.parametrize("length", [1e9, 1e160, 1e300])
def test_rodrigues_parameters_however_long_are_all_but_a_whole_turn(length):
    assert (
        np.abs(at_epoch(attitude={"mrp": [0, length, 0]}) - np.eye(3)).max()
        <= 4 / length + ATTITUDE_TOLERANCE
    )


def test_numbers_are_in_the_unit_beside_them():
    scene = Scene.model_validate(
        changed(
            body={"moments": [1.0, 1.6, 2.1], "unit": "g cm2"},
            angular_velocity={"value": [1.0, 2.0, 3.0], "unit": "deg/h"},
        )
    )
    motion = scene.motion()
    assert motion.body.moments == pytest.approx(np.array([1.0, 1.6, 2.1]) * 1e-7, rel=UNIT_ROUNDING)
    rate = motion.at(0.0).angular_velocity
    assert rate == pytest.approx(np.radians([1.0, 2.0, 3.0]) / 3600, rel=ATTITUDE_TOLERANCE)


def test_tensor_is_taken_as_a_tensor():
    tensor = [[199.0, 0.6, -0.2], [0.6, 201.0, 0.1], [-0.2, 0.1, 262.0]]
    scene = Scene.model_validate(changed(body={"tensor": tensor, "unit": "kg m2"}))
    assert scene.motion().body.tensor.tolist() == tensor


TENTH, THREE_TENTHS = Fraction(0.1), Fraction(0.3)
GRIDS = {
    "step": ({"start": 0, "stop": 1, "step": 0.1, "unit": "s"}, [k * TENTH for k in range(11)]),
    "step rounded past stop": (
        {"start": 0, "stop": 0.9, "step": 0.3, "unit": "s"},
        [k * THREE_TENTHS for k in range(4)],
    ),
    "step rounded before stop": (
        {"start": 0, "stop": 0.3, "step": 0.1, "unit": "s"},
        [k * TENTH for k in range(4)],
    ),
    "span rounded below its steps": (
        {"start": 1000, "stop": 1000.3, "step": 0.1, "unit": "s"},
        [1000 + k * TENTH for k in range(4)],
    ),
    "stop between steps": (
        {"start": 0, "stop": 0.99, "step": 0.1, "unit": "s"},
        [k * TENTH for k in range(10)],
    ),
    "step over no span": ({"start": 5, "stop": 5, "step": 1, "unit": "min"}, [300]),
    "start before the epoch": ({"start": -2, "stop": 2, "step": 3, "unit": "h"}, [-7200, 3600]),
    "count": ({"start": 0, "stop": 1, "count": 4, "unit": "d"}, [0, 28800, 57600, 86400]),
    "count of both ends": ({"start": -0.1, "stop": 0.1, "count": 2, "unit": "s"}, [-TENTH, TENTH]),
    "count of one": ({"start": 7, "stop": 7, "count": 1, "unit": "s"}, [7]),
    "count over no span": ({"start": 7, "stop": 7, "count": 3, "unit": "s"}, [7, 7, 7]),
    "minutes": ({"elapsed": [3, 0.1, -2], "unit": "min"}, [180, 60 * TENTH, -120]),
    "days": ({"elapsed": [0.1], "unit": "d"}, [86400 * TENTH]),
    "milliseconds": ({"elapsed": [0.1], "unit": "ms"}, [TENTH / 1000]),
}


@pytest.mark.parametrize(("times", "seconds"), GRIDS.values(), ids=GRIDS)
def test_times_are_exact_in_two_parts(times, seconds):
    instants = Scene.model_validate(changed(times=times)).run().instants
    rest = np.zeros(instants.shape) if instants.seconds_low is None else instants.seconds_low
    assert len(instants.seconds) == len(seconds)
    for high, low, exact in zip(instants.seconds.tolist(), rest.tolist(), seconds, strict=True):
        assert abs(Fraction(high) + Fraction(low) - exact) <= TWO_PART_TOLERANCE * abs(exact)


@pytest.mark.parametrize("last", [1e6, 123456.789, 1e-7])
def test_counted_grid_ends_where_it_says(last):
    instants = run(times={"start": 0.1, "stop": last + 0.1, "count": 1001, "unit": "s"}).instants
    assert (instants.seconds[0], instants.seconds[-1]) == (0.1, last + 0.1)


@pytest.mark.parametrize("scale", ["utc", "tai", "tt", "tdb"])
def test_dates_are_in_their_own_scale(scale):
    ephemeris = run(
        times={"dates": ["2020-01-01T00:00:00", "2020-01-02 12:00:00.5", "2020-01-03"], "scale": scale}
    )
    assert ephemeris.time.scale == scale
    expected = Time(["2020-01-01T00:00:00.0", "2020-01-02T12:00:00.5", "2020-01-03T00:00:00.0"], scale=scale)
    assert np.abs((ephemeris.time - expected).sec).max() == 0.0
    assert np.abs((expected.tai - Time("2020-01-01", scale="utc").tai).sec - ephemeris.elapsed).max() < 1e-9


def test_date_of_utc_may_end_in_z_and_be_a_leap_second():
    dates = ["2016-12-31T23:59:60Z", "2017-01-01T00:00:00Z"]
    epoch = {"time": "2016-12-31T23:59:59Z", "scale": "utc"}
    elapsed = run(epoch=epoch, times={"dates": dates, "scale": "utc"}).elapsed
    assert np.abs(elapsed - [1, 2]).max() < 1e-9


def test_epoch_and_frame_may_be_left_out():
    ephemeris = run(epoch=GONE, frame=GONE, name=GONE, effects=GONE)
    assert (ephemeris.epoch, ephemeris.frame, ephemeris.name) == (None, "ICRF", "")


# -- in and out ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", builtin_names())
def test_built_in_scene_runs_and_says_where_it_comes_from(name):
    scene = Scene.builtin(name)
    assert scene.name
    assert scene.description
    ephemeris = scene.run()
    assert len(ephemeris) == scene.times.samples > 50
    assert np.isfinite(ephemeris.quaternion("wxyz")).all()
    assert np.isfinite(ephemeris.angular_velocity).all()


@pytest.mark.parametrize("name", builtin_names())
def test_document_comes_back_as_it_was(name):
    scene = Scene.builtin(name)
    again = Scene.from_json(scene.to_json())
    assert again == scene
    assert again.document() == scene.document()
    assert again.to_json() == scene.to_json()


def test_document_holds_what_was_given_and_no_more():
    document = changed(epoch=GONE, frame=GONE)
    assert Scene.model_validate(document).document() == document
    assert Scene(**document) == Scene.model_validate(document)


def test_scene_is_read_from_a_file(tmp_path):
    (tmp_path / "scene.json").write_text(json.dumps(DOCUMENT), encoding="utf-8")
    assert Scene.read(tmp_path / "scene.json") == Scene.model_validate(DOCUMENT)


def test_scene_does_not_change():
    scene = Scene.model_validate(DOCUMENT)
    with pytest.raises(Exception, match="frozen"):
        scene.name = "other"


# -- faults of a document -----------------------------------------------------------------------

POSITIVE = "positive principal moments"
TRIANGLE = "no principal moment greater than the sum of the other two"
REQUIRED = r"a value \(the field is required\); got nothing"
UNKNOWN = r"no such key \(unknown keys are refused\)"
MOMENT_UNIT = 'a unit of moment of inertia, such as "kg m2"'
RATE_UNIT = 'a unit of angular .*, such as "rad/s", "deg/s" or "deg/d"'
TIME_UNIT = 'a unit of time, such as "s", "min", "h" or "d"'
DATE = r"a date such as 2026-01-01T00:00:00 \(ISO 8601\)"
FRAME = "an inertial frame, one of ICRF, GCRF, EME2000, ECLIPJ2000, INERTIAL"
ONE_ATTITUDE = "exactly one of euler, quaternion, matrix, mrp"
ONE_TIMES = "exactly one of start, elapsed, dates"
SCALE = "one of 'utc', 'tai', 'tt', 'tdb', 'tcb', 'tcg' or 'ut1'"
EYE = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]


def moments(*values, unit="kg m2", **more):
    return {"body": {"moments": list(values), "unit": unit, **more}}


def tensor(*rows):
    return {"body": {"tensor": list(rows), "unit": "kg m2"}}


def epoch(time, scale="utc"):
    return {"epoch": {"time": time, "scale": scale}}


def attitude(**form):
    return {"attitude": form}


def rate(*value, unit="rad/s"):
    return {"angular_velocity": {"value": list(value), "unit": unit}}


def times(**form):
    return {"times": form}


def grid(start=0, stop=60, unit="s", **more):
    return times(start=start, stop=stop, unit=unit, **more)


# Members changed, the pointer to the fault, the message.
FAULTS = {
    "no body": ({"body": GONE}, "/body", REQUIRED),
    "body of another form": ({"body": [1, 2, 2]}, "/body", "a JSON object; got"),
    "no inertia": ({"body": {"unit": "kg m2"}}, "/body", "exactly one of moments, tensor; got nothing"),
    "two inertias": (
        moments(1, 1, 1, tensor=EYE),
        "/body",
        "exactly one of moments, tensor; got 'moments and tensor'",
    ),
    "zero moment": (moments(0, 1, 1), "/body/moments/0", f"{POSITIVE}; got 0.0"),
    "negative moment": (moments(1, -1, 1), "/body/moments/1", f"{POSITIVE}; got -1.0"),
    "NaN moment": (moments(1, 1, float("nan")), "/body/moments/2", "a finite number; got nan"),
    "infinite moment": (moments(float("inf"), 1, 1), "/body/moments/0", "a finite number; got inf"),
    "moment of thousands of digits": (
        moments(10**400, 1, 1),
        "/body/moments/0",
        "a number in the range of a double",
    ),
    "moment too great": (moments(1, 1, 2.1), "/body/moments/2", f"{TRIANGLE}.*; got 2.1"),
    "two moments": (moments(1, 1), "/body/moments", "3 elements; got \\[1, 1\\]"),
    "four moments": (moments(1, 1, 1, 1), "/body/moments", "3 elements"),
    "moment of text": (moments("1", 1, 1), "/body/moments/0", "a number; got '1'"),
    "moment of truth": (moments(True, 1, 1), "/body/moments/0", "a number; got True"),
    "moment missing": (moments(1, None, 1), "/body/moments/1", "a number; got nothing"),
    "moments beyond a double": (
        moments(1e300, 1e300, 1e300, unit="1e300 kg m2"),
        "/body/moments/0",
        "finite numbers",
    ),
    "moments vanish in SI": (
        moments(1e-300, 1e-300, 1e-300, unit="1e-300 kg m2"),
        "/body/moments/0",
        POSITIVE,
    ),
    "no unit of moments": ({"body": {"moments": [1, 1, 1]}}, "/body/unit", REQUIRED),
    "unit of mass": (moments(1, 1, 1, unit="kg"), "/body/unit", f"{MOMENT_UNIT}; got 'kg'"),
    "unknown unit": (moments(1, 1, 1, unit="stone ell2"), "/body/unit", f"{MOMENT_UNIT}; got 'stone ell2'"),
    "unit left empty": (moments(1, 1, 1, unit=""), "/body/unit", MOMENT_UNIT),
    "unit of no text": (moments(1, 1, 1, unit=5), "/body/unit", "text; got 5"),
    "asymmetric tensor": (
        tensor([1, 0.5, 0], [0, 1, 0], [0, 0, 1]),
        "/body/tensor/0/1",
        "a symmetric tensor",
    ),
    "ragged tensor": (tensor([1, 0, 0], [0, 1], [0, 0, 1]), "/body/tensor/1", "3 elements"),
    "tensor of two rows": (tensor([1, 0, 0], [0, 1, 0]), "/body/tensor", "3 elements"),
    "key of a part unknown": (moments(1, 1, 1, weight=3), "/body/weight", f"{UNKNOWN}; got 3"),
    "key unknown": ({"colour": "red"}, "/colour", f"{UNKNOWN}; got 'red'"),
    "key with a dot": ({"a.b": 1}, "/a.b", UNKNOWN),
    "key with a slash": ({"a/b~c": 1}, "/a~1b~0c", UNKNOWN),
    "key with a bracket": ({"a[0]": 1}, "/a[0]", UNKNOWN),
    "key of nothing": ({"": 1}, "/", UNKNOWN),
    "name of no text": ({"name": 5}, "/name", "text; got 5"),
    "name of half a surrogate pair": ({"name": "\ud800"}, "/name", "text without half surrogate pairs"),
    "epoch in no month": (epoch("2020-13-01T00:00:00"), "/epoch/time", f"{DATE}; got '2020-13-01T00:00:00'"),
    "epoch of a word": (epoch("yesterday"), "/epoch/time", DATE),
    "epoch by its year": (epoch("J2000.0"), "/epoch/time", DATE),
    "epoch in a time zone": (epoch("2020-01-01T00:00:00+01:00"), "/epoch/time", DATE),
    "epoch of no text": (epoch(2020), "/epoch/time", "text; got 2020"),
    "epoch with a null": (epoch("2020-01-01\x00"), "/epoch/time", DATE),
    "Zulu time of another scale": (epoch("2020-01-01T00:00:00Z", "tt"), "/epoch/time", DATE),
    "leap second that never was": (epoch("2015-12-31T23:59:60"), "/epoch/time", "date|second"),
    "epoch without scale": ({"epoch": {"time": "2020-01-01"}}, "/epoch/scale", REQUIRED),
    "unknown scale": (epoch("2020-01-01", "gps"), "/epoch/scale", f"{SCALE}; got 'gps'"),
    "UT1 outside its tables": (epoch("1960-01-01", "ut1"), "/epoch/time", "UT1"),
    "rotating frame": ({"frame": "ITRF"}, "/frame", f"{FRAME}; got 'ITRF'"),
    "no frame": ({"frame": None}, "/frame", "text; got nothing"),
    "no attitude": ({"attitude": GONE}, "/attitude", REQUIRED),
    "attitude of no form": (attitude(), "/attitude", ONE_ATTITUDE),
    "attitude of two forms": (
        attitude(mrp=[0, 0, 0], matrix=EYE),
        "/attitude",
        f"{ONE_ATTITUDE}; got 'matrix and mrp'",
    ),
    "missing order": (
        attitude(quaternion=[1, 0, 0, 0]),
        "/attitude/order",
        '"wxyz" or "xyzw" beside quaternion; got nothing',
    ),
    "unknown order": (
        attitude(quaternion=[1, 0, 0, 0], order="wzyx"),
        "/attitude/order",
        '"wxyz" or "xyzw"; got \'wzyx\'',
    ),
    "zero quaternion": (
        attitude(quaternion=[0, 0, 0, 0], order="wxyz"),
        "/attitude/quaternion",
        "a unit quaternion, within 1e-6",
    ),
    "quaternion off unit": (
        attitude(quaternion=[1.1, 0, 0, 0], order="wxyz"),
        "/attitude/quaternion",
        "a unit quaternion, within 1e-6.*; got 1.1",
    ),
    "huge quaternion": (
        attitude(quaternion=[1e300, 0, 0, 0], order="wxyz"),
        "/attitude/quaternion",
        "a unit quaternion",
    ),
    "quaternion of three": (
        attitude(quaternion=[1, 0, 0], order="wxyz"),
        "/attitude/quaternion",
        "4 elements",
    ),
    "order beside another form": (
        attitude(mrp=[0, 0, 0], order="wxyz"),
        "/attitude/order",
        "no order beside mrp",
    ),
    "unit beside a quaternion": (
        attitude(quaternion=[1, 0, 0, 0], order="wxyz", unit="deg"),
        "/attitude/unit",
        "no unit beside quaternion",
    ),
    "angles without sequence": (
        attitude(euler=[1, 2, 3], unit="deg"),
        "/attitude/sequence",
        "beside euler; got nothing",
    ),
    "angles without unit": (
        attitude(euler=[1, 2, 3], sequence="ZXZ"),
        "/attitude/unit",
        "beside euler; got nothing",
    ),
    "angles in metres": (
        attitude(euler=[1, 2, 3], sequence="ZXZ", unit="m"),
        "/attitude/unit",
        'a unit of angle, such as "deg" or "rad"; got \'m\'',
    ),
    "fixed axes": (
        attitude(euler=[1, 2, 3], sequence="zxz", unit="deg"),
        "/attitude/sequence",
        "three axes.*; got 'zxz'",
    ),
    "two axes": (attitude(euler=[1, 2, 3], sequence="ZX", unit="deg"), "/attitude/sequence", "three axes"),
    "one axis twice": (
        attitude(euler=[1, 2, 3], sequence="ZZX", unit="deg"),
        "/attitude/sequence",
        "three axes, no two neighbours the same",
    ),
    "matrix that mirrors": (
        attitude(matrix=[[1, 0, 0], [0, 1, 0], [0, 0, -1]]),
        "/attitude/matrix",
        "a proper rotation matrix",
    ),
    "matrix that stretches": (
        attitude(matrix=[[1, 0, 0], [0, 1.1, 0], [0, 0, 1]]),
        "/attitude/matrix",
        "orthonormal within 1e-6",
    ),
    "huge matrix": (
        attitude(matrix=[[1e300, 0, 0], [0, 1, 0], [0, 0, 1]]),
        "/attitude/matrix",
        "a proper rotation matrix",
    ),
    "parameters of two": (attitude(mrp=[0, 0]), "/attitude/mrp", "3 elements"),
    "no rate": ({"angular_velocity": GONE}, "/angular_velocity", REQUIRED),
    "rate without unit": ({"angular_velocity": {"value": [1, 2, 3]}}, "/angular_velocity/unit", REQUIRED),
    "rate of two": (rate(1, 2), "/angular_velocity/value", "3 elements"),
    "rate in metres": (rate(1, 2, 3, unit="m/s"), "/angular_velocity/unit", f"{RATE_UNIT}; got 'm/s'"),
    "rate in hertz": (rate(1, 2, 3, unit="Hz"), "/angular_velocity/unit", f"{RATE_UNIT}; got 'Hz'"),
    "rate beyond a double": (
        rate(1, 1e308, 1, unit="rad/ns"),
        "/angular_velocity/value/1",
        "finite numbers|rad/s",
    ),
    "no times": ({"times": GONE}, "/times", REQUIRED),
    "times of no form": (times(), "/times", f"{ONE_TIMES}; got nothing"),
    "times of two forms": (times(start=0, elapsed=[1]), "/times", f"{ONE_TIMES}; got 'start and elapsed'"),
    "no unit of time": (times(start=0, stop=1, step=1), "/times/unit", "a value beside start; got nothing"),
    "metres of time": (grid(unit="m", step=1), "/times/unit", f"{TIME_UNIT}; got 'm'"),
    "no stop": (times(start=0, step=1, unit="s"), "/times/stop", "a value beside start"),
    "stop before start": (
        grid(0, -1, step=1),
        "/times/stop",
        r"an instant not before start \(0.0\); got -1.0",
    ),
    "neither step nor count": (grid(), "/times", "exactly one of step, count; got nothing"),
    "step and count": (grid(step=1, count=3), "/times", "exactly one of step, count; got 'step and count'"),
    "step of zero": (grid(step=0), "/times/step", "greater than 0; got 0"),
    "step back": (grid(step=-1), "/times/step", "greater than 0; got -1"),
    "step too small to count": (grid(step=1e-300), "/times/step", r"fewer than 2\*\*53 instants"),
    "count of none": (grid(count=0), "/times/count", "greater than or equal to 1; got 0"),
    "count of one over a span": (
        grid(count=1),
        "/times/count",
        "at least 2 where stop is after start; got 1",
    ),
    "half a count": (grid(count=2.5), "/times/count", "integer; got 2.5"),
    "count of truth": (grid(count=True), "/times/count", "integer; got True"),
    "scale beside a span": (grid(step=1, scale="utc"), "/times/scale", "no scale beside start; got 'utc'"),
    "empty list": (times(elapsed=[], unit="s"), "/times/elapsed", r"at least one; got \[\]"),
    "missing value": (times(elapsed=[1, None], unit="s"), "/times/elapsed/1", "a number; got nothing"),
    "step beside a list": (times(elapsed=[1], unit="s", step=1), "/times/step", "no step beside elapsed"),
    "list without unit": (times(elapsed=[1]), "/times/unit", "a value beside elapsed"),
    "empty list of dates": (times(dates=[], scale="utc"), "/times/dates", "at least one"),
    "dates without scale": (times(dates=["2020-01-01"]), "/times/scale", "a value beside dates"),
    "date that is none": (
        times(dates=["2020-01-01", "tomorrow"], scale="utc"),
        "/times/dates/1",
        f"{DATE}; got 'tomorrow'",
    ),
    "date in no month": (times(dates=["2020-01-01", "2020-13-01"], scale="utc"), "/times/dates/1", DATE),
    "date of no text": (times(dates=["2020-01-01", 5], scale="utc"), "/times/dates/1", "text; got 5"),
    "dates of an unknown scale": (times(dates=["2020-01-01"], scale="gps"), "/times/scale", SCALE),
    "unit beside dates": (
        times(dates=["2020-01-01"], scale="utc", unit="s"),
        "/times/unit",
        "no unit beside dates",
    ),
    "dates without epoch": (
        {"epoch": GONE, **times(dates=["2020-01-01"], scale="utc")},
        "/times/dates",
        "an epoch in the scene, for dates to be counted from",
    ),
    "effect by its name": (
        {"effects": ["drag"]},
        "/effects/0",
        "an effect that this version simulates .*; got 'drag'",
    ),
    "effect by its type": (
        {"effects": [{"type": "tides"}]},
        "/effects/0/type",
        "an effect that this version simulates .uniform_gravity, ground, .*; got 'tides'",
    ),
    "key of an effect unknown": (
        {"effects": [{"type": "gravity_gradient", "rate": 1}]},
        "/effects/0/rate",
        f"{UNKNOWN}; got 1",
    ),
    "effects of another form": ({"effects": "drag"}, "/effects", "a list; got 'drag'"),
}


@pytest.mark.parametrize(("parts", "pointer", "message"), FAULTS.values(), ids=FAULTS)
def test_fault_is_refused_with_a_pointer_into_the_document(parts, pointer, message):
    with pytest.raises(InputError, match=message) as caught:
        run(**parts)
    error = caught.value
    assert error.pointer == pointer
    assert str(error).startswith(f"{error.field}: {error.expected}")
    assert "\n" not in str(error)
    part, last = parent(changed(**parts), pointer)
    assert error.value is None or holds(part, last)


def parent(document, pointer):
    """What the pointer goes through, and its last step."""
    *inner, last = [step.replace("~1", "/").replace("~0", "~") for step in pointer.split("/")[1:]]
    for step in inner:
        document = document[int(step)] if isinstance(document, list) else document[step]
    return document, last


def holds(part, step):
    return int(step) < len(part) if isinstance(part, list) else step in part


@pytest.mark.parametrize(
    "rows",
    [[[1, 0.5, 0], [0.5, 1, 0], [0, 0, 3]], [[1, 2, 0], [2, 1, 0], [0, 0, 1]]],
    ids=["triangle", "negative"],
)
def test_tensor_without_a_body_is_refused_as_a_tensor(rows):
    with pytest.raises(InputError, match=f"{POSITIVE}|{TRIANGLE}") as caught:
        run(**tensor(*rows))
    assert caught.value.pointer.startswith("/body/tensor")


@pytest.mark.parametrize("document", [None, [], 5, "scene", {1: 2}], ids=str)
def test_document_that_is_no_object_is_refused_as_a_whole(document):
    with pytest.raises(InputError, match="a JSON object") as caught:
        Scene.model_validate(document)
    assert caught.value.pointer == ""


def test_other_faults_are_named_beside_the_first():
    with pytest.raises(InputError, match=r"^body: .* \(also: attitude, angular_velocity, times\)$"):
        Scene()
    with pytest.raises(InputError, match=r"body.moments\[0\]: .*also: body.unit, colour"):
        Scene.model_validate(changed(body={"moments": ["1", 1, 1]}, colour="red"))


def test_many_faults_are_counted_and_few_are_told():
    with pytest.raises(InputError, match=r"also: .* and 81 more\)$") as caught:
        Scene.model_validate(changed(**{f"colour{i}": "red" for i in range(101)}))
    assert str(caught.value).count("colour") == 20


def test_faulty_list_of_instants_is_refused_at_its_first_fault():
    with pytest.raises(InputError, match=r"^times.elapsed\[0\]: a number; got ''$"):
        Scene.model_validate(changed(times={"elapsed": [""] * 100, "unit": "s"}))


def test_twin_of_a_key_among_many_is_found_at_once():
    """A count for each key took half a minute."""
    keys = "".join(f'"k{i}": 0, ' for i in range(100_000))
    with pytest.raises(InputError, match="k99999: each key once"):
        Scene.from_json(f'{{{keys}"k99999": 1}}')


def test_scene_made_in_python_is_refused_as_a_document_is():
    with pytest.raises(InputError, match=UNKNOWN) as caught:
        Scene(**DOCUMENT, colour="red")
    assert caught.value.pointer == "/colour"


# -- too much -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "instants",
    [
        grid(0, 1e15, step=1),
        grid(count=10**15),
        times(elapsed=list(range(1001)), unit="s"),
        times(dates=["2020-01-01"] * 1001, scale="utc"),
    ],
    ids=["step", "count", "elapsed", "dates"],
)
def test_too_many_samples_are_refused_before_they_are_made(instants):
    scene = Scene.model_validate(changed(**instants))
    assert scene.times.samples > 1000
    with pytest.raises(
        InputError, match=f"at most 1000 samples; got '{scene.times.samples} samples'"
    ) as caught:
        scene.run(max_samples=1000)
    assert caught.value.pointer == "/times"


def test_as_many_samples_as_the_limit_are_taken():
    assert len(Scene.model_validate(changed(**grid(0, 999, step=1))).run(max_samples=1000)) == 1000


@pytest.mark.parametrize("count", [2**53, 2**62, 10**30])
def test_more_samples_than_any_memory_holds_are_refused(count):
    with pytest.raises(InputError) as caught:
        run(**grid(count=count))
    assert caught.value.pointer.startswith("/times")


STILL = rate(0, 0, 0)


@pytest.mark.parametrize("moving", [{}, STILL], ids=["moving", "still"])
@pytest.mark.parametrize(
    "instants",
    [
        grid(-1e308, 1e308, count=3),
        grid(-1e308, 1e308, step=1e308),
        grid(0, 1e308, unit="d", count=3),
        times(elapsed=[0, 1e305], unit="d"),
        times(elapsed=[0, 1e302], unit="Gyr"),
    ],
    ids=["span overflows", "step overflows", "unit overflows", "value overflows", "value overflows by far"],
)
def test_times_that_no_double_holds_never_become_nan(instants, moving):
    try:
        ephemeris = run(**instants, **moving)
    except (InputError, ToleranceError):
        return
    assert np.isfinite(ephemeris.quaternion("wxyz")).all()
    assert np.isfinite(ephemeris.elapsed).all()


def test_time_too_far_for_the_phases_names_the_limit():
    with pytest.raises(ToleranceError, match=r"is beyond .* s"):
        run(**grid(0, 1e20, count=3, unit="d"))


# -- JSON text ----------------------------------------------------------------------------------

TEXT = json.dumps(DOCUMENT)

TEXTS = {
    "NaN": (TEXT.replace("1.6", "NaN"), InputError, "finite numbers .*; got 'NaN'"),
    "Infinity": (TEXT.replace("1.6", "Infinity"), InputError, "finite numbers .*; got 'Infinity'"),
    "-Infinity": (TEXT.replace("1.6", "-Infinity"), InputError, "finite numbers .*; got '-Infinity'"),
    "number beyond a double": (
        TEXT.replace("1.6", "1e400"),
        InputError,
        r"body.moments\[1\]: a finite number",
    ),
    "number of 5000 digits": (
        TEXT.replace("1.6", "1" * 5000),
        FormatError,
        "not JSON that can be read.*5000 digits",
    ),
    "key twice": (
        TEXT.replace('"frame"', '"name": "x", "frame"'),
        InputError,
        "name: each key once; got 'the key twice'",
    ),
    "inner key twice": (
        TEXT.replace('"order"', '"order": "xyzw", "order"'),
        InputError,
        "order: each key once",
    ),
    "cut": (TEXT[:-1], FormatError, "line 1: not JSON"),
    "cut in a later line": ("{\n\n" + TEXT[1:-20], FormatError, "line 3: not JSON"),
    "empty": ("", FormatError, "line 1: not JSON"),
    "more than JSON": (TEXT + "x", FormatError, "line 1: not JSON: Extra data"),
    "comment": ("// scene\n" + TEXT, FormatError, "line 1: not JSON"),
    "bytes that are no text": (b"\xff\xff" + TEXT.encode(), FormatError, "not JSON"),
    "lists without end": ("[" * 100_000, FormatError, "not JSON that can be read: nested too deeply"),
    "objects without end": ('{"a":' * 100_000, FormatError, "not JSON that can be read: nested too deeply"),
    "a list": ("[]", InputError, "a JSON object"),
}


@pytest.mark.parametrize(("text", "kind", "message"), TEXTS.values(), ids=TEXTS)
def test_text_is_refused(text, kind, message):
    with pytest.raises(kind, match=message) as caught:
        Scene.from_json(text, "a.json")
    assert "\n" not in str(caught.value)
    if kind is FormatError:
        assert caught.value.source == "a.json"
        assert str(caught.value).startswith("a.json")


@pytest.mark.parametrize("depth", [10, 100, 500, 900, 990])
def test_nesting_of_any_depth_is_refused(depth):
    nested = "[" * depth + "]" * depth
    with pytest.raises(AttitudeError):
        Scene.from_json(TEXT.replace('"effects": []', f'"effects": {nested}'))


EDGES = [
    None,
    True,
    "",
    "s",
    0,
    -1,
    0.5,
    1e-320,
    1e308,
    -1e308,
    10**400,
    2**63,
    float("nan"),
    [],
    {},
    [0, 0, 0],
]
JUNK = st.recursive(
    st.sampled_from(EDGES) | st.floats() | st.integers() | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=5,
)
FORMS = [
    {},
    tensor([2, 0.1, 0], [0.1, 2, 0], [0, 0, 3]),
    attitude(euler=[1, 2, 3], sequence="ZXZ", unit="deg"),
    attitude(matrix=EYE),
    attitude(mrp=[0.1, 0.2, 0.3]),
    grid(count=5),
    times(elapsed=[1, 2, 3], unit="s"),
    times(dates=["2020-01-01", "2020-01-02"], scale="utc"),
]


def places(part):
    """Every member of a document, at any depth, as (container, key)."""
    members = part.items() if isinstance(part, dict) else enumerate(part) if isinstance(part, list) else ()
    for key, inner in list(members):
        yield part, key
        yield from places(inner)


@pytest.mark.filterwarnings("ignore:ERFA function:erfa.ErfaWarning")
@settings(max_examples=600, deadline=None, database=None, derandomize=True)
@given(
    st.sampled_from(FORMS),
    st.lists(st.tuples(st.floats(0, 1, exclude_max=True), JUNK), min_size=1, max_size=2),
)
def test_any_junk_in_a_document_is_refused_or_gives_attitudes(form, junk):
    document = changed(**copy.deepcopy(form))
    for where, value in junk:
        found = list(places(document))
        part, key = found[int(where * len(found))]
        part[key] = copy.deepcopy(value)
    with contextlib.suppress(AttitudeError):
        ephemeris = Scene.model_validate(document).run(max_samples=1000)
        assert np.isfinite(ephemeris.quaternion("wxyz")).all()
        assert np.isfinite(ephemeris.angular_velocity).all()


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("missing.json", "cannot be read"),
        (".", "cannot be read"),
        ("a\0.json", "cannot be read"),
        ("x" * 300, "cannot be read"),
    ],
    ids=["missing", "folder", "null", "long"],
)
def test_file_that_cannot_be_read_is_said(path, message, tmp_path):
    with pytest.raises(FormatError, match=message) as caught:
        Scene.read(f"{tmp_path}/{path}")
    assert caught.value.source.startswith(str(tmp_path))


@pytest.mark.parametrize("name", ["pluto", "", "../scenes/toutatis", "toutatis.json"])
def test_unknown_built_in_scene_is_refused_with_those_there_are(name):
    with pytest.raises(InputError, match=f"one of {', '.join(builtin_names())}; got"):
        Scene.builtin(name)


def test_grid_of_a_dated_scene_builds_no_time(monkeypatch):
    def build(instants, epoch):
        raise AssertionError("a Time was built")

    monkeypatch.setattr(Instants, "_build_time", build)
    document = Scene.builtin("toutatis").document() | {
        "times": {"start": 0, "stop": 40, "count": 5000, "unit": "d"}
    }
    scene = Scene.model_validate(document)
    ephemeris = scene.run()
    assert (len(ephemeris), ephemeris.angular_velocity.shape) == (5000, (5000, 3))
    assert sum(len(chunk) for chunk in scene.chunks(700)) == 5000
    with pytest.raises(AssertionError, match="a Time was built"):
        _ = ephemeris.time


# Motions that are remembered


def test_same_body_asked_again_has_the_same_bits_and_an_epoch_of_its_own():
    document = Scene.builtin("toutatis").document()
    other = {**document, "times": {"elapsed": [1e6, 2e6], "unit": "s"}}
    scenes = [Scene.model_validate(each) for each in (document, other)]
    first, second = (scene.motion() for scene in scenes)
    assert (first.at(3e6).quaternion("wxyz") == second.at(3e6).quaternion("wxyz")).all()
    assert first.epoch is not second.epoch
    first.epoch = None
    assert scenes[0].motion().epoch is not None


@pytest.mark.parametrize(
    ("field", "changed"),
    [
        ("body", {"moments": [3.0836, 3.235, 1.1], "unit": "kg m2"}),
        ("attitude", {"quaternion": [1.0, 0.0, 0.0, 0.0], "order": "wxyz"}),
        ("angular_velocity", {"value": [14.51, 33.529, -98.8], "unit": "deg/d"}),
        ("frame", "ICRF"),
    ],
)
def test_whatever_makes_another_motion_is_not_taken_for_the_same(field, changed):
    document = Scene.builtin("toutatis").document()
    one, other = (Scene.model_validate(each).motion() for each in (document, {**document, field: changed}))
    assert (
        one.frame != other.frame or (one.at(1e6).quaternion("wxyz") != other.at(1e6).quaternion("wxyz")).any()
    )


def test_unit_that_no_text_holds_is_refused_like_any_other():
    document = Scene.builtin("toutatis").document()
    document["angular_velocity"]["unit"] = "\ud800"
    with pytest.raises(InputError, match=r"angular_velocity\.unit"):
        Scene.model_validate(document).motion()


def test_scene_is_not_kept_by_who_remembers_its_motion():
    """Of a document with a million dates only the body and its state are."""
    scene = Scene.model_validate(Scene.builtin("toutatis").document())
    scene.motion()
    gone = weakref.ref(scene)
    del scene
    gc.collect()
    assert gone() is None
