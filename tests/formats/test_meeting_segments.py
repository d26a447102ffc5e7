"""Segments of an AEM that meet: the first ends at the instant at which the second begins."""

import json
import re
from itertools import pairwise

import numpy as np
import pytest

from attitude import Ephemeris, FormatError, Scene
from attitude.formats.interpolation_nodes import Interpolant
from tests.effects.scenes import effect, quantity
from tests.formats.test_nodes import angle, between
from tests.formats.texts import HEADER, aem_segment

SCENE = {
    "body": {"moments": [1, 2, 2.5], "unit": "kg m2", "mass": quantity(3, "kg")},
    "epoch": {"time": "2024-03-01T00:00:00", "scale": "utc"},
    "frame": "EME2000",
    "attitude": {"quaternion": [1, 0, 0, 0], "order": "wxyz"},
    "angular_velocity": quantity([1, 2, 3], "deg/s"),
    "times": {"start": 0, "stop": 60, "count": 7, "unit": "s"},
}
FALL = {
    "attitude": {"quaternion": [0.33, -0.55, 0.77, 0.0], "order": "wxyz"},
    "angular_velocity": quantity([0.4, -1.0, 0.6], "rad/s"),
    "position": quantity([0, 0, 5], "m"),
    "velocity": quantity([1, 0, 0], "m/s"),
    "times": {"start": 0, "stop": 2, "count": 21, "unit": "s"},
}
GRAVITY = effect("uniform_gravity")
SHAPE = {"box": [1, 0.8, 0.5], "unit": "m"}
GROUND = effect("ground", shape=SHAPE, restitution=0.6, friction=0.3)


def impulse(seconds, size=0.1):
    return effect("impulse", time=quantity(seconds, "s"), angular_impulse=quantity([size, 0, 0], "N m s"))


def torque(start, stop):
    span = {"start": quantity(start, "s"), "stop": quantity(stop, "s")}
    return effect("constant_torque", torque=quantity([0.001, 0, 0], "N m"), **span)


def unit(document):
    q = np.array(document["attitude"]["quaternion"])
    return document | {"attitude": {"quaternion": (q / np.linalg.norm(q)).tolist(), "order": "wxyz"}}


def dated(seconds_past_the_minute):
    return {"epoch": {"time": f"2024-03-01T00:00:{seconds_past_the_minute}", "scale": "utc"}}


DOCUMENTS = {
    "impulse": SCENE | {"effects": [impulse(30.0)]},
    "impulse between nanoseconds": SCENE | dated("00.123456789") | {"effects": [impulse(12.3456789012345)]},
    "impulse where its tick is rounded": SCENE | dated("00.5") | {"effects": [impulse(31.9999999)]},
    "both ends of a torque": SCENE | {"effects": [torque(20.0, 40.0)]},
    "impulse during a torque": SCENE | {"effects": [torque(20.0, 40.0), impulse(30.0)]},
    "contacts": unit(SCENE | FALL | {"effects": [GRAVITY, GROUND]}),
}
each_scene = pytest.mark.parametrize("name", DOCUMENTS)


def scene(name):
    return Scene.from_json(json.dumps(DOCUMENTS[name]))


def events(ephemeris):
    last = ephemeris.elapsed[-1]
    return sorted({event.seconds for event in ephemeris.events if 0 < event.seconds < last})


def spans(path):
    """(starts, stops) as the metadata state them."""
    text = path.read_text()
    return [re.findall(rf"\b{name}_TIME(?: = |>)([^\s<]+)", text) for name in ("START", "STOP")]


@pytest.mark.parametrize("degree", [1, 4, 7])
@pytest.mark.parametrize("ending", [".aem", ".xml"])
@each_scene
def test_segments_meet_at_every_event_and_keep_the_tolerance(name, ending, degree, tmp_path):
    path, ephemeris, tolerance = tmp_path / f"a{ending}", scene(name).run(), 1e-4
    written = ephemeris.write(path, interpolation_error=tolerance, degree=degree)
    starts, stops = spans(path)
    at = events(ephemeris)
    assert len(starts) == len(at) + 1
    assert starts[1:] == stops[:-1]

    back = Ephemeris.read(path)
    assert len(back) == written.nodes
    assert [event.kind for event in back.events] == ["segment"] * len(at)
    assert [event.seconds for event in back.events] == pytest.approx(at, abs=1.1e-9)
    edges = [0, *(int(np.searchsorted(back.elapsed, event.seconds)) for event in back.events), len(back)]
    t, q = back.elapsed, back.quaternion("wxyz")
    for first, last in pairwise(edges):
        middle = t[first : last - 1] + 0.5 * np.diff(t[first:last])
        interpolated = between(Interpolant("lagrange", degree), t[first:last], q[first:last], middle)
        true = ephemeris.resampled(middle).quaternion("wxyz")
        assert angle(interpolated, true).max() < 1.01 * tolerance


@pytest.mark.parametrize("ending", [".aem", ".xml"])
@each_scene
def test_both_attitudes_at_an_event_are_one_and_each_rate_is_of_its_own_side(name, ending, tmp_path):
    path, ephemeris = tmp_path / f"a{ending}", scene(name).run()
    ephemeris.write(path, interpolation_error=1e-4)
    back = Ephemeris.read(path)
    for event, true in zip(back.events, events(ephemeris), strict=True):
        after = int(np.searchsorted(back.elapsed, event.seconds))
        q, rate = back.quaternion("wxyz")[after - 1 : after + 1], back.angular_velocity[after - 1 : after + 1]
        assert angle(q[:1], q[1:]).max() < 2e-10  # of a contact: 2e-11 s at 6 rad/s
        sides = ephemeris.resampled([true - 1e-9, true + 1e-9]).angular_velocity
        assert np.abs(rate - sides).max() < 1e-7


def test_rate_at_an_impulse_jumps_by_the_impulse_over_the_moment(tmp_path):
    scene("impulse").write(tmp_path / "a.aem", interpolation_error=1e-4)
    back = Ephemeris.read(tmp_path / "a.aem")
    after = int(np.searchsorted(back.elapsed, 30.0))
    jump = back.angular_velocity[after] - back.angular_velocity[after - 1]
    assert jump == pytest.approx([0.1, 0.0, 0.0], abs=1e-14)


@pytest.mark.parametrize("ending", [".bc", ".czml", ".xml", ".aem"])
@each_scene
def test_what_was_read_from_another_format_meets_too(name, ending, tmp_path):
    if ending == ".bc":
        pytest.importorskip("spiceypy")
    scene(name).write(tmp_path / f"a{ending}", interpolation_error=1e-3)
    read = Ephemeris.read(tmp_path / f"a{ending}")
    for other in (".aem", ".xml"):
        read.write(tmp_path / f"b{other}")
        starts, stops = spans(tmp_path / f"b{other}")
        assert starts[1:] == stops[:-1]
        assert len(starts) == len(read.events) + 1
        again = Ephemeris.read(tmp_path / f"b{other}")
        assert len(again) == len(read)
        assert np.abs(again.quaternion("wxyz") - read.quaternion("wxyz")).max() < 1e-15
        since = [each.elapsed - each.elapsed[0] for each in (again, read)]
        assert np.abs(since[0] - since[1]).max() < 2e-9


@pytest.mark.parametrize("seconds", [5e6, 1e8, 1e9])
def test_segments_meet_where_doubles_are_further_apart_than_nanoseconds(seconds, tmp_path):
    slow = {"angular_velocity": {"value": [0, 0, 1e-6], "unit": "deg/s"}}
    times = {"times": {"start": 0, "stop": 2 * seconds, "count": 7, "unit": "s"}}
    document = SCENE | slow | times | {"effects": [impulse(seconds + 0.1)]}
    document["effects"][0]["angular_impulse"]["value"] = [0, 0, 1e-8]
    Scene.from_json(json.dumps(document)).write(tmp_path / "a.aem", interpolation_error=1e-3)
    starts, stops = spans(tmp_path / "a.aem")
    assert starts[1:] == stops[:-1]
    back = Ephemeris.read(tmp_path / "a.aem")
    assert (np.diff(back.elapsed) > 0).all()
    back.write(tmp_path / "b.aem")
    assert spans(tmp_path / "b.aem") == [starts, stops]


# -- of others ---------------------------------------------------------------------------------------


def file(*segments):
    """Of segments of (seconds, degrees about z)."""
    text = HEADER.format("2.0")
    for states in segments:
        dates = [f"2024-01-01T00:{t // 60:02}:{t % 60:02}" for t, _ in states]
        rows = []
        for date, (_, degrees) in zip(dates, states, strict=True):
            half = np.deg2rad(degrees) / 2
            rows.append(f"{date} 0 0 {np.sin(half)!s} {np.cos(half)!s}")
        text += aem_segment("\n".join(rows), START_TIME=dates[0], STOP_TIME=dates[-1])
    return text


def read(text, tmp_path):
    (tmp_path / "a.aem").write_text(text)
    return Ephemeris.read(tmp_path / "a.aem")


@pytest.mark.parametrize("degrees", [60, 75], ids=["the same attitude", "another attitude"])
def test_of_a_shared_epoch_both_attitudes_are_read_one_double_apart(degrees, tmp_path):
    back = read(file([(0, 0), (60, 60)], [(60, degrees), (120, 120)]), tmp_path)
    assert back.elapsed.tolist() == [0.0, np.nextafter(60.0, 0.0), 60.0, 120.0]
    turned = np.rad2deg(2 * np.arctan2(*back.quaternion("wxyz")[:, [3, 0]].T))
    assert turned == pytest.approx([0, 60, degrees, 120], abs=1e-12)
    assert [(event.kind, event.seconds) for event in back.events] == [("segment", 60.0)]


def test_segment_of_one_instant_may_stand_between_two_that_share_it(tmp_path):
    back = read(file([(0, 0), (60, 60)], [(60, 70)], [(60, 80), (120, 120)]), tmp_path)
    assert (np.diff(back.elapsed) > 0).all()
    assert back.elapsed == pytest.approx([0, 60, 60, 60, 120], abs=1e-9)
    back.write(tmp_path / "b.aem")
    starts, stops = spans(tmp_path / "b.aem")
    assert starts[1:] == stops[:-1]
    assert len(starts) == 3


def test_segment_that_begins_before_the_end_of_the_one_before_is_refused(tmp_path):
    with pytest.raises(FormatError, match="before STOP_TIME of the segment before"):
        read(file([(0, 0), (60, 60)], [(59, 60), (120, 120)]), tmp_path)
