"""Writing an AEM (CCSDS 504.0-B-2) in either syntax: keywords and values, comments, and rows of numbers.

One departure from the standard: a double is written with 17 digits if 16 do not restore its bits.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import numpy as np

from ...errors import FormatError, InputError
from ...frames import rotations
from ...frames.inertial import OBLIQUITY_J2000
from ...frames.rotations import INERTIAL_FRAMES, check_frame
from ...samples.chunks import Samples
from ...samples.ephemeris_data import EphemerisData
from .. import schema
from ..interpolant import Interpolant, lagrange
from ..interpolation_nodes import Nodes
from ..text_rows import texts
from .epochs import TIME_SYSTEMS, RowError, parse_epoch
from .keywords import FRAME_ALIASES, VALUE, is_value

VERSION = "2.0"
EPOCH_WIDTH = 29
SAME_EPOCH = 4e-10  # s; dates are written to the nanosecond

UNREGISTERED_FRAMES = {
    "ECLIPJ2000": f"EME2000 turned about its X axis by {OBLIQUITY_J2000} arcsec",
    "INERTIAL": "an inertial frame of the producer's own",
}
Pairs = list[tuple[str, str]]


@dataclass(frozen=True)
class AemOptions:
    """Options of the AEM writers; InputError for one that a line of the file cannot hold.

    object_name : OBJECT_NAME; None for the ephemeris's name
    object_id, originator : OBJECT_ID, ORIGINATOR
    message_id, center_name : MESSAGE_ID, CENTER_NAME; None leaves them out
    creation_date : CREATION_DATE, UTC; None for now
    body_frame : REF_FRAME_B, the name of the body's axes
    rates : whether angular velocities are written; None writes those of an ephemeris that has them
    degree : degree of the Lagrange interpolation that the file states
    """

    object_name: str | None = None
    object_id: str = "UNKNOWN"
    originator: str = "ATTITUDE"
    message_id: str | None = None
    creation_date: str | None = None
    center_name: str | None = None
    body_frame: str = "SC_BODY_1"
    rates: bool | None = None
    degree: int = 7

    def __post_init__(self) -> None:
        for name in ("object_id", "originator", "body_frame"):
            _check_text(name, getattr(self, name))
        for name in ("object_name", "message_id", "creation_date", "center_name"):
            if getattr(self, name) is not None:
                _check_text(name, getattr(self, name))
        frame = "_".join(self.body_frame.upper().split())
        if FRAME_ALIASES.get(frame, frame) in INERTIAL_FRAMES:
            raise InputError("body_frame", self.body_frame, "the name of axes of the body, no inertial frame")
        if self.creation_date is not None:
            _check_date(self.creation_date)
        if self.rates not in (None, True, False):
            raise InputError("rates", self.rates, "True, False, or None: where there are any")
        lagrange(self.degree, "degree")


def interpolant(*, degree: int = 7, **_: Any) -> Interpolant:
    """How readers interpolate: the file tells them to use Lagrange polynomials of this degree."""
    return lagrange(degree, "degree")


def _check_text(name: str, value: Any) -> None:
    if not isinstance(value, str) or not is_value(value):
        raise InputError(name, value, VALUE)


def _check_date(text: str) -> None:
    try:
        parse_epoch(text.encode(), "UTC")
    except RowError as error:
        expected = f"a date in UTC, such as 2026-01-01T00:00:00 ({error.reason})"
        raise InputError("creation_date", text, expected) from None


class AemWriter:
    """The content of a file, without its syntax.

    attitude_type : ATTITUDE_TYPE
    number_count : numbers in a row
    """

    def __init__(self, nodes: Nodes, options: AemOptions):
        self.nodes, self.options = nodes, options
        head = nodes.segments[0].first
        self.frame = check_frame(head.frame)
        self.time_system = _time_system(head)
        if options.rates and not head.has_rate:
            raise InputError("rates", True, "an ephemeris that holds rates, or False")
        self.has_rate = head.has_rate if options.rates is None else bool(options.rates)
        self.attitude_type = "QUATERNION/ANGVEL" if self.has_rate else "QUATERNION"
        self.number_count = 7 if self.has_rate else 4
        self.object_name = head.name or "UNKNOWN" if options.object_name is None else options.object_name
        _check_text("object_name", self.object_name)
        self._last_epoch = b""
        self._last_attitude: np.ndarray | None = None

    def comments(self) -> list[str]:
        """Convention in words, and the interpolation error."""
        body, frame = self.options.body_frame, self.frame
        lines = [
            f"Q1 Q2 Q3 QC, scalar last, turn axes of {frame} into those of {body}",
            f"v_inertial = q * v_body * conj(q), Hamilton product: q rotates {body} to {frame}",
        ]
        if self.has_rate:
            lines.append(f"ANGVEL is that of {body} relative to {frame}, components in {body}, deg/s")
        if frame in UNREGISTERED_FRAMES:
            lines.append(f"{frame} is not in the SANA registry of frames: {UNREGISTERED_FRAMES[frame]}")
        return [*lines, self.nodes.remark]

    def header(self) -> Pairs:
        """Keywords of the header and their values."""
        date = self.options.creation_date or datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%S")
        pairs = [("CREATION_DATE", date), ("ORIGINATOR", self.options.originator)]
        return pairs + ([("MESSAGE_ID", self.options.message_id)] if self.options.message_id else [])

    def metadata(self, segment: Samples) -> Pairs:
        """Keywords of a segment and their values, in the order of table 4-3."""
        options, degree = self.options, min(self.options.degree, segment.count - 1)
        start, stop = _epoch_texts(segment.first)[0].decode(), self._stop(segment).decode()
        center = [("CENTER_NAME", options.center_name)] if options.center_name else []
        rate = [("ANGVEL_FRAME", options.body_frame)] if self.has_rate else []
        method = [("INTERPOLATION_METHOD", "LAGRANGE"), ("INTERPOLATION_DEGREE", str(degree))]
        return [
            ("OBJECT_NAME", self.object_name),
            ("OBJECT_ID", options.object_id),
            *center,
            ("REF_FRAME_A", self.frame),
            ("REF_FRAME_B", options.body_frame),
            ("TIME_SYSTEM", self.time_system),
            ("START_TIME", start),
            ("STOP_TIME", stop),
            ("ATTITUDE_TYPE", self.attitude_type),
            *rate,
            *(method if degree else []),
        ]

    def write_rows(self, segment: Samples, separators: list[bytes]) -> Iterator[bytes]:
        """Text of a segment's rows, block by block: epoch, quaternion and angular velocity.

        separators : what stands before the epoch, between it and the numbers, and after the last

        Raises FormatError for instants that do not increase by a nanosecond, and for a segment that begins
        before the one before it ends.
        """
        left = segment.count
        for piece in segment.chunks():
            epochs, is_begin = _epoch_texts(piece).copy(), left == segment.count
            left -= len(piece)
            if left == 0:
                epochs[-1] = self._stop(segment)
            self._check_order(epochs, is_begin)
            columns = np.empty((self.number_count, len(piece)))
            q = rotations.sign_continuous(piece.quaternion("xyzw"), self._last_attitude)
            self._last_attitude = q[-1]
            # Adding 0.0 makes -0.0 positive: the standard has no -0 (6.8.5).
            np.add(q.T, 0.0, out=columns[:4])
            if self.has_rate:
                np.add(schema.degrees(piece).T, 0.0, out=columns[4:])
            yield texts(columns, separators, epochs)

    def _stop(self, segment: Samples) -> bytes:
        """Last epoch: that of the next segment's beginning if both are one when rounded."""
        following = self.nodes.segments[self.nodes.segments.index(segment) + 1 :][:1]
        last = segment.last.elapsed[0]
        if following and following[0].first.elapsed[0] <= max(last + SAME_EPOCH, np.nextafter(last, np.inf)):
            return bytes(_epoch_texts(following[0].first)[0])
        return bytes(_epoch_texts(segment.last)[0])

    def _check_order(self, epochs: np.ndarray, is_begin: bool) -> None:
        """Refuse epochs that do not increase; a segment may begin at the last epoch of the one before."""
        before = np.concatenate([[self._last_epoch], epochs[:-1]])
        late = epochs <= before
        if is_begin:
            late[0] = epochs[0] < before[0]
        if late.any():
            i = int(np.argmax(late))
            order = f"{epochs[i].decode()} follows {bytes(before[i]).decode()}"
            raise FormatError(f"an AEM needs instants that increase by a nanosecond or more; {order}")
        self._last_epoch = epochs[-1]


def _time_system(head: EphemerisData) -> str:
    """TIME_SYSTEM; FormatError for an ephemeris without an epoch."""
    scale = head.instants.scale
    if head.epoch is None or scale is None:
        raise FormatError("an AEM has dates, and this ephemeris has no epoch to count them from")
    if scale.upper() not in TIME_SYSTEMS:
        raise FormatError(f"no TIME_SYSTEM of an AEM is the scale {scale!r}")
    return scale.upper()


def _epoch_texts(piece: EphemerisData) -> np.ndarray:
    epochs = schema.dates(piece.instants)
    if epochs.dtype.itemsize != EPOCH_WIDTH or epochs[0] < b"0001":
        raise FormatError("an AEM has dates of the years 1 to 9999")
    return epochs
