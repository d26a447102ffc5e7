"""Messages of blocks of keywords (APM, ACM): what their readers share."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...errors import AttitudeError, InputError, warn
from ...frames import rotations
from ...rigid_body.body import RigidBody
from ...times.instants import Instants
from ..text_reader import TextReader, finite_number
from .conventions import euler_axes
from .epochs import TIME_SYSTEMS, RowError, Timestamps, parse_epoch, to_instants
from .keywords import Keywords, frame_named, frame_taken_for, wrong_units
from .ndm import NdmLine


class Block(NamedTuple):
    """A block: its name, the line where it begins, the lines of its keywords, and its rows."""

    name: str
    number: int
    fields: dict[str, NdmLine]
    rows: list[NdmLine]


class BlockReader(TextReader):
    """Reads the values of keywords; FormatError, with the line, for one that is missing or invalid."""

    def needed(self, block: Block, name: str) -> NdmLine:
        """The line of a keyword that a block must have."""
        if name not in block.fields or not block.fields[name].value:
            raise self.error(f"no {name} in the block {block.name}", block.number)
        return block.fields[name]

    def number(self, block: Block, name: str) -> float:
        """A number of a block, in the unit that the standard has for it."""
        line = self.needed(block, name)
        in_brackets = re.fullmatch(r"(.*?)\s*\[([^][]*)\]", line.value)
        text, units = in_brackets.groups() if in_brackets else (line.value, line.units)
        value = finite_number(text)
        if np.isnan(value):
            raise self.error(f"{name} is {text[:40]!r}, not a finite number", line.number)
        if reason := wrong_units(name, units):
            raise self.error(reason, line.number)
        return value

    def tensor(self, block: Block) -> list[list[float]]:
        """The inertia tensor (3, 3), kg m2; products of inertia are its elements."""
        xx, yy, zz, xy, xz, yz = (self.number(block, name) for name in Keywords.INERTIA)
        return [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]

    def rigid_body(self, block: Block) -> RigidBody:
        """The body of that tensor; of moments that no real body has as they are, with a warning."""
        tensor = self.tensor(block)
        try:
            return RigidBody(tensor)
        except InputError:
            try:
                body = RigidBody(tensor, physical=False)
            except InputError as error:
                raise self.error(str(error), block.number) from None
            reason = "a principal moment greater than the sum of the other two, which no real body has"
            warn(f"{self.source}: inertia: {reason}, is taken as it is")
            return body

    def frames(self, block: Block) -> tuple[str, str, bool]:
        """External frame, name of the body's, and whether the external one is frame A."""
        names = [capitals(self.needed(block, key)) for key in ("REF_FRAME_A", "REF_FRAME_B")]
        known = rotations.INERTIAL_FRAMES.keys() | rotations.TURNING_FRAMES.keys()
        is_external = [frame_named(name) in known for name in names]
        if sum(is_external) != 1:
            reason = f"one of frames A and B is the body's, the other one of {', '.join(sorted(known))}"
            raise self.error(f"{names[0][:40]}, {names[1][:40]}: {reason}", block.number)
        external, body = names if is_external[0] else names[::-1]
        return frame_taken_for(external, self.source), body, is_external[0]

    def euler_axes(self, block: Block) -> str:
        """Axes of the Euler angles of a block."""
        line = self.needed(block, "EULER_ROT_SEQ")
        try:
            return euler_axes(line.value)
        except InputError as error:
            raise self.error(str(error), line.number) from None

    def instants(self, system: NdmLine, lines: Sequence[NdmLine]) -> Instants:
        """Instants of epochs in a time system, in seconds since the first of them."""
        name, stamps = system.value.upper(), []
        if name not in TIME_SYSTEMS:
            reason = f"TIME_SYSTEM = {system.value[:40]}: one of {', '.join(TIME_SYSTEMS)}"
            raise self.error(reason, system.number)
        for line in lines:
            try:
                stamps.append(parse_epoch(line.value.encode("ascii", "replace"), name))
            except RowError as error:
                raise self.error(f"{line.keyword}: {error.reason}", line.number) from None
        second, atto = np.array(stamps, dtype=np.int64).T
        try:
            return to_instants(Timestamps(second, atto), name)
        except AttitudeError as error:
            raise self.error(str(error), lines[-1].number) from None


def capitals(line: NdmLine) -> str:
    """The value in capitals, with underscores for blanks: how the standard writes names."""
    return "_".join(line.value.upper().split())
