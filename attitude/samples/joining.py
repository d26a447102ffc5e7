"""Ephemerides of one body, each of a span of time, joined to one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..errors import InputError
from ..times.instants import Instants, as_instants
from .ephemeris_data import EphemerisData
from .event import Event
from .interpolation import Interpolation
from .provenance import FROM_A_FILE, Plan


def joined(parts: Sequence[EphemerisData], names: Sequence[str]) -> EphemerisData:
    """One ephemeris of several, in the order of time; where a further one begins, an event "segment" says so.

    names : of the parts, for errors and events

    Raises InputError for parts that differ in frame, are of several bodies, have no dates where there are
    several, or overlap.  Where one begins as another ends, both attitudes are kept, the first a double
    earlier.
    """
    if len(parts) == 1:
        return parts[0]
    for part, name in zip(parts, names, strict=True):
        if len(part.shape) != 1 or part.epoch is None:
            raise InputError(name, f"shape {part.shape}", "one body at a list of dated instants")
        if part.frame != parts[0].frame:
            raise InputError(name, part.frame, f"attitudes relative to {parts[0].frame}, as in {names[0]}")
    order = sorted(range(len(parts)), key=lambda i: parts[i].time[:1].tai.jd)
    parts, names = [parts[i] for i in order], [names[i] for i in order]
    moved = [_since(part, parts[0]) for part in parts]
    notes = []
    for k, ((before, after), name) in enumerate(zip(pairwise(moved), names[1:], strict=True)):
        last, first = float(before.elapsed[-1]), float(after.elapsed[0])
        if abs(first - last) <= 1e-9:  # the rounding of dates in files
            instants = before.instants  # of which the last is the double before
            seconds, rest = instants.seconds.copy(), instants.low.copy()
            seconds[-1], rest[-1] = np.nextafter(first, -np.inf), 0.0
            changed = Instants(seconds, rest, instants.epoch, scale=instants.scale)
            moved[k] = replace(before, instants=changed)
            notes.append(f"the epoch at which {name} begins is read twice, the first a double earlier")
        elif first < last:
            raise InputError(name, f"from {first!r} s", f"instants not before {last!r} s")
    events = [
        Event(float(part.elapsed[0]), "segment", f"{name} begins")
        for part, name in zip(moved[1:], names[1:], strict=True)
    ]
    events += [event for part in moved for event in part.events]
    segments = [segment for part in moved if part.interpolation for segment in part.interpolation.segments]
    is_stated = any(part.interpolation.is_stated for part in moved if part.interpolation)
    origin = moved[0].instants
    low, count = None, sum(part.attitude[..., 0].size for part in parts)
    notes = [*(note for part in parts for note in part.notes), *notes]
    if any(part.instants.seconds_low is not None for part in moved):
        low = np.concatenate([part.instants.low for part in moved])
    return EphemerisData(
        np.concatenate([part.quaternion("wxyz") for part in moved]),
        Instants(
            np.concatenate([part.instants.seconds for part in moved]), low, origin.epoch, scale=origin.scale
        ),
        moved[0].frame,
        moved[0].body,
        np.concatenate([part.angular_velocity for part in moved]) if all(p.has_rate for p in moved) else None,
        moved[0].name,
        events=tuple(sorted(events, key=lambda event: event.seconds)),
        interpolation=Interpolation(tuple(segments), is_stated) if segments else None,
        plan=Plan(f"joined of {', '.join(names)}", count, 0.0, 0.0, None, FROM_A_FILE, notes=tuple(notes)),
    )


def _since(part: EphemerisData, first: EphemerisData) -> EphemerisData:
    """The ephemeris with its seconds counted from the epoch of the first."""
    offset = as_instants(part.epoch, first.epoch)
    if part is first or (offset.seconds == 0.0 and not offset.low):
        return part
    shift = float(offset.seconds)
    interpolation = part.interpolation
    if interpolation is not None:
        segments = tuple(
            segment._replace(
                start=segment.start + shift,
                stop=segment.stop + shift,
                instants=segment.instants.counted_from(offset),
            )
            for segment in interpolation.segments
        )
        interpolation = replace(interpolation, segments=segments)
    return replace(
        part,
        instants=part.instants.counted_from(offset),
        events=tuple(replace(event, seconds=event.seconds + shift) for event in part.events),
        interpolation=interpolation,
    )
