"""Reading an ACM (CCSDS 504.0-B-2), KVN and XML: attitudes and inertia.

Covariances, manoeuvres and estimations are skipped.
"""

from __future__ import annotations

from itertools import accumulate
from typing import BinaryIO, NamedTuple

import numpy as np
from astropy import units as u
from astropy.time import TimeDelta

from ...errors import AttitudeError, InputError, note
from ...frames import rotations
from ...rigid_body.body import RigidBody
from ...samples.ephemeris_data import EphemerisData
from ...samples.event import Event
from ...times.instants import Instants, as_instants
from .. import schema
from ..text_reader import check_number, finite_number
from .block_reader import Block, BlockReader, capitals
from .conventions import RowConvention
from .epochs import TIME_SYSTEMS, RowError, Timestamps, parse_epochs, to_instants
from .keywords import HEADER, VALUE, Keywords, is_value
from .ndm import NdmLine, Syntax, read_ndm

SYNTAX = Syntax(
    "acm",
    ("2.0",),
    {
        "metadata": "META",
        "att": "ATT",
        "phys": "PHYS",
        "cov": "COV",
        "man": "MAN",
        "ad": "AD",
        "sensor": "SENSOR",
        "sensorData": "SENSOR",
        "user": "USER",
    },
    {"attLine": (), "covLine": ()},
)
DCM = tuple(f"DCM_{i}{j}" for j in (1, 2, 3) for i in (1, 2, 3))  # column by column (annex B4)
ATTITUDES = {"QUATERNION": Keywords.Q, "EULER_ANGLES": Keywords.ANGLES, "DCM": DCM}
RATES = {
    "NONE": (),
    "ANGVEL": Keywords.ANGVEL,
    "Q_DOT": Keywords.Q_DOT,
    "EULER_RATE": Keywords.ANGLES_DOT,
    "GYRO_BIAS": ("GYRO_BIAS_X", "GYRO_BIAS_Y", "GYRO_BIAS_Z"),
}


class AcmPart(NamedTuple):
    """Attitudes of one block: instants since T0, wxyz, rad/s or None."""

    seconds: np.ndarray
    seconds_low: np.ndarray
    attitude: np.ndarray
    rate: np.ndarray | None
    ends: tuple[str, str]


class TimeZero(NamedTuple):
    """EPOCH_TZERO: its time system, its timestamp, and the one instant of it, which is the epoch of all."""

    system: str
    stamp: Timestamps
    instants: Instants

    def after(self, seconds: np.ndarray) -> Instants:
        """Instants at seconds of the time system since T0."""
        scale, epoch = TIME_SYSTEMS[self.system], self.instants.epoch
        if scale in ("utc", "tai", "tt"):
            return Instants(seconds, None, epoch)
        return as_instants(TimeDelta(seconds * u.s, scale=scale), epoch, "time tag")

    def dated(self, stamps: Timestamps) -> Instants:
        """Instants at timestamps."""
        both = (np.append(zero, later) for zero, later in zip(self.stamp, stamps, strict=True))
        return to_instants(Timestamps(*both), self.system)[1:]


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
            is_mark = name in SYNTAX.blocks.values() and not line.value
            if is_mark and mark == "START":
                stack.append(Block(name, line.number, {}, []))
                self.blocks.append(stack[-1])
            elif is_mark and mark == "STOP":
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
        system, line = self.needed(meta, "TIME_SYSTEM"), self.needed(meta, "EPOCH_TZERO")
        zero, scale = self.instants(system, [line]), system.value.upper()
        tzero = TimeZero(scale, parse_epochs([line.value.encode()], scale), zero)
        parts = [self._part(block, tzero) for block in attitudes]
        for before, after, block in zip(parts, parts[1:], attitudes[1:], strict=False):
            if after.ends != before.ends or not after.seconds[0] >= before.seconds[-1]:
                reason = "frames or instants that do not follow those of the block before"
                raise self.error(f"{reason}; block=k reads one of them", block.number)
            if after.seconds[0] == before.seconds[-1]:
                before.seconds[-1] = np.nextafter(after.seconds[0], -np.inf)
                note(
                    f"{self.source}: an epoch that two blocks share is read twice, the first a double earlier"
                )
        seconds, low = (np.concatenate([part[i] for part in parts]) for i in (0, 1))
        rates = [part.rate for part in parts if part.rate is not None]
        edges = list(accumulate(len(part.seconds) for part in parts))[:-1]
        events = tuple(Event(float(seconds[edge]), "segment", "a new block of the file") for edge in edges)
        try:
            q = schema.unit_rows(np.concatenate([part.attitude for part in parts]), self.source)
            instants = schema.check_dates(Instants(seconds, low if low.any() else None, tzero.instants.epoch))
            body = self._body(parts[0].ends[1])
        except AttitudeError as error:
            raise self.error(str(error)) from None
        rate = np.concatenate(rates) if len(rates) == len(parts) else None
        name = self.needed(meta, "OBJECT_NAME")
        if not is_value(name.value):
            raise self.error(f"OBJECT_NAME: {VALUE}; got {name.value[:40]!a}", name.number)
        q = rotations.sign_continuous(q)
        return EphemerisData(q, instants, parts[0].ends[0], body, rate, name.value, events=events)

    def _part(self, block: Block, tzero: TimeZero) -> AcmPart:
        """Attitudes of a block, in this library's convention."""
        kind, rate_line = self.needed(block, "ATT_TYPE"), block.fields.get("RATE_TYPE")
        rate_kind = "NONE" if rate_line is None else rate_line.value.upper()
        if kind.value.upper() not in ATTITUDES:
            raise self.error(f"ATT_TYPE = {kind.value[:40]}: one of {', '.join(ATTITUDES)}", kind.number)
        if rate_kind not in RATES:
            raise self.error(f"RATE_TYPE = {rate_kind[:40]}: one of {', '.join(RATES)}", block.number)
        attitude, rates = ATTITUDES[kind.value.upper()], RATES[rate_kind]
        instants, table = self._table(block, len(attitude) + len(rates), tzero)
        frame, body, is_a = self.frames(block)
        used = attitude + (() if rate_kind == "GYRO_BIAS" else rates)
        numbers = table[:, : len(used)].T
        if attitude is DCM:
            matrices = numbers[:9].T.reshape(-1, 3, 3)  # their transposes: axes of B to axes of A
            try:
                q = schema.nearest_rotations(matrices, self.source)
            except InputError as error:
                raise self.error(str(error), block.rows[int(error.steps[-1])].number) from None
            used, numbers = Keywords.Q + used[9:], np.concatenate([q[:, [1, 2, 3, 0]].T, numbers[9:]])
        axes = self.euler_axes(block) if attitude is Keywords.ANGLES else ""
        try:
            turned, rate = RowConvention(used, frame, is_a, True, axes).convert(np.ascontiguousarray(numbers))
        except RowError as error:
            raise self.error(error.reason, block.rows[error.index].number) from None
        low = instants.seconds_low
        low = np.zeros(instants.shape) if low is None else low
        return AcmPart(
            instants.seconds.copy(), low, turned.T, None if rate is None else rate.T, (frame, body)
        )

    def _table(self, block: Block, width: int, tzero: TimeZero) -> tuple[Instants, np.ndarray]:
        """Ascending instants, and (n, width) finite numbers."""
        if not block.rows:
            raise self.error("no rows in the block ATT", block.number)
        table, tags = np.empty((len(block.rows), width)), []
        for i, row in enumerate(block.rows):
            tag, *words = row.value.split()
            numbers = [finite_number(word) for word in words]
            if len(numbers) != width or np.isnan(numbers).any():
                reason = f"{row.value[:40]!r}: a time tag and {width} finite numbers belong here"
                raise self.error(reason, row.number)
            tags.append(tag)
            table[i] = numbers
        instants = self._instants(block, tags, tzero)
        later = np.diff(instants.seconds) > 0.0
        if not later.all():
            row = block.rows[int(np.argmin(later)) + 1]
            raise self.error("an instant that is not after the one before", row.number)
        return instants, table

    def _instants(self, block: Block, tags: list[str], tzero: TimeZero) -> Instants:
        """Instants of the time tags of a block: all seconds since T0, or all dates (5.3.4.5)."""
        seconds = np.array([finite_number(tag) for tag in tags])
        is_number = np.isfinite(seconds)
        try:
            if is_number.all():
                return tzero.after(seconds)
            if is_number.any():
                i = int(np.argmax(is_number != is_number[0]))
                raise RowError(i, "a block has finite seconds since EPOCH_TZERO, or dates, and not both")
            return tzero.dated(parse_epochs([tag.encode("ascii", "replace") for tag in tags], tzero.system))
        except RowError as error:
            raise self.error(error.reason, block.rows[error.index].number) from None
        except AttitudeError as error:
            raise self.error(str(error), block.number) from None

    def _body(self, frame: str) -> RigidBody | None:
        """The inertia of the block PHYS, where it is about the axes that attitudes are of."""
        block = next((b for b in self.blocks if b.name == "PHYS" and "IXX" in b.fields), None)
        if block is None:
            return None
        line = block.fields.get("INERTIA_REF_FRAME")
        if line is None or capitals(line) != frame:
            note(f"{self.source}: the inertia is not along the axes {frame}, and not used")
            return None
        return self.rigid_body(block)
