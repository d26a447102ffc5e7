"""STK attitude files: literal ones read, bits that come back, and what is refused with its line."""

import re
from dataclasses import replace

import numpy as np
import pytest
from astropy.time import Time

from attitude import Ephemeris, FormatError, InputError, RigidBody, TorqueFreeMotion
from attitude.formats import interpolation_nodes, stk
from attitude.samples import chunks
from attitude.samples.event import Event
from attitude.times.instants import Instants
from tests.tables import table

BODY = RigidBody((1.0, 1.6, 2.1))
Q0, OMEGA = (0.1, -0.7, 0.5, 0.5), (0.3, -0.5, 0.9)
EPOCH = Time("2016-12-31T23:59:50", scale="utc")
T = np.arange(40) / 4


def motion(frame="ICRF", epoch=EPOCH):
    return TorqueFreeMotion(BODY, Q0, OMEGA, epoch, order="wxyz", frame=frame)


def text_of(folder, ephemeris, **options):
    ephemeris.write(folder / "a.a", **options)
    return (folder / "a.a").read_text()


def read(folder, text):
    (folder / "a.a").write_bytes(text if isinstance(text, bytes) else text.encode())
    return Ephemeris.read(folder / "a.a")


def keywords(text):
    return dict(re.findall(r"(?m)^([A-Z]\w+) +(\S.*)$", text.partition("BEGIN")[2].partition("END")[0]))


def rows(text):
    return [line.split() for line in text.splitlines() if re.match(r"-?\d", line)]


# -- written -----------------------------------------------------------------------------------------


def test_header_says_what_stk_needs(tmp_path):
    text = text_of(tmp_path, motion().at(T))
    assert keywords(text) == {
        "NumberOfAttitudePoints": "40",
        "ScenarioEpoch": "31 Dec 2016 23:59:50.000000000",
        "BlockingFactor": "20",
        "InterpolationMethod": "Lagrange",
        "InterpolationOrder": "1",
        "CentralBody": "Earth",
        "CoordinateAxes": "ICRF",
    }
    assert "\nAttitudeTimeQuaternions\n" in text
    assert {len(row) for row in rows(text)} == {5}


@pytest.mark.parametrize(("frame", "axes"), [("GCRF", "ICRF"), ("EME2000", "J2000"), ("ECLIPJ2000", "ICRF")])
def test_axes_are_those_stk_knows(frame, axes, tmp_path):
    assert keywords(text_of(tmp_path, motion(frame).at(T)))["CoordinateAxes"] == axes


def test_ecliptic_attitudes_are_turned_into_the_icrf(tmp_path):
    """By the obliquity about x; SPICE, and this library once, differ by the frame bias, 1.1e-7 rad."""
    q = np.tile([1.0, 0.0, 0.0, 0.0], (2, 1))
    ephemeris = Ephemeris(q, Instants(np.array([0.0, 1.0]), None, EPOCH), "ECLIPJ2000")
    half = np.deg2rad(84381.448 / 3600) / 2
    found = np.array(rows(text_of(tmp_path, ephemeris)), dtype=float)[:, 1:]
    assert np.allclose(found, [np.sin(half), 0, 0, np.cos(half)], rtol=0, atol=1.2e-7)


def test_options_are_written_as_they_stand(tmp_path):
    options = {"central_body": "Sun", "version": "stk.v.12.2", "interpolation_order": 7}
    text = text_of(tmp_path, motion().at(T), **options)
    assert text.startswith("stk.v.12.2\n")
    assert keywords(text)["CentralBody"] == "Sun"
    assert keywords(text)["InterpolationOrder"] == "7"
    assert stk.interpolant(stk.StkOptions(**options)) == interpolation_nodes.Interpolant(
        "lagrange", 7, crosses=True
    )
    assert stk.interpolant(stk.StkOptions()) == interpolation_nodes.Interpolant("lagrange", 1, crosses=True)


def test_comments_say_convention_and_error_in_ascii(tmp_path):
    ephemeris = motion().at(T)
    ephemeris = replace(ephemeris, name="Å\nBEGIN Attitude\r")
    text = text_of(tmp_path, ephemeris)
    assert text.isascii()
    assert "# q rotates body to inertial" in text
    assert "scalar last" in text
    assert "# Error of interpolation" in text
    assert len(read(tmp_path, text)) == 40


@pytest.mark.parametrize("second", ["23:59:59.75", "23:59:60", "23:59:60.999"])
def test_epoch_is_never_in_a_leap_second(second, tmp_path):
    epoch = Time(f"2016-12-31T{second}", scale="utc")
    ephemeris = motion(epoch=epoch).at(T)
    text = text_of(tmp_path, ephemeris)
    assert keywords(text)["ScenarioEpoch"] == "31 Dec 2016 23:59:59.000000000"
    assert float(rows(text)[0][0]) == pytest.approx(float(second[6:]) - 59, abs=1e-10)
    assert np.abs((read(tmp_path, text).time - ephemeris.time).sec).max() < 1e-9


# -- round trip --------------------------------------------------------------------------------------


@pytest.mark.parametrize("rates", [False, True])
@pytest.mark.parametrize("frame", ["ICRF", "EME2000"])
def test_bits_of_quaternions_come_back(frame, rates, tmp_path):
    ephemeris = motion(frame).at(np.arange(0, 20, 0.25))
    back = read(tmp_path, text_of(tmp_path, ephemeris, rates=rates))
    assert np.array_equal(back.quaternion("wxyz"), ephemeris.quaternion("wxyz"))
    assert np.abs((back.time - ephemeris.time).sec).max() < 1e-9
    assert (back.frame, back.epoch.scale, back.has_rate) == (frame, "utc", rates)
    if rates:
        assert np.allclose(back.angular_velocity, ephemeris.angular_velocity, rtol=1e-15, atol=1e-16)


@pytest.mark.parametrize("scale", ["utc", "tai", "tt", "tdb"])
def test_dates_of_any_scale_come_back(scale, tmp_path):
    epoch = Time("2016-12-31T23:59:50.123456789", scale="utc")
    ephemeris = motion(epoch=getattr(epoch, scale)).at(T)
    back = read(tmp_path, text_of(tmp_path, ephemeris))
    assert np.abs((back.time - ephemeris.time).sec).max() < 1e-9


# -- segments ----------------------------------------------------------------------------------------


def in_segments(*groups, jump=False):
    """Nodes of several segments, each of these indices of the same motion."""
    whole = motion().at(T)
    segments = []
    for i, group in enumerate(groups):
        part = whole[list(group)]
        if jump and i:
            part = Ephemeris(motion().at(T + 1)[list(group)].quaternion("wxyz").copy(), part.instants, "ICRF")
        segments.append(chunks.Samples.of(part))
    return interpolation_nodes.Nodes(tuple(segments), stk.interpolant(stk.StkOptions()), None)


def test_an_instant_that_two_segments_share_stands_once(tmp_path):
    (tmp_path / "a.a").write_bytes(
        b"".join(stk.blocks(in_segments(range(11), range(10, 20), [19, 25]), stk.StkOptions()))
    )
    text = (tmp_path / "a.a").read_text()
    assert [float(row[0]) for row in rows(text)] == T[[*range(20), 25]].tolist()
    assert keywords(text)["NumberOfAttitudePoints"] == "21"
    assert text.count("# the rate jumps after") == 2
    assert len(read(tmp_path, text)) == 21


def test_two_attitudes_at_one_instant_are_refused():
    with pytest.raises(FormatError, match="STK takes an instant once"):
        b"".join(stk.blocks(in_segments(range(11), range(10, 20), jump=True), stk.StkOptions()))


def test_impulses_are_comments_and_allow_no_higher_order(tmp_path):
    whole = motion().at(T)
    events = (Event(5.1, "impulse", ""),)
    ephemeris = Ephemeris(whole.quaternion("wxyz").copy(), whole.instants, "ICRF", events=events)
    text = text_of(tmp_path, ephemeris)
    assert "# the rate jumps after 5.0 s of elapsed time; STK interpolates from there to 5.25 s" in text
    with pytest.raises(FormatError, match="no segments"):
        ephemeris.write(tmp_path / "b.a", interpolation_order=5)
    assert not (tmp_path / "b.a").exists()


REFUSED = {
    "undated": (lambda: motion(epoch=None).at(T), {}, FormatError, "without an epoch"),
    "backwards": (
        lambda: motion().at(T[::-1]),
        {},
        FormatError,
        "increasing order",
    ),
    "frame of the user": (lambda: motion("INERTIAL").at(T), {}, InputError, "frame"),
    "order": (lambda: motion().at(T), {"interpolation_order": 0}, InputError, "interpolation_order"),
    "version": (lambda: motion().at(T), {"version": "11"}, InputError, "version"),
    "body": (lambda: motion().at(T), {"central_body": "a b"}, InputError, "central_body"),
    "rates of none": (
        lambda: Ephemeris(motion().at(T).quaternion("wxyz").copy(), motion().at(T).instants, "ICRF"),
        {"rates": True},
        InputError,
        "rates",
    ),
}


@pytest.mark.parametrize(("make", "options", "error", "message"), REFUSED.values(), ids=REFUSED)
def test_what_stk_cannot_hold_is_refused_and_leaves_no_file(make, options, error, message, tmp_path):
    with pytest.raises(error, match=message):
        make().write(tmp_path / "a.a", **options)
    assert list(tmp_path.iterdir()) == []


# -- of others ---------------------------------------------------------------------------------------

LITERAL = """stk.v.4.3
# WrittenBy STK_v4.3
BEGIN Attitude
NUMBEROFATTITUDEPOINTS\t3
MessageLevel Warnings
ScenarioEpoch "1 Jul 2007 12:00:00.25"
InterpolationMethod Hermite
CentralBody Sun
CoordinateAxes J2000
TimeFormat EpSec

attitudetimequaternions
0.0 0.6 0.0 0.0 0.8

1.0e+000\t0 0.6 0 0.8
  # halfway
2 0 0 0.6 8.0e-1
END ATTITUDE
"""


def test_file_of_another_program_is_read(tmp_path):
    back = read(tmp_path, LITERAL)
    assert back.quaternion("wxyz").tolist() == [[0.8, 0.6, 0, 0], [0.8, 0, 0.6, 0], [0.8, 0, 0, 0.6]]
    assert back.elapsed.tolist() == [0, 1, 2]
    assert back.frame == "EME2000"
    assert back.epoch.isot == "2007-07-01T12:00:00.250"
    assert back.epoch.scale == "utc"


def test_scalar_first_and_rates_and_inertial_axes_are_read(tmp_path):
    first = LITERAL.replace("attitudetimequaternions", "AttitudeTimeQuatScalarFirst").replace(
        "J2000", "Inertial"
    )
    back = read(tmp_path, first.replace("\n", "\r\n"))
    assert back.quaternion("wxyz").tolist() == [[0.6, 0, 0, 0.8], [0, 0.6, 0, 0.8], [0, 0, 0.6, 0.8]]
    assert back.frame == "ICRF"
    rated = re.sub(r"(?m)(0\.8|8\.0e-1)$", r"\1 180 0 -90", LITERAL).replace("quaternions", "QuatAngVels")
    rate = read(tmp_path, rated).angular_velocity
    assert np.allclose(rate, np.tile([np.pi, 0, -np.pi / 2], (3, 1)), rtol=1e-15, atol=0)


def test_epoch_in_a_leap_second_is_read(tmp_path):
    back = read(tmp_path, LITERAL.replace("1 Jul 2007 12:00:00.25", "31 Dec 2016 23:59:60.5"))
    assert back.time.isot[2] == "2017-01-01T00:00:01.500"


@pytest.mark.parametrize(
    ("edit", "message", "line"), [pytest.param(*row, id=row[1]) for row in table("malformed_stk")]
)
def test_malformed_files_are_refused_with_their_line(edit, message, line, tmp_path):
    text = re.sub(*edit, LITERAL)
    assert text != LITERAL
    with pytest.raises(FormatError, match=message) as caught:
        read(tmp_path, text)
    assert (caught.value.source, caught.value.line) == (str(tmp_path / "a.a"), line)
