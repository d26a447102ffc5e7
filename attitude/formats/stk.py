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
from itertools import chain, pairwise
from typing import TYPE_CHECKING, BinaryIO, NamedTuple

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

if TYPE_CHECKING:
    from astropy.time import Time

    from .time_origin import TimeOrigin

MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")
# What this library's frames are called there; others are turned into the ICRF.
AXES = {"ICRF": "ICRF", "GCRF": "ICRF", "EME2000": "J2000"}
# Numbers after the time, and where w, x, y, z stand among them.
ROWS = {
    "attitudetimequaternions": (4, (3, 0, 1, 2)),
    "attitudetimequatscalarfirst": (4, (0, 1, 2, 3)),
    "attitudetimequatangvels": (7, (3, 0, 1, 2)),
}
GREATEST_RATE = 1e306  # rad/s: in deg/s it is still a number
MOST_REMARKS = 100_000  # comments and empty lines, in which a file without an end may go on
ODD = re.compile(rb"[^-+.\deE \t\r\n]")  # what no row of numbers has
SAME_ATTITUDE = 1e-9  # rad; more between the end of one segment and the beginning of the next is a jump


def interpolant(
    *,
    rates: bool = False,
    central_body: str = "Earth",
    version: str = "stk.v.11.0",
    interpolation_order: int = 1,
) -> Interpolant:
    """STK interpolates as the file asks it to: by Lagrange's polynomial of this order."""
    return lagrange(interpolation_order, "interpolation_order")._replace(crosses=True)


def blocks(
    nodes: Nodes,
    *,
    rates: bool = False,
    central_body: str = "Earth",
    version: str = "stk.v.11.0",
    interpolation_order: int = 1,
) -> Iterator[bytes]:
    """The file.

    rates : write angular velocities too (AttitudeTimeQuatAngVels)
    central_body : as STK calls it
    version : of STK, the least that is to read it: "stk.v.<major>.<minor>"
    interpolation_order : of STK's polynomial between the instants; above 1 only where nothing jumps
    """
    head = time_origin.checked_head(nodes, "An STK attitude file")
    lagrange(interpolation_order, "interpolation_order")
    if not re.fullmatch(r"stk\.v\.\d+\.\d+", version):
        raise InputError("version", version, "a version of STK, such as stk.v.11.0")
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", central_body):
        raise InputError("central_body", central_body, "the name of one of STK's central bodies")
    if rates and not head.has_rate:
        raise InputError("rates", rates, "False for an ephemeris that holds attitudes only")
    if interpolation_order > 1 and len(nodes.segments) > 1:
        raise FormatError(
            "STK attitude files have no segments: where rates jump, interpolation_order is 1 and no other"
        )
    origin, turn = time_origin.utc_origin(head), _turn(head.frame)
    shared = _shared_instants(nodes, origin)
    header = _header(nodes, head, origin, sum(shared), rates, central_body, version, interpolation_order)
    return chain([header], _rows(nodes, origin, shared, rates, turn), [b"END Attitude\n"])


def _turn(frame: str) -> np.ndarray | None:
    """(4,) wxyz by which attitudes are turned into the axes that the file names, or None."""
    if frame in AXES:
        return None
    return rotations.from_matrix(from_gcrf(frame, "an STK attitude file").T)


def _shared_instants(nodes: Nodes, origin: TimeOrigin) -> list[bool]:
    """Of each segment, whether it ends where the next one begins: STK takes an instant once."""
    shared = []
    for before, after in pairwise(nodes.segments):
        last, first = before.tail, after.head
        same = origin.seconds(last.instants)[0][0] == origin.seconds(first.instants)[0][0]
        apart = rotations.angle_between(last.quaternion("wxyz"), first.quaternion("wxyz"))[0]
        if same and apart > SAME_ATTITUDE:
            raise FormatError(f"STK takes an instant once; two attitudes {apart:.1e} rad apart have the same")
        shared.append(bool(same))
    return [*shared, False]


def _header(
    nodes: Nodes,
    head: EphemerisData,
    origin: TimeOrigin,
    shared: int,
    rates: bool,
    central_body: str,
    version: str,
    order: int,
) -> bytes:
    from ..version import __version__

    comments = [
        f"Written by attitude {__version__}" + (f": {_plain(head.name)}" if head.name else ""),
        CONVENTION,
        "In this file: transformation from CoordinateAxes to body axes, scalar last (the same four numbers)",
        "angular velocity in deg/s, body components" if rates else "no angular velocity",
        f"attitude was relative to {head.frame}",
        nodes.remark,
        *(_jump(before, after) for before, after in pairwise(nodes.segments)),
    ]
    keywords = {
        "NumberOfAttitudePoints": nodes.written.nodes - shared,
        "ScenarioEpoch": _utcg(origin.time),
        "BlockingFactor": 20,
        "InterpolationMethod": "Lagrange",
        "InterpolationOrder": order,
        "CentralBody": central_body,
        "CoordinateAxes": AXES.get(head.frame, "ICRF"),
    }
    text = [version, "", *(f"# {comment}" for comment in comments), "", "BEGIN Attitude", ""]
    text += [f"{name:<24}{value}" for name, value in keywords.items()]
    text += ["", "AttitudeTimeQuatAngVels" if rates else "AttitudeTimeQuaternions", ""]
    return "\n".join(text).encode("ascii")


def _jump(before: Samples, after: Samples) -> str:
    last, first = float(before.tail.elapsed[0]), float(after.head.elapsed[0])
    return f"the rate jumps after {last!r} s of elapsed time; STK interpolates from there to {first!r} s"


def _plain(text: str) -> str:
    """In one line of ASCII."""
    return text.encode("ascii", "backslashreplace").decode().replace("\n", " ").replace("\r", " ")


def _utcg(time: Time) -> str:
    text = schema.iso_text(time).item().decode()
    date = re.fullmatch(r"(\d{4})-(\d\d)-(\d\d)T(.+)", text)
    if date is None:
        raise FormatError(f"STK has years of four digits, not {text}")
    year, month, day, clock = date.groups()
    return f"{int(day)} {MONTHS[int(month) - 1]} {year} {clock}"


def _rows(
    nodes: Nodes, origin: TimeOrigin, shared: list[bool], rates: bool, turn: np.ndarray | None
) -> Iterator[bytes]:
    before, last = None, None
    for segment, ends_shared in zip(nodes.segments, shared, strict=True):
        left = segment.count - ends_shared
        for piece in segment.pieces():
            taken = min(left, len(piece))
            left -= taken
            if taken:
                table = _table(piece[:taken], origin, rates, turn)
                table[:, 1:5] = rotations.sign_continuous(table[:, 1:5], last)
                last = table[-1, 1:5]
                time_origin.refuse_unordered(table[:, 0], before, "An STK attitude file", "s of its epoch")
                before = float(table[-1, 0])
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


# -- and back -----------------------------------------------------------------------------------


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    """Quaternions, with angular velocities or without, relative to inertial axes."""
    read = _Reader(source)
    for block in line_blocks.blocks(stream, source):
        read.take(block)
    return read.ephemeris()


class _Keyword(NamedTuple):
    """What may stand after it; values of no consequence here are checked all the same."""

    name: str
    form: str


_KEYWORDS = {
    word.name.lower(): word
    for word in (
        _Keyword("NumberOfAttitudePoints", r"\d{1,15}"),
        _Keyword("ScenarioEpoch", r".+"),
        _Keyword("BlockingFactor", r"\d+"),
        _Keyword("InterpolationMethod", r"(?i:lagrange|hermite)"),
        _Keyword("InterpolationOrder", r"\d+"),
        _Keyword("CentralBody", r"\S+"),
        _Keyword("CoordinateAxes", r".+"),
        _Keyword("MessageLevel", r"(?i:errors|warnings|verbose)"),
        _Keyword("AttitudeDeviations", r"(?i:rapid|mild)"),
        _Keyword("TimeFormat", r"(?i:epsec)"),
    )
}


class _Reader:
    """The version, keywords, rows, and the end; of each line its number."""

    def __init__(self, source: str):
        self.source = source
        self.take_line: Callable[[str, int], None] = self._version
        self.number = 0
        self.keywords: dict[str, tuple[str, int]] = {}
        self.kind = ""
        self.last: float | None = None
        self.count = self.remarks = self.checked = 0
        self.tables: list[np.ndarray] = []
        self.numbers: list[np.ndarray] = []
        self.ended = False

    def refuse(self, message: str, line: int | None = None) -> FormatError:
        return FormatError(message, self.source, line)

    def take(self, block: line_blocks.Block) -> None:
        at, self.number = 0, block.number - 1
        while at < block.size:
            if self.kind and not self.ended:
                at = self._rows(block, at)
            if at < block.size:
                at = self._line(block, at)
        self._check_new()

    def _check_new(self) -> None:
        """What a block has brought is checked at once: a file may go on without an end."""
        if self.checked == len(self.tables):
            return
        seconds = np.concatenate([table[:, 0] for table in self.tables[self.checked :]])
        self._check_order(seconds, np.concatenate(self.numbers[self.checked :]), self.last)
        self.last, self.count, self.checked = float(seconds[-1]), self.count + len(seconds), len(self.tables)
        value, number = self.keywords.get("NumberOfAttitudePoints", (None, 0))
        if value is not None and self.count > int(value):
            raise self.refuse(f"NumberOfAttitudePoints is {value}, and there are more", number)

    def _rows(self, block: line_blocks.Block, at: int) -> int:
        """From there on; where the line begins that is no row of numbers."""
        odd = ODD.search(block.text, at)
        end = (block.text.rfind(b"\n", at, odd.start()) + 1 or at) if odd else block.size
        if end > at:
            number, self.number = block.number_at(at), block.number_at(end) - 1
            self._take(block.text[at:end], number)
        return end

    def _take(self, text: bytes, number: int) -> None:
        width = 1 + ROWS[self.kind][0]
        table, numbers = text_rows.read_spaced(text, number, "n" * width)
        self._remark(text.count(b"\n") - len(numbers))
        if not numbers:  # blank lines alone
            return
        if isinstance(table, list):
            each = zip(table, numbers, strict=True)
            self.tables.append(
                np.concatenate([_numbers(line.decode(), i, width, self.source) for line, i in each])
            )
        else:
            self.tables.append(table.columns.T)
        self.numbers.append(np.array(numbers))

    def _line(self, block: line_blocks.Block, at: int) -> int:
        self.number += 1
        line, at = block.line(at)
        text = line.decode("utf-8", errors="replace").strip()
        if not text or text.startswith("#"):
            self._remark()
            return at
        if self.kind and not self.ended and text[0] not in "Ee":
            self.tables.append(_numbers(text, self.number, 1 + ROWS[self.kind][0], self.source))
            self.numbers.append(np.array([self.number]))
        elif self.ended:
            raise self.refuse("something after END Attitude", self.number)
        else:
            self.take_line(text, self.number)
        return at

    def _remark(self, count: int = 1) -> None:
        self.remarks += count
        if self.remarks > max(MOST_REMARKS, self.count):
            raise self.refuse(f"more than {MOST_REMARKS} comments and empty lines", self.number)

    def _version(self, text: str, number: int) -> None:
        if number != 1 or not re.fullmatch(r"stk\.v\.\d+\.\d+", text.lower()):
            raise self.refuse("not an STK file: its first line is stk.v.<major>.<minor>", 1)
        self.take_line = self._begin

    def _begin(self, text: str, number: int) -> None:
        if text.lower().split() != ["begin", "attitude"]:
            raise self.refuse(f"BEGIN Attitude belongs here, not {text[:80]!r}", number)
        self.take_line = self._keyword

    def _keyword(self, text: str, number: int) -> None:
        name, *values = text.split(maxsplit=1)
        if name.lower() in ROWS:
            if values:
                raise self.refuse(f"{values[0][:80]!r} after {name}", number)
            self.kind, self.take_line = name.lower(), self._end
            return
        known = _KEYWORDS.get(name.lower())
        if known is None:
            kinds = "quaternions with or without angular velocities are read"
            raise self.refuse(f"keyword {name[:80]!r} is not known here; {kinds}", number)
        value = " ".join(values).strip().strip('"').strip()
        if not re.fullmatch(known.form, value):
            raise self.refuse(f"{known.name} {value[:80]!r}", number)
        if known.name in self.keywords:
            raise self.refuse(f"{known.name} twice", number)
        self.keywords[known.name] = value, number

    def _end(self, text: str, number: int) -> None:
        if text.lower().split() != ["end", "attitude"]:
            raise self.refuse(f"END Attitude or numbers belong here, not {text[:80]!r}", number)
        self.ended = True

    def ephemeris(self) -> EphemerisData:
        if not self.ended:
            raise self.refuse("ends before END Attitude", self.number or None)
        if not self.tables:
            raise self.refuse("no attitudes", self.number)
        table, numbers = np.concatenate(self.tables), np.concatenate(self.numbers)
        self._check_count(len(table))
        epoch, frame = self._epoch(), self._frame()
        quaternion = table[:, 1:5][:, ROWS[self.kind][1]]
        self._check(quaternion, numbers)
        quaternion = rotations.sign_continuous(quaternion)
        rate = np.deg2rad(table[:, 5:8]) if table.shape[1] == 8 else None
        found = EphemerisData(quaternion, Instants(table[:, 0], None, epoch), frame, None, rate)
        self._check_instants(found, numbers)
        self._check_rate(rate, numbers)
        return found

    def _check_instants(self, found: EphemerisData, numbers: np.ndarray) -> None:
        """They have dates, and are apart when they are counted from the first, as they are written."""
        try:
            schema.check_dates(found.instants)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ErfaWarning)  # of years whose leap seconds nobody knows
                origin = time_origin.utc_origin(found[:1])
                _utcg(origin.time)
        except AttitudeError as error:
            raise self.refuse(str(error), int(numbers[0])) from None
        self._check_order(origin.seconds(found.instants)[0], numbers, None)

    def _check_rate(self, rate: np.ndarray | None, numbers: np.ndarray) -> None:
        if rate is not None and not np.abs(rate).max() <= GREATEST_RATE:
            i = int(np.argmax(~(np.abs(rate) <= GREATEST_RATE).all(axis=1)))
            raise self.refuse(f"a rate of more than {GREATEST_RATE:g} rad/s", int(numbers[i]))

    def _check_count(self, count: int) -> None:
        stated = self.keywords.get("NumberOfAttitudePoints")
        if stated is not None and int(stated[0]) != count:
            raise self.refuse(f"{count} attitudes, and NumberOfAttitudePoints is {stated[0]}", stated[1])

    def _check_order(self, seconds: np.ndarray, numbers: np.ndarray, last: float | None) -> None:
        before = np.concatenate([[-np.inf if last is None else last], seconds[:-1]])
        wrong = np.flatnonzero(~(seconds > before))
        if wrong.size:
            i = int(wrong[0])
            raise self.refuse(f"{float(seconds[i])!r} s is not after {float(before[i])!r} s", int(numbers[i]))

    def _check(self, quaternion: np.ndarray, numbers: np.ndarray) -> None:
        try:
            rotations.attitude_quaternion(quaternion, "wxyz", "quaternion")
        except InputError as error:
            row = error.steps[1] if len(error.steps) > 1 else 0
            raise self.refuse(str(error), int(numbers[int(row)])) from None

    def _epoch(self) -> Time:
        if "ScenarioEpoch" not in self.keywords:
            raise self.refuse("no ScenarioEpoch: the instants have no dates")
        text, number = self.keywords["ScenarioEpoch"]
        try:
            return _read_utcg(text)
        except (AttitudeError, ValueError):
            expected = "a date in UTC such as 1 Jul 2007 12:00:00.000"
            raise self.refuse(f"ScenarioEpoch {text[:80]!r} is not {expected}", number) from None

    def _frame(self) -> str:
        """Of axes that do not turn; Inertial is the ICRF for the Earth and the Sun (help.agi.com)."""
        body, _ = self.keywords.get("CentralBody", ("Earth", 0))
        if "CoordinateAxes" not in self.keywords:
            raise self.refuse("no CoordinateAxes: nobody knows what the attitude is relative to")
        axes, number = self.keywords["CoordinateAxes"]
        known = {"icrf": "ICRF", "j2000": "EME2000"}
        if body.lower() in ("earth", "sun"):
            known["inertial"] = "ICRF"
        if axes.lower() not in known:
            raise self.refuse(f"CoordinateAxes {axes[:80]!r}; ICRF and J2000 are read", number)
        return known[axes.lower()]


def _numbers(text: str, number: int, width: int, source: str) -> np.ndarray:
    """(1, width) finite doubles of a row that is not plain."""
    found = len(text.split())
    if found != width:
        raise FormatError(f"{found} numbers where {width} belong", source, number)
    try:
        return finite_array(np.loadtxt([text], ndmin=2, comments=None), "row")
    except (InputError, ValueError) as error:
        raise FormatError(str(error), source, number) from None


def _read_utcg(text: str) -> Time:
    """Day, month, year and clock, as STK writes dates."""
    form = r"(\d{1,2}) ([A-Za-z]{3}) (\d{4}) (\d{2}:\d{2}:\d{2}(?:\.\d*)?)"
    found = re.fullmatch(form, " ".join(text.split()))
    if found is None:
        raise ValueError(text)
    day, month, year, clock = found.groups()
    number = MONTHS.index(month.capitalize()) + 1
    return parse_time(f"{year}-{number:02}-{int(day):02}T{clock.rstrip('.')}", "utc", "ScenarioEpoch")
