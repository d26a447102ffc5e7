"""STK attitude files as other programs write them, and the axes, times and forms of attitude they use."""

import re

import numpy as np
import pytest
from astropy.time import Time
from scipy.spatial.transform import Rotation

from attitude import AttitudeWarning, Ephemeris, FormatError, InputError
from attitude.frames import rotations
from attitude.samples.ephemeris_data import EphemerisData
from attitude.times.instants import Instants

PLAIN = """stk.v.11.0
BEGIN Attitude
NumberOfAttitudePoints 2
ScenarioEpoch 1 Jan 2025 00:00:00.000
CentralBody Earth
CoordinateAxes J2000
AttitudeTimeQuaternions
0 0 0 0 1
10 0 0 0.6 0.8
END Attitude
"""
EPOCH = Time("2025-01-01T00:00:00", scale="utc")


def read(tmp_path, text):
    (tmp_path / "a.a").write_bytes(text if isinstance(text, bytes) else text.encode())
    return Ephemeris.read(tmp_path / "a.a")


def file(keyword, rows, **keywords):
    """A file with these rows, relative to J2000."""
    lines = [f"{name} {value}" for name, value in keywords.items()]
    head = ["stk.v.12.0", "BEGIN Attitude", "ScenarioEpoch 1 Jan 2025 00:00:00", "CoordinateAxes J2000"]
    text = [" ".join(map(str, row)) for row in rows]
    return "\n".join([*head, *lines, keyword, *text, "END Attitude", ""])


DIALECTS = {
    "as it is": PLAIN,
    "count as a decimal": PLAIN.replace("Points 2", "Points 2.000000"),
    "count in exponents": PLAIN.replace("Points 2", "Points 2e+00"),
    "version of three parts": PLAIN.replace("stk.v.11.0", "stk.v.12.10.0"),
    "hour of one digit": PLAIN.replace(" 00:00:00.000", " 0:00:00.000"),
    "clock of one digit each": PLAIN.replace(" 00:00:00.000", " 0:0:0.000"),
    "name of the month in capitals": PLAIN.replace("1 Jan 2025", "01 JAN 2025"),
    "whole name of the month": PLAIN.replace("1 Jan 2025", "1 January 2025"),
    "epoch without seconds": PLAIN.replace(" 00:00:00.000", " 00:00"),
    "epoch in ISO 8601": PLAIN.replace("1 Jan 2025 00:00:00.000", "2025-01-01T00:00:00.000"),
    "epoch in ISO 8601 with its zone": PLAIN.replace("1 Jan 2025 00:00:00.000", "2025-01-01T00:00:00Z"),
    "epoch by the day of the year": PLAIN.replace("1 Jan 2025 00:00:00.000", "2025-001T00:00:00"),
    "epoch in quotes": PLAIN.replace("1 Jan 2025 00:00:00.000", '"1 Jan 2025 00:00:00.000"'),
    "comment first": "# made by hand\n" + PLAIN,
    "empty lines first": "\n\n" + PLAIN,
    "byte-order mark": b"\xef\xbb\xbf" + PLAIN.encode(),
    "byte-order mark and comment": b"\xef\xbb\xbf# by hand\n" + PLAIN.encode(),
    "line ends of Windows": PLAIN.replace("\n", "\r\n"),
    "InterpolationSamplesM1": PLAIN.replace("BEGIN Attitude", "BEGIN Attitude\nInterpolationSamplesM1 1"),
    "epoch of axes that need none": PLAIN.replace(
        "BEGIN Attitude", "BEGIN Attitude\nCoordinateAxesEpoch 1 Jan 2025 00:00:00.000"
    ),
    "no line end after the end": PLAIN[:-1],
    "time in exponents": PLAIN.replace("\n10 0", "\n1.0000000000e+01 0"),
    "small letters": re.sub("[A-Z]+", lambda word: word[0].lower(), PLAIN).replace("j2000", "J2000"),
    "minutes": PLAIN.replace("AttitudeTime", "TimeFormat EpMin\nAttitudeTime").replace(
        "\n10 ", "\n0.16666666666666666 "
    ),
    "scalar first": PLAIN.replace("Quaternions", "QuatScalarFirst")
    .replace("0 0 0 0 1", "0 1 0 0 0")
    .replace("0 0 0.6 0.8", "0.8 0 0 0.6"),
}


@pytest.mark.parametrize("text", DIALECTS.values(), ids=DIALECTS)
def test_dialect_holds_the_same_attitudes(text, tmp_path):
    back = read(tmp_path, text)
    assert back.quaternion("wxyz").tolist() == [[1.0, 0.0, 0.0, 0.0], [0.8, 0.0, 0.0, 0.6]]
    assert back.elapsed.tolist() == [0.0, 10.0]
    assert abs((back.time[0] - EPOCH).sec) < 1e-12
    assert back.frame == "EME2000"


@pytest.mark.parametrize("order", [None, 1, 7])
@pytest.mark.parametrize(("method", "intervals", "degree"), [("Lagrange", 5, 5), ("Hermite", 3, 7)])
def test_number_of_samples_tells_the_degree_of_interpolation(method, intervals, degree, order, tmp_path):
    """As in ephemerides; that an order is stated besides which is another is noted."""
    keywords = f"InterpolationMethod {method}\nInterpolationSamplesM1 {intervals}"
    keywords += "" if order is None else f"\nInterpolationOrder {order}"
    back = read(tmp_path, PLAIN.replace("BEGIN Attitude", f"BEGIN Attitude\n{keywords}"))
    assert back.interpolation.segments[0].method[:2] == (method.lower(), degree)
    noted = [f"InterpolationOrder {order} is not" in text for text in back.plan.notes]
    assert noted == [True] * (order not in (None, degree))


# -- times ----------------------------------------------------------------------------------------

# Of 2025-01-01T00:00:00 UTC, which is 37 s behind TAI, 69.184 s behind TT and 18 s behind GPS.
TIME_FORMATS = {
    "UTCG": ("1 Jan 2025 00:00:00.000", "1 Jan 2025 00:00:10.500"),
    "ISO-YMD": ("2025-01-01T00:00:00.000", "2025-01-01T00:00:10.5"),
    "ISO-YD": ("2025-001T00:00:00.000", "2025-001T00:00:10.5Z"),
    "UTCJFOUR": ("001/2025 00:00:00.000", "001/2025 00:00:10.5"),
    "TAIG": ("1 Jan 2025 00:00:37.000", "1 Jan 2025 00:00:47.500"),
    "TDTG": ("1 Jan 2025 00:01:09.184", "1 Jan 2025 00:01:19.684"),
    "GPSG": ("1 Jan 2025 00:00:18.000", "1 Jan 2025 00:00:28.500"),
}


@pytest.mark.parametrize("quotes", ["", '"'], ids=["bare", "quoted"])
@pytest.mark.parametrize("time_format", TIME_FORMATS)
def test_rows_begin_with_dates_of_the_time_format(time_format, quotes, tmp_path):
    first, second = (quotes + date + quotes for date in TIME_FORMATS[time_format])
    rows = [(first, 0, 0, 0, 1), (second, 0, 0, 0.6, 0.8)]
    back = read(tmp_path, file("AttitudeTimeQuaternions", rows, TimeFormat=time_format))
    assert np.abs((back.time - EPOCH).sec - [0.0, 10.5]).max() < 1e-9
    assert back.quaternion("wxyz")[1].tolist() == [0.8, 0.0, 0.0, 0.6]


def test_dates_pass_a_leap_second(tmp_path):
    rows = [("31 Dec 2016 23:59:59.5", 0, 0, 0, 1), ("31 Dec 2016 23:59:60.5", 0, 0, 0.6, 0.8)]
    rows.append(("1 Jan 2017 00:00:00.5", 0, 0, 0.8, 0.6))
    back = read(tmp_path, file("AttitudeTimeQuaternions", rows, TimeFormat="UTCG"))
    assert np.abs(back.elapsed - [0.0, 1.0, 2.0]).max() < 1e-9


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([("32 Jan 2025 00:00:00", 0, 0, 0, 1)], "a date such as"),
        ([("noon", 0, 0, 0, 1)], "'noon 0 0 0 1'.*no date and 4 numbers"),
        ([("1 Jan 2025 00:00:00", 0, 0, 1)], "no date and 4 numbers"),
        ([("1 Jan 2025 00:00:00", 0, 0, 0, "x")], "could not convert"),
        ([("1 Jan 2025 00:00:02", 0, 0, 0, 1), ("1 Jan 2025 00:00:01", 0, 0, 0, 1)], "is not after"),
    ],
)
def test_bad_dates_are_refused_with_their_line(rows, message, tmp_path):
    with pytest.raises(FormatError, match=message) as caught:
        read(tmp_path, file("AttitudeTimeQuaternions", rows, TimeFormat="UTCG"))
    assert caught.value.line == 6 + len(rows)


# -- forms of attitude -------------------------------------------------------------------------------

ANGLES = np.array([[10.0, -20.0, 30.0], [170.0, 80.0, -100.0]])


def same(back, expected):
    off = (expected.inv() * back.rotation).magnitude()
    assert off.max() < 1e-14


@pytest.mark.parametrize(
    "sequence", ["121", "123", "131", "132", "212", "213", "231", "232", "312", "313", "321", "323"]
)
def test_euler_angles_rotate_about_the_axes_as_they_have_turned(sequence, tmp_path):
    rows = np.column_stack([[0.0, 5.0], ANGLES])
    back = read(tmp_path, file("AttitudeTimeEulerAngles", rows, Sequence=sequence))
    axes = sequence.translate(str.maketrans("123", "XYZ"))
    same(back, Rotation.from_euler(axes, ANGLES, degrees=True))


@pytest.mark.parametrize("sequence", ["123", "132", "213", "231", "312", "321"])
def test_yaw_pitch_roll_rotate_about_the_axes_of_the_reference(sequence, tmp_path):
    rows = np.column_stack([[0.0, 5.0], ANGLES])
    back = read(tmp_path, file("AttitudeTimeYPRAngles", rows, Sequence=sequence))
    about = {"3": ANGLES[:, 0], "2": ANGLES[:, 1], "1": ANGLES[:, 2]}
    axes = sequence.translate(str.maketrans("123", "xyz"))
    expected = Rotation.from_euler(axes, np.stack([about[digit] for digit in sequence], axis=1), degrees=True)
    same(back, expected)


def test_sequences_left_out_are_those_of_stk(tmp_path):
    rows = np.column_stack([[0.0, 5.0], ANGLES])
    same(
        read(tmp_path, file("AttitudeTimeEulerAngles", rows)),
        Rotation.from_euler("ZXZ", ANGLES, degrees=True),
    )
    same(
        read(tmp_path, file("AttitudeTimeYPRAngles", rows)), Rotation.from_euler("zyx", ANGLES, degrees=True)
    )


def test_direction_cosines_turn_reference_components_into_body_components(tmp_path):
    expected = Rotation.from_euler("ZYX", ANGLES, degrees=True)
    matrices = expected.inv().as_matrix().reshape(2, 9)
    same(read(tmp_path, file("AttitudeTimeDCM", np.column_stack([[0.0, 5.0], matrices]))), expected)
    rows = np.column_stack([[0.0, 5.0], matrices, [[1.0, 2.0, 3.0]] * 2])
    back = read(tmp_path, file("AttitudeTimeDCMAngVels", rows))
    assert np.abs(np.rad2deg(back.angular_velocity) - [1.0, 2.0, 3.0]).max() < 1e-15 * 10
    with pytest.warns(AttitudeWarning, match="a.a: matrices are orthonormal within"):
        rounded = read(
            tmp_path, file("AttitudeTimeDCM", np.column_stack([[0.0, 5.0], np.round(matrices, 4)]))
        )
    assert (expected.inv() * rounded.rotation).magnitude().max() < 1e-4


@pytest.mark.parametrize(
    ("keyword", "rows", "sequence", "message"),
    [
        ("AttitudeTimeDCM", [[0, 1, 0, 0, 0, 1, 0, 0, 0, -1]], "321", r"matrix.*a rotation matrix"),
        ("AttitudeTimeDCM", [[0, 1, 0, 0, 0, 1, 0, 0, 0.1, 1]], "321", r"matrix.*a rotation matrix"),
        ("AttitudeTimeEulerAngles", [[0, 1, 2, 3]], "113", "Sequence 113: neighbouring axes"),
        ("AttitudeTimeYPRAngles", [[0, 1, 2, 3]], "313", "Sequence 313: yaw, pitch and roll"),
        ("AttitudeTimeYPRAngles", [[0, 1, 2, 3]], "0", "Sequence '0'"),
        ("AttitudeTimeEulerAngleRates", [[0, 1, 2, 3]], "313", "'AttitudeTimeEulerAngleRates' is not read"),
        ("AttitudeTimeECIVector", [[0, 1, 2, 3]], "313", "'AttitudeTimeECIVector' is not read"),
    ],
)
def test_other_forms_are_refused_by_name(keyword, rows, sequence, message, tmp_path):
    with pytest.raises(FormatError, match=message) as caught:
        read(tmp_path, file(keyword, rows, Sequence=sequence))
    assert caught.value.line is not None


# -- axes ---------------------------------------------------------------------------------------------

Q = np.array([[1.0, 0.0, 0.0, 0.0], [0.8, 0.0, 0.0, 0.6], [0.5, 0.5, 0.5, 0.5]])


def ephemeris(frame):
    return Ephemeris.of(EphemerisData(Q.copy(), Instants(np.arange(3.0) * 10, None, EPOCH), frame))


@pytest.mark.parametrize(("frame", "axes"), [("ITRF", "Fixed"), ("TEME", "TEMEOfDate")])
def test_rotating_axes_are_written_by_their_name_and_come_back(frame, axes, tmp_path):
    ephemeris(frame).write(tmp_path / "a.a")
    assert f"CoordinateAxes          {axes}\n" in (tmp_path / "a.a").read_text()
    back = Ephemeris.read(tmp_path / "a.a")
    assert back.frame == frame
    assert np.array_equal(back.quaternion("wxyz"), Q)


def test_rate_relative_to_fixed_axes_comes_back(tmp_path):
    rate = np.array([[0.1, 0.2, 0.3]] * 3)
    data = EphemerisData(Q.copy(), Instants(np.arange(3.0) * 10, None, EPOCH), "GCRF", None, rate)
    fixed = Ephemeris.of(data).in_frame("ITRF")
    fixed.write(tmp_path / "a.a", rates=True)
    back = Ephemeris.read(tmp_path / "a.a")
    assert np.abs(back.angular_velocity - fixed.angular_velocity).max() < 1e-16
    assert np.abs(back.in_frame("GCRF").angular_velocity - rate).max() < 1e-15


@pytest.mark.parametrize(("name", "frame"), [("TEMEOfEpoch", "TEME"), ("AlignmentAtEpoch", "ITRF")])
def test_axes_of_an_epoch_do_not_turn(name, frame, tmp_path):
    text = PLAIN.replace("J2000", f"{name}\nCoordinateAxesEpoch 1 Jan 2025 00:00:10")
    back = read(tmp_path, text)
    assert back.frame == "GCRF"
    at_epoch = Instants(np.array([10.0]), None, EPOCH)
    for q, found in zip(Q[:2], back.quaternion("wxyz"), strict=True):
        expected = Ephemeris.of(EphemerisData(q[None].copy(), at_epoch, frame)).in_frame("GCRF")
        assert rotations.angle_between(expected.quaternion("wxyz"), found).max() < 1e-15


@pytest.mark.parametrize(
    ("change", "message", "line"),
    [
        (
            ("Axes J2000", "System J2000"),
            "'CoordinateSystem' is not known here; did you mean 'CoordinateAxes'",
            6,
        ),
        (("J2000", "AlignmentAtEpoch"), "AlignmentAtEpoch: no CoordinateAxesEpoch", 6),
        (("J2000", "MeanOfDate"), "CoordinateAxes 'MeanOfDate' of Earth; ICRF and J2000 are read", 6),
        (("J2000", "Custom VVLH Satellite/S"), "CoordinateAxes 'Custom VVLH Satellite/S'", 6),
        (("Body Earth\nCoordinateAxes J2000", "Body Mars\nCoordinateAxes Fixed"), "'Fixed' of Mars", 6),
        (("J2000", "TEMEOfEpoch\nCoordinateAxesEpoch noon"), "CoordinateAxesEpoch 'noon' is not a date", 7),
        (("J2000", "AlignmentAtEpoch\nCoordinateAxesEpoch 1 Jan 1950 0:0:0"), "tables of UT1 cover", 6),
    ],
)
@pytest.mark.filterwarnings("ignore:ERFA function:erfa.ErfaWarning")
def test_axes_that_are_not_known_are_refused_by_name(change, message, line, tmp_path):
    with pytest.raises(FormatError, match=message) as caught:
        read(tmp_path, PLAIN.replace(*change))
    assert caught.value.line == line


def test_axes_of_the_earth_belong_to_the_earth(tmp_path):
    with pytest.raises(InputError, match="central_body: Earth, to whose axes ITRF belongs; got 'Sun'"):
        ephemeris("ITRF").write(tmp_path / "a.a", central_body="Sun")
    with pytest.raises(InputError, match=r"frame: .*for an STK attitude file"):
        ephemeris("QSW").write(tmp_path / "a.a")
