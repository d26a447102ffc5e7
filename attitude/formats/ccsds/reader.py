"""Reading an AEM, KVN or XML: what its keywords may be, what its numbers mean, and how segments are joined.

Sources: CCSDS 504.0-B-2 (version 2: tables 4-2 to 4-4, annex F) and 504.0-B-1 (version 1).  The quaternion
"from frame A to frame B" turns the axes of A into those of B, so v_A = q * v_B * conj(q): with A inertial and
B the body it is the quaternion of this library, number by number, and the conjugate of it the other way.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ...errors import AttitudeError, FormatError, InputError
from ...frames import rotations
from ...samples.ephemeris_data import EphemerisData
from ...samples.event import Event
from ...times.instants import Instants
from .. import schema, text_rows
from . import epochs, rows
from .epochs import EpochError, Stamps
from .rows import RowError, Rows

VERSIONS = ("1.0", "2.0")
ALIASES = {"J2000": "EME2000", "EME_2000": "EME2000"}
BOTH, FIRST, SECOND = ("1.0", "2.0"), ("1.0",), ("2.0",)


LONGEST = 230  # characters of a value: a line has at most 254, and the longest keyword 20 (6.6.1)
VALUE = f"one line of 1 to {LONGEST} printable ASCII characters, no blank at its ends"
MOST_REMARKS = 100_000  # comments and empty lines, in which a file without an end may go on
NANOSECOND = 10**9  # attoseconds: writers round to whole ones
GREATEST_RATE = 1e306  # rad/s: in deg/s it is still a number


def is_value(text: str) -> bool:
    """Whether a keyword may have it; the same for the writer."""
    return len(text) <= LONGEST and re.fullmatch(r"[!-~]([ -~]*[!-~])?", text) is not None


class Keyword(NamedTuple):
    """In which versions there is such a keyword, and whether each file must have it."""

    versions: tuple[str, ...]
    needed: bool = False


HEADER = {
    "CLASSIFICATION": Keyword(SECOND),
    "CREATION_DATE": Keyword(BOTH, True),
    "ORIGINATOR": Keyword(BOTH, True),
    "MESSAGE_ID": Keyword(SECOND),
}
METADATA = {
    "OBJECT_NAME": Keyword(BOTH, True),
    "OBJECT_ID": Keyword(BOTH, True),
    "CENTER_NAME": Keyword(BOTH),
    "REF_FRAME_A": Keyword(BOTH, True),
    "REF_FRAME_B": Keyword(BOTH, True),
    "ATTITUDE_DIR": Keyword(FIRST, True),
    "TIME_SYSTEM": Keyword(BOTH, True),
    "START_TIME": Keyword(BOTH, True),
    "USEABLE_START_TIME": Keyword(BOTH),
    "USEABLE_STOP_TIME": Keyword(BOTH),
    "STOP_TIME": Keyword(BOTH, True),
    "ATTITUDE_TYPE": Keyword(BOTH, True),
    "QUATERNION_TYPE": Keyword(FIRST),
    "EULER_ROT_SEQ": Keyword(BOTH),
    "RATE_FRAME": Keyword(FIRST),
    "ANGVEL_FRAME": Keyword(SECOND),
    "INTERPOLATION_METHOD": Keyword(BOTH),
    "INTERPOLATION_DEGREE": Keyword(BOTH),
}
METHODS = ("LINEAR", "HERMITE", "LAGRANGE")
# Segments that differ in one of these are not of one ephemeris.
SHARED = (
    "OBJECT_NAME",
    "OBJECT_ID",
    "CENTER_NAME",
    "REF_FRAME_A",
    "REF_FRAME_B",
    "ATTITUDE_DIR",
    "TIME_SYSTEM",
    "ATTITUDE_TYPE",
)

Q = ("Q1", "Q2", "Q3", "QC")
Q_DOT = ("Q1_DOT", "Q2_DOT", "Q3_DOT", "QC_DOT")
ANGVEL = ("ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z")
ANGLES = ("ANGLE_1", "ANGLE_2", "ANGLE_3")
ANGLES_DOT = ("ANGLE_1_DOT", "ANGLE_2_DOT", "ANGLE_3_DOT")
UNITS = {
    **dict.fromkeys(Q_DOT, "1/s"),
    **dict.fromkeys(ANGLES, "deg"),
    **dict.fromkeys((*ANGVEL, *ANGLES_DOT), "deg/s"),
}


class Kind(NamedTuple):
    """An ATTITUDE_TYPE: the columns of a row, and the elements of XML that hold them."""

    versions: tuple[str, ...]
    attitude: tuple[str, ...]
    rate: tuple[str, ...]
    elements: tuple[str, ...]


KINDS = {
    "QUATERNION": Kind(BOTH, Q, (), ("quaternionEphemeris", "quaternionState", "quaternion")),
    "QUATERNION/DERIVATIVE": Kind(
        BOTH, Q, Q_DOT, ("quaternionDerivative", "quaternion", "quaternionDot", "quaternionRate")
    ),
    "QUATERNION/ANGVEL": Kind(SECOND, Q, ANGVEL, ("quaternionAngVel", "quaternion", "angVel")),
    "QUATERNION/RATE": Kind(FIRST, Q, ANGVEL, ()),
    "EULER_ANGLE": Kind(BOTH, ANGLES, (), ("eulerAngle",)),
    "EULER_ANGLE/DERIVATIVE": Kind(SECOND, ANGLES, ANGLES_DOT, ("eulerAngleDerivative",)),
    "EULER_ANGLE/ANGVEL": Kind(SECOND, ANGLES, ANGVEL, ("eulerAngleAngVel", "angVel")),
}


class Fields:
    """Keywords and values of a header or of metadata, each with the line it stands in."""

    def __init__(self, known: Mapping[str, Keyword], version: str, what: str, source: str):
        self.known = {name for name, keyword in known.items() if version in keyword.versions}
        self.needed = [name for name in known if name in self.known and known[name].needed]
        self.what, self.version, self.source = what, version, source
        self.values: dict[str, str] = {}
        self.lines: dict[str, int] = {}

    def add(self, name: str, value: str, line: int) -> None:
        if name not in self.known:
            reason = f"{name[:40]!r} is no keyword of the {self.what} of version {self.version}"
            raise FormatError(reason, self.source, line)
        if name in self.values:
            raise FormatError(f"{name} twice", self.source, line)
        if not value:
            raise FormatError(f"{name} without a value", self.source, line)
        if not is_value(value):
            reason = f"{name}: {VALUE}; got {value[:40]!a}"
            raise FormatError(reason, self.source, line)
        self.values[name], self.lines[name] = value, line

    def close(self, line: int) -> None:
        """At the end of the block, which must have all that is needed."""
        for name in self.needed:
            if name not in self.values:
                raise FormatError(f"no {name} in the {self.what}", self.source, line)

    def get(self, name: str) -> str | None:
        """A value that is one of a list, as the standard writes it: in capitals, blanks as underscores."""
        value = self.values.get(name)
        return None if value is None else "_".join(value.upper().split())

    def error(self, name: str, reason: str) -> FormatError:
        value = self.values.get(name)
        shown = "no " + name if value is None else f"{name} = {value[:60]}"
        return FormatError(f"{shown}: {reason}", self.source, self.lines.get(name))


class Segment:
    """Metadata and what was read of the attitudes that follow them."""

    def __init__(self, fields: Fields):
        self.fields = fields
        self.source = fields.source
        self.system = self._system()
        self.turns = turns(fields)
        self.columns = self.turns.columns
        self.kinds = "t" + "n" * len(self.columns)  # an epoch and numbers
        self._check_interpolation()
        self._span = self._spans()
        self.stamps: list[Stamps] = []
        self.attitudes: list[np.ndarray] = []  # (4, n) wxyz
        self.rates: list[np.ndarray] = []  # (3, n) rad/s

    # -- metadata -------------------------------------------------------------------------------

    def _system(self) -> str:
        system = self.fields.get("TIME_SYSTEM")
        if system not in epochs.SYSTEMS:
            known = ", ".join(epochs.SYSTEMS)
            raise self.fields.error("TIME_SYSTEM", f"this version reads {known}")
        return system

    def _check_interpolation(self) -> None:
        method, degree = self.fields.get("INTERPOLATION_METHOD"), self.fields.get("INTERPOLATION_DEGREE")
        if method is not None and method not in METHODS:
            raise self.fields.error("INTERPOLATION_METHOD", f"not one of {', '.join(METHODS)}")
        if method is not None and degree is None:
            raise self.fields.error("INTERPOLATION_METHOD", "no INTERPOLATION_DEGREE beside it")
        if degree is not None and not (degree.isascii() and degree.isdigit() and int(degree[:10]) > 0):
            raise self.fields.error("INTERPOLATION_DEGREE", "not a whole number greater than 0")

    def _spans(self) -> dict[str, tuple[int, int]]:
        names = ("START_TIME", "USEABLE_START_TIME", "USEABLE_STOP_TIME", "STOP_TIME")
        found = {name: self._epoch(name) for name in names if name in self.fields.values}
        for (name, before), (other, after) in pairwise(found.items()):
            if before > after:
                raise self.fields.error(other, f"before {name}")
        return found

    def _epoch(self, name: str) -> tuple[int, int]:
        try:
            return epochs.one(self.fields.values[name].encode("ascii", "replace"), self.system)
        except EpochError as error:
            raise self.fields.error(name, error.reason) from None

    # -- attitudes ------------------------------------------------------------------------------

    def take_text(self, text: bytes, number: int) -> int:
        """Whole lines, of which the first has this number; how many of them are empty."""
        table, numbers = text_rows.read_spaced(text, number, self.kinds)
        if numbers:
            self._take(table, numbers)
        return text.count(b"\n") - len(numbers)

    def take(self, texts: list[bytes], numbers: Sequence[int]) -> None:
        """Rows, one blank between their words, and the numbers of the lines that they stand in."""
        if texts:
            table = text_rows.read(b"\n".join(texts) + b"\n", self.kinds)
            self._take(texts if table is None else table, numbers)

    def _take(self, table: text_rows.ParsedRows | list[bytes], numbers: Sequence[int]) -> None:
        """FormatError for the first row that is wrong, with the number of its line."""
        try:
            if isinstance(table, list):
                self._keep(rows.careful(table, self.columns, self.system))
            else:
                self._keep(Rows(rows.stamps(table.texts[0], self.system), table.columns))
        except RowError as error:
            raise FormatError(error.reason, self.source, numbers[error.index]) from None

    def _keep(self, read: Rows) -> None:
        self._check_order(read.stamps)
        attitude, rate = self.turns.of(read.numbers)
        self.stamps.append(read.stamps)
        self.attitudes.append(attitude)
        if rate is not None:
            self.rates.append(rate)

    def _check_order(self, stamps: Stamps) -> None:
        """Each later than the one before, and all within START_TIME and STOP_TIME."""
        second, atto = stamps
        later = (second[1:] > second[:-1]) | ((second[1:] == second[:-1]) & (atto[1:] > atto[:-1]))
        if self.stamps and stamps.first <= self.stamps[-1].last:
            raise RowError(0, "an epoch that is not after the one before")
        if not later.all():
            raise RowError(int(np.argmin(later)) + 1, "an epoch that is not after the one before")
        if stamps.first < self._span["START_TIME"]:
            raise RowError(0, "an epoch before START_TIME")
        if stamps.last > self._span["STOP_TIME"]:
            stop = self._span["STOP_TIME"]
            beyond = (second > stop[0]) | ((second == stop[0]) & (atto > stop[1]))
            raise RowError(int(np.argmax(beyond)), "an epoch after STOP_TIME")

    def close(self, line: int) -> None:
        if not self.stamps:
            raise FormatError("no attitudes between DATA_START and DATA_STOP", self.source, line)

    @property
    def count(self) -> int:
        return sum(len(stamps.second) for stamps in self.stamps)

    def check_after(self, other: Segment) -> None:
        """Refuses what cannot follow another segment in one ephemeris."""
        for name in SHARED:
            if self.fields.get(name) != other.fields.get(name):
                shown = f"the segment before has {other.fields.values.get(name)}"
                raise self.fields.error(name, f"{shown}; segment=k reads one of them")
        useable = other._span.get("USEABLE_STOP_TIME"), self._span.get("USEABLE_START_TIME")
        if useable[0] is not None and useable[1] is not None and useable[1] < useable[0]:
            raise self.fields.error("USEABLE_START_TIME", "before USEABLE_STOP_TIME of the segment before")
        if self._span["START_TIME"] < other._span["STOP_TIME"]:
            raise self.fields.error("START_TIME", "before STOP_TIME of the segment before")
        if self.stamps[0].first < other.stamps[-1].last:
            raise self.fields.error("START_TIME", "its first epoch is before the last of the segment before")


class Skipped:
    """A segment that was not asked for: its place in the file is checked, its content is not."""

    columns: tuple[str, ...] = ()

    def take(self, texts: list[bytes], numbers: Sequence[int]) -> None:
        pass

    def close(self, line: int) -> None:
        pass


# -- meaning ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Turns:
    """What the numbers of a row turn.

    columns : their names, in the order of the file
    frame : the inertial frame
    forward : whether the numbers are of the rotation from inertial to body axes, as CCSDS names it
    in_body : whether components of the rate are along body axes
    axes : of Euler angles, "XYZ"; or ""
    """

    columns: tuple[str, ...]
    frame: str
    forward: bool
    in_body: bool
    axes: str

    def of(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
        """(4, n) wxyz, body to inertial, and (3, n) rad/s, of body components, or None."""
        columns = dict(zip(self.columns, numbers, strict=True))
        if self.axes:
            q, derivative = self._euler(columns)
        else:
            q = np.stack([columns[name] for name in ("QC", "Q1", "Q2", "Q3")])
            _check_unit(q)
            dotted = [columns[name] for name in ("QC_DOT", "Q1_DOT", "Q2_DOT", "Q3_DOT") if name in columns]
            derivative = np.stack(dotted) if dotted else None
        if not self.forward:
            q[1:] = -q[1:]
            if derivative is not None:
                derivative[1:] = -derivative[1:]
        if derivative is not None:
            return q, _bounded(_rate(q, derivative))
        if "ANGVEL_X" not in columns:
            return q, None
        rate = np.deg2rad(np.stack([columns[name] for name in ANGVEL]))
        return q, self._of_body(q, rate)

    def _of_body(self, q: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """The rate is that of the frame the numbers turn to, relative to the one they turn from."""
        if not self.forward:
            rate = -rate
        if self.in_body:
            return _bounded(rate)
        with np.errstate(over="ignore", invalid="ignore"):
            return _bounded(rotations.rotate(rotations.conjugate(q.T), rate.T).T)

    def _euler(self, columns: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray | None]:
        """q = q_1 * q_2 * q_3, intrinsic, and its derivative where the angles have one (product rule)."""
        q, derivative = np.zeros((len(columns["ANGLE_1"]), 4)), None
        q[:, 0] = 1.0
        for axis, name in zip(self.axes, ANGLES, strict=True):
            half, speed = 0.5 * np.deg2rad(columns[name]), columns.get(f"{name}_DOT")
            turn = np.zeros_like(q)
            turn[:, 0], turn[:, 1 + "XYZ".index(axis)] = np.cos(half), np.sin(half)
            if speed is not None:
                along = np.zeros_like(q)
                along[:, 1 + "XYZ".index(axis)] = 0.5 * np.deg2rad(speed)
                turning = rotations.product(q, rotations.product(turn, along))
                before = 0.0 if derivative is None else rotations.product(derivative, turn)
                derivative = before + turning
            q = rotations.product(q, turn)
        return np.ascontiguousarray(q.T), None if derivative is None else np.ascontiguousarray(derivative.T)


def _check_unit(q: np.ndarray) -> None:
    with np.errstate(over="ignore"):
        length = np.sqrt((q * q).sum(axis=0))
    off = ~(np.abs(length - 1.0) <= rotations.UNIT_TOLERANCE)
    if off.any():
        i = int(np.argmax(off))
        raise RowError(
            i, f"quaternion: a unit quaternion, within 1e-6 of length 1; got length {length[i]:.9g}"
        )


def _rate(q: np.ndarray, derivative: np.ndarray) -> np.ndarray:
    """omega = 2 vec(conj(q) dq/dt) / (q.q), body components."""
    with np.errstate(over="ignore", invalid="ignore"):
        twice = 2.0 * rotations.product(rotations.conjugate(q.T), derivative.T)[:, 1:].T
        return twice / (q * q).sum(axis=0)


def _bounded(rate: np.ndarray) -> np.ndarray:
    if rate.size and not max(rate.max(), -rate.min()) <= GREATEST_RATE:
        bad = ~(np.abs(rate) <= GREATEST_RATE).all(axis=0)
        raise RowError(int(np.argmax(bad)), f"a rate of more than {GREATEST_RATE:g} rad/s")
    return rate


def turns(fields: Fields) -> Turns:
    """Read off the metadata; FormatError for types and frames that this library has not."""
    name = fields.get("ATTITUDE_TYPE")
    kind = KINDS.get(name or "")
    if kind is None or fields.version not in kind.versions:
        known = ", ".join(known for known, kind in KINDS.items() if fields.version in kind.versions)
        raise fields.error("ATTITUDE_TYPE", f"of version {fields.version} this library reads {known}")
    frame, of_first = _inertial(fields)
    forward = of_first == (_direction(fields) == "A2B")
    rated = bool(kind.rate) and kind.rate[0] == "ANGVEL_X"
    in_body = not rated or _rate_frame(fields) != ("REF_FRAME_A" if of_first else "REF_FRAME_B")
    columns = kind.attitude + kind.rate
    if fields.version == "1.0" and kind.attitude is Q:
        columns = _placed(fields, kind)
    return Turns(columns, frame, forward, in_body, _axes(fields) if kind.attitude is ANGLES else "")


def _inertial(fields: Fields) -> tuple[str, bool]:
    """The inertial frame, and whether it is frame A; the other one is the body's."""
    frames = [fields.get(name) or "" for name in ("REF_FRAME_A", "REF_FRAME_B")]
    frames = [ALIASES.get(frame, frame) for frame in frames]
    known = [frame in rotations.INERTIAL_FRAMES for frame in frames]
    if all(known):
        raise fields.error("REF_FRAME_B", "frames A and B are both inertial, so neither is the body's")
    if not any(known):
        names = ", ".join(rotations.INERTIAL_FRAMES)
        raise fields.error("REF_FRAME_A", f"neither frame A nor frame B is one of {names}")
    return frames[known.index(True)], known[0]


def _direction(fields: Fields) -> str:
    direction = fields.get("ATTITUDE_DIR") or "A2B"  # version 2 has no other
    if direction not in ("A2B", "B2A"):
        raise fields.error("ATTITUDE_DIR", "neither A2B nor B2A")
    return direction


def _rate_frame(fields: Fields) -> str:
    """REF_FRAME_A or REF_FRAME_B, which version 1 says so and version 2 by the frame's own name."""
    name = "RATE_FRAME" if fields.version == "1.0" else "ANGVEL_FRAME"
    found = fields.get(name)
    for frame in ("REF_FRAME_A", "REF_FRAME_B"):
        if found is not None and found in (frame, fields.get(frame)):
            return frame
    raise fields.error(name, "REF_FRAME_A or REF_FRAME_B belongs here, for the components of the rate")


def _placed(fields: Fields, kind: Kind) -> tuple[str, ...]:
    """The columns of version 1: QC comes first or last."""
    place = fields.get("QUATERNION_TYPE")
    if place not in ("FIRST", "LAST"):
        raise fields.error("QUATERNION_TYPE", "FIRST or LAST belongs here, the place of QC")
    if place == "LAST":
        return kind.attitude + kind.rate
    rate = (kind.rate[3], *kind.rate[:3]) if kind.rate is Q_DOT else kind.rate
    return ("QC", "Q1", "Q2", "Q3", *rate)


def _axes(fields: Fields) -> str:
    """Of the three rotations: letters, or in version 1 digits."""
    axes = (fields.get("EULER_ROT_SEQ") or "").translate(str.maketrans("123", "XYZ"))
    if len(axes) != 3 or set(axes) - set("XYZ") or any(a == b for a, b in pairwise(axes)):
        raise fields.error("EULER_ROT_SEQ", "three axes belong here, no two alike side by side, such as ZXZ")
    return axes


# -- the whole file -----------------------------------------------------------------------------


class Message:
    """What a file has told so far: the same for both syntaxes."""

    def __init__(self, source: str, segment: Any):
        if segment is not None and (isinstance(segment, bool) or not isinstance(segment, int) or segment < 1):
            raise InputError("segment", segment, "a whole number, 1 for the first, or None for all")
        self.source, self.wanted = source, segment
        self.version = ""
        self.seen = self.remarks = 0
        self.segments: list[Segment] = []

    def begin(self, version: str, line: int) -> None:
        if version not in VERSIONS:
            raise FormatError(f"AEM version {version[:20]!r}, not 1.0 or 2.0", self.source, line)
        self.version = version

    def remark(self, line: int, count: int = 1) -> None:
        """A comment or an empty line."""
        self.remarks += count
        if self.remarks > MOST_REMARKS:
            reason = f"more than {MOST_REMARKS} comments and empty lines"
            raise FormatError(reason, self.source, line)

    def header(self) -> Fields:
        return Fields(HEADER, self.version, "header", self.source)

    def metadata(self) -> Fields:
        return Fields(METADATA, self.version, "metadata", self.source)

    def segment(self, fields: Fields, line: int) -> Segment | Skipped:
        """To be filled, after the metadata have ended at this line."""
        fields.close(line)
        self.seen += 1
        if self.wanted not in (None, self.seen):
            return Skipped()
        self.segments.append(Segment(fields))
        return self.segments[-1]

    def ephemeris(self) -> EphemerisData:
        if not self.segments:
            raise FormatError(f"no segment {self.wanted or 1}, of {self.seen}", self.source)
        for before, after in pairwise(self.segments):
            after.check_after(before)
        try:
            return self._joined()
        except AttitudeError as error:
            raise FormatError(str(error), self.source) from None

    def _joined(self) -> EphemerisData:
        segments, first = self.segments, self.segments[0]
        columns = zip(*(stamps for part in segments for stamps in part.stamps), strict=True)
        whole = Stamps(*map(np.concatenate, columns))
        starts = np.cumsum([part.count for part in segments])[:-1].tolist()
        shared = [
            start
            for start, (before, after) in zip(starts, pairwise(segments), strict=True)
            if after.stamps[0].first == before.stamps[-1].last
        ]
        for part in segments:
            part.stamps.clear()
        times = schema.check_dates(epochs.to_instants(whole, first.system))
        _check_steps(times, whole, shared)
        for start in reversed(
            shared
        ):  # of an instant that two segments share, the first has the double before
            times.seconds[start - 1] = np.nextafter(times.seconds[start], -np.inf)
        events = tuple(
            Event(float(times.seconds[start]), "segment", f"segment {k} of the file begins")
            for k, start in enumerate(starts, start=2)
        )
        q = rotations.sign_continuous(_gathered([part.attitudes for part in segments]))
        rate = _gathered([part.rates for part in segments]) if first.rates else None
        name = first.fields.values["OBJECT_NAME"]
        return EphemerisData(q, times, first.turns.frame, None, rate, name, events=events)


def _check_steps(times: Instants, stamps: Stamps, shared: list[int]) -> None:
    """Refuses epochs that are one when they are written again, to the nanosecond; `shared` ones may be."""
    steps = np.diff(times.seconds)
    if times.seconds_low is not None:
        steps += np.diff(times.seconds_low)
    steps[np.array(shared, dtype=int) - 1] = np.inf
    if not steps.size or steps.min() > 2.1e-9:
        return
    least = 2e-9 if (stamps.atto % NANOSECOND).any() else 1e-9
    close = np.flatnonzero(steps < least * (1.0 - 1e-3))
    if close.size:
        i = int(close[0])
        expected = f"epochs at least {least:g} s apart, to be told from each other when they are rounded"
        raise InputError(f"attitudes[{i + 1}]", f"{float(steps[i]):.3g} s after the one before", expected)


def _gathered(lists: list[list[np.ndarray]]) -> np.ndarray:
    """(n, components), stored by component; the blocks are let go."""
    whole = np.concatenate([block for blocks in lists for block in blocks], axis=1).T
    for blocks in lists:
        blocks.clear()
    return whole
