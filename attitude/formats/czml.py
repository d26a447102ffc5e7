"""CZML, what Cesium shows: attitudes relative to the Earth-fixed frame, scalar last, seconds from an epoch.

[t, x, y, z, w, ...] of `orientation.unitQuaternion` turn the body's axes to the Earth-fixed ones, which here
are ITRF (`Ephemeris.in_frame`); times are SI seconds from `epoch`, which is UTC to the nanosecond.  Where
nobody may interpolate, an interval ends and holds its last attitude.  Cesium interpolates in the Earth-fixed
frame, so that is where nodes should be judged: `prepared` gives the samples there.
"""

from __future__ import annotations

import html
import math
import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any, BinaryIO

import numpy as np
import orjson
from astropy.time import Time

from ..errors import AttitudeError, FormatError, InputError
from ..frames import rotations
from ..frames.earth_fixed import itrf
from ..frames.inertial import rotation_from_gcrf
from ..samples.chunks import CHUNK_INSTANTS, Samples
from ..samples.ephemeris_data import EphemerisData, OrbitStates
from ..samples.event import Event
from ..samples.transform import in_frame
from ..times.instants import Instants, as_instants
from ..times.iso8601 import parse_time, parse_times
from . import bounded_read, schema
from .interpolation_nodes import Interpolant, Nodes

FRAME = "ITRF"
MOST_BYTES = 1 << 30  # the whole text is read at once
# Where a body without an orbit is drawn: 1000 km above the equator, at longitude 0.
PLACE = (7378137.0, 0.0, 0.0)
BOX = (3.0, 2.0, 1.0)
# s; no orbit about the Earth turns faster than 1.8e-3 rad/s: one of degree 5 errs by 5 cm.
POSITION_STEP, POSITION_DEGREE = 60.0, 5
A_MINUTE = 60.0  # what playing all of it takes, unless it is shorter
SAID_OF_IT = (
    "Attitude: rotation from the body's axes to the Earth-fixed frame (ITRF, IAU 2006/2000A, UT1 and the "
    "pole from the tables of the IERS), scalar last, unit quaternion"
)


# -- writing ------------------------------------------------------------------------------------


def interpolant(
    *, id: str | None = None, position: Any = None, box: Any = BOX, model: str | None = None
) -> Interpolant:
    """Cesium's LINEAR of a quaternion is slerp; the options make no difference."""
    return Interpolant("slerp")


def prepared(samples: Samples) -> Samples:
    """The samples as Cesium interpolates them: relative to the Earth-fixed frame."""
    return Samples(
        samples.count, lambda first, last: _earth_fixed(samples.chunk(first, last)), samples.progress
    )


def blocks(
    nodes: Nodes, *, id: str | None = None, position: Any = None, box: Any = BOX, model: str | None = None
) -> Iterator[bytes]:
    """The document's packet, and one of the body.

    id : of the packet; the ephemeris's name where there is one
    position : (x, y, z), m, Earth-fixed, where it is drawn; else along the scene's orbit about the Earth, and
        without one at PLACE
    box : (x, y, z), m, how large a box along the body's axes stands for it; None for none
    model : the URI of a glTF model to draw instead
    """
    place = None if position is None else _three(position, "position")
    size = None if box is None or model is not None else _three(box, "box")
    head, tail = nodes.segments[0].first, nodes.segments[-1].last
    if head.epoch is None:
        raise FormatError("CZML dates every attitude, and this ephemeris has no epoch")
    span = _interval(head, tail)
    name = head.name or "attitude"
    yield b"[" + orjson.dumps(_document(head, tail, span, name)) + b","
    packet: dict[str, Any] = {"id": id or name, "name": name, "availability": span}
    packet["description"] = "<p>" + html.escape(f"{SAID_OF_IT}. {nodes.remark}.") + "</p>"
    if model is not None:
        packet["model"] = {"gltf": model, "minimumPixelSize": 64}
    if size is not None:
        packet["box"] = {
            "dimensions": {"cartesian": size},
            "outline": True,
            "outlineColor": {"rgba": [0, 0, 0, 255]},
        }
    yield orjson.dumps(packet)[:-1] + b',"position":'
    yield from _position(head, tail, place)
    yield b',"orientation":'
    yield from _orientation(nodes.segments)
    yield b"}]\n"


def _document(head: EphemerisData, tail: EphemerisData, span: str, name: str) -> dict[str, Any]:
    seconds = _last(tail) - _first(head)
    clock = {
        "interval": span,
        "currentTime": span.split("/")[0],
        "multiplier": max(1.0, seconds / A_MINUTE),
        "range": "LOOP_STOP",
        "step": "SYSTEM_CLOCK_MULTIPLIER",
    }
    return {"id": "document", "name": name, "version": "1.0", "clock": clock}


def _orientation(segments: tuple[Samples, ...]) -> Iterator[bytes]:
    """One object; or one an interval, up to where the next begins."""
    last, several = None, len(segments) > 1
    yield b"[" if several else b""
    for i, segment in enumerate(segments):
        head = segment.first
        property = _sampled(head, "LINEAR", 1)
        if several:
            following = segments[i + 1].first if i + 1 < len(segments) else segment.last
            property = {
                "interval": _interval(head, following),
                **property,
                "forwardExtrapolationType": "HOLD",
            }
        yield (b"," if i else b"") + orjson.dumps(property)[:-1] + b',"unitQuaternion":['
        for k, piece in enumerate(segment.chunks()):
            last = _refuse_disorder(piece, last)
            yield (b"," if k else b"") + _rows(piece.elapsed, _earth_fixed(piece).quaternion("xyzw"))
        yield b"]}"
    yield b"]" if several else b""


def _position(head: EphemerisData, tail: EphemerisData, place: list[float] | None) -> Iterator[bytes]:
    along = head.orbit
    if place is None and along is not None and along.frame != "INERTIAL" and along.is_about_the_earth:
        first, last = _first(head), _last(tail)
        if last > first:
            yield orjson.dumps(_sampled(head, "LAGRANGE", POSITION_DEGREE))[:-1] + b',"cartesian":['
            yield from _positions(along, head, first, last)
            yield b"]}"
            return
        place = _place(along, head.instants)[0].tolist()
    yield orjson.dumps({"cartesian": list(PLACE) if place is None else place})


def _positions(along: OrbitStates, head: EphemerisData, first: float, last: float) -> Iterator[bytes]:
    """Rows of positions at even instants, close enough for a polynomial between them."""
    intervals = max(POSITION_DEGREE, math.ceil((last - first) / POSITION_STEP))
    for k in range(0, intervals + 1, CHUNK_INSTANTS):
        i = np.arange(k, min(k + CHUNK_INSTANTS, intervals + 1))
        t = np.where(i == intervals, last, first + (last - first) * (i / intervals))
        yield (b"," if k else b"") + _rows(t, _place(along, Instants(t, None, head.epoch)))


def _place(along: OrbitStates, instants: Instants) -> np.ndarray:
    """(n, 3) m, Earth-fixed."""
    turn = rotation_from_gcrf(along.frame, "an Earth-fixed position").back().then(itrf(instants))
    return rotations.rotate(turn.quaternion, along.state(instants)[0])


def _earth_fixed(ephemeris: EphemerisData) -> EphemerisData:
    try:
        return in_frame(ephemeris, FRAME)
    except AttitudeError as error:
        raise FormatError(f"CZML is relative to the Earth-fixed frame ({error})") from None


def _sampled(ephemeris: EphemerisData, algorithm: str, degree: int) -> dict[str, Any]:
    return {
        "epoch": _date(ephemeris.epoch),
        "interpolationAlgorithm": algorithm,
        "interpolationDegree": degree,
    }


def _rows(seconds: np.ndarray, values: np.ndarray) -> bytes:
    """t, x, y, z, ... of all rows, between commas."""
    table = np.column_stack([seconds, values]).reshape(-1)
    return orjson.dumps(table, option=orjson.OPT_SERIALIZE_NUMPY)[1:-1]


def _refuse_disorder(piece: EphemerisData, last: float | None) -> float:
    """The last instant of a piece; refuses one that is not after the one before it, `last` at first."""
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


def _first(ephemeris: EphemerisData) -> float:
    return float(ephemeris.elapsed[0])


def _last(ephemeris: EphemerisData) -> float:
    return float(ephemeris.elapsed[-1])


def _three(value: Any, field: str) -> list[float]:
    """Three finite numbers, or text of them between commas."""
    try:
        numbers = value.split(",") if isinstance(value, str) else list(value)
        found = [float(number) for number in numbers]
    except (TypeError, ValueError):
        found = []
    if len(found) != 3 or not np.isfinite(found).all():
        raise InputError(field, value, "three finite numbers, m")
    return found


# -- reading ------------------------------------------------------------------------------------

SAMPLED = {
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
WITHIN = 1e-9  # s: dates are written to the nanosecond


def parse(stream: BinaryIO, source: str, *, id: str | None = None, frame: str = "GCRF") -> EphemerisData:
    """The attitudes of one packet, turned from the Earth-fixed frame to `frame`; they have no rates.

    id : of the packet, where several have an orientation
    frame : "ITRF" for the very numbers of the file
    """
    rotations.check_any_frame(frame)
    try:
        packet = _packet(_packets(stream, source), id)
        found = in_frame(_ephemeris(packet), frame)
    except FormatError as error:
        raise FormatError(str(error), source) if not error.source else error from None
    except AttitudeError as error:
        raise FormatError(str(error), source) from None
    if not _states_polynomials(packet):  # slerp does not mind the signs
        return found
    q = rotations.sign_continuous(found.quaternion("wxyz"))
    return EphemerisData(q, found.instants, frame, name=found.name, events=found.events)


def _states_polynomials(packet: dict[str, Any]) -> bool:
    """Whether any interval of its orientation is to be interpolated by Lagrange's or Hermite's."""
    given = packet["orientation"]
    intervals = given if isinstance(given, list) else [given]
    return any(part.get("interpolationAlgorithm") in ("LAGRANGE", "HERMITE") for part in intervals)


def _packets(stream: BinaryIO, source: str) -> list[dict[str, Any]]:
    text = bounded_read.text(stream, source, MOST_BYTES)
    try:
        packets = orjson.loads(text)
    except orjson.JSONDecodeError as error:
        raise FormatError(f"not JSON: {error.msg}", source, error.lineno) from None
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


def _packet(packets: list[dict[str, Any]], id: str | None) -> dict[str, Any]:
    """The one with an orientation, or that of the id."""
    turning = [packet for packet in packets if "orientation" in packet and id in (None, packet.get("id"))]
    if not turning:
        raise FormatError(
            "no packet has an orientation" if id is None else f"no packet {id!r} has an orientation"
        )
    if len(turning) > 1:
        names = ", ".join(repr(packet.get("id")) for packet in turning[:10])
        raise FormatError(f"several packets have an orientation ({names}): one is read, by its id")
    return turning[0]


def _ephemeris(packet: dict[str, Any]) -> EphemerisData:
    given = packet["orientation"]
    intervals = given if isinstance(given, list) else [given]
    if not intervals:
        raise FormatError("orientation: nothing")
    several = len(intervals) > 1
    read = [
        _segment(part, f"orientation[{i}]" if several else "orientation") for i, part in enumerate(intervals)
    ]
    epoch = read[0][0]
    seconds = [t + _between(start, epoch) for start, t, _ in read]
    for before, after in pairwise(np.concatenate(seconds).tolist()):
        if not before < after:
            raise FormatError(f"orientation: {after!r} s is not after {before!r} s")
    quaternion = np.concatenate([q for _, _, q in read])
    rotations.attitude_quaternion(quaternion, "wxyz", "unitQuaternion")
    events = tuple(Event(float(t[0]), "segment", "a new interval of the file") for t in seconds[1:])
    name = packet.get("name", packet.get("id", ""))
    return EphemerisData(
        quaternion,
        schema.check_dates(
            Instants(np.concatenate(seconds), None, epoch, scale="utc").finite("unitQuaternion")
        ),
        FRAME,
        name=name if isinstance(name, str) else "",
        events=events,
    )


def _segment(part: Any, field: str) -> tuple[Time, np.ndarray, np.ndarray]:
    """Epoch, (n,) s since it, and (n, 4) wxyz of one interval."""
    if not isinstance(part, dict) or not isinstance(part.get("unitQuaternion"), list):
        raise FormatError(f"{field}: no unitQuaternion with its samples")
    unknown = sorted(set(part) - SAMPLED)
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
    """Numbers since the epoch, or dates."""
    if all(isinstance(time, str) for time in times):
        dates = parse_times([_plain_date(time, field) for time in times], "utc")
        return dates[0], np.asarray(as_instants(dates, dates[0]).seconds)
    if not all(type(time) in (int, float) for time in times):
        raise FormatError(f"{field}: times that are neither all numbers nor all dates")
    if "epoch" not in part:
        raise FormatError(f"{field}: times without an epoch")
    return _read_date(part["epoch"], f"{field}.epoch"), np.array(times, dtype=float)


def _check_interval(interval: Any, epoch: Time, seconds: np.ndarray, field: str) -> None:
    """Samples outside their interval would not be shown."""
    if interval is None:
        return
    ends = interval.split("/") if isinstance(interval, str) else []
    if len(ends) != 2:
        raise FormatError(f"{field}.interval: no two dates with / between them")
    start, stop = (_between(_read_date(end, f"{field}.interval"), epoch) for end in ends)
    if not (start - WITHIN <= seconds.min() and seconds.max() <= stop + WITHIN):
        raise FormatError(f"{field}: attitudes outside their interval")


def _between(time: Time, epoch: Time) -> float:
    """s, from the epoch to the time."""
    return float(as_instants(time, epoch).seconds)


def _read_date(text: Any, field: str) -> Time:
    return parse_time(_plain_date(text, field), "utc", field)


def _plain_date(text: Any, field: str) -> str:
    """UTC, without its Z."""
    if not isinstance(text, str) or not re.fullmatch(
        r"\d{4}-\d\d-\d\dT\d\d:\d\d(:\d\d(\.\d{1,20})?)?Z", text
    ):
        raise FormatError(f"{field}: {str(text)[:40]!r} is no date such as 2026-01-01T00:00:00Z")
    return text.removesuffix("Z")
