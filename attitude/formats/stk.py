"""STK attitude files (.a): quaternions at seconds since an epoch in UTC.

Conventions (help.agi.com, Attitude File Format, and StkAttitudeFile of STK Components): a file holds the
transformation from the reference axes to the body's, scalar last; those are the numbers of this library's
rotation from body to inertial.  Angular velocity is in deg/s, components along the body axes.  Readers
interpolate by polynomials through the components of the quaternion.  An attitude file has no segments.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain, pairwise
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
from erfa import ErfaWarning

from ..errors import AttitudeError, FormatError, InputError
from ..frames import rotations
from ..frames.inertial import from_gcrf
from ..samples.chunks import Samples
from ..samples.ephemeris_data import CONVENTION, EphemerisData
from ..times.instants import Instants
from ..times.iso8601 import parse_time
from ..units import finite_array
from . import line_blocks, schema, text_rows, time_origin
from .interpolant import Interpolant, lagrange
from .interpolation_nodes import Nodes
from .time_origin import TimeOrigin
from .writer_options import takes_options

if TYPE_CHECKING:
    from astropy.time import Time

MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")
# STK's names of the axes; attitudes in any other frame are rotated into the ICRF.
AXES = {"ICRF": "ICRF", "GCRF": "ICRF", "EME2000": "J2000"}
# Data keywords: the columns of w, x, y, z after the time, and whether rates follow.
ROWS = {
    "attitudetimequaternions": ((3, 0, 1, 2), False),
    "attitudetimequatscalarfirst": ((0, 1, 2, 3), False),
    "attitudetimequatangvels": ((3, 0, 1, 2), True),
}
MAX_RATE = 1e306  # rad/s: in deg/s it is still a finite double
MAX_REMARKS = 100_000  # comments and empty lines, in which a file without an end may go on
NOT_IN_ROWS = re.compile(rb"[^-+.\deE \t\r\n]")  # a byte that no row of numbers has
SAME_ATTITUDE = 1e-9  # rad; more between the end of one segment and the beginning of the next is a jump
VERSION_FORM = r"stk\.v\.\d+\.\d+"


@dataclass(frozen=True)
class StkOptions:
    """Options of the writer; InputError for one that STK does not take.

    rates : write angular velocities too (AttitudeTimeQuatAngVels)
    central_body : STK's name of it
    version : the oldest version of STK that is to read the file: "stk.v.<major>.<minor>"
    interpolation_order : of STK's polynomial between the instants; above 1 only where no rate jumps
    """

    rates: bool = False
    central_body: str = "Earth"
    version: str = "stk.v.11.0"
    interpolation_order: int = 1

    def __post_init__(self) -> None:
        lagrange(self.interpolation_order, "interpolation_order")
        if not re.fullmatch(VERSION_FORM, self.version):
            raise InputError("version", self.version, "a version of STK, such as stk.v.11.0")
        if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", self.central_body):
            raise InputError("central_body", self.central_body, "the name of one of STK's central bodies")


def interpolant(*, interpolation_order: int = 1, **_: Any) -> Interpolant:
    """Lagrange polynomials of the order that the file asks STK for."""
    return lagrange(interpolation_order, "interpolation_order")._replace(crosses=True)


@takes_options(StkOptions)
def blocks(nodes: Nodes, **options: Any) -> Iterator[bytes]:
    """File, with the options of `StkOptions`."""
    head = time_origin.checked_head(nodes, "An STK attitude file")
    checked = StkOptions(**options)
    if checked.rates and not head.has_rate:
        raise InputError("rates", checked.rates, "False for an ephemeris that holds attitudes only")
    if checked.interpolation_order > 1 and len(nodes.segments) > 1:
        raise FormatError(
            "STK attitude files have no segments: where rates jump, interpolation_order is 1 and no other"
        )
    turn = None
    if head.frame not in AXES:
        turn = rotations.from_matrix(from_gcrf(head.frame, "an STK attitude file").T)
    origin = time_origin.utc_origin(head)
    shared = _shared_instants(nodes, origin)
    header = _header(nodes, origin, nodes.written.nodes - sum(shared), checked)
    return chain([header], _rows(nodes, origin, shared, checked.rates, turn), [b"END Attitude\n"])


def _shared_instants(nodes: Nodes, origin: TimeOrigin) -> list[bool]:
    """Whether each segment ends where the next one begins: STK takes an instant once."""
    shared = []
    for before, after in pairwise(nodes.segments):
        last, first = before.last, after.first
        same = origin.seconds(last.instants)[0][0] == origin.seconds(first.instants)[0][0]
        apart = rotations.angle_between(last.quaternion("wxyz"), first.quaternion("wxyz"))[0]
        if same and apart > SAME_ATTITUDE:
            raise FormatError(f"STK takes an instant once; two attitudes {apart:.1e} rad apart have the same")
        shared.append(bool(same))
    return [*shared, False]


def _header(nodes: Nodes, origin: TimeOrigin, count: int, options: StkOptions) -> bytes:
    from ..version import __version__

    head = nodes.segments[0].first
    name = head.name.encode("ascii", "backslashreplace").decode().replace("\n", " ").replace("\r", " ")
    comments = [
        f"Written by attitude {__version__}" + (f": {name}" if name else ""),
        CONVENTION,
        "In this file: transformation from CoordinateAxes to body axes, scalar last (the same four numbers)",
        "angular velocity in deg/s, body components" if options.rates else "no angular velocity",
        f"attitude was relative to {head.frame}",
        nodes.remark,
        *(_jump_comment(before, after) for before, after in pairwise(nodes.segments)),
    ]
    keywords = {
        "NumberOfAttitudePoints": count,
        "ScenarioEpoch": _format_utcg(origin.time),
        "BlockingFactor": 20,
        "InterpolationMethod": "Lagrange",
        "InterpolationOrder": options.interpolation_order,
        "CentralBody": options.central_body,
        "CoordinateAxes": AXES.get(head.frame, "ICRF"),
    }
    text = [options.version, "", *(f"# {comment}" for comment in comments), "", "BEGIN Attitude", ""]
    text += [f"{name:<24}{value}" for name, value in keywords.items()]
    text += ["", "AttitudeTimeQuatAngVels" if options.rates else "AttitudeTimeQuaternions", ""]
    return "\n".join(text).encode("ascii")


def _jump_comment(before: Samples, after: Samples) -> str:
    last, first = float(before.last.elapsed[0]), float(after.first.elapsed[0])
    return f"the rate jumps after {last!r} s of elapsed time; STK interpolates from there to {first!r} s"


def _format_utcg(time: Time) -> str:
    """Date as STK writes it: day, month, year and time of day."""
    text = schema.iso_text(time).item().decode()
    date = re.fullmatch(r"(\d{4})-(\d\d)-(\d\d)T(.+)", text)
    if date is None:
        raise FormatError(f"STK has years of four digits, not {text}")
    year, month, day, clock = date.groups()
    return f"{int(day)} {MONTHS[int(month) - 1]} {year} {clock}"


def _parse_utcg(text: str) -> Time:
    form = r"(\d{1,2}) ([A-Za-z]{3}) (\d{4}) (\d{2}:\d{2}:\d{2}(?:\.\d*)?)"
    date = re.fullmatch(form, " ".join(text.split()))
    if date is None:
        raise ValueError(text)
    day, month, year, clock = date.groups()
    number = MONTHS.index(month.capitalize()) + 1
    return parse_time(f"{year}-{number:02}-{int(day):02}T{clock.rstrip('.')}", "utc", "ScenarioEpoch")


def _rows(
    nodes: Nodes, origin: TimeOrigin, shared: list[bool], rates: bool, turn: np.ndarray | None
) -> Iterator[bytes]:
    last_time, last_attitude = None, None
    for segment, ends_shared in zip(nodes.segments, shared, strict=True):
        left = segment.count - ends_shared
        for piece in segment.chunks():
            count = min(left, len(piece))
            left -= count
            if count:
                table = _table(piece[:count], origin, rates, turn)
                table[:, 1:5] = rotations.sign_continuous(table[:, 1:5], last_attitude)
                last_attitude = table[-1, 1:5]
                time_origin.refuse_unordered(table[:, 0], last_time, "An STK attitude file", "s of its epoch")
                last_time = float(table[-1, 0])
                yield text_rows.texts(table.T, [b"", *[b" "] * (table.shape[1] - 1), b"\n"])


def _table(piece: EphemerisData, origin: TimeOrigin, rates: bool, turn: np.ndarray | None) -> np.ndarray:
    """(n, 5) or (n, 8): seconds, quaternion, deg/s."""
    q = piece.quaternion("wxyz")
    if turn is not None:
        q = rotations.product(turn, q)
    columns = [origin.seconds(piece.instants)[0][:, None], rotations.in_order(q, "xyzw")]
    if rates:
        columns.append(schema.degrees(piece))
    return np.concatenate(columns, axis=1)


# -- reading ------------------------------------------------------------------------------------

# Keywords and the form of their values, which are checked even where they are not used.
KEYWORDS = {
    "NumberOfAttitudePoints": r"\d{1,15}",
    "ScenarioEpoch": r".+",
    "BlockingFactor": r"\d+",
    "InterpolationMethod": r"(?i:lagrange|hermite)",
    "InterpolationOrder": r"\d+",
    "CentralBody": r"\S+",
    "CoordinateAxes": r".+",
    "MessageLevel": r"(?i:errors|warnings|verbose)",
    "AttitudeDeviations": r"(?i:rapid|mild)",
    "TimeFormat": r"(?i:epsec)",
}
KEYWORD_NAMES = {name.lower(): name for name in KEYWORDS}


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    """Quaternions, with angular velocities or without, relative to inertial axes."""
    reader = StkReader(source)
    for block in line_blocks.blocks(stream, source):
        reader.add_block(block)
    return reader.ephemeris()


class StkReader:
    """Takes the version, the keywords, the rows and the end of a file, in this order."""

    def __init__(self, source: str):
        self.source = source
        self.add_line: Callable[[str, int], None] = self._add_version
        self.number = 0  # of the last line
        self.keywords: dict[str, tuple[str, int]] = {}  # values and their lines
        self.row_kind = ""  # a key of ROWS, once it was read
        self.width = 0  # numbers in a row
        self.last_time: float | None = None
        self.count = self.remark_count = self.checked_tables = 0
        self.tables: list[np.ndarray] = []
        self.line_numbers: list[np.ndarray] = []  # of the rows of each table
        self.ended = False

    def _error(self, message: str, line: int | None = None) -> FormatError:
        return FormatError(message, self.source, line)

    def add_block(self, block: line_blocks.LineBlock) -> None:
        """Take the next lines of the file."""
        offset, self.number = 0, block.number - 1
        while offset < block.size:
            if self.row_kind and not self.ended:
                offset = self._add_rows(block, offset)
            if offset < block.size:
                offset = self._add_line(block, offset)
        self._check_new_rows()

    def _check_new_rows(self) -> None:
        """Check the rows of a block at once: a file may go on without an end."""
        if self.checked_tables == len(self.tables):
            return
        seconds = np.concatenate([table[:, 0] for table in self.tables[self.checked_tables :]])
        self._check_order(seconds, np.concatenate(self.line_numbers[self.checked_tables :]), self.last_time)
        self.last_time, self.checked_tables = float(seconds[-1]), len(self.tables)
        self.count += len(seconds)
        value, number = self.keywords.get("NumberOfAttitudePoints", (None, 0))
        if value is not None and self.count > int(value):
            raise self._error(f"NumberOfAttitudePoints is {value}, and there are more", number)

    def _add_rows(self, block: line_blocks.LineBlock, offset: int) -> int:
        """Take the rows from an offset on; the offset of the first line that is none."""
        other = NOT_IN_ROWS.search(block.text, offset)
        end = (block.text.rfind(b"\n", offset, other.start()) + 1 or offset) if other else block.size
        if end == offset:
            return end
        number, self.number = block.number_at(offset), block.number_at(end) - 1
        text = block.text[offset:end]
        table, numbers = text_rows.read_spaced(text, number, "n" * self.width)
        self._add_remarks(text.count(b"\n") - len(numbers))
        if isinstance(table, list):
            for line, i in zip(table, numbers, strict=True):
                self._add_row(line.decode(), i)
        elif numbers:
            self.tables.append(table.columns.T)
            self.line_numbers.append(np.array(numbers))
        return end

    def _add_row(self, text: str, number: int) -> None:
        """Take a row that is not in the form that Arrow reads."""
        count = len(text.split())
        if count != self.width:
            raise self._error(f"{count} numbers where {self.width} belong", number)
        try:
            row = finite_array(np.loadtxt([text], ndmin=2, comments=None), "row")
        except (InputError, ValueError) as error:
            raise self._error(str(error), number) from None
        self.tables.append(row)
        self.line_numbers.append(np.array([number]))

    def _add_line(self, block: line_blocks.LineBlock, offset: int) -> int:
        self.number += 1
        line, offset = block.line(offset)
        text = line.decode("utf-8", errors="replace").strip()
        if not text or text.startswith("#"):
            self._add_remarks()
        elif self.ended:
            raise self._error("something after END Attitude", self.number)
        elif self.row_kind and text[0] not in "Ee":
            self._add_row(text, self.number)
        else:
            self.add_line(text, self.number)
        return offset

    def _add_remarks(self, count: int = 1) -> None:
        self.remark_count += count
        if self.remark_count > max(MAX_REMARKS, self.count):
            raise self._error(f"more than {MAX_REMARKS} comments and empty lines", self.number)

    def _add_version(self, text: str, number: int) -> None:
        if number != 1 or not re.fullmatch(VERSION_FORM, text.lower()):
            raise self._error("not an STK file: its first line is stk.v.<major>.<minor>", 1)
        self.add_line = self._begin

    def _begin(self, text: str, number: int) -> None:
        if text.lower().split() != ["begin", "attitude"]:
            raise self._error(f"BEGIN Attitude belongs here, not {text[:80]!r}", number)
        self.add_line = self._add_keyword

    def _add_keyword(self, text: str, number: int) -> None:
        word, *values = text.split(maxsplit=1)
        if word.lower() in ROWS:
            if values:
                raise self._error(f"{values[0][:80]!r} after {word}", number)
            self.row_kind, self.add_line = word.lower(), self._end
            self.width = 8 if ROWS[self.row_kind][1] else 5
            return
        name = KEYWORD_NAMES.get(word.lower())
        if name is None:
            kinds = "quaternions with or without angular velocities are read"
            raise self._error(f"keyword {word[:80]!r} is not known here; {kinds}", number)
        value = " ".join(values).strip().strip('"').strip()
        if not re.fullmatch(KEYWORDS[name], value):
            raise self._error(f"{name} {value[:80]!r}", number)
        if name in self.keywords:
            raise self._error(f"{name} twice", number)
        self.keywords[name] = value, number

    def _end(self, text: str, number: int) -> None:
        if text.lower().split() != ["end", "attitude"]:
            raise self._error(f"END Attitude or numbers belong here, not {text[:80]!r}", number)
        self.ended = True

    # -- the ephemeris --------------------------------------------------------------------------

    def ephemeris(self) -> EphemerisData:
        """Return what was read; FormatError if it is truncated, or no ephemeris."""
        if not self.ended:
            raise self._error("ends before END Attitude", self.number or None)
        if not self.tables:
            raise self._error("no attitudes", self.number)
        table, numbers = np.concatenate(self.tables), np.concatenate(self.line_numbers)
        stated, line = self.keywords.get("NumberOfAttitudePoints", (None, 0))
        if stated is not None and int(stated) != len(table):
            raise self._error(f"{len(table)} attitudes, and NumberOfAttitudePoints is {stated}", line)
        epoch, frame = self._epoch(), self._frame()
        quaternion = table[:, 1:5][:, ROWS[self.row_kind][0]]
        quaternion = rotations.sign_continuous(self._unit(quaternion, numbers))
        rate = np.deg2rad(table[:, 5:8]) if self.width == 8 else None
        ephemeris = EphemerisData(quaternion, Instants(table[:, 0], None, epoch), frame, None, rate)
        self._check_instants(ephemeris, numbers)
        if rate is not None and not np.abs(rate).max() <= MAX_RATE:
            i = int(np.argmax(~(np.abs(rate) <= MAX_RATE).all(axis=1)))
            raise self._error(f"a rate of more than {MAX_RATE:g} rad/s", int(numbers[i]))
        return ephemeris

    def _check_instants(self, ephemeris: EphemerisData, numbers: np.ndarray) -> None:
        """Refuse instants without dates, or that coincide when they are written again."""
        try:
            schema.check_dates(ephemeris.instants)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ErfaWarning)  # years whose leap seconds are unknown
                origin = time_origin.utc_origin(ephemeris[:1])
                _format_utcg(origin.time)
        except AttitudeError as error:
            raise self._error(str(error), int(numbers[0])) from None
        self._check_order(origin.seconds(ephemeris.instants)[0], numbers, None)

    def _check_order(self, seconds: np.ndarray, numbers: np.ndarray, last: float | None) -> None:
        before = np.concatenate([[-np.inf if last is None else last], seconds[:-1]])
        wrong = np.flatnonzero(~(seconds > before))
        if wrong.size:
            i = int(wrong[0])
            raise self._error(f"{float(seconds[i])!r} s is not after {float(before[i])!r} s", int(numbers[i]))

    def _unit(self, quaternion: np.ndarray, numbers: np.ndarray) -> np.ndarray:
        try:
            return schema.unit_rows(quaternion, self.source)
        except InputError as error:
            row = error.steps[1] if len(error.steps) > 1 else 0
            raise self._error(str(error), int(numbers[int(row)])) from None

    def _epoch(self) -> Time:
        if "ScenarioEpoch" not in self.keywords:
            raise self._error("no ScenarioEpoch: the instants have no dates")
        text, number = self.keywords["ScenarioEpoch"]
        try:
            return _parse_utcg(text)
        except (AttitudeError, ValueError):
            expected = "a date in UTC such as 1 Jul 2007 12:00:00.000"
            raise self._error(f"ScenarioEpoch {text[:80]!r} is not {expected}", number) from None

    def _frame(self) -> str:
        """Inertial frame of the axes; Inertial is the ICRF for the Earth and the Sun (help.agi.com)."""
        body, _ = self.keywords.get("CentralBody", ("Earth", 0))
        if "CoordinateAxes" not in self.keywords:
            raise self._error("no CoordinateAxes: what the attitude is relative to is unknown")
        axes, number = self.keywords["CoordinateAxes"]
        frames = {"icrf": "ICRF", "j2000": "EME2000"}
        if body.lower() in ("earth", "sun"):
            frames["inertial"] = "ICRF"
        if axes.lower() not in frames:
            raise self._error(f"CoordinateAxes {axes[:80]!r}; ICRF and J2000 are read", number)
        return frames[axes.lower()]
