"""CZML: against czml3 and astropy, as literal text, and what is refused."""

import copy
import io
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import GCRS, ITRS, CartesianRepresentation
from astropy.coordinates.builtin_frames import intermediate_rotation_transforms as matrices
from astropy.time import Time, TimeDelta
from scipy.interpolate import BarycentricInterpolator
from scipy.spatial.transform import Rotation

from attitude import Ephemeris, FormatError, InputError, RigidBody, TorqueFreeMotion
from attitude.formats import FORMATS, bounded_read, czml, encode
from attitude.samples import chunks
from attitude.times.instants import as_instants
from tests.effects.scenes import KEPLER, effect, quantity, scene
from tests.test_frames import orbiting

EPOCH = Time("2026-03-20T12:00:00", scale="utc")
HALF = math.sqrt(0.5)


pytestmark = pytest.mark.usefixtures("offline")


def motion(epoch=EPOCH, frame="GCRF", rate=(0.02, -0.01, 0.03)):
    body = RigidBody([1.0, 2.0, 2.5])
    return TorqueFreeMotion(body, (0.5, 0.1, -0.7, 0.5), rate, epoch, order="wxyz", frame=frame)


def earth_fixed(quaternion, seconds, epoch=EPOCH, name=""):
    q = np.tile(np.array(quaternion, dtype=float), (len(seconds), 1))
    return Ephemeris(q, as_instants(np.array(seconds, dtype=float), epoch), "ITRF", name=name)


def text_of(ephemeris, **options):
    return b"".join(encode(chunks.Samples.of(ephemeris), FORMATS["czml"], None, options).blocks).decode()


def packets(ephemeris, **options):
    return json.loads(text_of(ephemeris, **options))


def read(text, **options):
    return czml.parse(io.BytesIO(text if isinstance(text, bytes) else text.encode()), "a.czml", **options)


# -- what is written ------------------------------------------------------------------------------

QUARTER = (
    '[{"id":"document","name":"attitude","version":"1.0","clock":{"interval":"2026-03-20T12:00:00Z/'
    '2026-03-20T12:00:10.5Z","currentTime":"2026-03-20T12:00:00Z","multiplier":1.0,"range":"LOOP_STOP",'
    '"step":"SYSTEM_CLOCK_MULTIPLIER"}},{"id":"attitude","name":"attitude","availability":'
    '"2026-03-20T12:00:00Z/2026-03-20T12:00:10.5Z","description":"<p>Attitude: rotation from the body&#x27;s '
    "axes to the Earth-fixed frame (ITRF, IAU 2006/2000A, UT1 and the pole from the tables of the IERS), "
    'scalar last, unit quaternion. Error of interpolation between these attitudes is not known.</p>",'
    '"box":{"dimensions":{"cartesian":[3.0,2.0,1.0]},"outline":true,"outlineColor":{"rgba":[0,0,0,255]}},'
    '"position":{"cartesian":[7378137.0,0.0,0.0]},"orientation":{"epoch":"2026-03-20T12:00:00Z",'
    '"interpolationAlgorithm":"LINEAR","interpolationDegree":1,"unitQuaternion":[0.0,0.0,0.0,'
    "0.7071067811865476,0.7071067811865476,10.5,0.0,0.0,0.7071067811865476,0.7071067811865476]}}]\n"
)


def test_body_turned_by_a_quarter_about_the_earths_axis():
    """Its x axis points to the east of Bengal, at 90 degrees, where the frame's y axis points."""
    written = earth_fixed((HALF, 0, 0, HALF), (0.0, 10.5))
    assert written.rotation.apply([1, 0, 0]) == pytest.approx(np.tile([0, 1, 0], (2, 1)), abs=1e-15)
    assert text_of(written) == QUARTER


def test_generic_attitude_is_scalar_last():
    written = earth_fixed((0.1, 0.3, -0.5, 0.806225774829855), (1.25,))
    back = packets(written)[1]["orientation"]["unitQuaternion"]
    assert back == [1.25, 0.3, -0.5, 0.806225774829855, 0.1]


def test_attitudes_are_composed_with_the_earths_rotation_as_astropy_has_it():
    when = EPOCH + TimeDelta(np.linspace(0, 86400.0, 25), format="sec")
    written = motion().at(when)
    orientation = packets(written)[1]["orientation"]
    rows = np.array(orientation["unitQuaternion"]).reshape(-1, 5)
    assert rows[:, 0].tolist() == written.elapsed.tolist()
    to_earth = matrices.cirs_to_itrs_mat(when) @ matrices.gcrs_to_cirs_mat(when)
    expected = to_earth @ written.rotation.as_matrix()
    assert np.abs(Rotation.from_quat(rows[:, 1:]).as_matrix() - expected).max() < 1e-12
    assert ((rows[1:, 1:] * rows[:-1, 1:]).sum(axis=1) > -1.0).all()
    assert orientation["interpolationAlgorithm"] == "LINEAR"


def test_neighbours_never_flip():
    written = motion(rate=(1e-5, 1e-5, 2e-5)).at(np.linspace(0, 5 * 86400.0, 721))
    rows = np.array(packets(written)[1]["orientation"]["unitQuaternion"]).reshape(-1, 5)
    assert ((rows[1:, 1:] * rows[:-1, 1:]).sum(axis=1) > 0.99).all()


def test_czml3_builds_the_same_document():
    czml3 = pytest.importorskip("czml3")
    from czml3 import properties, types

    written = motion().at(np.arange(5.0) * 10)
    written = replace(written, name="a body")
    document, packet = packets(written, id="body-1", position=(7e6, 1.0, -2.0), box=(1, 2, 3))
    rows = np.column_stack([written.elapsed, written.in_frame("ITRF").quaternion("xyzw")])
    span = types.TimeInterval(start="2026-03-20T12:00:00Z", end="2026-03-20T12:00:40Z")
    expected = czml3.Document(
        packets=[
            czml3.Packet(
                id="document",
                name="a body",
                version=czml3.CZML_VERSION,
                clock=properties.Clock(
                    interval=span,
                    currentTime="2026-03-20T12:00:00Z",
                    multiplier=1.0,
                    range="LOOP_STOP",
                    step="SYSTEM_CLOCK_MULTIPLIER",
                ),
            ),
            czml3.Packet(
                id="body-1",
                name="a body",
                availability=span,
                description=packet["description"],
                position=properties.Position(cartesian=[7e6, 1.0, -2.0]),
                orientation=properties.Orientation(
                    epoch="2026-03-20T12:00:00Z",
                    interpolationAlgorithm="LINEAR",
                    interpolationDegree=1,
                    unitQuaternion=rows.reshape(-1).tolist(),
                ),
                box=properties.Box(
                    dimensions=properties.BoxDimensions(cartesian=[1.0, 2.0, 3.0]),
                    outline=True,
                    outlineColor=properties.Color(rgba=[0, 0, 0, 255]),
                ),
            ),
        ]
    )
    assert [document, packet] == json.loads(expected.dumps())
    back = read(expected.dumps())
    assert np.abs(back.quaternion("wxyz") - written.quaternion("wxyz")).max() < 1e-15


WRITTEN = {
    "fixed": lambda: (motion().at([0.0, 1.0, 5.0]), {}),
    "one instant": lambda: (motion().at([2.0]), {}),
    "orbit": lambda: (orbiting().run(), {}),
    "segments": lambda: (scene(effect("impulse", time=quantity(1000, "s"))).run(), {}),
    "model": lambda: (motion().at([0.0, 1.0]), {"model": "https://example.org/a.glb"}),
    "no box": lambda: (motion().at([0.0, 1.0]), {"box": None}),
}


@pytest.mark.parametrize("name", WRITTEN)
def test_czml3_takes_what_is_written(name):
    czml3 = pytest.importorskip("czml3")
    written, options = WRITTEN[name]()
    text = text_of(written, **options)
    assert json.loads(czml3.Document.model_validate_json(text).dumps()) == json.loads(text)


@pytest.mark.parametrize("name", WRITTEN)
def test_what_is_written_comes_back(name):
    written, options = WRITTEN[name]()
    text = text_of(written, **options)
    back = read(text)
    assert back.frame == "GCRF"
    assert back.elapsed.tolist() == written.elapsed.reshape(-1).tolist()
    assert np.abs(back.quaternion("wxyz") - written.quaternion("wxyz").reshape(-1, 4)).max() < 1e-15
    assert back.epoch.isot == written.epoch.isot
    assert not back.has_rate
    fixed = read(text, frame="ITRF")
    expected = written.in_frame("ITRF").quaternion("wxyz").reshape(-1, 4)
    assert fixed.quaternion("wxyz").tobytes() == np.ascontiguousarray(expected).tobytes()
    assert text_of(fixed) == text_of(fixed)


def test_files_by_their_ending(tmp_path):
    written = motion().at([0.0, 1.0])
    written = replace(written, name="a <body>")
    written.write(tmp_path / "a.czml")
    back = Ephemeris.read(tmp_path / "a.czml")
    assert back.name == "a <body>"
    assert Ephemeris.read(tmp_path / "a.czml", frame="EME2000").frame == "EME2000"
    with pytest.raises(InputError, match="unknown option of czml; known: id, position, box, model"):
        written.write(tmp_path / "b.czml", colour="red")


def test_instants_in_another_scale_are_seconds_since_the_same_epoch():
    epoch = Time("2026-03-20T12:01:09.184", scale="tt")
    back = packets(motion(epoch=epoch).at([0.0, 30.0]))[1]["orientation"]
    assert back["epoch"] == "2026-03-20T12:00:00Z"
    assert back["unitQuaternion"][5] == 30.0


def test_leap_second_is_second_sixty():
    written = motion(epoch=Time("2016-12-31T23:59:50", scale="utc")).at(np.arange(11.0))
    packet = packets(written)[1]
    assert packet["availability"] == "2016-12-31T23:59:50Z/2016-12-31T23:59:60Z"
    back = read(text_of(motion(epoch=Time("2016-12-31T23:59:60.5", scale="utc")).at([0.0, 1.0])))
    assert back.epoch.isot == "2016-12-31T23:59:60.500"
    assert back.time.isot.tolist() == ["2016-12-31T23:59:60.500", "2017-01-01T00:00:00.500"]


def test_pieces_make_no_difference(monkeypatch):
    written = orbiting(count=40).run()
    whole = text_of(written)
    monkeypatch.setattr(chunks, "CHUNK_INSTANTS", 7)
    monkeypatch.setattr(czml, "CHUNK_INSTANTS", 7)
    assert text_of(written) == whole


def test_samples_are_prepared_in_the_earth_fixed_frame_in_which_cesium_interpolates():
    fixed = czml.prepared(chunks.Samples.of(orbiting().run()), czml.CzmlOptions())
    assert fixed.first.frame == fixed.ephemeris().resampled([3.0]).frame == "ITRF"


def test_nobody_interpolates_across_an_impulse():
    written = scene(effect("impulse", time=quantity(1000, "s"))).run()
    first, second = packets(written)[1]["orientation"]
    assert first["unitQuaternion"][::5] == [0.0, 600.0]
    assert second["unitQuaternion"][::5] == list(np.arange(1200.0, 6001.0, 600.0))
    assert first["interval"] == "2026-03-20T12:00:00Z/2026-03-20T12:20:00Z"
    assert second["interval"] == "2026-03-20T12:20:00Z/2026-03-20T13:40:00Z"
    assert first["forwardExtrapolationType"] == second["forwardExtrapolationType"] == "HOLD"
    (event,) = read(text_of(written)).events
    assert (event.kind, event.seconds) == ("segment", 1200.0)


def test_body_on_an_orbit_is_drawn_along_it():
    written = orbiting(count=5).run()
    back = packets(written)[1]["position"]
    rows = np.array(back["cartesian"]).reshape(-1, 4)
    assert (back["interpolationAlgorithm"], back["interpolationDegree"]) == ("LAGRANGE", 5)
    assert rows[0, 0] == 0.0
    assert rows[-1, 0] == 6000.0
    middle = rows[40:46, 0].mean()
    at = BarycentricInterpolator(rows[40:46, 0], rows[40:46, 1:])(middle)
    instants = as_instants([middle], EPOCH)
    position, _ = written.orbit.state(instants)
    gcrs = GCRS(CartesianRepresentation(position.T * u.m), obstime=instants.time)
    itrs = gcrs.transform_to(ITRS(obstime=instants.time)).cartesian.xyz.to_value(u.m).T
    assert np.abs(at - itrs).max() < 0.05


def test_body_about_mars_is_not_drawn_about_the_earth():
    orbit = {**KEPLER, "mu": quantity(4.2828e13, "m3/s2")}
    assert packets(orbiting(orbit).run())[1]["position"] == {"cartesian": list(czml.DEFAULT_POSITION)}


def test_position_may_be_given():
    back = packets(orbiting().run(), position="1,2.5,-3")[1]["position"]
    assert back == {"cartesian": [1.0, 2.5, -3.0]}


@pytest.mark.parametrize("position", ["1,2", (1, 2, math.nan), "a,b,c", 3, (1, 2, 3, 4), (1, None, 2)])
def test_position_that_is_none_is_refused(position):
    with pytest.raises(InputError, match="position: three finite numbers, m"):
        text_of(motion().at([0.0]), position=position)


REFUSED = {
    "undated": (lambda: motion(epoch=None).at([0.0]), "epoch: a Time, for instants to be dated"),
    "backwards": (lambda: motion().at([0.0, 2.0, 1.0]), "increasing order"),
    "twice": (lambda: motion().at([0.0, 0.0]), "increasing order"),
    "own frame": (lambda: motion(frame="INERTIAL").at([0.0]), "relative to the Earth-fixed frame .*INERTIAL"),
    "along an orbit": (lambda: orbiting().run().in_frame("LVLH"), "no rotation from LVLH"),
    "beyond the tables": (
        lambda: motion(epoch=Time("2061-01-01", scale="tai")).at([0.0]),
        "tables of UT1 cover",
    ),
    "two dimensions": (lambda: motion().at([[0.0, 1.0]]), "one body at a list of instants"),
}


@pytest.mark.filterwarnings("ignore:ERFA function:erfa.ErfaWarning")
@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_written_is_refused_and_leaves_no_file(name, tmp_path):
    build, message = REFUSED[name]
    with pytest.raises(FormatError, match=message):
        build().write(tmp_path / "a.czml")
    assert not list(tmp_path.iterdir())


# -- what is read ---------------------------------------------------------------------------------


def other(**orientation):
    """As other people write it."""
    written = {
        "interpolationAlgorithm": "LINEAR",
        "interpolationDegree": 1,
        "epoch": "2012-03-15T10:00:00Z",
        "unitQuaternion": [0, 0.5, -0.5, 0.5, 0.5, 300, 0, 0, 0.6, 0.8, 600.5, 0, 0, 0, 1],
        **orientation,
    }
    written = {key: value for key, value in written.items() if value is not None}
    return [
        {"id": "document", "version": "1.0"},
        {"id": "ground", "position": {"cartesian": [1, 2, 3]}},
        {"id": "a", "name": "satellite", "orientation": written, "label": {"text": "x"}},
    ]


def test_other_peoples_files_are_read():
    back = read(json.dumps(other()), frame="ITRF")
    assert back.name == "satellite"
    assert back.elapsed.tolist() == [0.0, 300.0, 600.5]
    assert back.quaternion("wxyz").tolist() == [[0.5, 0.5, -0.5, 0.5], [0.8, 0, 0, 0.6], [1, 0, 0, 0]]
    assert back.time.isot.tolist() == [
        "2012-03-15T10:00:00.000",
        "2012-03-15T10:05:00.000",
        "2012-03-15T10:10:00.500",
    ]


def test_dates_at_every_attitude_are_read():
    """Over a leap second: what UTC calls a second is one."""
    rows = [
        "2012-06-30T23:59:59Z",
        0,
        0,
        0,
        1,
        "2012-06-30T23:59:60.5Z",
        0,
        0,
        0.6,
        0.8,
        "2012-07-01T00:00Z",
        0,
        0,
        0,
        1,
    ]
    back = read(json.dumps(other(unitQuaternion=rows, epoch=None)), frame="ITRF")
    assert back.elapsed == pytest.approx([0.0, 1.5, 2.0], abs=1e-9)


def test_intervals_with_their_own_epochs_are_read():
    parts = [
        {"epoch": "2012-03-15T10:00:00Z", "unitQuaternion": [0, 0, 0, 0, 1, 10, 0, 0, 0, 1]},
        {
            "interval": "2012-03-15T10:00:20Z/2012-03-15T10:01:00Z",
            "epoch": "2012-03-15T10:00:30Z",
            "unitQuaternion": [-10, 0, 0, 0.6, 0.8, 30, 0, 0, 0, 1],
        },
    ]
    packets = other()
    packets[2]["orientation"] = parts
    back = read(json.dumps(packets), frame="ITRF")
    assert back.elapsed == pytest.approx([0.0, 10.0, 20.0, 60.0], abs=1e-9)
    assert [(event.kind, event.seconds) for event in back.events] == [
        ("segment", pytest.approx(20.0, abs=1e-9))
    ]


def test_one_of_several_packets_is_read_by_its_id():
    packets = other()
    packets.append({**copy.deepcopy(packets[2]), "id": "b"})
    with pytest.raises(FormatError, match=r"several packets have an orientation \('a', 'b'\)"):
        read(json.dumps(packets))
    assert read(json.dumps(packets), id="b").shape == (3,)
    with pytest.raises(FormatError, match="no packet 'c' has an orientation"):
        read(json.dumps(packets), id="c")


START = "2012-03-15T10:00:00Z"


def orientations(*parts, ids=None):
    """A document with an orientation of these parts, in one packet or each in one of its own."""
    document = other()[:1]
    if ids is None:
        return json.dumps([*document, {"id": "a", "orientation": list(parts)}])
    return json.dumps([*document, *({"id": i, "orientation": p} for i, p in zip(ids, parts, strict=True))])


def sampled(*rows, **more):
    return {"epoch": START, "unitQuaternion": [number for row in rows for number in row], **more}


def test_packets_of_one_id_are_parts_of_one():
    first = sampled((0, 0, 0, 0, 1), (10, 0, 0, 0.6, 0.8))
    second = sampled((10, 0, 0, 0.8, 0.6), (20, 0, 0, 0, 1))
    back = read(orientations(first, second, ids=["a", "a"]), frame="ITRF")
    assert back.elapsed.tolist() == [0.0, 10.0, 20.0]
    # of two samples at one instant Cesium keeps the one that came last
    assert back.quaternion("wxyz")[1].tolist() == [0.6, 0.0, 0.0, 0.8]
    assert not back.events
    with pytest.raises(FormatError, match="several packets have an orientation"):
        read(orientations(first, second, ids=["a", "b"]))


def test_samples_of_packets_of_one_id_may_interleave():
    first = sampled((0, 0, 0, 0, 1), (10, 0, 0, 0.6, 0.8))
    second = sampled((5, 0, 0.6, 0, 0.8), (15, 0, 0, 0, 1))
    back = read(orientations(first, second, ids=["a", "a"]), frame="ITRF")
    assert back.elapsed.tolist() == [0.0, 5.0, 10.0, 15.0]
    assert back.quaternion("wxyz")[1].tolist() == [0.8, 0.0, 0.6, 0.0]


@pytest.mark.parametrize("ids", [None, ["a", "a"]], ids=["one packet", "two packets"])
def test_intervals_that_share_an_instant_keep_both_attitudes(ids):
    spans = [f"{START}/2012-03-15T10:00:10Z", "2012-03-15T10:00:10Z/2012-03-15T10:00:20Z"]
    first = sampled((0, 0, 0, 0, 1), (10, 0, 0, 0.6, 0.8), interval=spans[0])
    second = sampled((10, 0, 0, 0.8, 0.6), (20, 0, 0, 0, 1), interval=spans[1])
    back = read(orientations(first, second, ids=ids), frame="ITRF")
    assert back.elapsed.tolist() == [0.0, np.nextafter(10.0, 0.0), 10.0, 20.0]
    assert back.quaternion("wxyz")[1:3].tolist() == [[0.8, 0.0, 0.0, 0.6], [0.6, 0.0, 0.0, 0.8]]
    assert [event.seconds for event in back.events] == [10.0]
    overlap = sampled((9, 0, 0, 0.8, 0.6), (20, 0, 0, 0, 1), interval=f"{START}/2012-03-15T10:00:20Z")
    with pytest.raises(FormatError, match=r"9\.0 s is not after 10\.0 s"):
        read(orientations(first, overlap, ids=ids))


DATES = ["2012-03-15T11:00:00+01:00", "2012-03-15T04:30:00-05:30", "20120315T100000Z", "2012-075T10:00:00.0Z"]


@pytest.mark.parametrize("date", [START.replace("Z", "+00:00"), START.replace("Z", "+0000"), *DATES])
def test_dates_of_every_form_of_iso_8601_are_read(date):
    back = read(json.dumps(other(epoch=date)), frame="ITRF")
    assert back.epoch.isot == "2012-03-15T10:00:00.000"
    with pytest.raises(FormatError, match="no date such as"):
        read(json.dumps(other(epoch=START.removesuffix("Z"))))


QS = [0, 0, 0, 0, 1, 1, 0, 0, 0, 1]
MALFORMED = {
    "not JSON": ("[{", "a.czml, line 1: not JSON"),
    "no list": ("{}", "a list of packets"),
    "empty": ("[]", "a list of packets"),
    "packets of something else": ("[1]", "a list of packets"),
    "no document": ([other()[2]], "the first packet is not the document's"),
    "no version": ([{"id": "document"}, other()[2]], "the first packet is not the document's"),
    "version to come": ([{"id": "document", "version": "2.0"}, other()[2]], "version '2.0' of CZML"),
    "nothing turns": (other()[:2], "no packet has an orientation"),
    "another packet's": (other(unitQuaternion=None, reference="a#b"), "reference to 'a#b', which is not"),
    "along the velocity": (
        other(velocityReference="#position"),
        "velocityReference to '#position', which is not",
    ),
    "unknown key": (other(colour="red"), "'colour' is not read"),
    "constant": (other(unitQuaternion=[0, 0, 0, 1]), "one attitude without an instant"),
    "no attitude": (other(unitQuaternion=[]), "0 numbers"),
    "number missing": (other(unitQuaternion=QS[:-1]), "9 numbers"),
    "text": (other(unitQuaternion=[*QS[:-1], "1"]), "something else than numbers"),
    "yes": (other(unitQuaternion=[*QS[:-1], True]), "something else than numbers"),
    "infinite": (json.dumps(other()).replace("600.5", "1e400"), "not JSON|finite"),
    "not a number": (json.dumps(other()).replace("600.5", "NaN"), "not JSON"),
    "not unit": (other(unitQuaternion=[*QS[:-1], 1.1]), r"unitQuaternion\[1\].*a unit quaternion"),
    "backwards": (other(unitQuaternion=QS[5:] + QS[:5]), "0.0 s is not after 1.0 s"),
    "twice": (other(unitQuaternion=QS[:5] * 2), "0.0 s is not after 0.0 s"),
    "no epoch": (other(epoch=None), "times without an epoch"),
    "epoch without Z": (other(epoch="2012-03-15T10:00:00"), "no date such as"),
    "epoch of no calendar": (other(epoch="2012-13-15T10:00:00Z"), "epoch: a date"),
    "second 60 of no leap second": (other(epoch="2012-03-15T10:00:60Z"), "epoch: a date"),
    "epoch that is no text": (other(epoch=3), "no date such as"),
    "times of two kinds": (other(unitQuaternion=["2012-03-15T10:00:00Z", *QS[1:]]), "neither all numbers"),
    "interval of one date": (other(interval="2012-03-15T10:00:00Z"), "no two dates"),
    "outside the interval": (
        other(interval="2012-03-15T10:00:00Z/2012-03-15T10:10:00Z"),
        "attitudes outside their interval",
    ),
    "no intervals": ([other()[0], {"id": "a", "orientation": []}], "orientation: an empty list"),
    "intervals of something else": ([other()[0], {"orientation": [1]}], "orientation: no unitQuaternion"),
    "beyond the tables": (other(epoch="2161-03-15T10:00:00Z"), "tables of UT1 cover"),
    "before any UT1": (other(epoch="1912-03-15T10:00:00Z"), "tables of UT1 cover"),
}


@pytest.mark.filterwarnings("ignore:ERFA function:erfa.ErfaWarning")
@pytest.mark.parametrize("name", MALFORMED)
def test_malformed_files_are_refused_by_name(name, tmp_path):
    written, message = MALFORMED[name]
    (tmp_path / "a.czml").write_text(written if isinstance(written, str) else json.dumps(written))
    with pytest.raises(FormatError, match=message) as caught:
        Ephemeris.read(tmp_path / "a.czml")
    assert caught.value.source == str(tmp_path / "a.czml")
    assert str(caught.value).count("a.czml") == 1


def test_unknown_frame_to_read_into_is_refused():
    with pytest.raises(InputError, match="frame: a frame, one of"):
        read(QUARTER, frame="ECEF")


def test_too_long_a_file_is_refused(monkeypatch):
    monkeypatch.setattr(bounded_read, "MAX_TEXT_BYTES", 100)
    with pytest.raises(FormatError, match="more than 100 bytes"):
        read(QUARTER)


STATED = {
    "a degree beyond": ([("LAGRANGE", 40)], "interpolationDegree 40 is taken for 31"),
    "no degree": ([("HERMITE", 0)], "interpolationDegree 0 is taken for 1"),
    "an unknown algorithm": ([("SPLINE", 3)], "'SPLINE' of degree 3 is taken for LINEAR"),
    "a degree that is none": ([("LAGRANGE", "5")], "of degree '5' is taken for LINEAR"),
    "several": ([("LAGRANGE", 5), ("LINEAR", 1)], "intervals state several interpolations"),
}


@pytest.mark.parametrize(("stated", "said"), STATED.values(), ids=STATED)
def test_what_cannot_be_interpolated_as_stated_is_noted(stated, said, tmp_path):
    day = "2026-03-20T12:0{0}:00Z/2026-03-20T12:0{1}:00Z"
    parts = [
        {
            "epoch": "2026-03-20T12:00:00Z",
            "interval": day.format(i, i + 1),
            "interpolationAlgorithm": algorithm,
            "interpolationDegree": degree,
            "unitQuaternion": [60 * i, 0, 0, 0, 1, 60 * i + 30, 0, 0, 0.6, 0.8],
        }
        for i, (algorithm, degree) in enumerate(stated)
    ]
    packet = {"id": "a", "orientation": parts if len(parts) > 1 else parts[0]}
    path = tmp_path / "a.czml"
    path.write_text(json.dumps([{"id": "document", "version": "1.0"}, packet]))
    (note,) = Ephemeris.read(path).plan.notes
    assert said in note
