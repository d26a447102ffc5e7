"""CZML, the format of Cesium: attitudes relative to the Earth-fixed frame, scalar last.

[t, x, y, z, w, ...] of `orientation.unitQuaternion` rotate the body's axes to the Earth-fixed ones, those of
ITRF here; times are SI seconds from `epoch`, which is UTC to the nanosecond.  Where interpolation is not
allowed, an interval ends and holds its last attitude.  Cesium interpolates in the Earth-fixed frame, so
`prepared` transforms the samples to it before nodes are chosen.
"""

from __future__ import annotations

import html
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import orjson
from astropy.time import Time

from ..errors import AttitudeError, FormatError, InputError
from ..frames import rotations
from ..samples.chunks import CHUNK_INSTANTS, Samples
from ..samples.ephemeris_data import EphemerisData
from ..samples.transform import in_frame, rotation_between
from ..times.instants import Instants
from . import time_origin
from .czml_reader import parse as parse
from .date_text import one_date
from .interpolant import Interpolant
from .interpolation_nodes import Nodes

DEFAULT_POSITION = (7378137.0, 0.0, 0.0)  # m: 1000 km above the equator, at longitude 0


@dataclass(frozen=True)
class CzmlOptions:
    """Options of the writer; InputError for an invalid one.

    id : of the body's packet; by default the ephemeris's name
    position : (x, y, z), m, Earth-fixed, at which the body is drawn; by default along the scene's orbit about
        the Earth, and without one at DEFAULT_POSITION
    box : (x, y, z), m, size of the box that is drawn along the body's axes; None for none
    model : URI of a glTF model that is drawn instead of the box
    ut1 : "utc" to take UTC for UT1, beyond the tables that come with astropy
    """

    id: str | None = None
    position: Any = None
    box: Any = (3.0, 2.0, 1.0)
    model: str | None = None
    ut1: str | None = None

    def __post_init__(self) -> None:
        if self.ut1 is not None:
            rotations.check_ut1(self.ut1)
        for field in ("position", "box"):
            value = getattr(self, field)
            if value is None:
                continue
            try:
                parts = value.split(",") if isinstance(value, str) else value
                numbers = [float(number) for number in parts]
            except (TypeError, ValueError):
                numbers = []
            if len(numbers) != 3 or not np.isfinite(numbers).all():
                raise InputError(field, value, "three finite numbers, m")
            object.__setattr__(self, field, numbers)


Options = CzmlOptions


def interpolant(_: CzmlOptions) -> Interpolant:
    """Slerp, which is what Cesium's LINEAR does with a quaternion."""
    return Interpolant("slerp")


def other_interpolants(_: CzmlOptions) -> dict[str, Interpolant]:
    """None: this writer has no option for them."""
    return {}


def prepared(samples: Samples, options: CzmlOptions) -> Samples:
    """Transform samples to the Earth-fixed frame, in which Cesium interpolates."""

    def earth_fixed(first: int, last: int) -> EphemerisData:
        piece = samples.chunk(first, last)
        try:
            return in_frame(piece, "ITRF", options.ut1)
        except AttitudeError as error:
            raise FormatError(f"CZML is relative to the Earth-fixed frame ({error})") from None

    return Samples(samples.count, earth_fixed, samples.progress)


def blocks(nodes: Nodes, options: CzmlOptions) -> Iterator[bytes]:
    """Packet of the document, and packet of the body."""
    head, tail = nodes.segments[0].first, nodes.segments[-1].last
    if head.epoch is None:
        raise FormatError("CZML dates every attitude, and this ephemeris has no epoch")
    span = _interval(head, tail)
    name = head.name or "attitude"
    yield b"[" + orjson.dumps(_document(head, tail, span, name)) + b","
    ut1 = {
        "tables": "UT1 and the pole from the tables of the IERS",
        "utc": "UTC taken for UT1, off by at most 0.9 s, and no polar motion",
    }[head.ut1]
    frames = f"rotation from the body's axes to the Earth-fixed frame (ITRF, IAU 2006/2000A, {ut1})"
    comments = [f"Attitude: {frames}, scalar last, unit quaternion", nodes.remark, *nodes.notes]
    packet: dict[str, Any] = {"id": options.id or name, "name": name, "availability": span}
    packet["description"] = f"<p>{html.escape('. '.join(comments) + '.')}</p>"
    if options.model is not None:
        packet["model"] = {"gltf": options.model, "minimumPixelSize": 64}
    elif options.box is not None:
        packet["box"] = {
            "dimensions": {"cartesian": options.box},
            "outline": True,
            "outlineColor": {"rgba": [0, 0, 0, 255]},
        }
    yield orjson.dumps(packet)[:-1] + b',"position":'
    yield from _position(head, tail, options.position)
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
    last: float | None = None
    is_list = len(segments) > 1
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
            seconds = piece.elapsed
            time_origin.refuse_unordered(seconds, last, "CZML", "s")
            last = float(seconds[-1])
            yield (b"," if k else b"") + _rows(seconds, piece.quaternion("xyzw"))
        yield b"]}"
    yield b"]" if is_list else b""


def _position(head: EphemerisData, tail: EphemerisData, fixed: list[float] | None) -> Iterator[bytes]:
    """The position that is given, or those of an orbit about the Earth, Earth-fixed, m."""
    orbit = head.orbit
    if fixed or orbit is None or orbit.frame == "INERTIAL" or not orbit.is_about_the_earth:
        yield orjson.dumps({"cartesian": fixed or list(DEFAULT_POSITION)})
        return

    def positions(instants: Instants) -> np.ndarray:
        turn = rotation_between(orbit.frame, "ITRF", instants, head.ut1)
        assert turn is not None
        return rotations.rotate(turn.quaternion, orbit.state(instants)[0])

    first, last = float(head.elapsed[0]), float(tail.elapsed[-1])
    if last <= first:
        yield orjson.dumps({"cartesian": positions(head.instants)[0].tolist()})
        return
    yield orjson.dumps(_sampled(head, "LAGRANGE", 5))[:-1] + b',"cartesian":['
    # No orbit about the Earth turns faster than 1.8e-3 rad/s: degree 5 over minutes errs by 5 cm at most.
    intervals = max(5, math.ceil((last - first) / 60.0))
    for k in range(0, intervals + 1, CHUNK_INSTANTS):
        i = np.arange(k, min(k + CHUNK_INSTANTS, intervals + 1))
        t = np.where(i == intervals, last, first + (last - first) * (i / intervals))
        yield (b"," if k else b"") + _rows(t, positions(Instants(t, None, head.epoch)))
    yield b"]}"


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


def _interval(head: EphemerisData, tail: EphemerisData) -> str:
    return f"{_date(head.time[0])}/{_date(tail.time[-1])}"


def _date(time: Time) -> str:
    """ISO 8601, UTC to the nanosecond, without zeros at its end."""
    return one_date(time.utc).rstrip("0").rstrip(".") + "Z"
