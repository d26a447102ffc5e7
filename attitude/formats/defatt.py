"""Definitive attitude of the Magnetospheric Multiscale mission (DEFATT), as its flight dynamics publish it.

A CCSDS AEM of version 1 in outline, with rows of a type of its own, QUATERNION/RATE/SPIN/NUTATION: UTC by the
day of the year, elapsed seconds of TAI since 1958, the quaternion from J2000 to body axes, scalar last, whose
numbers are those of this library's rotation from body to J2000; rates in deg/s along the body's axes; phases
and directions, which follow from these, the nutation angle and a quality flag.  It is read, not written.
"""

from __future__ import annotations

import re
from typing import BinaryIO

import numpy as np

from ..errors import AttitudeError, InputError, warn
from ..frames import rotations
from ..samples.ephemeris_data import EphemerisData
from . import line_blocks, schema, text_rows
from .ccsds.epochs import RowError, Timestamps, parse_epochs, to_instants
from .text_reader import TextReader

ROW = "t-" + "n" * 7 + "-" * 11 + "t"  # time, elapsed, quaternion and rate, derived numbers, quality
# What the header has to state, for the numbers to mean what is read from them.
STATED = {
    "REF_FRAME_A": "J2000",
    "REF_FRAME_B": "BCS",
    "ATTITUDE_DIR": "A2B",
    "ATTITUDE_TYPE": "QUATERNION/RATE/SPIN/NUTATION",
    "QUATERNION_TYPE": "LAST",
    "TIME_SYSTEM": "UTC",
}


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    """Attitudes and rates of the body, relative to EME2000."""
    reader = DefattReader(source)
    for block in line_blocks.blocks(stream, source, last_line=rb"\s*DATA_STOP\s*"):
        reader.add_block(block)
    return reader.ephemeris()


class DefattReader(TextReader):
    """Takes the header, the rows and DATA_STOP, in this order."""

    def __init__(self, source: str):
        super().__init__(source)
        self.fields: dict[str, str] = {}
        self.in_rows = self.ended = False
        self.stamps: list[Timestamps] = []
        self.tables: list[np.ndarray] = []
        self.numbers: list[np.ndarray] = []  # of the lines of rows
        self.unconverged = 0

    def add_block(self, block: line_blocks.LineBlock) -> None:
        """Take the next lines of the file."""
        offset = 0
        while offset < block.size:
            if self.in_rows:
                end = block.find(b"DATA_STOP", offset)
                self._add_rows(block.text[offset:end], block.number_at(offset))
                if end == block.size:
                    return
                offset, self.in_rows, self.ended = end, False, True
            number = block.number_at(offset)
            line, offset = block.line(offset)
            self._add_line(line.decode("utf-8", errors="replace").strip(), number)

    def _add_line(self, text: str, number: int) -> None:
        if not text or text.startswith("COMMENT") or text in ("META_START", "META_STOP", "DATA_STOP"):
            return
        if self.ended:
            raise self.error("something after DATA_STOP", number)
        if text == "DATA_START":
            if self.fields.get("CCSDS_AEM_VERS") != "1.0":
                raise self.error("not a DEFATT file, which begins with CCSDS_AEM_VERS = 1.0", number)
            for name, value in STATED.items():
                if self.fields.get(name) != value:
                    raise self.error(f"{name} is {self.fields.get(name)!r}, not {value!r}", number)
            self.in_rows = True
            return
        match = re.fullmatch(r"([A-Z_]+)\s*=\s*(.*)", text)
        if match is None:
            raise self.error(f"KEYWORD = value belongs here, not {text[:80]!r}", number)
        if match[1] in self.fields:
            raise self.error(f"{match[1]} twice", number)
        self.fields[match[1]] = match[2].strip()

    def _add_rows(self, text: bytes, first: int) -> None:
        """Take rows, among which may be comments and empty lines."""
        lines = text.split(b"\n")[:-1]
        kept = [(line.split(), i) for i, line in enumerate(lines, first) if line.split()]
        kept = [(words, i) for words, i in kept if not words[0].startswith(b"COMMENT")]
        if not kept:
            return
        for words, i in kept:
            if len(words) != len(ROW):
                raise self.error(f"{len(words)} values where {len(ROW)} belong", i)
        numbers = np.array([i for _, i in kept])
        table = text_rows.read(b"".join(b" ".join(words) + b"\n" for words, _ in kept), ROW)
        if table is None:
            for words, i in kept:
                for word in words[2:9]:
                    self.finite(word.decode(errors="replace"), i)
            raise self.error("values that are not separated by blanks", kept[0][1])
        try:
            self.stamps.append(parse_epochs(table.texts[0], "UTC"))
        except RowError as error:
            raise self.error(error.reason, int(numbers[error.index])) from None
        # CNV flags attitudes at which the filter has converged
        self.unconverged += sum(flag != b"CNV" for flag in table.texts[1].to_pylist())
        self.tables.append(table.columns)
        self.numbers.append(numbers)

    def ephemeris(self) -> EphemerisData:
        """Return what was read; FormatError if it is truncated, or no ephemeris."""
        if not self.ended:
            raise self.error("ends before DATA_STOP")
        if not self.tables:
            raise self.error("no attitudes between DATA_START and DATA_STOP")
        numbers = np.concatenate(self.numbers)
        stamps = Timestamps.joined(self.stamps)
        try:
            stamps.check_ascending()
        except RowError as error:
            raise self.error(error.reason, int(numbers[error.index])) from None
        columns = np.concatenate(self.tables, axis=1).T
        try:
            q = schema.unit_rows(columns[:, [3, 0, 1, 2]], self.source)
            instants = schema.check_dates(to_instants(stamps, "UTC"))
        except InputError as error:
            row = error.steps[1] if len(error.steps) > 1 else 0
            raise self.error(str(error), int(numbers[int(row)])) from None
        except AttitudeError as error:
            raise self.error(str(error)) from None
        if self.unconverged:
            text = f"{self.unconverged} of {len(q)} attitudes have a quality flag other than CNV"
            warn(f"{self.source}: {text}")
        rate, name = np.deg2rad(columns[:, 4:7]), self.fields.get("OBJECT_NAME", "")
        return EphemerisData(rotations.sign_continuous(q), instants, "EME2000", None, rate, name)
