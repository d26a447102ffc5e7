"""Reading STK attitude files (.a), and what other programs write as such.

Euler angles rotate about the body's axes as they have turned; yaw, pitch and roll are rotations about the
axes of the reference, in the order of Sequence (help.agi.com, Attitude File Format and Attitude YPR).
"""

from __future__ import annotations

import re
from itertools import pairwise
from typing import BinaryIO, NamedTuple

import numpy as np

from ..errors import AttitudeError, InputError, note
from ..frames import rotations
from ..frames.earth_fixed import itrf, teme
from ..samples.ephemeris_data import EphemerisData
from ..samples.resampling import with_method
from ..times.instants import Instants
from ..times.leap_seconds import dubious_years
from ..units import finite_array
from . import line_blocks, schema, stk_dates, stk_text, text_rows, time_origin
from .stk_dates import DATES, ELAPSED
from .stk_text import StkTextReader

KEYWORDS = stk_text.KEYWORDS | {
    "NumberOfAttitudePoints": r"\d{1,15}(?:\.0*)?(?:[eE]\+?\d{1,2})?",
    "CoordinateAxes": r".+",
    "CoordinateAxesEpoch": r".+",
    "Sequence": r"[123]{3}",
    "AttitudeDeviations": r"(?i:rapid|mild)",
}


class RowKind(NamedTuple):
    """What is in a row after its time: an attitude, its form and how many numbers it has; a rate, or none."""

    form: str
    numbers: int
    has_rate: bool = False

    @property
    def width(self) -> int:
        """Numbers of a row, without its time."""
        return self.numbers + 3 * self.has_rate


ROWS = {
    "attitudetimequaternions": RowKind("xyzw", 4),
    "attitudetimequatscalarfirst": RowKind("wxyz", 4),
    "attitudetimequatangvels": RowKind("xyzw", 4, True),
    "attitudetimeeulerangles": RowKind("Euler angles", 3),
    "attitudetimeyprangles": RowKind("yaw, pitch, roll", 3),
    "attitudetimedcm": RowKind("matrix", 9),
    "attitudetimedcmangvels": RowKind("matrix", 9, True),
}
ROW_NAMES = (
    "AttitudeTimeQuaternions, ...QuatScalarFirst, ...QuatAngVels, ...EulerAngles, ...YPRAngles, ...DCM "
    "and ...DCMAngVels are read"
)
AXES_NAMES = (
    "ICRF and J2000 are read, of the Earth also Inertial, Fixed, TEMEOfDate and, with a CoordinateAxesEpoch, "
    "TEMEOfEpoch and AlignmentAtEpoch"
)
NOT_IN_ROWS = re.compile(rb"[^-+.\deE \t\r\n]")  # a byte that no row of numbers has


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    """Attitudes, with angular velocities or without, relative to inertial or Earth-fixed axes."""
    reader = StkReader(source)
    for block in line_blocks.blocks(stream, source, last_line=rb"(?i)\s*END\s+Attitude\s*"):
        reader.add_block(block)
    return reader.ephemeris()


class StkReader(StkTextReader):
    """Takes the version, the keywords, the rows and the end of a file, in this order."""

    def __init__(self, source: str):
        super().__init__(source, "Attitude", KEYWORDS, ROW_NAMES)
        self.number = 0  # of the last line
        self.row_kind: RowKind | None = None  # once its keyword was read
        self.last_time: float | None = None
        self.count = self.checked_tables = 0
        self.tables: list[np.ndarray] = []
        self.line_numbers: list[np.ndarray] = []  # of the rows of each table

    def add_block(self, block: line_blocks.LineBlock) -> None:
        """Take the next lines of the file."""
        offset, self.number = 0, block.number - 1
        while offset < block.size:
            if self.row_kind and self.stage == "rows" and self.time_format in ELAPSED:
                offset = self._add_rows(block, offset, self.row_kind)
            if offset < block.size:
                offset = self._add_line(block, offset)
        if self.checked_tables == len(self.tables):
            return
        # the rows of a block at once: a file may go on without an end
        seconds = np.concatenate([table[:, 0] for table in self.tables[self.checked_tables :]])
        self._check_order(seconds, np.concatenate(self.line_numbers[self.checked_tables :]), self.last_time)
        self.last_time, self.checked_tables = float(seconds[-1]), len(self.tables)
        self.count += len(seconds)
        value, number = self.keywords.get("NumberOfAttitudePoints", (None, 0))
        if value is not None and self.count > float(value):
            raise self.error(f"NumberOfAttitudePoints is {value}, and there are more", number)

    def _add_rows(self, block: line_blocks.LineBlock, offset: int, kind: RowKind) -> int:
        """Take the rows from an offset on; the offset of the first line that is none."""
        other = NOT_IN_ROWS.search(block.text, offset)
        end = (block.text.rfind(b"\n", offset, other.start()) + 1 or offset) if other else block.size
        if end == offset:
            return end
        number, self.number = block.number_at(offset), block.number_at(end) - 1
        text = block.text[offset:end]
        table, numbers = text_rows.read_spaced(text, number, "n" * (1 + kind.width))
        self.add_remarks(self.number, text.count(b"\n") - len(numbers), self.count)
        if isinstance(table, list):
            for line, i in zip(table, numbers, strict=True):
                self._add_row(line.decode(), i, kind)
        elif numbers:
            self.tables.append(table.columns.T)
            self.line_numbers.append(np.array(numbers))
        return end

    def _add_row(self, text: str, number: int, kind: RowKind) -> None:
        """Take a row that is not in the form that Arrow reads, or begins with a date."""
        words = self.row(text.split(), kind.width, number)
        try:
            row = finite_array(np.loadtxt([" ".join(words)], ndmin=2, comments=None), "row")
        except (InputError, ValueError) as error:
            raise self.error(str(error), number) from None
        self.tables.append(row)
        self.line_numbers.append(np.array([number]))

    def _add_line(self, block: line_blocks.LineBlock, offset: int) -> int:
        self.number += 1
        line, offset = block.line(offset)
        text = line.decode("utf-8", errors="replace").removeprefix("\ufeff").strip()
        if not text or text.startswith("#"):
            self.add_remarks(self.number, rows=self.count)
        elif self.is_outside(text, self.number):
            pass
        elif self.row_kind and text[0] not in "Ee":
            self._add_row(text, self.number, self.row_kind)
        elif self.row_kind:
            if text.lower().split() != ["end", "attitude"]:
                raise self.error(f"END Attitude or numbers belong here, not {text[:80]!r}", self.number)
            self.stage = "end"
        else:
            word, *values = text.split(maxsplit=1)
            self.add_keyword(word, " ".join(values), self.number)
        return offset

    def add_keyword(self, word: str, value: str, number: int) -> None:
        """Take a keyword and its value, or the keyword before the rows."""
        if not word.lower().startswith("attitudetime"):
            super().add_keyword(word, value, number)
        elif word.lower() not in ROWS:
            raise self.error(f"{word[:80]!r} is not read; {ROW_NAMES}", number)
        elif value:
            raise self.error(f"{value[:80]!r} after {word}", number)
        else:
            self.row_kind, self.stage = ROWS[word.lower()], "rows"

    # -- the ephemeris --------------------------------------------------------------------------

    def ephemeris(self) -> EphemerisData:
        """Return what was read; FormatError if it is truncated, or no ephemeris."""
        if self.stage != "end":
            raise self.error("ends before END Attitude", self.number or None)
        if not self.tables or self.row_kind is None:
            raise self.error("no attitudes", self.number)
        table, numbers = np.concatenate(self.tables), np.concatenate(self.line_numbers)
        self.check_count(len(table), "attitudes")
        instants = self.instants(table[:, 0], numbers)
        if self.time_format in DATES:
            self._check_order(np.asarray(instants.seconds), numbers, None)
        frame, turn = self._frame()
        width = self.row_kind.numbers
        quaternion = self._quaternion(table[:, 1 : 1 + width], numbers, self.row_kind.form)
        if turn is not None:
            quaternion = rotations.product(turn, quaternion)
        rate = np.deg2rad(table[:, 1 + width :]) if self.row_kind.has_rate else None
        ephemeris = EphemerisData(rotations.sign_continuous(quaternion), instants, frame, None, rate)
        self._check_instants(ephemeris, numbers)
        if rate is not None and not np.abs(rate).max() <= schema.MAX_RATE:
            i = int(np.argmax(~(np.abs(rate) <= schema.MAX_RATE).all(axis=1)))
            raise self.error(f"a rate of more than {schema.MAX_RATE:g} rad/s", int(numbers[i]))
        return with_method(ephemeris, self.method(1), rotations.sign_changes(quaternion))

    def _quaternion(self, values: np.ndarray, numbers: np.ndarray, form: str) -> np.ndarray:
        """(n, 4) wxyz of the rows' numbers; transformation from the reference axes to the body's."""
        try:
            if form in rotations.ORDERS:
                return schema.unit_rows(values[:, rotations.ORDERS[form]], self.source)
            if form == "matrix":
                return schema.nearest_rotations(np.swapaxes(values.reshape(-1, 3, 3), 1, 2), self.source)
        except InputError as error:
            row = error.steps[1] if len(error.steps) > 1 else 0
            raise self.error(str(error), int(numbers[int(row)])) from None
        default = "313" if form == "Euler angles" else "321"
        sequence, line = self.keywords.get("Sequence", (default, 0))
        if "Sequence" not in self.keywords:
            note(f"{self.source}: no Sequence, taken as {default}")
        axes, angles = sequence.translate(str.maketrans("123", "XYZ")), np.deg2rad(values)
        if form == "Euler angles":
            if any(a == b for a, b in pairwise(sequence)):
                raise self.error(f"Sequence {sequence}: neighbouring axes are the same", line)
            return rotations.from_euler(axes, angles)
        if set(sequence) != set("123"):
            raise self.error(
                f"Sequence {sequence}: yaw, pitch and roll are about 3, 2 and 1, each once", line
            )
        # About the axes of the reference, which do not turn: the last rotation stands first in the product.
        columns = [3 - int(digit) for digit in reversed(sequence)]
        return rotations.from_euler(axes[::-1], angles[:, columns])

    def _check_instants(self, ephemeris: EphemerisData, numbers: np.ndarray) -> None:
        """Refuse instants without dates, or that coincide when they are written again."""
        try:
            schema.check_dates(ephemeris.instants)
            with dubious_years():
                origin = time_origin.utc_origin(ephemeris[:1])
                stk_dates.utcg(origin.time)
        except AttitudeError as error:
            raise self.error(str(error), int(numbers[0])) from None
        self._check_order(origin.seconds(ephemeris.instants)[0], numbers, None)

    def _check_order(self, seconds: np.ndarray, numbers: np.ndarray, last: float | None) -> None:
        before = np.concatenate([[-np.inf if last is None else last], seconds[:-1]])
        wrong = np.flatnonzero(~(seconds > before))
        if wrong.size:
            i = int(wrong[0])
            raise self.error(f"{float(seconds[i])!r} s is not after {float(before[i])!r} s", int(numbers[i]))

    def _frame(self) -> tuple[str, np.ndarray | None]:
        """Frame of the axes, and the rotation to it from axes that were frozen at an epoch."""
        body, _ = self.keywords.get("CentralBody", ("Earth", 0))
        if "CoordinateAxes" not in self.keywords:
            raise self.error("no CoordinateAxes: what the attitude is relative to is unknown")
        name, number = self.keywords["CoordinateAxes"]
        axes, frames = name.lower(), dict(stk_text.AXES)
        if body.lower() == "earth":
            frames |= stk_text.EARTH_AXES
            frozen = {"temeofepoch": teme, "alignmentatepoch": itrf}
            if axes in frozen and "CoordinateAxesEpoch" not in self.keywords:
                raise self.error(f"CoordinateAxes {name}: no CoordinateAxesEpoch", number)
            if axes in frozen:
                instants = Instants(np.zeros(1), None, self.date("CoordinateAxesEpoch"))
                try:
                    return "GCRF", frozen[axes](instants).back().quaternion[0]
                except InputError as error:
                    raise self.error(f"CoordinateAxesEpoch: {error}", number) from None
        elif body.lower() == "sun":
            frames["inertial"] = "ICRF"
        if axes not in frames:
            raise self.error(f"CoordinateAxes {name[:80]!r} of {body[:40]}; {AXES_NAMES}", number)
        return frames[axes], None
