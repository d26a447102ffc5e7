"""Writing a CK with CSPICE, record by record.

CSPICE has one state per process, so files are written under a lock, and no kernel is loaded.
"""

from __future__ import annotations

import os
import re
import tempfile
import unicodedata
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...errors import FormatError, InputError, suggestion
from ...frames import rotations
from ...frames.inertial import from_gcrf
from ...samples.chunks import Samples
from ...samples.ephemeris_data import CONVENTION, EphemerisData
from .. import time_origin
from ..date_text import one_date
from ..interpolant import Interpolant, hermite
from ..interpolation_nodes import Nodes
from ..time_origin import TimeOrigin
from . import text_kernels
from .ck_records import MAX_ID, CkRecords, check_id, concatenated, rotate_at_constant_rate
from .cspice import calling
from .reference_frames import NUMBERS

POLYNOMIALS = (5, 6)  # types of Hermite's polynomials
MAX_ROTATION = 1000.0  # rad; beyond, the rotation since a record's start loses its thirteenth digit
# SPICE's names of frames: the same frame under another name, or the same name.
SPICE_FRAMES = {"ICRF": "J2000", "GCRF": "J2000", "ECLIPJ2000": "ECLIPJ2000"}
MAX_FRAME_LENGTH = 26  # of a frame's name, which is part of a variable's, of 32 characters


@dataclass(frozen=True)
class CkOptions:
    """Options of the CK writer; InputError for one that a CK cannot hold.

    naif_id : number of the body, a spacecraft (below 0) or a natural one, and of its clock
    structure_id : number of the structure whose attitude it is; None for a thousand times naif_id, or for
        naif_id itself where that is beyond 32 bits (asteroids of the numbers from 20000001)
    type : 3; 5 for Hermite's polynomials, which need the fewest instants; 6 for these in one segment of the
        file, whose mini-segments are the segments of the ephemeris; or 2 for intervals of constant rate
    degree : of the polynomials of types 5 and 6
    rates : write angular velocities, where the ephemeris has them; type 2 consists of them
    reference : for INERTIAL, SPICE's name of the frame it is; None for any other frame
    frame_name : name of the frame of the body's axes; None derives it from the ephemeris's name
    """

    naif_id: int = -999
    structure_id: int | None = None
    type: int = 3
    rates: bool = True
    reference: str | None = None
    frame_name: str | None = None
    degree: int = 7

    def __post_init__(self) -> None:
        check_id(self.naif_id, "naif_id")
        check_id(self.structure, "structure_id")
        if self.type not in (2, 3, 5, 6):
            raise InputError("type", self.type, "2, 3, 5 or 6")
        hermite(self.degree, "degree")
        if self.type == 2 and not self.rates:
            raise InputError("rates", self.rates, "True for type 2, which is made of rates")

    @property
    def interpolant(self) -> Interpolant:
        """How readers interpolate between the records."""
        return Interpolant("slerp") if self.type not in POLYNOMIALS else hermite(self.degree, "degree")

    @property
    def structure(self) -> int:
        """Number of the structure."""
        if self.structure_id is not None:
            return self.structure_id
        is_asteroid = self.naif_id * 1000 > MAX_ID  # of eight digits: its structure has its own number
        return self.naif_id if is_asteroid else self.naif_id * 1000


class CkTarget(NamedTuple):
    """Whose attitude is written, and how.

    reference : SPICE's name of the frame that attitudes are relative to
    turn : (4,) wxyz, the rotation from the ephemeris's frame to it, or None
    frame : name of the frame of the body's axes
    """

    naif_id: int
    structure: int
    type: int
    rates: bool
    reference: str
    turn: np.ndarray | None
    frame: str
    name: str
    degree: int

    @property
    def segment_name(self) -> str:
        """Cut a name to the length that a segment's may have."""
        return self.name[:40].rstrip()

    @classmethod
    def of(cls, nodes: Nodes, options: CkOptions) -> CkTarget:
        """Target of an ephemeris; refuses what a CK cannot hold."""
        head = time_origin.checked_head(nodes, "A CK")
        plain = unicodedata.normalize("NFKD", head.name).encode("ascii", "ignore").decode()  # no accents
        plain = " ".join("".join(c if c.isprintable() else " " for c in plain).split())
        name, frame = plain or f"OBJECT {abs(options.naif_id)}", options.frame_name
        if frame is None:
            stem = re.sub(r"[^A-Z0-9]+", "_", name.upper()).strip("_") or "OBJECT"
            frame = stem[: MAX_FRAME_LENGTH - len("_BODY")].rstrip("_") + "_BODY"
        if not isinstance(frame, str) or not re.fullmatch(rf"[A-Z0-9_]{{1,{MAX_FRAME_LENGTH}}}", frame):
            raise InputError(
                "frame_name", frame, f"capitals, digits and _, at most {MAX_FRAME_LENGTH} of them"
            )
        reference, turn = _reference(head.frame, options.reference)
        if options.type in POLYNOMIALS and not head.has_rate:
            raise FormatError(
                f"type {options.type} is written with rates, and this ephemeris has none; type 3 holds it"
            )
        rates, numbers = options.rates and head.has_rate, (options.naif_id, options.structure, options.type)
        return cls(*numbers, rates, reference, turn, frame, name, options.degree)


def _reference(frame: str, reference: str | None) -> tuple[str, np.ndarray | None]:
    """SPICE's frame, and the rotation to it from the ephemeris's."""
    if frame == "INERTIAL":
        if reference not in NUMBERS:
            expected = "for INERTIAL attitudes the frame of SPICE that they are relative to"
            meant = suggestion(reference, NUMBERS)
            raise InputError("reference", reference, f"{expected}: {', '.join(NUMBERS)}{meant}")
        return str(reference), None
    if reference is not None:
        raise InputError("reference", reference, f"none for {frame}, which SPICE knows")
    if frame in SPICE_FRAMES:
        return SPICE_FRAMES[frame], None
    return "J2000", rotations.from_matrix(from_gcrf(frame, "a CK").T)


# -- the file -----------------------------------------------------------------------------------


def write_blocks(nodes: Nodes, target: CkTarget, spice: Any) -> Iterator[bytes]:
    """Write a temporary file, and yield its content."""
    origin = time_origin.tt_origin(nodes.segments[0].first)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "attitude.bc")
        CkWriter(target, origin, spice).write(path, nodes)
        with open(path, "rb") as stream:
            while block := stream.read(1 << 22):
                yield block


def _comments(nodes: Nodes, target: CkTarget, origin: TimeOrigin) -> list[str]:
    from ...version import __version__

    head = nodes.segments[0].first
    anchor = one_date(origin.time)
    with_or_without = "with" if target.rates else "without"
    return [
        f"Written by attitude {__version__}: {target.name}",
        f"Attitudes were given relative to {head.frame}; here to {target.reference} of SPICE",
        f"Convention of the library: {CONVENTION}",
        "In this file SPICE's: C-matrix from reference to body components, its quaternion the conjugate,",
        f"{with_or_without} angular velocity, rad/s, components in the reference frame",
        f"Ticks of 1/{text_kernels.TICKS} s of TT from {anchor} TT (the SCLK kernel beside this file)",
        nodes.remark,
        *nodes.notes,
    ]


class CkWriter(NamedTuple):
    """Writes the segments of a file.

    origin : of the ticks
    spice : spiceypy
    """

    target: CkTarget
    origin: TimeOrigin
    spice: Any

    def write(self, path: str, nodes: Nodes) -> None:
        """Write all segments; the file is closed whatever happens."""
        comments, spice = _comments(nodes, self.target, self.origin), self.spice
        with calling(spice):
            internal_name = self.target.name[:60].rstrip()  # the length that SPICE takes
            handle = spice.ckopn(path, internal_name, sum(len(line) + 1 for line in comments))
        try:
            with calling(spice):
                spice.dafac(handle, comments)
            begins = [float(self.ticks(segment.first)[0]) for segment in nodes.segments[1:]]
            segments = zip(nodes.segments, [*begins, np.inf], strict=True)
            if self.target.type == 6:
                parts = [self.whole(*segment) for segment in segments]
                with calling(spice):
                    self.write_type_6(handle, parts)
                return
            for segment, following in segments:
                self.write_segment(handle, segment, following)
        finally:
            with calling(spice):
                spice.dafcls(handle)

    def write_segment(self, handle: int, segment: Samples, following: float) -> None:
        """Write a segment; all of its ticks are before the one at which the following segment begins."""
        target, spice, table = self.target, self.spice, tuple[Any, ...]()
        if target.type == 2 and segment.count < 2:
            reason = "type 2 holds intervals, and a segment of one instant has none; type 3 holds it"
            raise FormatError(reason)
        is_constant = target.type == 2 and _is_constant(segment)
        batches: Iterable[CkRecords] = self.batches(segment, following, target.rates, target.type == 2)
        for records in [self.whole(segment, following)] if target.type == 5 else batches:
            ticks, name, velocity = records.ticks, target.segment_name, records.velocity
            span = (ticks[0], ticks[-1], target.structure, target.reference)
            rate = 1.0 / text_kernels.TICKS
            with calling(spice):
                if target.type == 3:
                    rates = np.zeros((len(ticks), 3)) if velocity is None else np.ascontiguousarray(velocity)
                    table = ticks, records.c_quaternion, rates
                    is_rated = velocity is not None
                    spice.ckw03(handle, *span, is_rated, name, len(ticks), *table, 1, ticks[:1])
                elif target.type == 5:  # subtype 0
                    table = ticks, records.packets, rate, 1, ticks[:1]
                    spice.ckw05(handle, 0, target.degree, *span, target.rates, name, *table)
                else:
                    begins, stops, rates = _intervals(records, is_constant)
                    table = begins.ticks, stops, begins.c_quaternion, np.ascontiguousarray(rates)
                    spice.ckw02(handle, *span, name, len(stops), *table, np.full(len(stops), rate))

    def write_type_6(self, handle: int, parts: list[CkRecords]) -> None:
        """Subtype 0, a mini-segment for each part; where two meet, the second one holds.

        By CKW06 of Fortran's interface, which CSPICE and spiceypy do not wrap: all arguments are passed by
        reference, and the lengths of texts follow them.
        """

        def passed(values: Any) -> Any:
            array = np.array(values).reshape(-1)
            return np.ctypeslib.as_ctypes(array.astype(float if array.dtype.kind == "f" else np.int32))

        target, count = self.target, len(parts)
        bounds = [*(part.ticks[0] for part in parts), parts[-1].ticks[-1]]
        reference, name = target.reference.encode(), target.segment_name.encode()
        segment = map(passed, (target.rates, bounds[0], bounds[-1]))
        mini_segments: tuple[Any, ...] = (
            *(count, [len(part.ticks) for part in parts], [0] * count, [target.degree] * count),
            np.concatenate([part.packets for part in parts]),
            [1.0 / text_kernels.TICKS] * count,
            *(np.concatenate([part.ticks for part in parts]), bounds, True),
        )
        self.spice.utils.libspicehelper.libspice.ckw06_(
            *(passed(handle), passed(target.structure), reference, *segment, name),
            *(*map(passed, mini_segments), len(reference), len(name)),
        )
        self.spice.spiceypy.check_for_spice_error(None)

    # -- records --------------------------------------------------------------------------------

    def whole(self, segment: Samples, following: float) -> CkRecords:
        """All records of a segment, with rates: of one instant there is no polynomial."""
        batches = list(self.batches(segment, following, True))
        whole = concatenated([batches[0], *(batch.part(slice(1, None)) for batch in batches[1:])])
        if len(whole.ticks) < 2:
            reason = "holds polynomials, and a segment of one instant has none; type 3 holds it"
            raise FormatError(f"type {self.target.type} {reason}")
        return whole

    def batches(
        self, segment: Samples, following: float, rates: bool, is_second_pass: bool = False
    ) -> Iterator[CkRecords]:
        """Batches of records in order; each begins with the last record of the one before, leaving no gap."""
        last: CkRecords | None = None
        for piece in segment.chunks(*((1, 2) if is_second_pass else (0, 1))):
            records = self.records(piece, following, rates)
            before = None if last is None else last.ticks[0]
            time_origin.refuse_unordered(records.ticks, before, "A CK", "ticks")
            batch = records if last is None else concatenated([last, records])
            last = batch.part(slice(-1, None))
            if len(batch.ticks) > 1 or segment.count == 1:
                yield batch

    def records(self, piece: EphemerisData, following: float, rates: bool) -> CkRecords:
        """Records of a piece; an instant that rounds to the tick `following` gets the one before."""
        ticks = np.minimum(self.ticks(piece), np.nextafter(following, -np.inf))
        q = piece.quaternion("wxyz")
        if self.target.turn is not None:
            q = rotations.product(self.target.turn, q)
        return CkRecords(ticks, q, rotations.rotate(q, piece.angular_velocity) if rates else None)

    def ticks(self, piece: EphemerisData) -> np.ndarray:
        """Ticks, of which a second has a power of two: nothing is rounded but the seconds."""
        seconds, _ = self.origin.seconds(piece.instants)
        if not seconds[-1] < text_kernels.SECONDS:
            raise FormatError(f"{seconds[-1]:.3g} s are more than the clock of a CK counts")
        return seconds * text_kernels.TICKS


def _intervals(records: CkRecords, is_constant: bool) -> tuple[CkRecords, np.ndarray, np.ndarray]:
    """Records at which intervals of type 2 begin, the ticks at which they stop, and their rates (n, 3).

    At one rate from the first to the last, each covers `MAX_ROTATION` at most.
    """
    if not is_constant or records.velocity is None:
        return records.part(slice(-1)), records.ticks[1:], text_kernels.TICKS * records.rates_between
    speed = float(np.sqrt((records.velocity[0] ** 2).sum()))
    angle = speed * (records.ticks - records.ticks[0]) / text_kernels.TICKS
    begins = np.flatnonzero(np.diff(np.floor(angle[:-1] / MAX_ROTATION), prepend=-1.0))
    edges = np.append(begins, len(records.ticks) - 1)
    return records.part(edges[:-1]), records.ticks[edges[1:]], records.velocity[edges[:-1]]


def _is_constant(segment: Samples) -> bool:
    """Whether one body rate takes the first attitude to all others."""
    head = segment.first
    if not head.has_rate:
        return False
    omega, q, start = head.angular_velocity[0], head.quaternion("wxyz")[0], float(head.elapsed[0])
    speed = float(np.sqrt(omega @ omega))
    rounding = 4 * float(np.finfo(float).eps) * speed
    for piece in segment.chunks(0, 2):
        if not np.abs(piece.angular_velocity - omega).max() <= rounding:
            return False
        t = piece.elapsed - start
        error = rotations.angle_between(rotate_at_constant_rate(q, omega, t), piece.quaternion("wxyz"))
        if not (error <= 1e-13 + rounding * np.abs(t)).all():
            return False
    return True
