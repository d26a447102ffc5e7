"""AEM as others write it: frames of the registries, spins, useable spans, an <ndm>, missing keywords."""

import io

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from attitude import FormatError, InputError, RigidBody, TorqueFreeMotion
from attitude.formats.ccsds.reader import parse
from attitude.samples.resampling import with_interpolation
from tests.formats.test_aem import EPOCH, GENERIC, LAST, OURS, T, file, motion, text_of
from tests.formats.test_malformed import Endless

LATER = "2020-01-01T00:00:59"


def read(text, **options):
    return parse(io.BytesIO(text.encode()), "given", **options)


def spinning(kind, numbers, version="2.0", **metadata):
    direction = {"ATTITUDE_DIR": "A2B"} if version == "1.0" else {}
    row = f"2020-01-01T00:00:01 {numbers}"
    return read(file(row, version=version, ATTITUDE_TYPE=kind, **direction, **metadata))


FRAMES = {
    "ICRF": ["ICRF", "ICRF2", "ICRF3"],
    "GCRF": ["GCRF", "GCRF1"],
    "EME2000": ["EME2000", "J2000", "EME 2000"],
    "ITRF": [
        "ITRF",
        "ITRF-93",
        "ITRF-97",
        "ITRF97",
        "ITRF1997",
        "ITRF2014",
        "ITRF-2020",
        "FIXED_EARTH",
        "WGS84",
    ],
    "GTOD": ["GTOD"],
    "TEME": ["TEME", "TEMEOFDATE"],
    "LVLH": ["LVLH", "LVLH_ROTATING"],
    "QSW": ["QSW", "RSW", "RTN", "RIC", "RSW_ROTATING", "QSW_ROTATING"],
}


@pytest.mark.parametrize(("frame", "name"), [(frame, name) for frame in FRAMES for name in FRAMES[frame]])
@pytest.mark.parametrize("body", ["SC_BODY_1", "STARTRACKER_2", "INSTRUMENT_A", "MAIN_BODY"])
def test_frames_of_the_registries_are_known_by_all_their_names(frame, name, body):
    back = read(file(f"{LATER} {LAST}", REF_FRAME_A=name, REF_FRAME_B=body))
    assert back.frame == frame
    assert Rotation.from_quat(back.quaternion("xyzw")[0]).approx_equal(OURS, 1e-15)
    turned = read(file(f"{LATER} {LAST}", REF_FRAME_A=body, REF_FRAME_B=name))
    assert turned.frame == frame
    assert Rotation.from_quat(turned.quaternion("xyzw")[0]).approx_equal(OURS.inv(), 1e-15)


# Numbers of a row; what Orekit 13.1 finds in it: its quaternion (frame to body axes) and body rate, rad/s.
SPINS = {
    ("SPIN", "40 25 70 6"): ([0.0, 0.0, 0.10471975511965978]),
    ("SPIN/NUTATION", "40 25 70 6 12 50 33"): [
        0.02191190703011268,
        -0.014229758806793103,
        0.227637407783332,
    ],
    ("SPIN/NUTATION", "40 25 70 6 12 50 120"): [
        -0.013063476809370058,
        -0.02262660555732664,
        0.22763740778333208,
    ],
    ("SPIN/NUTATION_MOM", "40 25 70 6 44 31 2"): [
        0.004171484978936276,
        -0.0007028217823215839,
        0.1393690615161757,
    ],
}
OREKIT_ATTITUDE = [-0.1464533876252852, 0.46531511027177885, 0.26864980417341194, 0.8305784346607054]


@pytest.mark.parametrize(("case", "rate"), SPINS.items(), ids=map(" ".join, SPINS))
def test_spins_are_those_that_orekit_finds(case, rate):
    back = spinning(*case)
    q = back.quaternion("wxyz")[0]
    assert abs(abs(q @ OREKIT_ATTITUDE) - 1.0) <= 1e-15
    assert np.abs(back.angular_velocity[0] - rate).max() <= 1e-15


def test_spin_of_version_1_and_in_xml_is_that_of_version_2():
    plain = spinning("SPIN", "40 25 70 6")
    assert (spinning("SPIN", "40 25 70 6", "1.0").quaternion("wxyz") == plain.quaternion("wxyz")).all()
    xml = text_of(plain, "xml", rates=False)
    state = (
        "<spin><SPIN_ALPHA>40</SPIN_ALPHA><SPIN_DELTA>25</SPIN_DELTA><SPIN_ANGLE units='deg'>70</SPIN_ANGLE>"
    )
    state += "<SPIN_ANGLE_VEL>6</SPIN_ANGLE_VEL></spin>"
    head, rest = xml.split("<quaternionEphemeris>")
    epoch, tail = rest.split("<quaternion>")[0], rest.split("</quaternionEphemeris>")[1]
    state = state.replace("<spin>", f"<spin>{epoch}")
    back = read((head + state + tail).replace("<ATTITUDE_TYPE>QUATERNION<", "<ATTITUDE_TYPE>SPIN<"))
    assert (back.quaternion("wxyz") == plain.quaternion("wxyz")).all()
    assert (back.angular_velocity == plain.angular_velocity).all()


@pytest.mark.parametrize("syntax", ["kvn", "xml"])
@pytest.mark.parametrize("sequence", ["ZYX", "ZXZ", "YZY"])
@pytest.mark.parametrize("kind", ["EULER_ANGLE", "EULER_ANGLE/ANGVEL"])
def test_euler_angles_are_written_where_asked_for(kind, sequence, syntax):
    written = motion(frame="EME2000").at(T)
    text = text_of(written, syntax, attitude_type=kind, rotation_sequence=sequence)
    back = read(text)
    assert (back.rotation * written.rotation.inv()).magnitude().max() <= 1e-14
    assert back.has_rate == kind.endswith("ANGVEL")
    assert "INTERPOLATION" not in text
    angles = written.rotation.as_euler(sequence, degrees=True)
    if syntax == "kvn":
        row = text.split("DATA_START\n")[1].split()[1:4]
        assert np.abs(np.array(row, dtype=float) - angles[0]).max() <= 1e-12


@pytest.mark.parametrize("syntax", ["kvn", "xml"])
def test_spins_are_written_of_bodies_that_spin(syntax):
    spinner = TorqueFreeMotion(RigidBody((2.0, 2.0, 1.0)), GENERIC, (0.0, 0.0, 0.9), EPOCH, order="wxyz")
    text = text_of(spinner.at(T), syntax, attitude_type="SPIN")
    assert_motion(read(text), spinner.at(T))
    nutating = TorqueFreeMotion(RigidBody((2.0, 2.0, 1.0)), GENERIC, (0.2, -0.1, 0.9), EPOCH, order="wxyz")
    for kind in ("SPIN/NUTATION_MOM", "SPIN/NUTATION"):
        for turning in (nutating, spinner):
            assert_motion(read(text_of(turning.at(T), syntax, attitude_type=kind)), turning.at(T))
    if syntax == "kvn":
        row = text_of(nutating.at(T), attitude_type="SPIN/NUTATION").split("DATA_START\n")[1].split()
        momentum = np.array(
            [0.4, -0.2, 0.9]
        )  # along the body's axes; of a body of equal moments it turns at L/I
        size = np.linalg.norm(momentum)
        expected = [
            np.rad2deg(np.arccos(0.9 / size)),
            2.0 * np.pi / (size / 2.0),
            np.rad2deg(np.arctan2(0.2, 0.4)),
        ]
        np.testing.assert_allclose(np.array(row[5:8], dtype=float), expected, rtol=1e-13)


def assert_motion(back, written):
    assert (back.rotation * written.rotation.inv()).magnitude().max() <= 1e-13
    assert np.abs(back.angular_velocity - written.angular_velocity).max() <= 1e-13


def test_spin_of_a_body_that_does_not_is_refused():
    with pytest.raises(FormatError, match="of the body's rate is not that of SPIN, which is about z"):
        text_of(motion().at(T), attitude_type="SPIN")
    for kind in ("SPIN/NUTATION_MOM", "SPIN/NUTATION"):
        with pytest.raises(
            FormatError, match="of bodies symmetric about z; QUATERNION/ANGVEL holds any rate"
        ):
            text_of(motion().at(T), attitude_type=kind)
    for wrong in ({"attitude_type": "EULER"}, {"attitude_type": "EULER_ANGLE", "rotation_sequence": "ZZX"}):
        with pytest.raises(InputError, match=r"attitude_type: one of|three axes"):
            text_of(motion().at(T), **wrong)


def test_nutation_without_a_period_is_refused():
    with pytest.raises(FormatError, match="NUTATION_PER: a period greater than 0"):
        spinning("SPIN/NUTATION", "40 25 70 6 12 0 33")


def test_euler_rates_of_version_1_are_derivatives_of_the_angles():
    """Against the difference of attitudes: z by 3 deg/s, then y, then x."""
    fields = {"ATTITUDE_DIR": "A2B", "EULER_ROT_SEQ": "321", "RATE_FRAME": "REF_FRAME_B"}
    angles, speeds, dt = np.array([10.0, 20.0, 30.0]), np.array([1.0, 2.0, 3.0]), 1e-4
    row = f"{LATER} 10 20 30 1 2 3"
    back = read(file(row, version="1.0", ATTITUDE_TYPE="EULER_ANGLE/RATE", **fields))
    before, after = (Rotation.from_euler("ZYX", angles + s * dt * speeds, degrees=True) for s in (-1, 1))
    expected = (before.inv() * after).as_rotvec() / (2.0 * dt)
    assert np.abs(back.angular_velocity[0] - expected).max() <= 1e-9


@pytest.mark.parametrize("sequence", ["ZXZ", "313", "z x z", "Z-X-Z", "3, 1, 3"])
def test_separators_of_a_sequence_have_no_meaning(sequence):
    back = read(file(f"{LATER} 10 20 30", ATTITUDE_TYPE="EULER_ANGLE", EULER_ROT_SEQ=sequence))
    expected = Rotation.from_euler("ZXZ", [10, 20, 30], degrees=True).as_quat(scalar_first=True)
    assert np.abs(back.quaternion("wxyz")[0] @ expected) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("name", ["J2000", "EME2000", "REF_FRAME_A"])
def test_frame_of_the_rate_may_have_another_of_its_names(name):
    fields = {"REF_FRAME_A": "J2000", "ATTITUDE_TYPE": "QUATERNION/ANGVEL", "ANGVEL_FRAME": name}
    back = read(file(f"{LATER} 0.6 0 0 0.8 0 1 0", **fields))
    expected = np.deg2rad(Rotation.from_quat([0.6, 0, 0, 0.8]).inv().apply([0.0, 1.0, 0.0]))
    np.testing.assert_allclose(back.angular_velocity[0], expected, atol=1e-17)


def two(first, second, **metadata):
    """Two segments: (start, useable start, useable stop, stop), minutes, with a row each minute."""
    parts = []
    for start, useable_start, useable_stop, stop in (first, second):
        rows = "\n".join(
            f"2020-01-01T00:{minute:02}:00 0 0 {np.sin(minute / 20)!r} {np.cos(minute / 20)!r}"
            for minute in range(start, stop + 1)
        )
        times = {
            "START_TIME": start,
            "USEABLE_START_TIME": useable_start,
            "USEABLE_STOP_TIME": useable_stop,
            "STOP_TIME": stop,
        }
        fields = {k: None if v is None else f"2020-01-01T00:{v:02}:00" for k, v in times.items()}
        parts.append(file(rows, **(fields | metadata)).replace("np.float64(", "").replace(")", ""))
    return parts[0] + parts[1][parts[1].index("META_START") :]


def test_segments_may_overlap_outside_their_useable_spans():
    back = read(two((0, 0, 3, 5), (1, 3, 6, 6)))
    assert back.elapsed.tolist() == [0.0, 60.0, 120.0, 180.0, 240.0, 300.0, 360.0]
    assert [event.kind for event in back.events] == ["segment"]


@pytest.mark.parametrize(
    "spans",
    [
        ((0, None, 1, 5), (1, None, None, 6)),
        ((0, None, None, 5), (1, 5, None, 6)),
        ((0, None, 2, 5), (1, 4, None, 6)),
    ],
    ids=["stop", "start", "gap"],
)
def test_one_useable_end_is_enough_to_cut_an_overlap(spans):
    expected = {1: [0, 60, 120, 180, 240, 300, 360], 2: [0, 60, 120, 240, 300, 360]}[spans[0][2] or 1]
    assert read(two(*spans)).elapsed.tolist() == expected


def test_rows_outside_the_useable_span_serve_interpolation():
    degree = {"INTERPOLATION_METHOD": "LAGRANGE", "INTERPOLATION_DEGREE": "3"}
    back = with_interpolation(read(two((0, 0, 3, 5), (1, 3, 6, 6), **degree)))
    t = np.array([170.0, 190.0])
    angle = np.arctan2(*back.resampled(t).quaternion("xyzw")[:, 2:].T)
    assert np.abs(angle - t / 1200).max() <= 2e-9  # the nodes on both sides of 180 s: without them 3e-7


def test_useable_spans_that_overlap_are_refused_with_the_way_out():
    with pytest.raises(
        FormatError, match="before USEABLE_STOP_TIME of the segment before; segment=k reads one"
    ):
        read(two((0, 0, 4, 5), (1, 3, 6, 6)))
    with pytest.raises(
        FormatError, match=r"START_TIME = .*: before STOP_TIME of the segment before; segment=k"
    ):
        read(two((0, None, None, 5), (1, None, None, 6)))


@pytest.mark.parametrize(
    ("stop", "epoch", "fits"),
    [
        ("00:01:00", "00:01:00.4", True),
        ("00:01:00", "00:01:01", False),
        ("00:01:00.50", "00:01:00.5099", True),
        ("00:01:00.50", "00:01:00.51", False),
        ("23:59:59", "23:59:59.9", True),
        ("00:01:00.2555", "00:01:00.256", True),
        ("00:01:00.2555", "00:01:00.257", False),
    ],
)
def test_epochs_past_a_rounded_stop_time_are_read(stop, epoch, fits):
    text = file(f"2020-01-01T{epoch} {LAST}", STOP_TIME=f"2020-01-01T{stop}")
    if fits:
        assert len(read(text)) == 1
    else:
        with pytest.raises(FormatError, match="an epoch after STOP_TIME"):
            read(text)


def test_epoch_rounded_to_before_start_time_is_read():
    start = {"START_TIME": "2020-01-01T00:00:07.2555"}
    assert len(read(file(f"2020-01-01T00:00:07.255 {LAST}\n2020-01-01T00:00:09.555 {LAST}", **start))) == 2
    with pytest.raises(FormatError, match="an epoch before START_TIME"):
        read(file(f"2020-01-01T00:00:07.25500 {LAST}\n2020-01-01T00:00:09.55501 {LAST}", **start))


def version_1_xml(kind, state, **fields):
    """A message of version 1 with one state, whose values are numbered instead of named."""
    text = text_of(motion(frame="EME2000").at(T[:1]), "xml", rates=False).replace('"2.0"', '"1.0"')
    head, rest = text.split("<attitudeState>")
    epoch = rest[rest.index("<EPOCH>") : rest.index("</EPOCH>") + len("</EPOCH>")]
    more = "".join(f"<{name}>{value}</{name}>" for name, value in fields.items())
    head = head.replace("<ATTITUDE_TYPE>QUATERNION<", f"<ATTITUDE_TYPE>{kind}<")
    head = head.replace("<TIME_SYSTEM>", f"<ATTITUDE_DIR>A2B</ATTITUDE_DIR>{more}<TIME_SYSTEM>")
    tail = rest[rest.index("</attitudeState>") :]
    return f"{head}<attitudeState>{state.format(epoch=epoch)}{tail}"


ANGLES = "".join(f'<rotation{i} angle="X_ANGLE" units="deg">{10 * i}</rotation{i}>' for i in (1, 2, 3))
RATES = "".join(f'<rotation{i} rate="X_RATE">{i}</rotation{i}>' for i in (1, 2, 3))


def test_numbered_rotations_of_version_1_in_xml():
    state = "<eulerAngleRate>{epoch}<rotationAngles>" + ANGLES + "</rotationAngles><rotationRates>"
    state += RATES + "</rotationRates></eulerAngleRate>"
    fields = {"EULER_ROT_SEQ": "321", "RATE_FRAME": "REF_FRAME_B"}
    back = read(version_1_xml("EULER_ANGLE/RATE", state, **fields))
    row = f"{LATER} 10 20 30 1 2 3"
    kvn = read(file(row, version="1.0", ATTITUDE_DIR="A2B", ATTITUDE_TYPE="EULER_ANGLE/RATE", **fields))
    assert (back.quaternion("wxyz") == kvn.quaternion("wxyz")).all()
    assert (back.angular_velocity == kvn.angular_velocity).all()
    q = "".join(f"<{n}>{v}</{n}>" for n, v in zip(("Q1", "Q2", "Q3", "QC"), LAST.split(), strict=True))
    state = "<quaternionEulerRate>{epoch}<quaternion>" + q + "</quaternion><rotationRates>"
    state += RATES + "</rotationRates></quaternionEulerRate>"
    fields = {"QUATERNION_TYPE": "LAST", "RATE_FRAME": "REF_FRAME_B"}
    back = read(version_1_xml("QUATERNION/RATE", state, **fields))
    assert np.abs(back.angular_velocity[0] - np.deg2rad([1.0, 2.0, 3.0])).max() <= 1e-17


def test_spins_of_version_1_with_and_without_nutation():
    plain = spinning("SPIN", "40 25 70 6")
    none = spinning("SPIN/NUTATION", "40 25 70 6 0 0 0", "1.0")  # no nutation: all its numbers are zero
    assert (none.angular_velocity == plain.angular_velocity).all()
    momentum = ("SPIN/NUTATION_MOM", "40 25 70 6 44 31 2")
    assert (spinning(*momentum, "1.0").angular_velocity == spinning(*momentum).angular_velocity).all()


def test_segments_of_several_types_over_one_span_are_read_one_by_one():
    first = file(f"{LATER} {LAST}")
    second = file(f"{LATER} 40 25 70 6", ATTITUDE_TYPE="SPIN")
    both = first + second[second.index("META_START") :]
    with pytest.raises(FormatError, match="segment=k reads one of them"):
        read(both)
    assert read(both, segment=2).has_rate
    following = second.replace("2020-01-01T00:0", "2020-01-01T01:0")
    joined = read(first + following[following.index("META_START") :])
    assert (len(joined), joined.has_rate) == (2, False)


def combined(*messages):
    bodies = [m[m.index("<aem") :] for m in messages]
    other = "<oem id='CCSDS_OEM_VERS' version='2.0'><header><X>text</X></header></oem>"
    return (
        f"<?xml version='1.0'?>\n<ndm>\n<MESSAGE_ID>1</MESSAGE_ID>{other}\n{''.join(bodies)}{other}</ndm>\n"
    )


def test_message_of_a_combined_instantiation_is_read():
    plain = spinning("SPIN", "40 25 70 6")
    other = spinning("SPIN", "50 25 70 6")
    one, two = text_of(plain, "xml"), text_of(other, "xml")
    assert (read(combined(one)).quaternion("wxyz") == plain.quaternion("wxyz")).all()
    assert (read(combined(one, two), message=2).quaternion("wxyz") == other.quaternion("wxyz")).all()
    with pytest.raises(FormatError, match="2 attitude ephemeris messages: message=k reads one"):
        read(combined(one, two))
    with pytest.raises(FormatError, match="no message 3, of 2"):
        read(combined(one, two), message=3)
    with pytest.raises(FormatError, match="an <ndm> without an <aem>"):
        read(combined())
    with pytest.raises(InputError, match="message: a whole number"):
        read(one, message=0)


@pytest.mark.parametrize("first", [b"<?xml version='1.0'?>", b"<!-- a -->", b"<ndm>"])
def test_endless_blanks_without_an_element_are_refused(first):
    with pytest.raises(FormatError, match=r"without an element or text|a text of more than"):
        parse(Endless(first, b"\n"), "given")
