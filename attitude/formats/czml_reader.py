"""Reading CZML: attitudes of one packet, relative to the Earth-fixed frame or transformed from it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, BinaryIO

import numpy as np
from astropy.time import Time

from ..errors import AttitudeError, FormatError, note
from ..frames import rotations
from ..samples.ephemeris_data import EphemerisData
from ..samples.event import Event
from ..samples.interpolation import MAX_STATED_DEGREE, InterpolationMethod
from ..samples.resampling import with_interpolation, with_method
from ..samples.transform import in_frame
from ..times.instants import Instants, as_instants
from ..times.iso8601 import parse_time, parse_times
from . import bounded_read, schema

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
    stated = [
        (part.get("interpolationAlgorithm", "LINEAR"), part.get("interpolationDegree", 1))
        for part in packet["orientation"]
    ]
    (algorithm, degree), others = stated[0], stated[1:]
    if any(other != stated[0] for other in others):
        note("intervals state several interpolations: that of the first is taken for all")
    if algorithm not in ("LINEAR", "LAGRANGE", "HERMITE") or type(degree) is not int:
        note(
            f"interpolationAlgorithm {algorithm!r:.40} of degree {degree!r:.40} is taken for LINEAR, which "
            "is Cesium's where none is stated"
        )
        return with_method(ephemeris, InterpolationMethod())
    if algorithm == "LINEAR":
        return with_method(ephemeris, InterpolationMethod())
    used = max(1, min(degree, MAX_STATED_DEGREE))
    if used != degree:
        note(f"interpolationDegree {degree} is taken for {used}: 1 to {MAX_STATED_DEGREE} are interpolated")
    signed = replace(ephemeris, attitude=rotations.sign_continuous(ephemeris.quaternion("wxyz")))
    return with_method(signed, InterpolationMethod(algorithm.lower(), used))


def _packets(stream: BinaryIO, source: str) -> list[dict[str, Any]]:
    packets = bounded_read.json(stream, source)
    if not (isinstance(packets, list) and packets and all(isinstance(each, dict) for each in packets)):
        raise FormatError("not CZML, which is a list of packets")
    version = packets[0].get("version")
    if packets[0].get("id") != "document" or not isinstance(version, str):
        raise FormatError("the first packet is not the document's, with its version")
    if not re.fullmatch(r"1(\.\d+)?", version):
        raise FormatError(f"version {version[:20]!r} of CZML, not 1.0")
    return packets[1:]


def _packet_with_orientation(packets: list[dict[str, Any]], name: str | None) -> dict[str, Any]:
    """Packet with a list of orientations, of this id if one is given; packets of one id are parts of one."""
    candidates = [
        packet for packet in packets if "orientation" in packet and name in (None, packet.get("id"))
    ]
    if not candidates:
        raise FormatError(f"no packet {'' if name is None else f'{name!r} '}has an orientation")
    names = list(dict.fromkeys(repr(packet.get("id")) for packet in candidates))
    if len(names) > 1 or (len(candidates) > 1 and candidates[0].get("id") is None):
        listed = ", ".join(names[:10])
        raise FormatError(f"several packets have an orientation ({listed}): one is read, by its id")
    orientations = [packet["orientation"] for packet in candidates]
    parts = [part for each in orientations for part in (each if isinstance(each, list) else [each])]
    return {**candidates[0], "orientation": parts}


def _ephemeris(packet: dict[str, Any], source: str) -> EphemerisData:
    intervals = packet["orientation"]
    if not intervals:
        raise FormatError("orientation: an empty list")
    fields = [f"orientation[{i}]" for i in range(len(intervals))] if len(intervals) > 1 else ["orientation"]
    segments = [_segment(part, field) for part, field in zip(intervals, fields, strict=True)]
    epoch = segments[0][0]
    parts = [(t + float(as_instants(start, epoch).seconds), q) for start, t, q in segments]
    has_interval = [isinstance(part, dict) and "interval" in part for part in intervals]
    seconds, quaternions = _in_order(parts, has_interval)
    quaternion = schema.unit_rows(np.concatenate(quaternions), source, field="unitQuaternion")
    events = tuple(Event(float(t[0]), "segment", "a new interval of the file") for t in seconds[1:])
    instants = Instants(np.concatenate(seconds), None, epoch, scale="utc").finite("unitQuaternion")
    name = packet.get("name", packet.get("id", ""))
    name = name if isinstance(name, str) else ""
    return EphemerisData(quaternion, schema.check_dates(instants), "ITRF", name=name, events=events)


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
    return parse_time(_plain_date(part["epoch"], f"{field}.epoch"), "utc", f"{field}.epoch"), np.array(
        times, dtype=float
    )


def _check_interval(interval: Any, epoch: Time, seconds: np.ndarray, field: str) -> None:
    """Refuse attitudes outside their interval, which Cesium would not show."""
    if interval is None:
        return
    ends = interval.split("/") if isinstance(interval, str) else []
    if len(ends) != 2:
        raise FormatError(f"{field}.interval: no two dates with / between them")
    times = [parse_time(_plain_date(end, f"{field}.interval"), "utc", f"{field}.interval") for end in ends]
    start, stop = (float(as_instants(time, epoch).seconds) for time in times)
    if not (start - 1e-9 <= seconds.min() and seconds.max() <= stop + 1e-9):  # dates have nanoseconds
        raise FormatError(f"{field}: attitudes outside their interval")


def _plain_date(text: Any, field: str) -> str:
    """The date, without a zone that is UTC; FormatError without any zone."""
    if not isinstance(text, str) or not re.search(r"T.*(Z|[+-]\d\d(:?\d\d)?)$", text):
        raise FormatError(f"{field}: {str(text)[:40]!r} is no date such as 2026-01-01T00:00:00Z")
    return re.sub(r"(Z|\+00(:?00)?)$", "", text)
