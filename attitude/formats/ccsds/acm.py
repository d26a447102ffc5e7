"""CCSDS attitude comprehensive message (ACM), 504.0-B-2: written in KVN, read in KVN and XML.

Blocks that are written: the attitude history (ATT, one for each segment), the inertia (PHYS) and impulses
(MAN, with the momentum after them).  `BLOCKS` lists what writes each kind, in the order of the standard.  Of
what is read, attitudes and inertia are used; covariances, manoeuvres and estimations are skipped.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import accumulate
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from ...errors import AttitudeError, FormatError, InputError, RegimeError, note
from ...frames import rotations
from ...rigid_body.body import RigidBody
from ...samples.chunks import Samples
from ...samples.ephemeris_data import EphemerisData
from ...samples.event import Event
from ...times.instants import Instants
from .. import schema
from ..interpolation_nodes import split_at_jumps
from ..text_reader import finite_number
from ..text_rows import texts
from ..writer_options import takes_options
from .block_reader import Block, BlockReader, capitals
from .conventions import RowConvention
from .epochs import TIME_SYSTEMS, RowError
from .keywords import ANGLES, ANGLES_DOT, ANGVEL, INERTIA, Q_DOT, Q
from .message_options import (
    VERSION,
    MessageOptions,
    inertia_elements,
    kvn_lines,
    registered_name,
    writes_rates,
)
from .ndm import NdmLine, Syntax, read_ndm
from .reader import check_number

ELEMENTS = {
    "metadata": "META",
    "att": "ATT",
    "phys": "PHYS",
    "cov": "COV",
    "man": "MAN",
    "ad": "AD",
    "sensor": "SENSOR",
    "user": "USER",
}
SYNTAX = Syntax("acm", ("2.0",), ELEMENTS, {"attLine": (), "covLine": ()})
HEADER = ("CLASSIFICATION", "CREATION_DATE", "ORIGINATOR", "MESSAGE_ID")
DCM = tuple(f"DCM_{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3))
ATTITUDES = {"QUATERNION": Q, "EULER_ANGLES": ANGLES, "DCM": DCM}
RATES = {
    "NONE": (),
    "ANGVEL": ANGVEL,
    "Q_DOT": Q_DOT,
    "EULER_RATE": ANGLES_DOT,
    "GYRO_BIAS": ("GYRO_BIAS_X", "GYRO_BIAS_Y", "GYRO_BIAS_Z"),
}


@dataclass(frozen=True, kw_only=True)
class AcmOptions(MessageOptions):
    """Options of an ACM; InputError for one that a line of the file cannot hold.

    object_name : OBJECT_NAME; None for the ephemeris's name
    originator, body_frame : ORIGINATOR, the name of the body's axes
    international_designator, message_id : None leaves them out
    creation_date : CREATION_DATE, UTC; None for now
    rates : whether angular velocities are written; None writes those of an ephemeris that has them
    """

    international_designator: str | None = None
    rates: bool | None = None


# -- writing ------------------------------------------------------------------------------------------


class History(NamedTuple):
    """What the blocks of a file are written of: segments, the options, whether rates are written."""

    segments: list[Samples]
    options: AcmOptions
    has_rate: bool

    @property
    def head(self) -> EphemerisData:
        """What all samples share."""
        return self.segments[0].first


@takes_options(AcmOptions)
def blocks(samples: Samples, **options: Any) -> Iterator[bytes]:
    """File, with the options of `AcmOptions`."""
    schema.refuse_unless_list(samples, "An ACM")
    checked, head = AcmOptions(**options), samples.first
    if head.columns:
        raise InputError("columns", head.columns, "none for acm, which is no table")
    scale = head.instants.scale
    if head.epoch is None or scale is None or scale.upper() not in TIME_SYSTEMS:
        raise FormatError("an ACM has dates in one of its time systems, and this ephemeris has no such epoch")
    history = History(split_at_jumps(samples), checked, writes_rates(checked.rates, head))
    return _blocks(history, checked.name_of(head.name), scale.upper())


def _blocks(history: History, name: str, system: str) -> Iterator[bytes]:
    options, head = history.options, history.head
    designator = options.international_designator
    assert head.epoch is not None
    epoch = getattr(head.epoch, system.lower() if system != "GPS" else "tai")
    yield kvn_lines(
        [
            ("CCSDS_ACM_VERS", VERSION),
            *options.header(),
            ("", ""),
            ("META_START", ""),
            ("OBJECT_NAME", name),
            *([("INTERNATIONAL_DESIGNATOR", designator)] if designator else []),
            ("TIME_SYSTEM", system),
            ("EPOCH_TZERO", schema.iso_text(epoch).item().decode()),
            ("META_STOP", ""),
        ]
    ).encode()
    for block in BLOCKS:
        yield from block(history)


def _attitudes(history: History) -> Iterator[bytes]:
    """ATT: a block for each segment, across which nothing is interpolated."""
    frame, body = rotations.check_any_frame(history.head.frame), history.options.body_frame
    remarks = [ascii(text)[1:-1][:200] for text in history.head.notes]
    for k, segment in enumerate(history.segments, start=1):
        columns = Q + (ANGVEL if history.has_rate else ())
        yield kvn_lines(
            [
                ("", ""),
                ("ATT_START", ""),
                ("COMMENT", f"Q1 Q2 Q3 QC, scalar last, turn axes of {frame} into those of {body}"),
                *(("COMMENT", f"Input: {text}") for text in remarks),
                ("ATT_ID", f"ATT_{k}"),
                *([("ATT_PREV_ID", f"ATT_{k - 1}")] if k > 1 else []),
                ("ATT_BASIS", "SIMULATED" if history.head.has_known_motion else "PREDICTED"),
                ("REF_FRAME_A", registered_name(frame)),
                ("REF_FRAME_B", body),
                ("NUMBER_STATES", str(len(columns))),
                ("ATT_TYPE", "QUATERNION"),
                ("RATE_TYPE", "ANGVEL" if history.has_rate else "NONE"),
            ]
        ).encode()
        last: np.ndarray | None = None
        for piece in segment.chunks():
            q = rotations.sign_continuous(piece.quaternion("xyzw"), last)
            last = q[-1]
            rate = [schema.degrees(piece).T] if history.has_rate else []
            numbers = np.concatenate([piece.elapsed[None], q.T, *rate])
            yield texts(numbers + 0.0, [b"", *[b" "] * len(columns), b"\n"], None)
        yield b"ATT_STOP\n"


def _physical_properties(history: History) -> Iterator[bytes]:
    """PHYS: the inertia, whose products are elements of the tensor, -integral of x y dm."""
    body = history.head.body
    if body is None:
        return
    values = inertia_elements(np.asarray(body.tensor))
    frame = ("INERTIA_REF_FRAME", history.options.body_frame)
    elements = zip(INERTIA, values, strict=True)
    yield kvn_lines([("", ""), ("PHYS_START", ""), frame, *elements, ("PHYS_STOP", "")]).encode()


def _manoeuvres(history: History) -> Iterator[bytes]:
    """MAN: impulses, each with the angular momentum after it."""
    impulses = [event for event in history.head.events if event.kind == "impulse"]
    for k, event in enumerate(impulses, start=1):
        after = next((s.first for s in history.segments if s.first.elapsed[0] >= event.seconds), None)
        try:
            momentum = [] if after is None else after.angular_momentum[0].tolist()
        except RegimeError:  # in a frame that turns, or of a body without inertia
            momentum = []
        target = " ".join(repr(value) for value in momentum)
        yield kvn_lines(
            [
                ("", ""),
                ("MAN_START", ""),
                ("COMMENT", event.text if event.text.isascii() else "an impulse"),
                ("MAN_ID", f"MAN_{k}"),
                ("MAN_PURPOSE", "ATT_ADJUST"),
                ("MAN_BEGIN_TIME", repr(event.seconds)),
                ("MAN_DURATION", "0.0"),
                *([("TARGET_MOMENTUM", target), ("TARGET_MOM_FRAME", history.head.frame)] if target else []),
                ("MAN_STOP", ""),
            ]
        ).encode()


BLOCKS: tuple[Callable[[History], Iterator[bytes]], ...] = (_attitudes, _physical_properties, _manoeuvres)


# -- reading ------------------------------------------------------------------------------------------


class AcmPart(NamedTuple):
    """Attitudes of one block: seconds since T0, wxyz, rad/s or None."""

    seconds: np.ndarray
    attitude: np.ndarray
    rate: np.ndarray | None
    ends: tuple[str, str]


def parse(stream: BinaryIO, source: str, *, block: int | None = None) -> EphemerisData:
    """Read the attitude history.

    block : number of the ATT block to read, 1 for the first; None joins all to one ephemeris
    """
    check_number(block, "block", "all")
    return _AcmReader(read_ndm(stream, source, SYNTAX).lines, source).ephemeris(block)


class _AcmReader(BlockReader):
    """The blocks of an ACM."""

    def __init__(self, lines: list[NdmLine], source: str):
        super().__init__(source)
        self.blocks: list[Block] = []
        stack: list[Block] = [Block("HEADER", 1, {}, [])]
        for line in lines:
            name, _, mark = line.keyword.rpartition("_")
            if name in ELEMENTS.values() and mark == "START" and not line.value:
                stack.append(Block(name, line.number, {}, []))
                self.blocks.append(stack[-1])
            elif name in ELEMENTS.values() and mark == "STOP" and not line.value:
                if stack[-1].name != name:
                    raise self.error(f"{line.keyword} does not belong here", line.number)
                stack.pop()
            elif len(stack) == 1 and line.keyword not in HEADER:
                shown = line.keyword or line.value
                raise self.error(f"{shown[:40]!r} does not belong here", line.number)
            elif not line.keyword:
                stack[-1].rows.append(line)
            elif line.keyword in stack[-1].fields:
                raise self.error(f"{line.keyword[:40]} twice", line.number)
            else:
                stack[-1].fields[line.keyword] = line
        if len(stack) > 1:
            raise self.error(f"no {stack[-1].name}_STOP", stack[-1].number)

    def ephemeris(self, number: int | None) -> EphemerisData:
        """The attitudes of all ATT blocks, or of one."""
        meta = next((block for block in self.blocks if block.name == "META"), None)
        if meta is None:
            raise self.error("no META_START")
        attitudes = [block for block in self.blocks if block.name == "ATT"]
        if number is not None and number > len(attitudes):
            raise self.error(f"no block {number} of attitudes, of {len(attitudes)}")
        attitudes = attitudes if number is None else attitudes[number - 1 : number]
        if not attitudes:
            raise self.error("no attitudes: no block ATT")
        epoch = self.instants(self.needed(meta, "TIME_SYSTEM"), [self.needed(meta, "EPOCH_TZERO")]).epoch
        parts = [self._part(block) for block in attitudes]
        for before, after, block in zip(parts, parts[1:], attitudes[1:], strict=False):
            if after.ends != before.ends or not after.seconds[0] >= before.seconds[-1]:
                reason = "frames or instants that do not follow those of the block before"
                raise self.error(f"{reason}; block=k reads one of them", block.number)
            if after.seconds[0] == before.seconds[-1]:
                before.seconds[-1] = np.nextafter(after.seconds[0], -np.inf)
                note(
                    f"{self.source}: an epoch that two blocks share is read twice, the first a double earlier"
                )
        seconds = np.concatenate([part.seconds for part in parts])
        rates = [part.rate for part in parts if part.rate is not None]
        edges = list(accumulate(len(part.seconds) for part in parts))[:-1]
        events = tuple(Event(float(seconds[edge]), "segment", "a new block of the file") for edge in edges)
        try:
            q = schema.unit_rows(np.concatenate([part.attitude for part in parts]), self.source)
            instants = schema.check_dates(Instants(seconds, None, epoch))
            body = self._body(parts[0].ends[1])
        except AttitudeError as error:
            raise self.error(str(error)) from None
        rate = np.concatenate(rates) if len(rates) == len(parts) else None
        name = self.needed(meta, "OBJECT_NAME").value
        q = rotations.sign_continuous(q)
        return EphemerisData(q, instants, parts[0].ends[0], body, rate, name, events=events)

    def _part(self, block: Block) -> AcmPart:
        """Attitudes of a block, in this library's convention."""
        kind, rate_line = self.needed(block, "ATT_TYPE"), block.fields.get("RATE_TYPE")
        rate_kind = "NONE" if rate_line is None else rate_line.value.upper()
        if kind.value.upper() not in ATTITUDES:
            raise self.error(f"ATT_TYPE = {kind.value[:40]}: one of {', '.join(ATTITUDES)}", kind.number)
        if rate_kind not in RATES:
            raise self.error(f"RATE_TYPE = {rate_kind[:40]}: one of {', '.join(RATES)}", block.number)
        attitude, rates = ATTITUDES[kind.value.upper()], RATES[rate_kind]
        table = self._table(block, len(attitude) + len(rates))
        frame, body, is_a = self.frames(block)
        used = attitude + (() if rate_kind == "GYRO_BIAS" else rates)
        numbers = table[:, 1 : 1 + len(used)].T
        if attitude is DCM:
            used, numbers = self._of_matrices(block, used, numbers)
        axes = self.euler_axes(block) if attitude is ANGLES else ""
        try:
            q, rate = RowConvention(used, frame, is_a, True, axes).convert(np.ascontiguousarray(numbers))
        except RowError as error:
            raise self.error(error.reason, block.rows[error.index].number) from None
        return AcmPart(table[:, 0].copy(), q.T, None if rate is None else rate.T, (frame, body))

    def _of_matrices(
        self, block: Block, used: tuple[str, ...], numbers: np.ndarray
    ) -> tuple[tuple[str, ...], np.ndarray]:
        """The quaternions of matrices from frame A to frame B, in place of these."""
        matrices = numbers[:9].T.reshape(-1, 3, 3)
        with np.errstate(over="ignore", invalid="ignore"):
            off = np.abs(matrices @ np.swapaxes(matrices, 1, 2) - np.eye(3)).max(axis=(1, 2))
            wrong = ~(off <= schema.MAX_OFF_UNIT_IN_FILES) | ~(np.linalg.det(matrices) > 0.0)
        if wrong.any():
            row = block.rows[int(np.argmax(wrong))]
            raise self.error("a matrix that is no rotation, orthonormal within 0.01", row.number)
        q = rotations.from_matrix(np.swapaxes(matrices, 1, 2))
        return Q + used[9:], np.concatenate([q[:, [1, 2, 3, 0]].T, numbers[9:]])

    def _table(self, block: Block, width: int) -> np.ndarray:
        """(n, 1 + width) finite numbers, their instants ascending."""
        if not block.rows:
            raise self.error("no rows in the block ATT", block.number)
        table = np.empty((len(block.rows), 1 + width))
        for i, row in enumerate(block.rows):
            numbers = [finite_number(word) for word in row.value.split()]
            if len(numbers) != 1 + width or np.isnan(numbers).any():
                raise self.error(f"{row.value[:40]!r}: {1 + width} finite numbers belong here", row.number)
            table[i] = numbers
        later = np.diff(table[:, 0]) > 0.0
        if not later.all():
            row = block.rows[int(np.argmin(later)) + 1]
            raise self.error("an instant that is not after the one before", row.number)
        return table

    def _body(self, frame: str) -> RigidBody | None:
        """The inertia of the block PHYS, where it is about the axes that attitudes are of."""
        block = next((b for b in self.blocks if b.name == "PHYS" and "IXX" in b.fields), None)
        if block is None:
            return None
        line = block.fields.get("INERTIA_REF_FRAME")
        if line is None or capitals(line) != frame:
            note(f"{self.source}: the inertia is not along the axes {frame}, and not used")
            return None
        return RigidBody(self.tensor(block))
