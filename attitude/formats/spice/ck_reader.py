"""Reading a CK of types 1, 2, 3, 5 and 6, from its bytes: without CSPICE, its state and its lock."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ...errors import FormatError, InputError
from ...frames import rotations
from ...samples.ephemeris_data import EphemerisData
from ...samples.event import Event
from ...samples.interpolation import Interpolation, InterpolationMethod
from ...samples.resampling import segments_at_events
from ...times.instants import Instants
from .. import schema, time_origin
from . import daf, reference_frames, text_kernels
from .ck_records import check_id
from .ck_segments import CkSegment, CkSeries, joined, ranked, segments
from .sclk import clock_from

FRAMES = {1: "ICRF", 17: "ECLIPJ2000"}  # by SPICE's numbers: those whose attitudes are not turned


def parse(
    stream: BinaryIO,
    source: str,
    *,
    sclk: str | Path | None = None,
    structure_id: int | None = None,
    clock_id: int | None = None,
    fk: str | Path | None = None,
) -> EphemerisData:
    """Attitudes of one structure, dated in TT, relative to the ICRF, or to ECLIPJ2000 where all of them are.

    Of type 2, the attitudes at the ends of its intervals, and between them where one turns by more than a
    right angle.  Where segments overlap, the last of the file counts, as in SPICE; likewise of two records at
    one instant that ends an interval and begins the next.
    Angular velocities only where all segments have them.  Where a record begins an interval, an event
    "segment" says so.

    sclk : SCLK kernel of the clock that counted the ticks; else that of the same name, ending in .tsc
    structure_id : which, where the file has several
    clock_id : number of the spacecraft whose clock it is (-82), where neither the structure's number nor a
        frame kernel tells
    fk : frame kernel that defines the frame which attitudes are relative to, or names the clock
    """
    if clock_id is not None:
        check_id(clock_id, "clock_id")
    frames = {} if fk is None else text_kernels.variables(_kernel_text(fk, "fk", source), str(fk))
    arrays = daf.arrays(stream, b"DAF/CK", 2, 6, source)
    structures = sorted({array.integers[0] for array in arrays})
    structure = structures[0] if structure_id is None and len(structures) == 1 else structure_id
    if structure not in structures or structure is None:
        names = ", ".join(map(str, structures[:20])) or "none"
        raise FormatError(f"structure_id is one of {names}; got {structure_id}", source)
    arrays = [array for array in arrays if array.integers[0] == structure]
    frame = FRAMES.get(arrays[0].integers[1], "ICRF")
    if any(array.integers[1] != arrays[0].integers[1] for array in arrays):
        frame = "ICRF"
    parts: list[CkSegment] = []
    for rank, array in enumerate(arrays):
        parts += _in_frame(segments(array, rank, source), array.integers[1], frame, frames, source)
    if not parts:
        raise FormatError("segments that cover none of their records", source)
    series = joined(ranked(parts))
    stated = frames.get(f"CK_{structure}_SCLK", [None])[0]
    if clock_id is None and isinstance(stated, float) and stated == int(stated):
        clock_id = int(stated)
    path = Path(source).with_suffix(".tsc") if sclk is None else Path(sclk)
    noun = "a CK counts the ticks of a clock, and its SCLK kernel"
    text = _kernel_text(path, noun, source, "; sclk= names another")
    clock = clock_from(text, str(path), structure, source, clock_id)
    anchor, seconds, rest = clock.tt(series.records.ticks, source)
    instants = Instants(seconds, rest if rest.any() else None, time_origin.tt_time(anchor))
    return _ephemeris(series, instants, frame, arrays[0].name, source)


def _kernel_text(path: str | Path, noun: str, source: str, cure: str = "") -> str:
    """The text of a kernel that the file needs."""
    try:
        return Path(path).read_bytes().decode("latin-1")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", error)
        raise FormatError(f"{noun} {path} cannot be read ({reason}){cure}", source) from None


def _in_frame(
    parts: list[CkSegment], number: int, frame: str, frames: dict[str, list[Any]], source: str
) -> list[CkSegment]:
    """Segments relative to SPICE's frame of this number, turned into `frame`."""
    if FRAMES.get(number) == frame:
        return parts
    turn = rotations.from_matrix(reference_frames.matrix_from_icrf(number, frames, source).T)
    turned = []
    for part in parts:
        q, velocity = rotations.product(turn, part.records.quaternion), part.records.velocity
        velocity = None if velocity is None else rotations.rotate(turn, velocity)
        turned.append(part._replace(records=part.records._replace(quaternion=q, velocity=velocity)))
    return turned


def _ephemeris(series: CkSeries, instants: Instants, frame: str, name: str, source: str) -> EphemerisData:
    q, velocity = series.records.quaternion, series.records.velocity
    try:
        q = schema.unit_rows(q, source)
        schema.check_dates(instants.finite("instants"))
    except InputError as error:
        raise FormatError(str(error), source) from None
    rate = None if velocity is None else rotations.rotate(rotations.conjugate(q), velocity)
    text = "a new interval begins: not to be interpolated into from before"
    starts = instants.seconds[1:][series.begins[1:]]
    events = tuple(Event(float(seconds), "segment", text) for seconds in starts)
    q = rotations.sign_continuous(q)
    ephemeris = EphemerisData(q, instants, frame, None, rate, name, events=events)
    # Instants remain distinct, and within the clock's range, when they are counted as a CK of theirs would.
    seconds, _ = time_origin.tt_origin(ephemeris[:1]).seconds(instants)
    if not (np.diff(seconds) > 0.0).all() or not seconds[-1] < text_kernels.SECONDS:
        raise FormatError("instants that coincide, or span too many years, for one clock", source)
    if not any(series.methods):  # all are of type 1, which states none
        return ephemeris
    parts = segments_at_events(ephemeris, InterpolationMethod())
    first = np.searchsorted(ephemeris.elapsed, [part.start for part in parts])
    methods = [series.methods[series.owner[i]] for i in first]  # of each its own
    pairs = zip(parts, methods, strict=True)
    whole = Interpolation(tuple(p._replace(method=m) if m else p for p, m in pairs), True)
    return replace(ephemeris, interpolation=whole)
