"""CCSDS attitude comprehensive message (ACM), 504.0-B-2: written in KVN, read in KVN and XML.

Blocks that are written: the attitude history (ATT, one for each segment), the inertia (PHYS) and impulses
(MAN, with the momentum after them).  `BLOCKS` lists what writes each kind, in the order of the standard.  Of
what is read, attitudes and inertia are used; covariances, manoeuvres and estimations are skipped.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
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
from ..text_rows import texts
from ..writer_options import takes_options
from .conventions import RowConvention
from .epochs import TIME_SYSTEMS, RowError, Timestamps, check_creation_date, parse_epoch, to_instants
from .keywords import ANGLES, ANGLES_DOT, ANGVEL, Q_DOT, VALUE, Q, frame_named, is_value
from .ndm import NdmLine, Syntax, read_ndm
from .rows import NUMBER
from .writer import ORBIT_RELATIVE_NAMES, VERSION, Pairs

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
INERTIA = ("IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ")
DCM = tuple(f"DCM_{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3))
ATTITUDES = {"QUATERNION": Q, "EULER_ANGLES": ANGLES, "DCM": DCM}
RATES = {
    "NONE": (),
    "ANGVEL": ANGVEL,
    "Q_DOT": Q_DOT,
    "EULER_RATE": ANGLES_DOT,
    "GYRO_BIAS": ("GYRO_BIAS_X", "GYRO_BIAS_Y", "GYRO_BIAS_Z"),
}


@dataclass(frozen=True)
class AcmOptions:
    """Options of an ACM; InputError for one that a line of the file cannot hold.

    object_name : OBJECT_NAME; None for the ephemeris's name
    originator, body_frame : ORIGINATOR, the name of the body's axes
    international_designator, message_id : None leaves them out
    creation_date : CREATION_DATE, UTC; None for now
    rates : whether angular velocities are written; None writes those of an ephemeris that has them
    """

    object_name: str | None = None
    originator: str = "ATTITUDE"
    body_frame: str = "SC_BODY_1"
    international_designator: str | None = None
    message_id: str | None = None
    creation_date: str | None = None
    rates: bool | None = None

    def __post_init__(self) -> None:
        if self.rates not in (None, True, False):
            raise InputError("rates", self.rates, "True, False, or None: where there are any")
        for name, value in vars(self).items():
            if name != "rates" and value is not None and not (isinstance(value, str) and is_value(value)):
                raise InputError(name, value, VALUE)
        check_creation_date(self.creation_date)


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
    if checked.rates and not head.has_rate:
        raise InputError("rates", True, "an ephemeris that holds rates, or False")
    has_rate = head.has_rate if checked.rates is None else bool(checked.rates)
    name = checked.object_name or head.name or "UNKNOWN"
    if not is_value(name):
        raise InputError("object_name", name, VALUE)
    return _blocks(History(split_at_jumps(samples), checked, has_rate), name, scale.upper())


def _blocks(history: History, name: str, system: str) -> Iterator[bytes]:
    options, head = history.options, history.head
    date = options.creation_date or datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%S")
    designator = options.international_designator
    assert head.epoch is not None
    epoch = getattr(head.epoch, system.lower() if system != "GPS" else "tai")
    yield _lines(
        [
            (f"CCSDS_ACM_VERS = {VERSION}", ""),
            ("CREATION_DATE", date),
            ("ORIGINATOR", options.originator),
            *([("MESSAGE_ID", options.message_id)] if options.message_id else []),
            ("", ""),
            ("META_START", ""),
            ("OBJECT_NAME", name),
            *([("INTERNATIONAL_DESIGNATOR", designator)] if designator else []),
            ("TIME_SYSTEM", system),
            ("EPOCH_TZERO", schema.iso_text(epoch).item().decode()),
            ("META_STOP", ""),
        ]
    )
    for block in BLOCKS:
        yield from block(history)


def _lines(pairs: Pairs) -> bytes:
    return "".join(f"{name} = {value}\n" if value else f"{name}\n" for name, value in pairs).encode()


def _attitudes(history: History) -> Iterator[bytes]:
    """ATT: a block for each segment, across which nothing is interpolated."""
    frame, body = history.head.frame, history.options.body_frame
    remarks = [ascii(text)[1:-1][:200] for text in history.head.notes]
    for k, segment in enumerate(history.segments, start=1):
        columns = Q + (ANGVEL if history.has_rate else ())
        yield _lines(
            [
                ("", ""),
                ("ATT_START", ""),
                (f"COMMENT Q1 Q2 Q3 QC, scalar last, turn axes of {frame} into those of {body}", ""),
                *((f"COMMENT Input: {text}", "") for text in remarks),
                ("ATT_ID", f"ATT_{k}"),
                *([("ATT_PREV_ID", f"ATT_{k - 1}")] if k > 1 else []),
                ("ATT_BASIS", "SIMULATED" if history.head.has_known_motion else "PREDICTED"),
                ("REF_FRAME_A", ORBIT_RELATIVE_NAMES.get(frame, frame)),
                ("REF_FRAME_B", body),
                ("NUMBER_STATES", str(len(columns))),
                ("ATT_TYPE", "QUATERNION"),
                ("RATE_TYPE", "ANGVEL" if history.has_rate else "NONE"),
            ]
        )
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
    elements = np.asarray(body.tensor)[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)]
    values = [repr(float(element) + 0.0) for element in elements]
    frame = ("INERTIA_REF_FRAME", history.options.body_frame)
    yield _lines([("", ""), ("PHYS_START", ""), frame, *zip(INERTIA, values, strict=True), ("PHYS_STOP", "")])


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
        yield _lines(
            [
                ("", ""),
                ("MAN_START", ""),
                (f"COMMENT {event.text}" if event.text.isascii() else "COMMENT an impulse", ""),
                ("MAN_ID", f"MAN_{k}"),
                ("MAN_PURPOSE", "ATT_ADJUST"),
                ("MAN_BEGIN_TIME", repr(event.seconds)),
                ("MAN_DURATION", "0.0"),
                *([("TARGET_MOMENTUM", target), ("TARGET_MOM_FRAME", history.head.frame)] if target else []),
                ("MAN_STOP", ""),
            ]
        )


BLOCKS: tuple[Callable[[History], Iterator[bytes]], ...] = (_attitudes, _physical_properties, _manoeuvres)


# -- reading ------------------------------------------------------------------------------------------


class AcmBlock(NamedTuple):
    """A block: its keywords, its rows, and the line where it begins."""

    name: str
    fields: dict[str, NdmLine]
    rows: list[NdmLine]
    number: int


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
    if block is not None and (isinstance(block, bool) or not isinstance(block, int) or block < 1):
        raise InputError("block", block, "a whole number, 1 for the first, or None for all")
    return _AcmReader(read_ndm(stream, source, SYNTAX).lines, source).ephemeris(block)


class _AcmReader:
    """The blocks of an ACM."""

    def __init__(self, lines: list[NdmLine], source: str):
        self.source = source
        self.blocks: list[AcmBlock] = []
        stack: list[AcmBlock] = [AcmBlock("HEADER", {}, [], 1)]
        self.header = stack[0]
        for line in lines:
            name, _, mark = line.keyword.rpartition("_")
            if name in ELEMENTS.values() and mark == "START" and not line.value:
                stack.append(AcmBlock(name, {}, [], line.number))
                self.blocks.append(stack[-1])
            elif name in ELEMENTS.values() and mark == "STOP" and not line.value:
                if stack[-1].name != name:
                    raise self._error(f"{line.keyword} does not belong here", line.number)
                stack.pop()
            elif len(stack) == 1 and line.keyword not in HEADER:
                shown = line.keyword or line.value
                raise self._error(f"{shown[:40]!r} does not belong here", line.number)
            elif not line.keyword:
                stack[-1].rows.append(line)
            elif line.keyword in stack[-1].fields:
                raise self._error(f"{line.keyword[:40]} twice", line.number)
            else:
                stack[-1].fields[line.keyword] = line
        if len(stack) > 1:
            raise self._error(f"no {stack[-1].name}_STOP", stack[-1].number)

    def _error(self, reason: str, number: int | None = None) -> FormatError:
        return FormatError(reason, self.source, number)

    def _needed(self, block: AcmBlock, name: str) -> NdmLine:
        if name not in block.fields or not block.fields[name].value:
            raise self._error(f"no {name} in the block {block.name}", block.number)
        return block.fields[name]

    def ephemeris(self, number: int | None) -> EphemerisData:
        """The attitudes of all ATT blocks, or of one."""
        meta = next((block for block in self.blocks if block.name == "META"), None)
        if meta is None:
            raise self._error("no META_START")
        attitudes = [block for block in self.blocks if block.name == "ATT"]
        if number is not None and number > len(attitudes):
            raise self._error(f"no block {number} of attitudes, of {len(attitudes)}")
        attitudes = attitudes if number is None else attitudes[number - 1 : number]
        if not attitudes:
            raise self._error("no attitudes: no block ATT")
        epoch = self._epoch(meta)
        parts = [self._part(block) for block in attitudes]
        for before, after, block in zip(parts, parts[1:], attitudes[1:], strict=False):
            if after.ends != before.ends or not after.seconds[0] >= before.seconds[-1]:
                reason = "frames or instants that do not follow those of the block before"
                raise self._error(f"{reason}; block=k reads one of them", block.number)
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
            raise self._error(str(error)) from None
        rate = np.concatenate(rates) if len(rates) == len(parts) else None
        name = self._needed(meta, "OBJECT_NAME").value
        q = rotations.sign_continuous(q)
        return EphemerisData(q, instants, parts[0].ends[0], body, rate, name, events=events)

    def _epoch(self, meta: AcmBlock) -> Any:
        system, line = self._needed(meta, "TIME_SYSTEM"), self._needed(meta, "EPOCH_TZERO")
        if system.value.upper() not in TIME_SYSTEMS:
            reason = f"TIME_SYSTEM = {system.value[:40]}: one of {', '.join(TIME_SYSTEMS)}"
            raise self._error(reason, system.number)
        try:
            second, atto = parse_epoch(line.value.encode("ascii", "replace"), system.value.upper())
            return to_instants(Timestamps(np.array([second]), np.array([atto])), system.value.upper()).epoch
        except RowError as error:
            raise self._error(f"EPOCH_TZERO: {error.reason}", line.number) from None
        except AttitudeError as error:
            raise self._error(str(error), line.number) from None

    def _part(self, block: AcmBlock) -> AcmPart:
        """Attitudes of a block, in this library's convention."""
        kind, rate_line = self._needed(block, "ATT_TYPE"), block.fields.get("RATE_TYPE")
        rate_kind = "NONE" if rate_line is None else rate_line.value.upper()
        if kind.value.upper() not in ATTITUDES:
            raise self._error(f"ATT_TYPE = {kind.value[:40]}: one of {', '.join(ATTITUDES)}", kind.number)
        if rate_kind not in RATES:
            raise self._error(f"RATE_TYPE = {rate_kind[:40]}: one of {', '.join(RATES)}", block.number)
        attitude, rates = ATTITUDES[kind.value.upper()], RATES[rate_kind]
        table = self._table(block, len(attitude) + len(rates))
        frame, body, is_a = self._ends(block)
        used = attitude + (() if rate_kind == "GYRO_BIAS" else rates)
        numbers = table[:, 1 : 1 + len(used)].T
        if attitude is DCM:
            used, numbers = self._of_matrices(block, used, numbers)
        axes = self._axes(block) if attitude is ANGLES else ""
        try:
            q, rate = RowConvention(used, frame, is_a, True, axes).convert(np.ascontiguousarray(numbers))
        except RowError as error:
            raise self._error(error.reason, block.rows[error.index].number) from None
        return AcmPart(table[:, 0].copy(), q.T, None if rate is None else rate.T, (frame, body))

    def _of_matrices(
        self, block: AcmBlock, used: tuple[str, ...], numbers: np.ndarray
    ) -> tuple[tuple[str, ...], np.ndarray]:
        """The quaternions of matrices from frame A to frame B, in place of these."""
        matrices = numbers[:9].T.reshape(-1, 3, 3)
        with np.errstate(over="ignore", invalid="ignore"):
            off = np.abs(matrices @ np.swapaxes(matrices, 1, 2) - np.eye(3)).max(axis=(1, 2))
            wrong = ~(off <= schema.MAX_OFF_UNIT_IN_FILES) | ~(np.linalg.det(matrices) > 0.0)
        if wrong.any():
            row = block.rows[int(np.argmax(wrong))]
            raise self._error("a matrix that is no rotation, orthonormal within 0.01", row.number)
        q = rotations.from_matrix(np.swapaxes(matrices, 1, 2))
        return Q + used[9:], np.concatenate([q[:, [1, 2, 3, 0]].T, numbers[9:]])

    def _table(self, block: AcmBlock, width: int) -> np.ndarray:
        """(n, 1 + width) finite numbers, their instants ascending."""
        if not block.rows:
            raise self._error("no rows in the block ATT", block.number)
        table = np.empty((len(block.rows), 1 + width))
        for i, row in enumerate(block.rows):
            words = row.value.split()
            if len(words) != 1 + width or not all(NUMBER.fullmatch(word.encode()) for word in words):
                raise self._error(f"{row.value[:40]!r}: {1 + width} numbers belong here", row.number)
            table[i] = [float(word) for word in words]
        is_late = np.append(False, ~(np.diff(table[:, 0]) > 0.0))
        wrong = is_late | ~np.isfinite(table).all(axis=1)
        if wrong.any():
            row = block.rows[int(np.argmax(wrong))]
            raise self._error(
                "a number that is not finite, or an instant not after the one before", row.number
            )
        return table

    def _ends(self, block: AcmBlock) -> tuple[str, str, bool]:
        """External frame, name of the body's, and whether the external one is frame A."""
        names = [
            "_".join(self._needed(block, key).value.upper().split()) for key in ("REF_FRAME_A", "REF_FRAME_B")
        ]
        known = rotations.INERTIAL_FRAMES.keys() | rotations.TURNING_FRAMES.keys()
        is_external = [frame_named(name) in known for name in names]
        if sum(is_external) != 1:
            reason = f"one of frames A and B is the body's, the other one of {', '.join(sorted(known))}"
            raise self._error(f"{names[0][:40]}, {names[1][:40]}: {reason}", block.number)
        external, body = names if is_external[0] else names[::-1]
        return frame_named(external), body, is_external[0]

    def _axes(self, block: AcmBlock) -> str:
        line = self._needed(block, "EULER_ROT_SEQ")
        try:
            return rotations.check_sequence(line.value.upper().translate(str.maketrans("123", "XYZ")))
        except InputError as error:
            raise self._error(str(error), line.number) from None

    def _body(self, frame: str) -> RigidBody | None:
        """The inertia of the block PHYS, where it is about the axes that attitudes are of."""
        block = next((b for b in self.blocks if b.name == "PHYS" and "IXX" in b.fields), None)
        if block is None:
            return None
        line = block.fields.get("INERTIA_REF_FRAME")
        if line is None or "_".join(line.value.upper().split()) != frame:
            note(f"{self.source}: the inertia is not along the axes {frame}, and not used")
            return None
        values = []
        for name in INERTIA:
            text = self._needed(block, name)
            if not NUMBER.fullmatch(text.value.encode()):
                raise self._error(f"{name} is {text.value[:40]!r}, not a number", text.number)
            values.append(float(text.value))
        xx, yy, zz, xy, xz, yz = values
        return RigidBody([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
