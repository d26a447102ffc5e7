"""CZML, the format of Cesium: attitudes relative to the Earth-fixed frame, scalar last.

[t, x, y, z, w, ...] of `orientation.unitQuaternion` rotate the body's axes to the Earth-fixed ones, those of
ITRF here; times are SI seconds from `epoch`, which is UTC to the nanosecond.  Where interpolation is not
allowed, an interval ends and holds its last attitude.  Cesium interpolates in the Earth-fixed frame, so
`prepared` transforms the samples to it before nodes are chosen.
"""

from __future__ import annotations

import html
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, BinaryIO

import numpy as np
import orjson
from astropy.time import Time

from ..errors import AttitudeError, FormatError, InputError, note
from ..frames import rotations
from ..samples.chunks import CHUNK_INSTANTS, Samples
from ..samples.ephemeris_data import EphemerisData, OrbitStates
from ..samples.event import Event
from ..samples.interpolation import InterpolationMethod
from ..samples.resampling import with_interpolation, with_method
from ..samples.transform import in_frame, rotation_between
from ..times.instants import Instants, as_instants
from ..times.iso8601 import parse_time, parse_times
from . import bounded_read, schema
from .interpolant import MAX_DEGREE, Interpolant
from .interpolation_nodes import Nodes

FRAME = "ITRF"
# Position, m, of a body without an orbit: 1000 km above the equator, at longitude 0.
DEFAULT_POSITION = (7378137.0, 0.0, 0.0)
# s; no orbit about the Earth turns faster than 1.8e-3 rad/s, so that degree 5 errs by 5 cm at most.
POSITION_STEP, POSITION_DEGREE = 60.0, 5
DESCRIPTION = (
    "Attitude: rotation from the body's axes to the Earth-fixed frame (ITRF, IAU 2006/2000A, {ut1}), scalar "
    "last, unit quaternion"
)
UT1_DESCRIPTIONS = {
    "tables": "UT1 and the pole from the tables of the IERS",
    "utc": "UTC taken for UT1, off by at most 0.9 s, and no polar motion",
}


# -- writing ------------------------------------------------------------------------------------


def interpolant(**_: Any) -> Interpolant:
    """Slerp, which is what Cesium's LINEAR does with a quaternion."""
    return Interpolant("slerp")


def other_interpolants(**_: Any) -> dict[str, Interpolant]:
    """None: this writer has no option for them."""
    return {}


def prepared(samples: Samples, *, ut1: str | None = None, **_: Any) -> Samples:
    """Transform samples to the Earth-fixed frame, in which Cesium interpolates."""
    if ut1 is not None:
        rotations.check_ut1(ut1)
    return Samples(
        samples.count, lambda first, last: _earth_fixed(samples.chunk(first, last), ut1), samples.progress
    )


def blocks(
    nodes: Nodes,
    *,
    id: str | None = None,  # noqa: A002 (public name)
    position: Any = None,
    box: Any = (3.0, 2.0, 1.0),
    model: str | None = None,
    ut1: str | None = None,  # noqa: ARG001 (`prepared` uses it)
) -> Iterator[bytes]:
    """Packet of the document, and packet of the body.

    id : of the body's packet; by default the ephemeris's name
    position : (x, y, z), m, Earth-fixed, at which the body is drawn; by default along the scene's orbit about
        the Earth, and without one at DEFAULT_POSITION
    box : (x, y, z), m, size of the box that is drawn along the body's axes; None for none
    model : URI of a glTF model that is drawn instead of the box
    ut1 : "utc" to take UTC for UT1, beyond the tables that come with astropy
    """
    fixed = None if position is None else _three_numbers(position, "position")
    size = None if box is None or model is not None else _three_numbers(box, "box")
    head, tail = nodes.segments[0].first, nodes.segments[-1].last
    if head.epoch is None:
        raise FormatError("CZML dates every attitude, and this ephemeris has no epoch")
    span = _interval(head, tail)
    name = head.name or "attitude"
    yield b"[" + orjson.dumps(_document(head, tail, span, name)) + b","
    description = DESCRIPTION.format(ut1=UT1_DESCRIPTIONS[head.ut1])
    packet: dict[str, Any] = {"id": id or name, "name": name, "availability": span}
    packet["description"] = (
        "<p>" + html.escape(f"{'. '.join([description, nodes.remark, *nodes.notes])}.") + "</p>"
    )
    if model is not None:
        packet["model"] = {"gltf": model, "minimumPixelSize": 64}
    if size is not None:
        packet["box"] = {
            "dimensions": {"cartesian": size},
            "outline": True,
            "outlineColor": {"rgba": [0, 0, 0, 255]},
        }
    yield orjson.dumps(packet)[:-1] + b',"position":'
    yield from _position(head, tail, fixed)
    yield b',"orientation":'
    yield from _orientation(nodes.segments)
    yield b"}]\n"


def _document(head: EphemerisData, tail: EphemerisData, span: str, name: str) -> dict[str, Any]:
    seconds = float(tail.elapsed[-1]) - float(head.elapsed[0])
    clock = {
        "interval": span,
        "currentTime": span.split("/", maxsplit=1)[0],
        "multiplier": max(1.0, seconds / 60.0),  # longer ephemerides play for a minute
        "range": "LOOP_STOP",
        "step": "SYSTEM_CLOCK_MULTIPLIER",
    }
    return {"id": "document", "name": name, "version": "1.0", "clock": clock}


def _orientation(segments: tuple[Samples, ...]) -> Iterator[bytes]:
    """Orientation as one object, or a list of one object an interval, which extends to the next."""
    last, is_list = None, len(segments) > 1
    yield b"[" if is_list else b""
    for i, segment in enumerate(segments):
        head = segment.first
        sampled = _sampled(head, "LINEAR", 1)
        if is_list:
            following = segments[i + 1].first if i + 1 < len(segments) else segment.last
            interval = _interval(head, following)
            sampled = {"interval": interval, **sampled, "forwardExtrapolationType": "HOLD"}
        yield (b"," if i else b"") + orjson.dumps(sampled)[:-1] + b',"unitQuaternion":['
        for k, piece in enumerate(segment.chunks()):
            last = _refuse_disorder(piece, last)
            yield (b"," if k else b"") + _rows(piece.elapsed, _earth_fixed(piece).quaternion("xyzw"))
        yield b"]}"
    yield b"]" if is_list else b""


def _position(head: EphemerisData, tail: EphemerisData, fixed: list[float] | None) -> Iterator[bytes]:
    orbit = head.orbit
    if fixed is None and orbit is not None and orbit.frame != "INERTIAL" and orbit.is_about_the_earth:
        first, last = float(head.elapsed[0]), float(tail.elapsed[-1])
        if last > first:
            yield orjson.dumps(_sampled(head, "LAGRANGE", POSITION_DEGREE))[:-1] + b',"cartesian":['
            yield from _positions(orbit, head, first, last)
            yield b"]}"
            return
        fixed = _earth_fixed_positions(orbit, head.instants, head.ut1)[0].tolist()
    yield orjson.dumps({"cartesian": list(DEFAULT_POSITION) if fixed is None else fixed})


def _positions(orbit: OrbitStates, head: EphemerisData, first: float, last: float) -> Iterator[bytes]:
    """Rows of positions at even instants, close enough for interpolation."""
    intervals = max(POSITION_DEGREE, math.ceil((last - first) / POSITION_STEP))
    for k in range(0, intervals + 1, CHUNK_INSTANTS):
        i = np.arange(k, min(k + CHUNK_INSTANTS, intervals + 1))
        t = np.where(i == intervals, last, first + (last - first) * (i / intervals))
        yield (b"," if k else b"") + _rows(
            t, _earth_fixed_positions(orbit, Instants(t, None, head.epoch), head.ut1)
        )


def _earth_fixed_positions(orbit: OrbitStates, instants: Instants, ut1: str) -> np.ndarray:
    """(n, 3) m."""
    turn = rotation_between(orbit.frame, FRAME, instants, ut1)
    assert turn is not None
    return rotations.rotate(turn.quaternion, orbit.state(instants)[0])


def _earth_fixed(ephemeris: EphemerisData, ut1: str | None = None) -> EphemerisData:
    try:
        return in_frame(ephemeris, FRAME, ut1)
    except AttitudeError as error:
        raise FormatError(f"CZML is relative to the Earth-fixed frame ({error})") from None


def _sampled(ephemeris: EphemerisData, algorithm: str, degree: int) -> dict[str, Any]:
    return {
        "epoch": _date(ephemeris.epoch),
        "interpolationAlgorithm": algorithm,
        "interpolationDegree": degree,
    }


def _rows(seconds: np.ndarray, values: np.ndarray) -> bytes:
    """Numbers of all rows, t, x, y, z, ..., between commas."""
    table = np.column_stack([seconds, values]).reshape(-1)
    return orjson.dumps(table, option=orjson.OPT_SERIALIZE_NUMPY)[1:-1]


def _refuse_disorder(piece: EphemerisData, last: float | None) -> float:
    """Return the last instant of a piece; refuses instants that do not increase, from `last` on."""
    seconds = piece.elapsed
    before = np.concatenate([[-np.inf if last is None else last], seconds[:-1]])
    late = ~(seconds > before)
    if late.any():
        i = int(np.argmax(late))
        raise FormatError(
            f"CZML is written in order of time; {seconds[i]:.17g} s is not after {before[i]:.17g} s"
        )
    return float(seconds[-1])


def _interval(head: EphemerisData, tail: EphemerisData) -> str:
    return f"{_date(head.time[0])}/{_date(tail.time[-1])}"


def _date(time: Time | None) -> str:
    """ISO 8601, UTC to the nanosecond, without zeros at its end."""
    if time is None:
        raise FormatError("CZML dates every attitude, and this ephemeris has no epoch")
    text = schema.iso_text(time.utc).item().decode()
    return text.rstrip("0").rstrip(".") + "Z"


def _three_numbers(value: Any, field: str) -> list[float]:
    """Three finite numbers, given as such or as text with commas."""
    try:
        numbers = [float(number) for number in (value.split(",") if isinstance(value, str) else value)]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) != 3 or not np.isfinite(numbers).all():
        raise InputError(field, value, "three finite numbers, m")
    return numbers


# -- reading ------------------------------------------------------------------------------------

SAMPLED_KEYS = {
    "epoch",
    "interval",
    "interpolationAlgorithm",
    "interpolationDegree",
    "forwardExtrapolationType",
    "forwardExtrapolationDuration",
    "backwardExtrapolationType",
    "backwardExtrapolationDuration",
    "unitQuaternion",
}
DATE_TOLERANCE = 1e-9  # s: dates are written to the nanosecond


def parse(
    stream: BinaryIO,
    source: str,
    *,
    id: str | None = None,  # noqa: A002 (public name)
    frame: str = "GCRF",
    ut1: str = "tables",
) -> EphemerisData:
    """Attitudes of one packet, without rates, transformed from the Earth-fixed frame to `frame`.

    id : of the packet, if several have an orientation
    frame : "ITRF" for the numbers of the file, unchanged
    ut1 : "utc" to take UTC for UT1, beyond the tables that come with astropy
    """
    rotations.check_any_frame(frame)
    try:
        packet = _packet_with_orientation(_packets(stream, source), id)
        # interpolated in the frame of the file, as Cesium does
        ephemeris = in_frame(with_interpolation(_with_method(_ephemeris(packet, source), packet)), frame, ut1)
    except FormatError as error:
        raise FormatError(str(error), source) if not error.source else error from None
    except AttitudeError as error:
        raise FormatError(str(error), source) from None
    interpolation = ephemeris.interpolation
    if interpolation is None or interpolation.segments[0].method.kind == "slerp":
        return ephemeris  # slerp does not depend on the signs
    return replace(ephemeris, attitude=rotations.sign_continuous(ephemeris.quaternion("wxyz")))


def _with_method(ephemeris: EphemerisData, packet: dict[str, Any]) -> EphemerisData:
    """The ephemeris with the polynomials that the packet states; LINEAR is slerp (Cesium's default)."""
    part = _intervals(packet)[0]
    algorithm, degree = part.get("interpolationAlgorithm", "LINEAR"), part.get("interpolationDegree", 1)
    if algorithm not in ("LAGRANGE", "HERMITE") or not isinstance(degree, int):
        return with_method(ephemeris, InterpolationMethod())
    signed = replace(ephemeris, attitude=rotations.sign_continuous(ephemeris.quaternion("wxyz")))
    return with_method(signed, InterpolationMethod(algorithm.lower(), max(1, min(degree, MAX_DEGREE))))


def _intervals(packet: dict[str, Any]) -> list[Any]:
    orientation = packet["orientation"]
    return orientation if isinstance(orientation, list) else [orientation]


def _packets(stream: BinaryIO, source: str) -> list[dict[str, Any]]:
    packets = bounded_read.json(stream, source)
    if (
        not isinstance(packets, list)
        or not all(isinstance(packet, dict) for packet in packets)
        or not packets
    ):
        raise FormatError("not CZML, which is a list of packets")
    version = packets[0].get("version")
    if packets[0].get("id") != "document" or not isinstance(version, str):
        raise FormatError("the first packet is not the document's, with its version")
    if not re.fullmatch(r"1(\.\d+)?", version):
        raise FormatError(f"version {version[:20]!r} of CZML, not 1.0")
    return packets[1:]


def _packet_with_orientation(packets: list[dict[str, Any]], name: str | None) -> dict[str, Any]:
    """Packet with an orientation, of this id if one is given; packets of one id are parts of one."""
    candidates = [
        packet for packet in packets if "orientation" in packet and name in (None, packet.get("id"))
    ]
    if not candidates:
        raise FormatError(f"no packet {'' if name is None else f'{name!r} '}has an orientation")
    names = list(dict.fromkeys(repr(packet.get("id")) for packet in candidates))
    if len(names) > 1 or (len(candidates) > 1 and candidates[0].get("id") is None):
        listed = ", ".join(names[:10])
        raise FormatError(f"several packets have an orientation ({listed}): one is read, by its id")
    if len(candidates) == 1:
        return candidates[0]
    return {**candidates[0], "orientation": [part for packet in candidates for part in _intervals(packet)]}


def _ephemeris(packet: dict[str, Any], source: str) -> EphemerisData:
    intervals = _intervals(packet)
    if not intervals:
        raise FormatError("orientation: an empty list")
    fields = [f"orientation[{i}]" for i in range(len(intervals))] if len(intervals) > 1 else ["orientation"]
    segments = [_segment(part, field) for part, field in zip(intervals, fields, strict=True)]
    epoch = segments[0][0]
    parts = [(t + _seconds_between(start, epoch), q) for start, t, q in segments]
    has_interval = [isinstance(part, dict) and "interval" in part for part in intervals]
    seconds, quaternions = _in_order(parts, has_interval)
    quaternion = schema.unit_rows(np.concatenate(quaternions), source, field="unitQuaternion")
    events = tuple(Event(float(t[0]), "segment", "a new interval of the file") for t in seconds[1:])
    instants = Instants(np.concatenate(seconds), None, epoch, scale="utc").finite("unitQuaternion")
    name = packet.get("name", packet.get("id", ""))
    name = name if isinstance(name, str) else ""
    return EphemerisData(quaternion, schema.check_dates(instants), FRAME, name=name, events=events)


def _in_order(
    parts: list[tuple[np.ndarray, np.ndarray]], has_interval: list[bool]
) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Times and quaternions of the intervals, in order.

    Samples without an interval belong together, and of two at one instant the later one counts, as in Cesium.
    Of an instant that two intervals share, the first one gets the double before.
    """
    seconds: list[np.ndarray] = []
    quaternions: list[np.ndarray] = []
    for k, (t, q) in enumerate(parts):
        if any(not before < after for before, after in pairwise(t.tolist())):
            i = int(np.argmax(np.diff(t) <= 0.0))
            raise FormatError(f"orientation: {float(t[i + 1])!r} s is not after {float(t[i])!r} s")
        if k and not has_interval[k] and not has_interval[k - 1]:
            times, values = np.append(seconds[-1], t), np.concatenate([quaternions[-1], q])
            order = np.argsort(times, kind="stable")
            is_last = np.append(np.diff(times[order]) > 0.0, True)
            seconds[-1], quaternions[-1] = times[order][is_last], values[order][is_last]
            if not is_last.all():
                note(f"of {int((~is_last).sum())} instants with two attitudes the later one counts")
            continue
        if k and t[0] <= seconds[-1][-1]:
            if t[0] < seconds[-1][-1]:
                raise FormatError(f"orientation: {float(t[0])!r} s is not after {float(seconds[-1][-1])!r} s")
            seconds[-1][-1] = np.nextafter(t[0], -np.inf)
            note("an instant that two intervals share is read twice, the first a double earlier")
        seconds.append(t)
        quaternions.append(q)
    return seconds, quaternions


def _segment(part: Any, field: str) -> tuple[Time, np.ndarray, np.ndarray]:
    """Epoch, (n,) s since it, and (n, 4) wxyz, of one interval."""
    for key in ("reference", "references", "velocityReference"):
        if isinstance(part, dict) and key in part:
            target = str(part[key])[:60]
            raise FormatError(
                f"{field}: {key} to {target!r}, which is not followed; read that packet, by its id"
            )
    if not isinstance(part, dict) or not isinstance(part.get("unitQuaternion"), list):
        raise FormatError(f"{field}: no unitQuaternion with its samples")
    unknown = sorted(set(part) - SAMPLED_KEYS)
    if unknown:
        raise FormatError(f"{field}: {unknown[0]!r} is not read here")
    values = part["unitQuaternion"]
    if len(values) == 4:
        raise FormatError(f"{field}: one attitude without an instant")
    if not values or len(values) % 5:
        raise FormatError(f"{field}: {len(values)} numbers, where each attitude has its time and four")
    numbers = [value for i, value in enumerate(values) if i % 5]
    if not all(type(number) in (int, float) for number in numbers):
        raise FormatError(f"{field}: a quaternion of something else than numbers")
    epoch, seconds = _times(part, values[::5], field)
    _check_interval(part.get("interval"), epoch, seconds, field)
    return epoch, seconds, np.array(numbers, dtype=float).reshape(-1, 4)[:, [3, 0, 1, 2]]


def _times(part: dict[str, Any], times: Sequence[Any], field: str) -> tuple[Time, np.ndarray]:
    """Epoch, and seconds since it, of times that are all numbers or all dates."""
    if all(isinstance(time, str) for time in times):
        dates = parse_times([_plain_date(time, field) for time in times], "utc")
        return dates[0], np.asarray(as_instants(dates, dates[0]).seconds)
    if not all(type(time) in (int, float) for time in times):
        raise FormatError(f"{field}: times that are neither all numbers nor all dates")
    if "epoch" not in part:
        raise FormatError(f"{field}: times without an epoch")
    return _parse_date(part["epoch"], f"{field}.epoch"), np.array(times, dtype=float)


def _check_interval(interval: Any, epoch: Time, seconds: np.ndarray, field: str) -> None:
    """Refuse attitudes outside their interval, which Cesium would not show."""
    if interval is None:
        return
    ends = interval.split("/") if isinstance(interval, str) else []
    if len(ends) != 2:
        raise FormatError(f"{field}.interval: no two dates with / between them")
    start, stop = (_seconds_between(_parse_date(end, f"{field}.interval"), epoch) for end in ends)
    if not (start - DATE_TOLERANCE <= seconds.min() and seconds.max() <= stop + DATE_TOLERANCE):
        raise FormatError(f"{field}: attitudes outside their interval")


def _seconds_between(time: Time, epoch: Time) -> float:
    """From the epoch to the time, s."""
    return float(as_instants(time, epoch).seconds)


def _parse_date(text: Any, field: str) -> Time:
    return parse_time(_plain_date(text, field), "utc", field)


def _plain_date(text: Any, field: str) -> str:
    """UTC date without its Z."""
    form = r"(\d{4}-\d\d-\d\dT\d\d:\d\d(:\d\d(\.\d{1,20})?)?)(Z|\+00:?00)"
    match = re.fullmatch(form, text) if isinstance(text, str) else None
    if match is None:
        raise FormatError(f"{field}: {str(text)[:40]!r} is no date such as 2026-01-01T00:00:00Z")
    return str(match[1])
