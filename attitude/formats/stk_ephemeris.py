"""STK ephemeris files (.e): read as an orbit."""

from __future__ import annotations

from typing import BinaryIO, NamedTuple

import numpy as np

from ..errors import FormatError, note
from ..samples.interpolation import InterpolationMethod
from ..times.instants import Instants
from . import bounded_read, stk_text
from .orbits import OrbitRows, OrbitSegment
from .stk_text import StkTextReader

KEYWORDS = stk_text.KEYWORDS | {
    "NumberOfEphemerisPoints": r"\d{1,15}(?:\.0*)?(?:[eE]\+?\d{1,2})?",
    "InterpolationMethod": r"(?i:lagrange|hermite|lagrangevop)",
    "CoordinateSystem": r".+",
    "CoordinateSystemEpoch": r".+",
    "DistanceUnit": r".+",
    "MessageLevel": r".+",
}
WIDTHS = {"ephemeristimepos": 3, "ephemeristimeposvel": 6, "ephemeristimeposvelacc": 9}
ROW_NAMES = "EphemerisTimePos, ...PosVel and ...PosVelAcc are read, one of them"


class _Row(NamedTuple):
    words: list[str]
    number: int


def parse_orbit(stream: BinaryIO, source: str, object_name: str | None = None) -> OrbitRows:
    """Orbit in an STK ephemeris; FormatError with its line for what is wrong."""
    if object_name is not None:
        raise FormatError(f"one object without a name, not {object_name!r}", source)
    text = bounded_read.text(stream, source, bounded_read.MAX_MESSAGE_BYTES).decode("utf-8", errors="replace")
    reader = _Reader(source)
    for number, line in enumerate(text.removeprefix("\ufeff").splitlines(), start=1):
        words = line.split()
        if words and words[0][0] != "#":
            reader.add(words, number)
    return reader.orbit()


class _Reader(StkTextReader):
    """Takes the version, the keywords, rows, boundaries of segments and the end."""

    def __init__(self, source: str):
        super().__init__(source, "Ephemeris", KEYWORDS, ROW_NAMES)
        self.width = 0
        self.rows: list[_Row] = []
        self.boundaries: list[float] = []

    def add(self, words: list[str], number: int) -> None:
        """Take the words of the next line that has any."""
        lowered = [word.lower() for word in words]
        if self.is_outside(" ".join(words), number):
            return
        if lowered == ["end", "ephemeris"]:
            self.stage = "end"
        elif self.stage == "boundaries" and lowered[0] in ("begin", "end"):
            self.stage = "keywords"
        elif lowered == ["begin", "segmentboundarytimes"]:
            self.stage = "boundaries"
        elif self.stage == "boundaries":
            self.boundaries.append(self.finite(words[0], number))
        elif self.stage == "rows" and lowered[0] not in self.names and lowered[0][0] not in "be":
            self.rows.append(_Row(words, number))
        elif not lowered[0].startswith("ephemeris"):
            self.add_keyword(words[0], " ".join(words[1:]), number)
        elif lowered[0] not in WIDTHS or self.width:
            raise self.error(f"{words[0][:80]!r}: {ROW_NAMES}", number)
        else:
            self.width, self.stage = WIDTHS[lowered[0]], "rows"

    # -- the orbit ------------------------------------------------------------------------------

    def orbit(self) -> OrbitRows:
        """Return what was read; FormatError if it is truncated, or no orbit."""
        if self.stage != "end":
            raise self.error("ends before END Ephemeris")
        if not self.rows:
            raise self.error("no rows")
        self.check_count(len(self.rows), "rows")
        name, line = self.keywords.get("DistanceUnit", ("Meters", 0))
        units = {"meters": 1.0, "meter": 1.0, "kilometers": 1e3, "kilometer": 1e3}
        if name.lower() not in units:
            raise self.error(f"DistanceUnit {name[:40]!r} is not Meters or Kilometers", line)
        table = np.empty((len(self.rows), 1 + self.width))
        for i, (words, number) in enumerate(self.rows):
            table[i] = [self.finite(word, number) for word in self.row(words, self.width, number)]
        instants = self._instants(table)
        frame, center = self._frame()
        method, edges = self.method(5), self._edges(instants)
        segments = tuple(
            OrbitSegment(
                instants[first:last],
                units[name.lower()] * table[first:last, 1:4],
                units[name.lower()] * table[first:last, 4:7] if self.width > 3 else None,
                method,
                (float(instants.seconds[first]), float(instants.seconds[last - 1])),
            )
            for first, last in edges
        )
        return OrbitRows(segments, frame, center, self.source)

    def _instants(self, table: np.ndarray) -> Instants:
        instants = self.instants(table[:, 0], [row.number for row in self.rows])
        steps = np.diff(instants.seconds)
        if self.boundaries:  # at which a row may stand twice
            steps = np.where(np.isin(instants.seconds[1:], self.boundaries), np.abs(steps) + 1.0, steps)
        if not (steps > 0.0).all():
            i = int(np.argmin(steps > 0.0)) + 1
            raise self.error("an instant that is not after the one before", self.rows[i].number)
        return instants

    def _edges(self, instants: Instants) -> list[tuple[int, int]]:
        """First row and last, exclusive, of each segment; a boundary's own row is in both."""
        edges, first = [], 0
        seconds = instants.seconds
        for boundary in sorted(self.boundaries):
            at = np.flatnonzero(seconds == boundary)
            if at.size == 0:
                raise self.error(f"no row at the segment boundary {boundary!r} s")
            if at[0] > 0 and at[-1] < len(seconds) - 1:
                edges.append((first, int(at[0]) + 1))
                first = int(at[-1])
        return [*edges, (first, len(seconds))]

    def method(self, default: int) -> InterpolationMethod:
        """How STK interpolates the file."""
        name, number = self.keywords.get("InterpolationMethod", ("Lagrange", 0))
        if name.lower() == "lagrangevop":
            raise self.error("InterpolationMethod LagrangeVOP is not read", number)
        if name.lower() == "hermite" and self.width == 3:
            raise self.error("InterpolationMethod Hermite without velocities", number)
        if not self.keywords.keys() & {"InterpolationOrder", "InterpolationSamplesM1"}:
            note(f"{self.source}: no InterpolationOrder, taken as {default}")
        return super().method(default)

    def _frame(self) -> tuple[str, str]:
        body, _ = self.keywords.get("CentralBody", ("Earth", 0))
        if "CoordinateSystem" not in self.keywords:
            note(f"{self.source}: no CoordinateSystem, taken as Fixed")
        name, number = self.keywords.get("CoordinateSystem", ("Fixed", 0))
        systems = stk_text.AXES | (stk_text.EARTH_AXES if body.lower() == "earth" else {})
        if name.lower() not in systems:
            known = "ICRF and J2000 are read, of the Earth also Inertial, Fixed and TEMEOfDate"
            raise self.error(f"CoordinateSystem {name[:40]!r} of {body[:40]}; {known}", number or None)
        return systems[name.lower()], body.upper()
