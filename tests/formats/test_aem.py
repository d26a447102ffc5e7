"""CCSDS AEM: what other readers find in our files, we in theirs, and what is refused."""

import io
import re
from itertools import pairwise

import numpy as np
import pytest
from astropy.time import Time
from scipy.spatial.transform import Rotation

from attitude import Ephemeris, FormatError, InputError, Scene
from attitude.formats import interpolation_nodes
from attitude.formats.ccsds import aem as aem_format
from attitude.formats.ccsds.aem import AemOptions
from attitude.samples.event import Event
from attitude.times.instants import as_instants
from attitude.times.leap_seconds import tai_minus_utc
from tests.bodies import ATTITUDE
from tests.formats import aem_oracles, damage
from tests.formats.test_malformed import Endless
from tests.formats.texts import aem as file
from tests.tables import table

FORMATS = {"kvn": "aem", "xml": "aem-xml"}
both = pytest.mark.parametrize("syntax", FORMATS)
EPOCH = Time("2016-12-31T23:59:50.123456789", scale="utc")
T = np.arange(40) / 7  # across the leap second
NANOSECOND = 0.51e-9  # s; half of the last decimal that is written, and what astropy loses on the way
BRAHE_EPOCH = 2e-7  # s; it counts seconds since 2000 in one double
GENERIC = Rotation.from_quat([0.1, -0.3, 0.5, 0.8]).as_quat(scalar_first=True)


def motion(epoch=EPOCH, attitude=ATTITUDE, frame="GCRF"):
    return damage.motion(epoch, frame, attitude)


def text_of(ephemeris, syntax="kvn", **options):
    return damage.written(FORMATS[syntax], ephemeris, **options).decode()


def read(text, **options):
    return aem_format.parse(io.BytesIO(text.encode() if isinstance(text, str) else text), "given", **options)


def rebuilt(ephemeris, **changes):
    """The same samples, with other properties."""
    properties = {
        "rate": ephemeris.angular_velocity,
        "name": ephemeris.name,
        "events": ephemeris.events,
    } | changes
    q = np.array(properties.pop("quaternion", ephemeris.quaternion("wxyz")))
    times = properties.pop("instants", ephemeris.instants)
    return Ephemeris(q, times, properties.pop("frame", ephemeris.frame), None, **properties)


def assert_same(back, written, times=NANOSECOND):
    assert back.shape == written.shape
    assert np.array_equal(back.quaternion("wxyz"), written.quaternion("wxyz"))
    assert np.abs((back.time - written.time).sec).max() <= times
    assert (back.frame, back.instants.scale) == (written.frame, written.instants.scale)


def assert_same_rate(back, written):
    size = np.abs(written.angular_velocity).max()
    assert np.abs(back.angular_velocity - written.angular_velocity).max() <= 1e-15 * size


# -- round trips --------------------------------------------------------------------------------


@both
@pytest.mark.parametrize("scale", ["utc", "tai", "tt", "tdb", "tcb", "tcg", "ut1"])
def test_what_comes_back_is_what_was_written(syntax, scale, tmp_path):
    written = motion(getattr(EPOCH, scale)).at(T)
    path = tmp_path / f"a.{'aem' if syntax == 'kvn' else 'xml'}"
    assert written.write(path).nodes == len(T)
    back = Ephemeris.read(path)
    assert_same(back, written)
    assert_same_rate(back, written)
    assert back.events == ()
    assert back.name == "UNKNOWN"


@both
def test_attitudes_alone(syntax):
    text = text_of(motion().at(T), syntax, rates=False)
    assert "ANGVEL" not in text
    back = read(text)
    assert_same(back, motion().at(T))
    assert not back.has_rate
    assert text_of(back, syntax, creation_date="2020-01-01T00:00:00").count("2016-12-31T") == 40 + 2


@both
def test_one_attitude_has_no_interpolation(syntax):
    text = text_of(motion().at(T[:1]), syntax)
    assert "INTERPOLATION" not in text
    assert_same(read(text), motion().at(T[:1]))


@both
def test_leap_second_is_second_60(syntax):
    text = text_of(motion(Time("2016-12-31T23:59:59.5", scale="utc")).at([0.0, 0.5, 1.0, 1.5]), syntax)
    stamps = re.findall(r"(201\S+T[\d:.]+)", text.partition("ANGVEL_FRAME")[2])
    assert stamps == [
        "2016-12-31T23:59:59.500000000",
        "2016-12-31T23:59:60.000000000",
        "2016-12-31T23:59:60.500000000",
        "2017-01-01T00:00:00.000000000",
    ]
    assert read(text).elapsed.tolist() == [0.0, 0.5, 1.0, 1.5]


@both
def test_reading_does_not_depend_on_the_blocks(syntax, monkeypatch):
    written = motion().at(np.arange(300) / 7)
    text = text_of(written, syntax)
    for size in (1, 1000, 4097):
        monkeypatch.setattr("attitude.formats.line_blocks.BLOCK_BYTES", size)
        monkeypatch.setattr("attitude.formats.ccsds.xml_reader.CHUNK_BYTES", size)
        monkeypatch.setattr("attitude.formats.ccsds.reader.FIRST_BYTES", size)
        assert_same(read(text), written)


def planned():
    """A scene with impulses, dated."""
    document = Scene.builtin("thruster-plan").model_dump(mode="json", exclude_none=True, by_alias=True)
    return Scene.model_validate(document | {"epoch": {"time": "2026-01-01T00:00:00", "scale": "tai"}}).run()


@both
def test_impulses_begin_segments_and_segments_are_cut_again(syntax):
    written = planned()
    cuts = [event.seconds for event in written.events if event.kind == "impulse"]
    assert len(cuts) == 4
    text = text_of(written, syntax, creation_date="2020-01-01T00:00:00")
    assert text.count("STOP_TIME") in (5, 10)  # elements have two ends
    back = read(text)
    assert_same(back, written)
    assert [(event.kind, event.seconds) for event in back.events] == [("segment", cut) for cut in cuts]
    again = text_of(back, syntax, creation_date="2020-01-01T00:00:00", object_name="UNKNOWN")
    assert re.findall("T_TIME.*|P_TIME.*", again) == re.findall("T_TIME.*|P_TIME.*", text)
    edges = [0, *np.searchsorted(written.elapsed, cuts).tolist(), len(written)]
    for k, (first, last) in enumerate(pairwise(edges), start=1):
        assert_same(read(text, segment=k), written[first:last])


def test_content_tells_the_syntax_whatever_the_ending(tmp_path):
    motion().at(T).write(tmp_path / "a.txt", "aem-xml")
    (tmp_path / "a.aem").write_bytes(b"\n  " + (tmp_path / "a.txt").read_bytes()[39:])
    assert_same(Ephemeris.read(tmp_path / "a.aem"), motion().at(T))


# -- the literal text ------------------------------------------------------------------------------


WHOLE = """\
CCSDS_AEM_VERS = 2.0
COMMENT Q1 Q2 Q3 QC, scalar last, turn axes of ECLIPJ2000 into those of IMU_FRAME_1
COMMENT v_inertial = q * v_body * conj(q), Hamilton product: q rotates IMU_FRAME_1 to ECLIPJ2000
COMMENT ANGVEL is that of IMU_FRAME_1 relative to ECLIPJ2000, components in IMU_FRAME_1, deg/s
COMMENT ECLIPJ2000 is not in the SANA registry of frames: EME2000 turned about its X axis by 84381.448 arcsec
COMMENT Error of interpolation between these attitudes is not known
CREATION_DATE = 2026-01-01T00:00:00
ORIGINATOR = JAXA
MESSAGE_ID = A & B

META_START
OBJECT_NAME = TEST SAT
OBJECT_ID = 2000-052A
CENTER_NAME = SUN
REF_FRAME_A = ECLIPJ2000
REF_FRAME_B = IMU_FRAME_1
TIME_SYSTEM = TT
START_TIME = 2020-01-01T00:00:00.000000000
STOP_TIME = 2020-01-01T00:00:02.000000000
ATTITUDE_TYPE = QUATERNION/ANGVEL
ANGVEL_FRAME = IMU_FRAME_1
INTERPOLATION_METHOD = LAGRANGE
INTERPOLATION_DEGREE = 2
META_STOP

DATA_START
2020-01-01T00:00:00.000000000 0.0 0.0 0.0 1.0 0.0 0.0 5.0e-8
2020-01-01T00:00:01.000000000 0.0 0.0 0.0 1.0 0.0 0.0 5.0e-8
2020-01-01T00:00:02.000000000 -1.0e-9 0.0 0.0 1.0 0.0 0.0 -1.5e-300
DATA_STOP
"""
OPTIONS = {
    "object_name": "TEST SAT",
    "object_id": "2000-052A",
    "originator": "JAXA",
    "message_id": "A & B",
    "creation_date": "2026-01-01T00:00:00",
    "center_name": "SUN",
    "body_frame": "IMU_FRAME_1",
}


def small():
    q = np.array([[1.0, -0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [1.0, -1e-9, 0.0, 0.0]])
    rate = np.deg2rad([[0.0, 0.0, 5e-8], [-0.0, 0.0, 5e-8], [0.0, 0.0, -1.5e-300]])
    times = as_instants([0.0, 1.0, 2.0], Time("2020-01-01", scale="tt"))
    return Ephemeris(q, times, "ECLIPJ2000", None, rate, "other")


def test_whole_text():
    """Numbers as 504.0-B-2, 6.8 has them: a decimal point in each, and no -0."""
    assert text_of(small(), **OPTIONS) == WHOLE


def test_whole_xml():
    text = text_of(small(), "xml", **OPTIONS)
    assert text.startswith('<?xml version="1.0" encoding="UTF-8"?>\n<aem xmlns:xsi="http://www.w3.org/2001/')
    assert 'id="CCSDS_AEM_VERS" version="2.0">\n<header>\n<COMMENT>' in text
    assert "<MESSAGE_ID>A &amp; B</MESSAGE_ID>\n</header>\n<body>\n<segment>\n<metadata>\n<OBJECT_" in text
    pairs = [line.split(" = ") for line in WHOLE.splitlines() if " = " in line and "COMMENT" not in line]
    fields = dict(re.findall(r"<([A-Z_]+)>([^<]*)</\1>", text))
    assert all(
        fields[name] == value.replace("&", "&amp;") for name, value in pairs if name != "CCSDS_AEM_VERS"
    )
    assert text.endswith(
        "<attitudeState>\n<quaternionAngVel>\n<EPOCH>2020-01-01T00:00:02.000000000</EPOCH>\n"
        "<quaternion>\n<Q1>-1.0e-9</Q1>\n<Q2>0.0</Q2>\n<Q3>0.0</Q3>\n<QC>1.0</QC>\n</quaternion>\n"
        '<angVel>\n<ANGVEL_X units="deg/s">0.0</ANGVEL_X>\n<ANGVEL_Y units="deg/s">0.0</ANGVEL_Y>\n'
        '<ANGVEL_Z units="deg/s">-1.5e-300</ANGVEL_Z>\n</angVel>\n</quaternionAngVel>\n</attitudeState>\n'
        "</data>\n</segment>\n</body>\n</aem>\n"
    )


def test_no_line_is_longer_than_the_standard_allows():
    longest = dict.fromkeys(("object_name", "object_id", "originator", "message_id"), "X" * 200)
    lines = text_of(motion(frame="INERTIAL").at(T), **longest).splitlines()
    assert max(map(len, lines)) <= 254
    assert "COMMENT INERTIAL is not in the SANA registry of frames: an inertial frame of the" in lines[4]


# -- other readers and writers -------------------------------------------------------------------


@both
@pytest.mark.parametrize("rates", [None, False], ids=["rates", "attitudes"])
@pytest.mark.parametrize("reader", aem_oracles.READERS)
def test_other_readers_find_our_attitudes(reader, rates, syntax):
    written = motion(attitude=GENERIC, frame="EME2000").at(T)
    seconds, quaternion, rate = aem_oracles.READERS[reader](text_of(written, syntax, rates=rates))
    assert np.abs(quaternion - written.quaternion("wxyz")).max() <= 1e-12
    if seconds is not None:
        assert np.abs(seconds - T).max() <= BRAHE_EPOCH
    if rates is False:
        assert rate is None
    else:
        assert np.abs(rate - written.angular_velocity).max() <= 1e-9 * np.abs(rate).max()


@both
@pytest.mark.parametrize("reader", aem_oracles.READERS)
def test_other_readers_find_our_segments(reader, syntax):
    written = planned()
    written = rebuilt(written, frame="EME2000")
    _, quaternion, _ = aem_oracles.READERS[reader](text_of(written, syntax))
    assert np.abs(quaternion - written.quaternion("wxyz")).max() <= 1e-12


@both
@pytest.mark.parametrize("rates", [None, False], ids=["rates", "attitudes"])
@pytest.mark.parametrize("writer", aem_oracles.WRITERS)
def test_we_read_what_others_write(writer, rates, syntax):
    """From our text, which they read and write in their own way: other widths of epochs, no blank lines."""
    written = motion(attitude=GENERIC, frame="EME2000").at(T)
    back = read(aem_oracles.WRITERS[writer](text_of(written, rates=rates), syntax))
    assert np.abs(back.quaternion("wxyz") - written.quaternion("wxyz")).max() <= 1e-12
    assert np.abs((back.time - written.time).sec).max() <= BRAHE_EPOCH
    assert back.has_rate is (rates is None)
    if back.has_rate:
        size = np.abs(written.angular_velocity).max()
        assert np.abs(back.angular_velocity - written.angular_velocity).max() <= 1e-9 * size


# -- other directions, types and versions ---------------------------------------------------------


EPOCH_TEXT = "2020-01-01T00:00:00.0"
OURS = Rotation.from_quat([0.1, -0.3, 0.5, 0.8])
RATE = np.array([1.0, -2.0, 3.0])  # deg/s, body components
LAST = " ".join(map(repr, OURS.as_quat().tolist()))
INVERSE = " ".join(map(repr, OURS.inv().as_quat().tolist()))
QC_FIRST = " ".join(map(repr, OURS.as_quat(scalar_first=True).tolist()))
QC_FIRST_INVERSE = " ".join(map(repr, OURS.inv().as_quat(scalar_first=True).tolist()))


def words(numbers):
    return " ".join(map(repr, np.asarray(numbers).tolist()))


def dotted(last):
    """dq/dt = q omega / 2 of the scalar-last numbers."""
    turn = Rotation.from_quat(last)
    half = 0.5 * np.deg2rad(RATE)
    w, r = turn.as_quat()[3], turn.as_quat()[:3]
    return np.concatenate([w * half + np.cross(r, half), [-r @ half]])


DOT = dotted(OURS.as_quat())
REVERSED = {"REF_FRAME_A": "SC_BODY_1", "REF_FRAME_B": "J2000"}
ANGVEL = {"ATTITUDE_TYPE": "QUATERNION/ANGVEL"}
DERIVATIVE = {"ATTITUDE_TYPE": "QUATERNION/DERIVATIVE"}
V1 = {"version": "1.0", "ATTITUDE_DIR": "A2B", "QUATERNION_TYPE": "LAST"}
V1_RATE = {"ATTITUDE_TYPE": "QUATERNION/RATE", "RATE_FRAME": "REF_FRAME_B"}
EULER = {"EULER_ROT_SEQ": "ZXY"}
ANGLES = OURS.as_euler("ZXY", degrees=True)
# The same attitude, and rate where there is one, in every convention of the standard.
EQUIVALENT_ROWS = {
    "inertial to body": (LAST, {}),
    "body to inertial": (INVERSE, REVERSED),
    "rate in the body": (f"{LAST} {words(RATE)}", ANGVEL | {"ANGVEL_FRAME": "SC_BODY_1"}),
    "rate in the inertial frame": (f"{LAST} {words(OURS.apply(RATE))}", ANGVEL | {"ANGVEL_FRAME": "J2000"}),
    "rate of the inverse, in the body": (
        f"{INVERSE} {words(-RATE)}",
        REVERSED | ANGVEL | {"ANGVEL_FRAME": "SC_BODY_1"},
    ),
    "rate of the inverse, in the inertial frame": (
        f"{INVERSE} {words(-OURS.apply(RATE))}",
        REVERSED | ANGVEL | {"ANGVEL_FRAME": "J2000"},
    ),
    "derivative": (f"{LAST} {words(DOT)}", DERIVATIVE),
    "derivative of the inverse": (f"{INVERSE} {words(DOT * [-1, -1, -1, 1])}", REVERSED | DERIVATIVE),
    "Euler angles": (words(ANGLES), EULER | {"ATTITUDE_TYPE": "EULER_ANGLE"}),
    "Euler angles and rate": (
        f"{words(ANGLES)} {words(RATE)}",
        EULER | {"ATTITUDE_TYPE": "EULER_ANGLE/ANGVEL", "ANGVEL_FRAME": "SC_BODY_1"},
    ),
    "version 1, QC last": (LAST, V1),
    "version 1, QC first": (QC_FIRST, V1 | {"QUATERNION_TYPE": "FIRST"}),
    "version 1, body to inertial": (INVERSE, V1 | {"ATTITUDE_DIR": "B2A"}),
    "version 1, frames and direction reversed": (
        QC_FIRST,
        V1 | REVERSED | {"ATTITUDE_DIR": "B2A", "QUATERNION_TYPE": "FIRST"},
    ),
    "version 1, frames reversed": (
        QC_FIRST_INVERSE,
        V1 | REVERSED | {"QUATERNION_TYPE": "FIRST"},
    ),
    "version 1, derivative, QC first": (
        f"{QC_FIRST} {words(DOT[[3, 0, 1, 2]])}",
        V1 | DERIVATIVE | {"QUATERNION_TYPE": "FIRST"},
    ),
    "version 1, rate": (f"{LAST} {words(RATE)}", V1 | V1_RATE),
    "version 1, rate in the inertial frame": (
        f"{LAST} {words(OURS.apply(RATE))}",
        V1 | V1_RATE | {"RATE_FRAME": "REF_FRAME_A"},
    ),
    "version 1, rate of the inverse": (
        f"{INVERSE} {words(-RATE)}",
        V1 | V1_RATE | {"ATTITUDE_DIR": "B2A"},
    ),
    "version 1, Euler angles": (
        words(ANGLES),
        V1 | {"ATTITUDE_TYPE": "EULER_ANGLE", "EULER_ROT_SEQ": "312", "QUATERNION_TYPE": None},
    ),
}


@pytest.mark.parametrize(("numbers", "metadata"), EQUIVALENT_ROWS.values(), ids=EQUIVALENT_ROWS)
def test_one_attitude_in_every_convention_is_read_the_same(numbers, metadata):
    back = read(file(f"{EPOCH_TEXT} {numbers}", **metadata))
    assert (back.frame, back.name, back.instants.scale) == ("EME2000", "SAT", "utc")
    q = back.quaternion("xyzw")[0]
    if len(numbers.split()) in (4, 7, 8):
        assert np.array_equal(np.abs(q), np.abs(OURS.as_quat()))  # bits, and below the signs
    assert (Rotation.from_quat(q).inv() * OURS).magnitude() <= 1e-15
    assert back.has_rate is (len(numbers.split()) > 4)
    if back.has_rate:
        assert np.abs(back.angular_velocity[0] - np.deg2rad(RATE)).max() <= 1e-15


def test_rates_of_euler_angles_are_those_of_a_difference():
    speeds, step = np.array([3.0, -2.0, 5.0]), 1e-4
    rows = f"{EPOCH_TEXT} {words(ANGLES)} {words(speeds)}"
    back = read(file(rows, ATTITUDE_TYPE="EULER_ANGLE/DERIVATIVE", **EULER))
    before, after = (
        Rotation.from_euler("ZXY", ANGLES + sign * step * speeds, degrees=True) for sign in (-1, 1)
    )
    difference = (before.inv() * after).as_rotvec() / (2 * step)
    assert np.abs(back.angular_velocity[0] - difference).max() <= 1e-9


EPOCHS = {
    "2020-01-01T00:00:00 2020-01-01T00:00:01.5": ("UTC", "utc", 1.5),
    "2020-001T00:00:00.25Z 2020-366T00:00:00Z": ("UTC", "utc", 365 * 86400 - 0.25),
    "2016-12-31T23:59:59.25 2017-01-01T00:00:00": ("UTC", "utc", 1.75),
    "2016-366T23:59:60.25 2017-01-01T00:00:00.5": ("UTC", "utc", 1.25),
    "2016-12-31T23:59:59 2017-01-01T00:00:00": ("TAI", "tai", 1.0),
    "2016-12-31T23:59:59.123456789012345678 2017-01-01T00:00:00": ("TT", "tt", 0.876543210987654322),
    "2016-12-31T23:59:59.000 2017-01-01T00:00:00": ("GPS", "tai", 1.0),
    "1969-01-01T00:00:00 1969-01-01T00:00:10": ("UTC", "utc", 10.0 + 10 * 3e-8),  # UTC ran slow by 3e-8
    "0001-01-01T00:00:00 9999-12-31T00:00:00.1": ("TAI", "tai", 3652058 * 86400 + 0.1),
}


@pytest.mark.parametrize("epochs", EPOCHS)
def test_epochs_of_every_form(epochs):
    system, scale, seconds = EPOCHS[epochs]
    texts = epochs.split()
    rows = "\n".join(f"{epoch} 0 0 0 1" for epoch in texts)
    back = read(file(rows, START_TIME=texts[0], STOP_TIME=texts[1], TIME_SYSTEM=system))
    assert back.instants.scale == back.epoch.scale == scale
    assert back.elapsed[0] == 0.0
    slack = 1e-10 if texts[0].startswith("1969") else 1e-15
    assert abs(back.elapsed[1] - seconds) <= slack * max(1.0, seconds)


def test_gps_is_behind_tai_by_19_seconds():
    text = file(f"2020-01-01T00:00:00 {LAST}", TIME_SYSTEM="GPS")
    assert abs((read(text).epoch - Time("2020-01-01T00:00:19", scale="tai")).sec) <= 1e-10


def test_seconds_between_epochs_are_exact():
    """Tenths of seconds, years after the first: to far more digits than one double of seconds holds."""
    rows = "2000-01-01T00:00:00.3 0 0 0 1\n2020-01-01T00:00:00.4 0 0 0 1"
    back = read(file(rows, TIME_SYSTEM="TAI", START_TIME="2000-01-01T00:00:00"))
    whole = 7305 * 86400
    assert abs((back.elapsed[1] - whole) + back.instants.seconds_low[1] - 0.1) <= 1e-16


def test_leap_seconds_are_those_of_astropy():
    days = Time(np.arange(41317, 61000, 10), format="mjd", scale="utc")
    tai = np.rint((days.tai.mjd - days.mjd) * 86400).astype(int)
    assert np.array_equal(tai_minus_utc(np.arange(41317, 61000, 10)), tai)


NUMBERS = ["1", "1.", "+1.0", "1.0e0", "10.E-1", "01.00", ".1e1"]


@pytest.mark.parametrize("one", NUMBERS)
def test_numbers_of_every_form(one):
    assert read(file(f"{EPOCH_TEXT} 0 -0.0 .0e5 {one}")).quaternion("wxyz").tolist() == [[1.0, 0.0, 0.0, 0.0]]


LOOSE = """
  CCSDS_AEM_VERS=2.0

COMMENT first \xc3\xa5
COMMENT
CREATION_DATE  =  2020-001T00:00:00Z
ORIGINATOR = NASA = ESA
  META_START
COMMENT here
 OBJECT_NAME = MARS_SPIRIT
OBJECT_ID = X
REF_FRAME_A = icrf
REF_FRAME_B = sc body 1
TIME_SYSTEM = utc
START_TIME = 2020-01-01T00:00:00
USEABLE_START_TIME = 2020-01-01T00:00:01
USEABLE_STOP_TIME = 2020-01-01T00:00:02
STOP_TIME = 2020-01-01T00:00:03
ATTITUDE_TYPE = quaternion
INTERPOLATION_METHOD = hermite
INTERPOLATION_DEGREE = 1
META_STOP
COMMENT before the block
DATA_START

COMMENT before the data

  2020-01-01T00:00:00   0 0 0\t1\x20
 COMMENT between two rows
2020-01-01T00:00:00.5 0 0 0 1

2020-001T00:00:03Z 0 0 0 1
 DATA_STOP

COMMENT after the block
"""


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r", "\n\r"])
@pytest.mark.parametrize("cut", [0, 1, 2])
def test_blanks_comments_and_line_ends_have_no_meaning(end, cut, mark):
    content = mark + LOOSE.replace("\n", end).encode("latin-1")
    back = read(content[: len(content) - cut * len(end)])
    assert back.elapsed.tolist() == [0.0, 0.5, 3.0]
    assert (back.frame, back.name) == ("ICRF", "MARS_SPIRIT")


def test_xml_in_other_forms_is_read_as_well():
    """Elements in another order, comments, character references, prefixes, and all on one line."""
    written = motion().at(T)
    text = text_of(written, "xml")
    moved = re.sub(r"(?s)(<Q1>.*?)(<QC>[^<]*</QC>)", r"\2<!-- < & -->\1", text)
    prefixed = re.sub(r"<(/?)(\w+)", r"<\1ndm:\2", text).replace("<ndm:aem", '<ndm:aem xmlns:ndm="urn:x"')
    variants = {
        "another order": moved,
        "one line": text.replace("\n", " "),
        "comments": text.replace("<attitudeState>", "<!-- <attitudeState> --><attitudeState>"),
        "references": text.replace("<Q1>-", "<Q1>&#45;"),
        "sections": re.sub("<Q2>([^<]*)<", r"<Q2><![CDATA[\1]]><", text),
        "no units": text.replace(' units="deg/s"', ""),
        "blanks": re.sub(r">([^<\n]+)</(Q|A|E)", r">  \1\n</\2", text),
        "prefixes": prefixed,
        "blanks that change": re.sub("(?s)(.*<attitudeState>)(.*?)<Q3>", r"\1 \2\t<Q3>\n", text),
        "UTF-16": text.replace('"UTF-8"', '"UTF-16"').encode("utf-16"),
        "mark": "\ufeff" + text,
    }
    for name, variant in variants.items():
        assert variant != text, name
        back = read(variant)
        assert_same(back, written)
        assert_same_rate(back, written)


def test_version_1_in_xml():
    text = text_of(motion().at(T), "xml", rates=False).replace('version="2.0"', 'version="1.0"')
    text = text.replace("quaternionEphemeris>", "quaternionState>").replace(
        "<TIME_SYSTEM>", "<ATTITUDE_DIR>A2B</ATTITUDE_DIR>\n<TIME_SYSTEM>"
    )
    for place in ("FIRST", "LAST"):  # elements have names: their order has no meaning
        placed = text.replace(
            "<INTERPOLATION_METHOD>",
            f"<QUATERNION_TYPE>{place}</QUATERNION_TYPE>\n<INTERPOLATION_METHOD>",
        )
        assert_same(read(placed), motion().at(T))


# -- what is refused -------------------------------------------------------------------------------


def two(**second):
    """Two segments, a minute each."""
    rows = f"{EPOCH_TEXT} {LAST}\n2020-01-01T00:01:00 {LAST}"
    later = {"START_TIME": "2020-01-01T00:01:00", "STOP_TIME": "2020-01-01T00:02:00"}
    following = file(f"2020-01-01T00:01:30 {LAST}", **(later | second))
    return file(rows) + following[following.index("META_START") :]


def test_segment_that_differs_is_read_on_its_own():
    assert len(read(two())) == 3
    other = two(OBJECT_ID="1999-001A")
    with pytest.raises(
        FormatError, match="OBJECT_ID = 1999-001A: the segment before has 2000-052A; segment=k"
    ):
        read(other)
    assert [len(read(other, segment=k)) for k in (1, 2)] == [2, 1]
    spinning = two(ATTITUDE_TYPE="SPIN")
    assert len(read(spinning, segment=1)) == 2
    with pytest.raises(FormatError, match="no segment 3, of 2"):
        read(other, segment=3)
    for bad in (0, True, "1"):
        with pytest.raises(InputError, match="segment: a whole number"):
            read(other, segment=bad)


ROW = f"2020-01-01T00:00:01.0 {LAST}"
NEXT = f"2020-01-01T00:00:02.0 {LAST}"


@pytest.mark.parametrize(
    ("changes", "message", "line"), [pytest.param(*row, id=row[1]) for row in table("malformed_aem")]
)
def test_malformed_file_is_refused_by_file_and_line(changes, message, line):
    """Arguments of `file`, and what replaces a part of it; META_START is in line 4, the first row in 15."""
    pattern, replacement = changes.pop("replace", ("", ""))
    rows = changes.pop("rows", "ROW\nNEXT").replace("ROW", ROW).replace("NEXT", NEXT)
    with pytest.raises(FormatError, match=message) as caught:
        read(re.sub(pattern, replacement, file(rows, **changes), count=1))
    assert caught.value.source == "given"
    assert "\n" not in str(caught.value)
    assert caught.value.line == line or line is None


@pytest.mark.parametrize("beginning", ["", "CCSDS_AEM_VERS = 2.0\n", "<?xml version='1.0'?>", "<aem>"])
@pytest.mark.parametrize(
    "pattern",
    [b"\0", b"a", b"a=b\n", b"<a>", b"<a", b"1.0 2.0 3.0\n", b"<!-- a -->", b"<?a b?>", b"<!-- "],
)
def test_endless_garbage_is_refused_at_once(beginning, pattern):
    endless = Endless(beginning.encode(), pattern)
    with pytest.raises(FormatError):
        aem_format.parse(endless, "given")
    assert endless.byte_count <= 1 << 25


def test_endless_empty_lines_are_refused_at_once():
    with pytest.raises(FormatError, match="nearly empty lines, one after another"):
        aem_format.parse(Endless(b"CCSDS_AEM_VERS = 2.0\n", b"\n"), "given")


# -- what is not written ---------------------------------------------------------------------------


def test_ephemeris_without_dates_is_refused(tmp_path):
    with pytest.raises(FormatError, match="no epoch to count them from"):
        motion(epoch=None).at(T).write(tmp_path / "a.aem")
    assert list(tmp_path.iterdir()) == []


@both
@pytest.mark.parametrize(
    ("times", "message"),
    [
        ([0.0, 2.0, 1.0], r"instants\[2\] \(1.0 s\) .* increasing order"),
        ([0.0, 1.0, 1.0 + 1e-10], "increase by a nanosecond.*51.123.* follows .*51.123"),
    ],
    ids=["unsorted", "collapsed"],
)
def test_instants_that_do_not_increase_are_refused(syntax, times, message, tmp_path):
    with pytest.raises(FormatError, match=message):
        motion().at(times).write(tmp_path / "a", FORMATS[syntax])
    assert list(tmp_path.iterdir()) == []


@both
@pytest.mark.parametrize("frame", ["TEME", "ITRF"])
def test_frame_that_turns_is_written_and_read_by_its_name(syntax, frame, tmp_path):
    written = motion().at(T).in_frame(frame)
    written.write(tmp_path / "a", FORMATS[syntax])
    back = Ephemeris.read(tmp_path / "a", FORMATS[syntax])
    assert back.frame == frame
    assert_same(back, written)
    assert_same_rate(back, written)


OPTION = {
    "line": {"object_name": "a\nb"},
    "empty": {"object_id": ""},
    "accent": {"originator": "é"},
    "blank at the end": {"message_id": "a "},
    "too long": {"center_name": "a" * 231},
    "no text": {"object_id": 5},
    "date": {"creation_date": "yesterday"},
    "inertial body": {"body_frame": "J2000"},
    "degree": {"degree": 0},
    "no whole degree": {"degree": 2.0},
    "rates": {"rates": "yes"},
}


@both
@pytest.mark.parametrize("options", OPTION.values(), ids=OPTION)
def test_option_that_a_file_cannot_hold_is_named(options, syntax, tmp_path):
    (name,) = options
    with pytest.raises(InputError, match=f"^{name}: "):
        motion().at(T).write(tmp_path / "a", FORMATS[syntax], **options)
    assert list(tmp_path.iterdir()) == []


@both
def test_options_that_the_writer_does_not_have_are_refused(syntax):
    assert AemOptions().object_id == "UNKNOWN"
    with pytest.raises(InputError, match=r"subject: unknown option of .*; known: object_name, originator, "):
        motion().at(T).write("-", FORMATS[syntax], subject="X")


def test_rates_that_are_not_there_are_refused():
    with pytest.raises(InputError, match="rates: an ephemeris that holds rates"):
        text_of(rebuilt(motion().at(T), rate=None), rates=True)


def test_name_that_a_line_cannot_hold_is_refused():
    with pytest.raises(InputError, match="object_name: one line of"):
        text_of(rebuilt(motion().at(T), name="å"))
    assert "OBJECT_NAME = A" in text_of(rebuilt(motion().at(T), name="å"), object_name="A")


def test_degree_is_written_and_decides_the_nodes():
    options = AemOptions(degree=3, object_id="X"), AemOptions()
    degrees = [aem_format.interpolant(each) for each in options]
    assert degrees == [interpolation_nodes.Interpolant("lagrange", degree) for degree in (3, 7)]
    assert "INTERPOLATION_DEGREE = 3\n" in text_of(motion().at(T), degree=3)
    cut = rebuilt(motion().at(T), events=(Event(T[2], "impulse", ""), Event(T[3], "contact", "")))
    assert re.findall("DEGREE = (.*)", text_of(cut)) == ["1", "7"]
