"""Writing an AEM (CCSDS 504.0-B-2), KVN or XML: keywords and values, comments, and the texts of numbers.

Departures from the standard, of one kind: a double needs 17 digits where 16 do not give back its bits.
"""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any, NamedTuple

import numpy as np

from ...errors import FormatError, InputError
from ...frames import rotations
from ...frames.inertial import OBLIQUITY_J2000
from ...frames.rotations import INERTIAL_FRAMES, check_frame
from ...samples.chunks import Samples
from ...samples.ephemeris_data import EphemerisData
from .. import schema
from ..interpolant import lagrange
from ..interpolation_nodes import Nodes
from ..text_rows import texts
from . import epochs
from .reader import ALIASES, VALUE, is_value

VERSION = "2.0"
EPOCH_WIDTH = 29
NEAR = 4e-10  # s; dates are written to the nanosecond

OUTSIDE = {
    "ECLIPJ2000": f"EME2000 turned about its X axis by {OBLIQUITY_J2000} arcsec",
    "INERTIAL": "an inertial frame of the producer's own",
}


class Options(NamedTuple):
    """What users may choose; `checked` refuses what a line of the file cannot hold."""

    object_name: str | None
    object_id: str
    originator: str
    message_id: str | None
    creation_date: str | None
    center_name: str | None
    body_frame: str
    rates: bool | None
    degree: int

    def checked(self) -> Options:
        for name in ("object_id", "originator", "body_frame"):
            _check_text(name, getattr(self, name))
        for name in ("object_name", "message_id", "creation_date", "center_name"):
            if getattr(self, name) is not None:
                _check_text(name, getattr(self, name))
        frame = "_".join(self.body_frame.upper().split())
        if ALIASES.get(frame, frame) in INERTIAL_FRAMES:
            raise InputError("body_frame", self.body_frame, "the name of axes of the body, no inertial frame")
        if self.creation_date is not None:
            _check_date(self.creation_date)
        if self.rates not in (None, True, False):
            raise InputError("rates", self.rates, "True, False, or None: where there are any")
        lagrange(self.degree, "degree")
        return self


def _check_text(name: str, value: Any) -> None:
    if not isinstance(value, str) or not is_value(value):
        raise InputError(name, value, VALUE)


def _check_date(text: str) -> None:
    try:
        epochs.one(text.encode(), "UTC")
    except epochs.EpochError as error:
        raise InputError(
            "creation_date", text, f"a date in UTC, such as 2026-01-01T00:00:00 ({error.reason})"
        ) from None


Pairs = list[tuple[str, str]]


class Message:
    """A file's content, without its syntax."""

    def __init__(self, nodes: Nodes, options: Options):
        self.nodes = nodes
        self.options = options = options.checked()
        head = nodes.segments[0].first
        self.frame = check_frame(head.frame)
        self.scale = _scale(head)
        if options.rates and not head.has_rate:
            raise InputError("rates", True, "an ephemeris that holds rates, or False")
        self.has_rate = head.has_rate if options.rates is None else bool(options.rates)
        name = head.name or "UNKNOWN" if options.object_name is None else options.object_name
        _check_text("object_name", name)
        self.object_name = name
        self._last = b""
        self._attitude: np.ndarray | None = None  # the last written

    def comments(self) -> list[str]:
        body, frame = self.options.body_frame, self.frame
        lines = [
            f"Q1 Q2 Q3 QC, scalar last, turn axes of {frame} into those of {body}",
            f"v_inertial = q * v_body * conj(q), Hamilton product: q rotates {body} to {frame}",
        ]
        if self.has_rate:
            lines.append(f"ANGVEL is that of {body} relative to {frame}, components in {body}, deg/s")
        if frame in OUTSIDE:
            lines.append(f"{frame} is not in the SANA registry of frames: {OUTSIDE[frame]}")
        return [*lines, self.nodes.remark]

    def header(self) -> Pairs:
        date = self.options.creation_date or datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%S")
        pairs = [("CREATION_DATE", date), ("ORIGINATOR", self.options.originator)]
        return pairs + ([("MESSAGE_ID", self.options.message_id)] if self.options.message_id else [])

    def metadata(self, segment: Samples) -> Pairs:
        """In the order of table 4-3."""
        options, degree = self.options, min(self.options.degree, segment.count - 1)
        start, stop = _epochs(segment.first)[0].decode(), self._stop(segment).decode()
        center = [("CENTER_NAME", options.center_name)] if options.center_name else []
        rate = [("ANGVEL_FRAME", options.body_frame)] if self.has_rate else []
        method = [("INTERPOLATION_METHOD", "LAGRANGE"), ("INTERPOLATION_DEGREE", str(degree))]
        return [
            ("OBJECT_NAME", self.object_name),
            ("OBJECT_ID", options.object_id),
            *center,
            ("REF_FRAME_A", self.frame),
            ("REF_FRAME_B", options.body_frame),
            ("TIME_SYSTEM", self.scale),
            ("START_TIME", start),
            ("STOP_TIME", stop),
            ("ATTITUDE_TYPE", "QUATERNION/ANGVEL" if self.has_rate else "QUATERNION"),
            *rate,
            *(method if degree else []),
        ]

    def rows(self, segment: Samples, pieces: list[bytes]) -> Iterator[bytes]:
        """Their text, block by block; the pieces stand around and between epoch and numbers.

        Refuses instants of a segment that do not increase by a nanosecond, and a segment that begins before
        the one before it ends.
        """
        left = segment.count
        for piece in segment.chunks():
            epochs, begins = _epochs(piece).copy(), left == segment.count
            left -= len(piece)
            if left == 0:
                epochs[-1] = self._stop(segment)
            self._check_order(epochs, begins)
            columns = np.empty((7 if self.has_rate else 4, len(piece)))
            q = rotations.sign_continuous(piece.quaternion("xyzw"), self._attitude)
            self._attitude = q[-1]
            # The standard has no -0 (6.8.5).
            np.add(q.T, 0.0, out=columns[:4])
            if self.has_rate:
                np.add(schema.degrees(piece).T, 0.0, out=columns[4:])
            yield texts(columns, pieces, epochs)

    def _stop(self, segment: Samples) -> bytes:
        """The epoch at which it ends: that of the next one's beginning, where no date lies between them."""
        following = self.nodes.segments[self.nodes.segments.index(segment) + 1 :][:1]
        last = segment.last.elapsed[0]
        if following and following[0].first.elapsed[0] <= max(last + NEAR, np.nextafter(last, np.inf)):
            return bytes(_epochs(following[0].first)[0])
        return bytes(_epochs(segment.last)[0])

    def _check_order(self, epochs: np.ndarray, begins: bool) -> None:
        """Each after the one before; that which begins a segment may be the last of the one before."""
        before = np.concatenate([[self._last], epochs[:-1]])
        late = epochs <= before
        if begins:
            late[0] = epochs[0] < before[0]
        if late.any():
            i = int(np.argmax(late))
            found, other = epochs[i].decode(), bytes(before[i]).decode()
            reason = f"an AEM needs instants that increase by a nanosecond or more; {found} follows {other}"
            raise FormatError(reason)
        self._last = epochs[-1]


def _scale(head: EphemerisData) -> str:
    """The TIME_SYSTEM; an ephemeris without an epoch has no dates to write."""
    scale = head.instants.scale
    if head.epoch is None or scale is None:
        raise FormatError("an AEM has dates, and this ephemeris has no epoch to count them from")
    if scale.upper() not in epochs.SYSTEMS:
        raise FormatError(f"no TIME_SYSTEM of an AEM is the scale {scale!r}")
    return scale.upper()


def _epochs(piece: EphemerisData) -> np.ndarray:
    epochs = schema.dates(piece.instants)
    if epochs.dtype.itemsize != EPOCH_WIDTH or epochs[0] < b"0001":
        raise FormatError("an AEM has dates of the years 1 to 9999")
    return epochs
