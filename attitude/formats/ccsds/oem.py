"""CCSDS orbit ephemeris message (OEM), 502.0-B-1 to -3, KVN and XML: read as an orbit."""

from __future__ import annotations

from typing import BinaryIO

from ... import stopping
from ...errors import AttitudeError
from ...samples.interpolation import InterpolationMethod
from ..orbits import OrbitRows, OrbitSegment
from ..text_reader import TextReader
from .epochs import RowError, seconds_at, to_instants
from .keywords import HEADER, Keyword, KeywordBlock, frame_named
from .ndm import NdmLine, Syntax, read_ndm
from .rows import parse_rows

COLUMNS = ("X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT", "X_DDOT", "Y_DDOT", "Z_DDOT")  # the last three or none
SYNTAX = Syntax(
    "oem",
    ("1.0", "2.0", "3.0"),
    {"metadata": "META", "covarianceMatrix": "COVARIANCE"},
    {"stateVector": ("EPOCH", *COLUMNS)},
)
METADATA = {
    "OBJECT_NAME": Keyword(True),
    "OBJECT_ID": Keyword(),
    "CENTER_NAME": Keyword(True),
    "REF_FRAME": Keyword(True),
    "REF_FRAME_EPOCH": Keyword(),
    "TIME_SYSTEM": Keyword(True),
    "START_TIME": Keyword(True),
    "USEABLE_START_TIME": Keyword(),
    "USEABLE_STOP_TIME": Keyword(),
    "STOP_TIME": Keyword(True),
    "INTERPOLATION": Keyword(),
    "INTERPOLATION_DEGREE": Keyword(),
}


def parse_orbit(stream: BinaryIO, source: str, object_name: str | None = None) -> OrbitRows:
    """Orbit in an OEM, of its only object, or of the one with this OBJECT_NAME or OBJECT_ID."""
    message = read_ndm(stream, source, SYNTAX)
    reader = _OemReader(source)
    for line in message.lines:
        reader.add(line)
    return reader.orbit(object_name)


class _OemReader(TextReader):
    """Takes the lines of an OEM: the header, then metadata and rows of each segment."""

    def __init__(self, source: str):
        super().__init__(source)
        self.fields = KeywordBlock(HEADER, "2.0", "header", source)
        self.parts: list[tuple[KeywordBlock, list[NdmLine]]] = []
        self.is_metadata = self.is_covariance = False

    def add(self, line: NdmLine) -> None:
        """Take the next line."""
        if line.keyword in ("COVARIANCE_START", "COVARIANCE_STOP"):
            self.is_covariance = line.keyword == "COVARIANCE_START"
        elif self.is_covariance:
            return
        elif (
            line.keyword in ("META_START", "META_STOP") and (line.keyword == "META_STOP") != self.is_metadata
        ):
            raise self.error(f"{line.keyword} does not belong here", line.number)
        elif line.keyword == "META_START":
            if not self.parts:
                self.fields.close(line.number)
            self.fields = KeywordBlock(METADATA, "2.0", "metadata", self.source)
            self.parts.append((self.fields, []))
            self.is_metadata = True
        elif line.keyword == "META_STOP":
            self.fields.close(line.number)
            self.is_metadata = False
        elif line.keyword and (self.is_metadata or not self.parts):
            self.fields.add(line.keyword, line.value, line.number)
        elif not line.keyword and self.parts and not self.is_metadata:
            self.parts[-1][1].append(line)
        else:
            shown = line.keyword or line.value
            raise self.error(f"{shown[:40]!r} does not belong here", line.number)

    def orbit(self, object_name: str | None) -> OrbitRows:
        """The orbit of one object, all its segments."""
        if not self.parts or self.is_metadata:
            raise self.error("ends before its first row")
        names = list(dict.fromkeys(fields.values["OBJECT_NAME"] for fields, _ in self.parts))
        if object_name is None and len(names) > 1:
            raise self.error(f"several objects ({', '.join(names)}): object names one")
        parts = [
            part
            for part in self.parts
            if object_name in (None, part[0].values["OBJECT_NAME"], part[0].values.get("OBJECT_ID"))
        ]
        if not parts:
            raise self.error(f"no object {object_name!r}, but {', '.join(names)}")
        first = parts[0][0]
        for fields, _ in parts[1:]:
            for name in ("CENTER_NAME", "REF_FRAME"):
                if fields.get(name) != first.get(name):
                    raise fields.error(name, f"the segment before has {first.values[name]}")
        frame = frame_named(first.get("REF_FRAME") or "")
        if frame in ("TEME", "GTOD") and "REF_FRAME_EPOCH" in first.values:
            raise first.error("REF_FRAME_EPOCH", f"{frame} is read as that of date, not as that of an epoch")
        segments = tuple(self._segment(fields, rows) for fields, rows in parts)
        return OrbitRows(segments, frame, first.get("CENTER_NAME") or "", self.source)

    def _segment(self, fields: KeywordBlock, rows: list[NdmLine]) -> OrbitSegment:
        stopping.check()
        system = fields.time_system()
        if not rows:
            raise self.error("a segment without rows", max(fields.lines.values()))
        width = len(rows[0].value.split()) - 1
        columns = COLUMNS if width == 9 else COLUMNS[:6]
        try:
            stamps, numbers = parse_rows([row.value.encode() for row in rows], columns, system)
            stamps.check_ascending()
        except RowError as error:
            raise self.error(error.reason, rows[error.index].number) from None
        try:
            instants = to_instants(stamps, system)
        except AttitudeError as error:
            raise self.error(str(error), rows[0].number) from None
        first, last = float(instants.seconds[0]), float(instants.seconds[-1])
        ends = {"START": first, "STOP": last}  # of the useable span, s since the first row
        for end in ends:
            time = fields.time(f"USEABLE_{end}_TIME")
            if time is not None:
                ends[end] = seconds_at(time, stamps, system)
        start, stop = max(ends["START"], first), min(ends["STOP"], last)
        if not start <= stop:
            raise fields.error("USEABLE_START_TIME", "no rows in the useable span")
        stated = fields.interpolation("INTERPOLATION")
        method = None if stated is None else InterpolationMethod(*stated)
        return OrbitSegment(instants, 1e3 * numbers[:3].T, 1e3 * numbers[3:6].T, method, (start, stop))
