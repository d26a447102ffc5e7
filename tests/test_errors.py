"""The tree of exceptions; every argument that is refused, with its field and what would be right."""

import copy
import datetime
import pickle

import numpy as np
import pytest
from astropy import units as u
from astropy.time import Time, TimeDelta
from astropy.utils.masked import Masked

import attitude
from attitude import (
    AttitudeError,
    FormatError,
    InputError,
    RegimeError,
    RigidBody,
    ToleranceError,
    TorqueFreeMotion,
)

BODY = RigidBody((1.0, 2.0, 2.5))
EPOCH = Time("2020-01-01T00:00:00", scale="utc")
IDENTITY = (1.0, 0.0, 0.0, 0.0)


def motion(attitude=IDENTITY, rate=(0.1, 0.2, 0.3), body=BODY, order="wxyz", **arguments):
    return TorqueFreeMotion(body, attitude, rate, order=order, **arguments)


def dated():
    return motion(epoch=EPOCH)


# -- the tree -----------------------------------------------------------------------------------


def test_one_class_catches_all():
    named = [getattr(attitude, name) for name in attitude.__all__ if name.endswith("Error")]
    assert set(named) == {AttitudeError, InputError, RegimeError, ToleranceError, FormatError}
    assert all(issubclass(kind, AttitudeError) for kind in named)


def test_bad_value_is_pythons_value_error_too():
    assert issubclass(InputError, ValueError)
    assert not issubclass(FormatError, ValueError)


def test_input_error_says_field_what_is_right_and_what_was_found():
    error = InputError("body.moments[2]", -1.0, "positive moments")
    assert (error.field, error.value, error.expected) == ("body.moments[2]", -1.0, "positive moments")
    assert str(error) == "body.moments[2]: positive moments; got -1.0"


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "nothing"), ("a\nb", "'a\\nb'"), (np.eye(2), "array([[1., 0.], [0., 1.]])")],
    ids=["nothing", "text of two lines", "array of two lines"],
)
def test_value_found_stands_on_one_line(value, text):
    assert str(InputError("field", value, "else")) == f"field: else; got {text}"


def test_long_value_is_cut():
    text = str(InputError("field", "x" * 10_000, "less"))
    assert len(text) < 120
    assert text.endswith("...")


@pytest.mark.parametrize(
    ("field", "pointer"),
    [
        ("", ""),
        ("body", "/body"),
        ("body.moments[2]", "/body/moments/2"),
        ("body.tensor[0][1]", "/body/tensor/0/1"),
        ("a/b~c", "/a~1b~0c"),
    ],
)
def test_field_is_a_json_pointer(field, pointer):
    assert InputError(field, 0, "else").pointer == pointer


@pytest.mark.parametrize(
    ("source", "line", "text"),
    [("", None, "bad"), ("a.csv", None, "a.csv: bad"), ("a.csv", 7, "a.csv, line 7: bad")],
)
def test_format_error_says_file_and_line(source, line, text):
    error = FormatError("bad", source, line)
    assert (str(error), error.source, error.line) == (text, source, line)


@pytest.mark.parametrize(
    "again", [copy.copy, lambda error: pickle.loads(pickle.dumps(error))], ids=["copy", "pickle"]
)
@pytest.mark.parametrize(
    "error",
    [
        InputError("t[3]", -1.0, "positive"),
        FormatError("bad", "a.csv", 7),
        RegimeError("no"),
        ToleranceError("far"),
    ],
    ids=lambda error: type(error).__name__,
)
def test_errors_come_back_whole_from_a_worker_process(error, again):
    returned = again(error)
    assert type(returned) is type(error)
    assert str(returned) == str(error)
    assert vars(returned) == vars(error)


# -- arguments refused --------------------------------------------------------------------------

POSITIVE = "positive principal moments"
TRIANGLE = "no principal moment greater than the sum of the other two"
SECONDS = "seconds as floats, a Quantity, a TimeDelta, a Grid or .* a Time"

INERTIA = {
    "zero moment": ((1, 0, 1), "inertia[1]", POSITIVE),
    "negative moment": ((1, 1, -2.5), "inertia[2]", f"{POSITIVE}.*; got -2.5"),
    "NaN": ((1, np.nan, 1), "inertia[1]", "finite numbers; got nan"),
    "infinity": ((np.inf, 1, 1), "inertia[0]", "finite numbers; got inf"),
    "one moment too great": ((1, 1, 2.1), "inertia[2]", TRIANGLE),
    "one of a batch": ([(1, 1, 1), (5, 1, 1)], "inertia[1][0]", TRIANGLE),
    "tensor with a negative moment": (np.diag([1.0, -1.0, 1.0]), "inertia[1]", POSITIVE),
    "tensor that no body has": ([[1, 0.5, 0], [0.5, 1, 0], [0, 0, 3]], "inertia[2]", TRIANGLE),
    "asymmetric tensor": (
        [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]],
        "inertia[0][1]",
        "symmetric tensor .*mirrored element is 0.0",
    ),
    "asymmetric tensor of a batch": (
        [np.eye(3), np.eye(3) + np.eye(3, k=2)],
        "inertia[1][0][2]",
        "symmetric",
    ),
    "asymmetric beyond rounding": (np.eye(3) + 2e-6 * np.eye(3, k=1), "inertia[0][1]", "symmetric"),
    "two numbers": ((1, 2), "inertia", r"shape \(\.\.\., 3\) for moments or \(\.\.\., 3, 3\)"),
    "one number": (1.0, "inertia", "shape"),
    "nothing": (None, "inertia", "numbers"),
    "NaN alone": (np.nan, "inertia", "finite numbers"),
    "text": ("heavy", "inertia", "numbers; got 'heavy'"),
    "ragged": ([[1, 2, 3], [1, 2]], "inertia", "numbers"),
    "complex": ((1j, 1, 1), "inertia", "numbers"),
    "dates": (np.array(["2020-01-01"] * 3, dtype="datetime64[D]"), "inertia", "numbers"),
    "masked": (np.ma.array([1.0, 2.0, 2.0], mask=[0, 1, 0]), "inertia", "a value for every element"),
    "mass": ((1, 2, 2) * u.kg, "inertia", "unit of moment of inertia.*; got 'kg'"),
}


@pytest.mark.parametrize(("inertia", "field", "message"), INERTIA.values(), ids=INERTIA)
def test_inertia_refused(inertia, field, message):
    with pytest.raises(InputError, match=message) as caught:
        RigidBody(inertia)
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("moments", "field"), [((1, 1, -1), "inertia[2]"), ((1, 2), "moments"), (np.nan, "moments")], ids=str
)
def test_moments_refused(moments, field):
    with pytest.raises(InputError) as caught:
        RigidBody.from_moments(moments)
    assert caught.value.field == field


UNIT = "a unit quaternion, within 0.001.*; got"
ORDER = '"wxyz" or "xyzw"'
MISSING = "a (value|time) for every (element|instant)"

STATE = {
    "missing order": ({"order": None}, "order", f"{ORDER}, beside a bare array; got nothing"),
    "unknown order": ({"order": "WXYZ"}, "order", f"{ORDER}; got 'WXYZ'"),
    "order that is no text": ({"order": ["wxyz"]}, "order", ORDER),
    "zero quaternion": ({"attitude": (0, 0, 0, 0)}, "attitude", f"{UNIT} 0.0"),
    "quaternion off unit": ({"attitude": (1.002, 0, 0, 0)}, "attitude", f"{UNIT} 1.002"),
    "quaternion off unit in a batch": (
        {"attitude": [IDENTITY, (0.9, 0, 0, 0)]},
        "attitude[1]",
        f"{UNIT} 0.9",
    ),
    "huge quaternion": ({"attitude": (1e200, 0, 0, 0)}, "attitude", UNIT),
    "quaternion with NaN": ({"attitude": (1, 0, np.nan, 0)}, "attitude[2]", "finite numbers; got nan"),
    "three numbers": ({"attitude": (1, 0, 0)}, "attitude", r"Rotation or quaternions of shape \(\.\.\., 4\)"),
    "attitude of text": ({"attitude": "north"}, "attitude", "numbers"),
    "attitude missing": ({"attitude": None}, "attitude", "numbers|Rotation"),
    "rate of two": ({"rate": (1, 2)}, "angular_velocity", r"shape \(\.\.\., 3\); got 'shape \(2,\)'"),
    "rate of one number": ({"rate": 1.0}, "angular_velocity", "shape"),
    "rate with infinity": ({"rate": (1, np.inf, 2)}, "angular_velocity[1]", "finite numbers; got inf"),
    "rate masked": (
        {"rate": np.ma.array([1.0, 2, 3], mask=[1, 0, 0])},
        "angular_velocity",
        "a value for every element",
    ),
    "rate in metres": ({"rate": (1, 2, 3) * u.m / u.s}, "angular_velocity", "unit of angular.*; got 'm / s'"),
    "batches that do not meet": (
        {"attitude": [IDENTITY] * 2, "rate": [(1, 2, 3)] * 3},
        "angular_velocity",
        r"broadcast together; got .*attitudes \(2,\), angular velocities \(3,\)",
    ),
    "moments for a body": ({"body": (1, 2, 2)}, "body", "a RigidBody"),
    "rotating frame": ({"frame": "ITRF"}, "frame", "an inertial frame, one of ICRF, .*; got 'ITRF'"),
    "frame that is no text": ({"frame": ["ICRF"]}, "frame", "an inertial frame"),
    "no frame": ({"frame": None}, "frame", "an inertial frame"),
    "epoch of text": ({"epoch": "soon"}, "epoch", "a date such as 2026-01-01T00:00:00"),
    "epoch of days": (
        {"epoch": 2460000.5},
        "epoch",
        "a datetime, ISO 8601 text .UTC., or None; got 2460000.5",
    ),
    "two epochs": (
        {"epoch": Time(["2020-01-01"] * 2)},
        "epoch",
        r"one Time for all bodies; got 'shape \(2,\)'",
    ),
    "epoch missing": ({"epoch": Time(np.ma.array(2.4e6, mask=True), format="jd")}, "epoch", MISSING),
    "epoch in local time": ({"epoch": Time("2020-01-01", scale="local")}, "epoch", "brought to TAI"),
}


@pytest.mark.parametrize(("arguments", "field", "message"), STATE.values(), ids=STATE)
def test_state_refused(arguments, field, message):
    with pytest.raises(InputError, match=message) as caught:
        motion(**arguments)
    assert caught.value.field == field


TIMES = {
    "NaN": ([0.0, np.nan], "t[1]", "finite numbers; got nan"),
    "NaN alone": (np.nan, "t", "finite numbers; got nan"),
    "infinity in two dimensions": ([[0.0, 1.0], [np.inf, 2.0]], "t[1][0]", "finite numbers; got inf"),
    "nothing": (None, "t", "numbers|seconds"),
    "missing": (np.ma.array([1.0, 2.0], mask=[0, 1]), "t", MISSING),
    "missing seconds": (Masked([1.0, 2.0] * u.s, mask=[0, 1]), "t", MISSING),
    "missing minutes": (Masked([1.0, 2.0] * u.min, mask=[0, 1]), "t", MISSING),
    "NaN minutes": ([1.0, np.nan] * u.min, "t[1]", "finite numbers; got nan"),
    "missing date": (Time(np.ma.array([2.4e6, 2.4e6], mask=[0, 1]), format="jd"), "t[1]", MISSING),
    "missing date alone": (Time(np.ma.array(2.4e6, mask=True), format="jd"), "t", MISSING),
    "missing span": (TimeDelta(np.ma.array([1.0, 1.0], mask=[1, 0]), format="jd"), "t[0]", MISSING),
    "NaN span": (TimeDelta([1.0, np.nan], format="sec"), "t[1]", "; got nan"),
    "length": (3 * u.m, "t", r"a unit of time \(s\); got 'm'"),
    "bare ratio": (3 * u.one, "t", "a unit of time"),
    "text": ("soon", "t", "a date such as"),
    "list of text": (["2020-01-01", "2020-01-32"], "t[1]", "a date such as"),
    "text that is a number": (["5"], "t[0]", "a date such as"),
    "a date and a number": (["2020-01-01", 5.0], "t[1]", "a date such as"),
    "lists of several lengths": ([[1.0], [2.0, 3.0]], "t", SECONDS),
    "numpy's missing date": (np.array("NaT", dtype="datetime64[s]"), "t", MISSING),
    "numpy minutes": (np.timedelta64(3, "m"), "t", SECONDS),
    "Python's date": (datetime.date(2020, 1, 1), "t", SECONDS),
    "list of Times": ([EPOCH, EPOCH], "t", SECONDS),
    "complex": ([1j], "t", SECONDS),
    "local time": (Time("2020-01-01", scale="local"), "t", "brought to TAI"),
    "span of local time": (TimeDelta(3.0, format="sec", scale="local"), "t", "TAI or TT"),
}


@pytest.mark.parametrize(("t", "field", "message"), TIMES.values(), ids=TIMES)
def test_times_refused(t, field, message):
    with pytest.raises(InputError, match=message) as caught:
        dated().at(t)
    assert caught.value.field == field


@pytest.mark.parametrize("date", [EPOCH, "2020-01-01T00:00:00"], ids=str)
def test_date_without_an_epoch_is_refused(date):
    with pytest.raises(InputError, match="elapsed time, or an epoch for the motion to count from") as caught:
        motion().at(date)
    assert caught.value.field == "t"


def test_date_of_an_instant_without_an_epoch_is_refused():
    with pytest.raises(InputError, match="this ephemeris has elapsed seconds") as caught:
        _ = motion().at([1.0]).time
    assert caught.value.field == "epoch"


def test_span_of_another_scale_without_an_epoch_is_refused():
    with pytest.raises(InputError, match="or an epoch to count it from"):
        motion().at(TimeDelta(3.0, format="sec", scale="tdb"))


@pytest.mark.parametrize("t", [1e300, [-1e18, 0.0]], ids=["after", "before"])
def test_time_too_far_for_two_parts_names_the_limit(t):
    with pytest.raises(ToleranceError, match=r"is beyond .* s, .* turns"):
        motion().at(t)


@pytest.mark.parametrize("order", [None, "zyxw", "WXYZ", ["wxyz"]], ids=str)
def test_answer_in_an_unknown_order_is_refused(order):
    with pytest.raises(InputError, match=ORDER) as caught:
        motion().at([1.0]).quaternion(order)
    assert caught.value.field == "order"
