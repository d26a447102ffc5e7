"""SPICE CK: types 3 and 2, with the text kernels beside it that make it work at once.

Conventions (NAIF, CK and rotation required reading): a C-matrix takes inertial components to body components,
and its quaternion is the conjugate of this library's, scalar first; the angular velocity is in rad/s with
INERTIAL components; instants are ticks of a spacecraft's clock.  SPICE's J2000 is the ICRF.

Type 3 readers turn at a constant rate from record to record, and interpolate angular velocities linearly.
Type 2 is intervals of constant angular velocity: where the body's rate is constant from the first instant
to the last, one record reaches over `REACH` radians; elsewhere one record an interval, at the rate that
takes the one attitude to the next.

CSPICE has one state a process: what is written here, is written under a lock, and loads no kernel.  Reading
does without it.
"""

from __future__ import annotations

import os
import re
import tempfile
import threading
import unicodedata
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple

import numpy as np

from ...errors import FormatError, InputError
from ...frames import rotations
from ...frames.inertial import from_gcrf
from ...samples.chunks import Samples
from ...samples.ephemeris_data import CONVENTION, EphemerisData
from ...samples.event import Event
from ...times.instants import Instants
from .. import schema, time_origin
from ..interpolation_nodes import Interpolant, Nodes
from . import daf, text_kernels

if TYPE_CHECKING:
    from ..time_origin import TimeOrigin

BLOCK = 1 << 22  # bytes
REACH = 1000.0  # rad; over more, the turn from a record's start loses digits of the thirteenth place
# Frames that SPICE has under other names, or the same; by their numbers there.
REFERENCES = {"ICRF": "J2000", "GCRF": "J2000", "ECLIPJ2000": "ECLIPJ2000"}
NUMBERS = {1: "ICRF", 17: "ECLIPJ2000"}
LARGEST = 2**31 - 1
LARGEST_NUMBER = 1e100  # of ticks, or of rad/s: its square is still a number
EPS = float(np.finfo(float).eps)
# SPICE's names: of frames at most 26 characters (a variable of the pool has 32), of segments 40, bodies 36.
FRAME, SEGMENT = 26, 40

_LOCK = threading.Lock()


class Target(NamedTuple):
    """What is written, and for whom.

    reference : SPICE's name of the frame that attitudes are relative to
    turn : (4,) wxyz by which ours are turned into it, or None
    """

    naif_id: int
    structure: int
    type: int
    rates: bool
    reference: str
    turn: np.ndarray | None
    frame: str
    name: str


class Records(NamedTuple):
    """Of some instants: ticks (n,), our quaternions (n, 4) wxyz, angular velocity (n, 3) inertial or None."""

    ticks: np.ndarray
    quaternion: np.ndarray
    velocity: np.ndarray | None

    def part(self, key: Any) -> Records:
        velocity = None if self.velocity is None else self.velocity[key]
        return Records(self.ticks[key], self.quaternion[key], velocity)


def interpolant(
    *,
    naif_id: int = -999,
    structure_id: int | None = None,
    type: int = 3,
    rates: bool = True,
    reference: str | None = None,
    frame_name: str | None = None,
) -> Interpolant:
    """Constant rate from record to record, in both types."""
    return Interpolant("slerp")


def blocks(
    nodes: Nodes,
    *,
    naif_id: int = -999,
    structure_id: int | None = None,
    type: int = 3,
    rates: bool = True,
    reference: str | None = None,
    frame_name: str | None = None,
) -> Iterator[bytes]:
    """The CK.

    naif_id : of the body, and of its clock
    structure_id : of the structure whose attitude it is; else a thousand times naif_id
    type : 3, or 2 for intervals of constant rate
    rates : write angular velocities, where the ephemeris has them; type 2 is made of them
    reference : SPICE's name of the frame that INERTIAL is; other frames need none
    frame_name : of the body's axes; else of the ephemeris's name
    """
    target = _target(nodes, naif_id, structure_id, type, rates, reference, frame_name)
    return _blocks(nodes, target, time_origin.tt_origin(nodes.segments[0].head), _spice())


def _blocks(nodes: Nodes, target: Target, origin: TimeOrigin, spice: Any) -> Iterator[bytes]:
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "attitude.bc")
        _fill(path, nodes, target, origin, spice)
        with open(path, "rb") as stream:
            while block := stream.read(BLOCK):
                yield block


def beside(
    nodes: Nodes,
    name: str,
    *,
    naif_id: int = -999,
    structure_id: int | None = None,
    type: int = 3,
    rates: bool = True,
    reference: str | None = None,
    frame_name: str | None = None,
) -> dict[str, bytes]:
    """Clock (.tsc), frame (.tf), leap seconds (.tls) and a meta-kernel of all (.tm) for a CK of this name."""
    target = _target(nodes, naif_id, structure_id, type, rates, reference, frame_name)
    origin = time_origin.tt_origin(nodes.segments[0].head)
    anchor = schema.iso_text(origin.time).item().decode()
    body = target.frame.removesuffix("_BODY")
    texts = {
        ".tsc": text_kernels.clock(target.naif_id, int(origin.tt), anchor),
        ".tf": text_kernels.frames(target.naif_id, target.structure, target.frame, body, target.name),
        ".tls": text_kernels.leap_seconds(),
    }
    if Path(name).suffix in (*texts, ".tm"):
        raise FormatError("a text kernel beside it would have the name of the CK; .bc is usual", name)
    names = [Path(name).with_suffix(ending).name for ending in texts] + [name]
    if all(name.isascii() and name.isprintable() for name in names):  # a text kernel holds no other
        texts[".tm"] = text_kernels.together(names)
    return {ending: text.encode("ascii") for ending, text in texts.items()}


def _target(
    nodes: Nodes,
    naif_id: int,
    structure_id: int | None,
    type: int,
    rates: bool,
    reference: str | None,
    frame_name: str | None,
) -> Target:
    head = time_origin.checked_head(nodes, "A CK")
    _check_id(naif_id, "naif_id")
    structure = naif_id * 1000 if structure_id is None else structure_id
    _check_id(structure, "structure_id")
    if type not in (2, 3):
        raise InputError("type", type, "2 or 3")
    if type == 2 and not rates:
        raise InputError("rates", rates, "True for type 2, which is made of rates")
    name = _ascii(head.name) or f"OBJECT {abs(naif_id)}"
    frame = _check_frame_name(_frame_name(name) if frame_name is None else frame_name)
    spice_name, turn = _reference(head.frame, reference)
    return Target(naif_id, structure, type, rates and head.has_rate, spice_name, turn, frame, name)


def _check_id(number: int, field: str) -> None:
    if isinstance(number, bool) or not isinstance(number, int) or not 0 < abs(number) <= LARGEST:
        raise InputError(field, number, f"a whole number other than 0, at most {LARGEST} either way")


def _ascii(text: str) -> str:
    """Letters without their accents, and no line ends."""
    plain = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
    return " ".join("".join(c if c.isprintable() else " " for c in plain).split())


def _frame_name(name: str) -> str:
    stem = re.sub(r"[^A-Z0-9]+", "_", name.upper()).strip("_") or "OBJECT"
    return stem[: FRAME - len("_BODY")].rstrip("_") + "_BODY"


def _check_frame_name(name: str) -> str:
    if not isinstance(name, str) or not re.fullmatch(rf"[A-Z0-9_]{{1,{FRAME}}}", name):
        raise InputError("frame_name", name, f"capitals, digits and _, at most {FRAME} of them")
    return name


def _reference(frame: str, reference: str | None) -> tuple[str, np.ndarray | None]:
    """SPICE's frame, and how attitudes are turned into it."""
    if frame == "INERTIAL":
        if reference not in SPICE_FRAMES:
            expected = "for INERTIAL attitudes the frame of SPICE that they are relative to"
            raise InputError("reference", reference, f"{expected}: {', '.join(SPICE_FRAMES)}")
        return str(reference), None
    if reference is not None:
        raise InputError("reference", reference, f"none for {frame}, which SPICE knows")
    if frame in REFERENCES:
        return REFERENCES[frame], None
    return "J2000", rotations.from_matrix(from_gcrf(frame, "a CK").T)


# Built into SPICE and inertial (NAIF, frames required reading).
SPICE_FRAMES = ("J2000", "ECLIPJ2000", "B1950", "ECLIPB1950", "FK4", "GALACTIC", "MARSIAU")


# -- writing ------------------------------------------------------------------------------------


def _spice() -> Any:
    try:
        import spiceypy
    except ImportError:
        raise FormatError("SPICE CK needs spiceypy: pip install 'attitude[spice]'") from None
    return spiceypy


@contextmanager
def _calling(spice: Any) -> Iterator[None]:
    """One caller at a time; what CSPICE says against it is a FormatError."""
    with _LOCK:
        try:
            yield
        except spice.utils.exceptions.SpiceyError as error:
            raise FormatError(f"CSPICE: {' '.join(str(error).split())[:300]}") from None


def _fill(path: str, nodes: Nodes, target: Target, origin: TimeOrigin, spice: Any) -> None:
    """Under its own name for as long as it takes; closed whatever happens."""
    comments = _comments(nodes, target, origin)
    with _calling(spice):
        handle = spice.ckopn(path, _cut(target.name, 60), sum(len(line) + 1 for line in comments))
    try:
        with _calling(spice):
            spice.dafac(handle, comments)
        begins = [float(_ticks(segment.head, origin)[0]) for segment in nodes.segments[1:]]
        for segment, following in zip(nodes.segments, [*begins, np.inf], strict=True):
            _write_segment(handle, segment, following, target, origin, spice)
    finally:
        with _calling(spice):
            spice.dafcls(handle)


def _cut(text: str, length: int) -> str:
    return text[:length].rstrip()


def _comments(nodes: Nodes, target: Target, origin: TimeOrigin) -> list[str]:
    from ...version import __version__

    head = nodes.segments[0].head
    anchor = schema.iso_text(origin.time).item().decode()
    kept = "with" if target.rates else "without"
    return [
        f"Written by attitude {__version__}: {target.name}",
        f"Attitudes were given relative to {head.frame}; here to {target.reference} of SPICE",
        f"Convention of the library: {CONVENTION}",
        "In this file SPICE's: C-matrix from reference to body components, its quaternion the conjugate,",
        f"{kept} angular velocity, rad/s, components in the reference frame",
        f"Ticks of 1/{text_kernels.TICKS} s of TT from {anchor} TT (the SCLK kernel beside this file)",
        nodes.remark,
    ]


def _write_segment(
    handle: int, segment: Samples, following: float, target: Target, origin: TimeOrigin, spice: Any
) -> None:
    """All of its ticks are before the one at which the following segment begins."""
    if target.type == 3:
        for records in _batches(segment, following, target, origin):
            with _calling(spice):
                _write_3(handle, records, target, spice)
        return
    if segment.count < 2:
        raise FormatError("type 2 holds intervals, and a segment of one instant has none; type 3 holds it")
    constant = _is_constant(segment)
    for records in _batches(segment, following, target, origin, (1, 2)):
        with _calling(spice):
            _write_2(handle, records, constant, target, spice)


def _batches(
    segment: Samples, following: float, target: Target, origin: TimeOrigin, turn: tuple[int, int] = (0, 1)
) -> Iterator[Records]:
    """In turn; each begins with the last record of the one before, so that no time is left out."""
    last: Records | None = None
    for piece in segment.pieces(*turn):
        records = _records(piece, following, target, origin)
        time_origin.refuse_unordered(records.ticks, None if last is None else last.ticks[0], "A CK", "ticks")
        whole = records if last is None else _joined([last, records])
        last = records.part(slice(-1, None))
        if len(whole.ticks) > 1 or segment.count == 1:
            yield whole


def _ticks(piece: EphemerisData, origin: TimeOrigin) -> np.ndarray:
    """They are whole powers of two in a second: nothing is rounded but the seconds."""
    seconds, _ = origin.seconds(piece.instants)
    if not seconds[-1] < text_kernels.SECONDS:
        raise FormatError(f"{seconds[-1]:.3g} s are more than the clock of a CK counts")
    return seconds * text_kernels.TICKS


def _records(piece: EphemerisData, following: float, target: Target, origin: TimeOrigin) -> Records:
    """An instant just before the following segment may round to its first tick: it has the one before."""
    ticks = np.minimum(_ticks(piece, origin), np.nextafter(following, -np.inf))
    q = piece.quaternion("wxyz")
    if target.turn is not None:
        q = rotations.product(target.turn, q)
    velocity = rotations.rotate(q, piece.angular_velocity) if target.rates else None
    return Records(ticks, q, velocity)


def _joined(several: list[Records]) -> Records:
    velocities = [each.velocity for each in several]
    return Records(
        np.concatenate([each.ticks for each in several]),
        np.concatenate([each.quaternion for each in several]),
        None if any(v is None for v in velocities) else np.concatenate(velocities),  # type: ignore[arg-type]
    )


def _write_3(handle: int, records: Records, target: Target, spice: Any) -> None:
    ticks, n = records.ticks, len(records.ticks)
    velocity = np.zeros((n, 3)) if records.velocity is None else records.velocity
    spice.ckw03(
        handle,
        ticks[0],
        ticks[-1],
        target.structure,
        target.reference,
        records.velocity is not None,
        _cut(target.name, SEGMENT),
        n,
        ticks,
        np.ascontiguousarray(rotations.conjugate(records.quaternion)),
        np.ascontiguousarray(velocity),
        1,
        ticks[:1],
    )


def _write_2(handle: int, records: Records, constant: bool, target: Target, spice: Any) -> None:
    if constant and records.velocity is not None:
        edges = _edges(records)
        begins, velocity = records.part(edges[:-1]), records.velocity[edges[:-1]]
    else:
        edges = np.arange(len(records.ticks))
        begins, velocity = records.part(slice(-1)), _between(records)
    spice.ckw02(
        handle,
        records.ticks[0],
        records.ticks[-1],
        target.structure,
        target.reference,
        _cut(target.name, SEGMENT),
        len(begins.ticks),
        begins.ticks,
        records.ticks[edges[1:]],
        np.ascontiguousarray(rotations.conjugate(begins.quaternion)),
        np.ascontiguousarray(velocity),
        np.full(len(begins.ticks), 1.0 / text_kernels.TICKS),
    )


def _edges(records: Records) -> np.ndarray:
    """Where records begin, and where the last ends: each as far as the turn keeps its digits."""
    assert records.velocity is not None
    speed = float(np.sqrt((records.velocity[0] ** 2).sum()))
    turned = speed * (records.ticks - records.ticks[0]) / text_kernels.TICKS
    begins = np.flatnonzero(np.diff(np.floor(turned[:-1] / REACH), prepend=-1.0))
    return np.append(begins, len(records.ticks) - 1)


def _between(records: Records) -> np.ndarray:
    """(n - 1, 3) rad/s, inertial: the constant rate that takes each attitude to the next, the shorter way."""
    q = records.quaternion
    step = rotations.product(q[1:], rotations.conjugate(q[:-1]))
    step = np.where(step[:, :1] < 0.0, -step, step)
    size = np.sqrt((step[:, 1:] ** 2).sum(axis=1))
    angle = 2.0 * np.arctan2(size, step[:, 0])
    seconds = np.diff(records.ticks) / text_kernels.TICKS
    scale = np.divide(angle, size, out=np.full_like(size, 2.0), where=size > 0.0)
    return step[:, 1:] * (scale / seconds)[:, None]


def _is_constant(segment: Samples) -> bool:
    """Whether one body rate takes the first attitude to all others."""
    head = segment.head
    if not head.has_rate:
        return False
    omega, q, start = head.angular_velocity[0], head.quaternion("wxyz")[0], float(head.elapsed[0])
    speed = float(np.sqrt(omega @ omega))
    for piece in segment.pieces(0, 2):
        t = piece.elapsed - start
        near = np.abs(piece.angular_velocity - omega).max() <= 4 * EPS * speed
        if not near:
            return False
        error = rotations.angle_between(_turned(q, omega, t), piece.quaternion("wxyz"))
        if not (error <= 1e-13 + 4 * EPS * speed * np.abs(t)).all():
            return False
    return True


def _turned(q: np.ndarray, omega: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(n, 4): q exp(omega t / 2), at a constant body rate."""
    speed = np.sqrt((omega * omega).sum(axis=-1))
    half = 0.5 * speed * t
    axis = np.divide(omega, speed[..., None], out=np.zeros_like(omega), where=speed[..., None] > 0.0)
    turn = np.concatenate([np.cos(half)[:, None], np.sin(half)[:, None] * axis], axis=1)
    return rotations.product(q, turn)


# -- and back -----------------------------------------------------------------------------------


class Run(NamedTuple):
    """Records of a segment, which of them begin an interval that nobody interpolates into, and whether
    rates may step from one to the next (type 2)."""

    records: Records
    begins: np.ndarray
    steps: bool


def parse(
    stream: BinaryIO,
    source: str,
    *,
    sclk: str | Path | None = None,
    structure_id: int | None = None,
    clock_id: int | None = None,
) -> EphemerisData:
    """Attitudes of one structure, dated in TT.

    Of type 2, the attitudes at the ends of its intervals.  Of two records at one instant, one ending an
    interval and the other beginning the next, the latter stays.  Angular velocities only where all segments
    have them.  Where a record begins an interval, an event "segment" says so.

    sclk : SCLK kernel of the clock that counted the ticks; else that of the same name, ending in .tsc
    structure_id : which, where the file has several
    clock_id : number of the spacecraft whose clock it is (-82), where the structure's number does not tell
    """
    if clock_id is not None:
        _check_id(clock_id, "clock_id")
    arrays = daf.arrays(daf.content(stream, b"DAF/CK", source), 2, 6, source)
    structure = _structure(arrays, structure_id, source)
    chosen = [array for array in arrays if array.integers[0] == structure]
    run = _in_order([_run(array, source) for array in chosen], source)
    frame, clock = _frame(chosen, source), _clock(sclk, structure, clock_id, source)
    anchor, seconds, rest = clock.tt(run.records.ticks, source)
    instants = Instants(seconds, rest if rest.any() else None, time_origin.tt_time(anchor))
    return _ephemeris(run, instants, frame, chosen[0].name, source)


def _structure(arrays: list[daf.Array], wanted: int | None, source: str) -> int:
    found = sorted({array.integers[0] for array in arrays})
    if wanted is None and len(found) == 1:
        return found[0]
    if wanted not in found or wanted is None:
        names = ", ".join(map(str, found[:20])) or "none"
        raise FormatError(f"structure_id is one of {names}; got {wanted}", source)
    return wanted


def _frame(arrays: list[daf.Array], source: str) -> str:
    numbers = {array.integers[1] for array in arrays}
    if len(numbers) > 1 or not numbers <= NUMBERS.keys():
        text = ", ".join(str(number) for number in sorted(numbers)[:20])
        raise FormatError(
            f"relative to SPICE's frame {text}; 1 (J2000) or 17 (ECLIPJ2000) is read, one a file", source
        )
    return NUMBERS[numbers.pop()]


def _clock(sclk: str | Path | None, structure: int, clock_id: int | None, source: str) -> text_kernels.Clock:
    path = Path(source).with_suffix(".tsc") if sclk is None else Path(sclk)
    try:
        text = path.read_bytes().decode("latin-1")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", error)
        raise FormatError(
            f"a CK counts the ticks of a clock, and its SCLK kernel {path} cannot be read ({reason}); "
            "sclk= names another",
            source,
        ) from None
    return text_kernels.clock_from(text, structure, str(path), clock_id)


def _run(array: daf.Array, source: str) -> Run:
    kind = array.integers[2]
    if kind not in (2, 3):
        raise FormatError(f"a segment of type {kind}; types 2 and 3 are read", source)
    if not (np.abs(array.values) < LARGEST_NUMBER).all():
        raise FormatError("a number that is not finite, or none of an attitude", source)
    run = _run_2(array, source) if kind == 2 else _run_3(array, source)
    _check_ticks(run.records.ticks, source)
    return run


def _check_ticks(ticks: np.ndarray, source: str) -> None:
    if not (np.diff(ticks) > 0.0).all():
        raise FormatError("instants of a segment that do not increase", source)


def _run_3(array: daf.Array, source: str) -> Run:
    """Records, their ticks, every hundredth of these, starts of intervals, the same of these, two counts."""
    values, width = array.values, 7 if array.integers[3] == 1 else 4
    intervals, count = (_count(value, source) for value in values[-2:]) if values.size > 2 else (0, 0)
    ends = np.cumsum([count * width, count, (count - 1) // 100, intervals, (intervals - 1) // 100, 2])
    if ends[-1] != values.size or not 1 <= intervals <= count:
        raise FormatError("a segment of type 3 whose counts are not its own", source)
    records = values[: ends[0]].reshape(count, width)
    ticks, starts = values[ends[0] : ends[1]], values[ends[2] : ends[3]]
    _check_ticks(ticks, source)
    begins = np.isin(ticks, starts)
    if not begins[0] or begins.sum() != intervals:
        raise FormatError("intervals that begin between the records of their segment", source)
    velocity = records[:, 4:] if width == 7 else None
    run = Records(ticks, rotations.conjugate(records[:, :4]), velocity)
    inside = (ticks >= array.doubles[0]) & (ticks <= array.doubles[1])
    if not inside.any():
        raise FormatError("a segment that covers none of its records", source)
    begins[int(np.argmax(inside))] = True
    return Run(run.part(inside), begins[inside], False)


def _count(value: float, source: str) -> int:
    if not (1 <= value <= LARGEST and value == int(value)):
        raise FormatError(f"a count of {float(value)!r}", source)
    return int(value)


def _run_2(array: daf.Array, source: str) -> Run:
    """Records, when they begin, when they end, every hundredth of the beginnings."""
    values = array.values
    count = -(-(100 * values.size + 1) // 1001)
    if count < 1 or values.size != 10 * count + (count - 1) // 100:
        raise FormatError("a segment of type 2 whose size is none of one", source)
    records = values[: 8 * count].reshape(count, 8)
    start, stop = values[8 * count : 9 * count], values[9 * count : 10 * count]
    if not ((stop >= start).all() and (start[1:] >= stop[:-1]).all() and (records[:, 7] > 0.0).all()):
        raise FormatError("intervals of a segment that do not follow each other", source)
    if not array.doubles[0] <= start[0] <= stop[-1] <= array.doubles[1]:
        raise FormatError("a segment that covers parts of its records", source)
    return _ends(records, start, stop)


def _ends(records: np.ndarray, start: np.ndarray, stop: np.ndarray) -> Run:
    """Attitudes at both ends of each interval, but once where one ends as the next begins."""
    q, velocity = rotations.conjugate(records[:, :4]), records[:, 4:7]
    omega = rotations.rotate(rotations.conjugate(q), velocity)
    at_end = _turned(q, omega, (stop - start) * records[:, 7])
    apart = rotations.angle_between(at_end[:-1], q[1:])
    joined = np.append(stop[:-1] == start[1:], False)
    begins = np.append(True, ~(joined[:-1] & (apart < 1e-9)))
    both = Records(
        np.stack([start, stop], axis=1).ravel(),
        np.stack([q, at_end], axis=1).reshape(-1, 4),
        np.repeat(velocity, 2, axis=0),
    )
    kept = np.stack([np.full(len(start), True), ~joined & (stop > start)], axis=1).ravel()
    return Run(both.part(kept), np.stack([begins, np.zeros_like(begins)], axis=1).ravel()[kept], True)


def _in_order(runs: list[Run], source: str) -> Run:
    """One after the other; a record that ends one and begins the next stands once."""
    runs = sorted(runs, key=lambda run: float(run.records.ticks[0]))
    if any(run.records.velocity is None for run in runs):
        runs = [run._replace(records=run.records._replace(velocity=None)) for run in runs]
    kept: list[Run] = []
    for run in runs:
        if kept and run.records.ticks[0] <= kept[-1].records.ticks[-1]:
            before = kept[-1]
            if run.records.ticks[0] < before.records.ticks[-1]:
                raise FormatError("segments that overlap: which counts depends on who reads them", source)
            run.begins[0] = not _follows(before, run)
            kept[-1] = Run(before.records.part(slice(-1)), before.begins[:-1], before.steps)
        kept.append(run)
    records, begins = _joined([run.records for run in kept]), np.concatenate([run.begins for run in kept])
    return Run(records, begins, any(run.steps for run in kept))


def _follows(before: Run, after: Run) -> bool:
    """Whether one begins with the record that the other ends with."""
    one, other = before.records.part(-1), after.records.part(0)
    if before.steps or after.steps:
        return bool(rotations.angle_between(one.quaternion, other.quaternion) < 1e-9)
    if not np.array_equal(one.quaternion, other.quaternion):
        return False
    return one.velocity is None or other.velocity is None or np.array_equal(one.velocity, other.velocity)


def _ephemeris(run: Run, instants: Instants, frame: str, name: str, source: str) -> EphemerisData:
    q, velocity = run.records.quaternion, run.records.velocity
    try:
        rotations.attitude_quaternion(q, "wxyz", "quaternion")
        schema.check_dates(instants.finite("instants"))
    except InputError as error:
        raise FormatError(str(error), source) from None
    rate = None if velocity is None else rotations.rotate(rotations.conjugate(q), velocity)
    at = instants.seconds[1:][run.begins[1:]]
    text = "a new interval begins: not to be interpolated into from before"
    happened = tuple(Event(float(seconds), "segment", text) for seconds in at)
    q = rotations.sign_continuous(q)
    found = EphemerisData(q, instants, frame, None, rate, name, events=happened)
    _check_written(found, source)
    return found


def _check_written(found: EphemerisData, source: str) -> None:
    """Instants are apart, and the clock counts them, from the second that a CK of theirs would begin with."""
    seconds, _ = time_origin.tt_origin(found[:1]).seconds(found.instants)
    if not (np.diff(seconds) > 0.0).all() or not seconds[-1] < text_kernels.SECONDS:
        raise FormatError("instants that are one, or too many years, for one clock", source)
