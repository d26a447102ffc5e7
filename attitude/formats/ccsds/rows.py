"""Rows of an AEM: epoch and numbers (quaternion, Euler angles or spin, rate), written and parsed.

One departure from the standard: a double is written with 17 digits if 16 do not restore its bits.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...errors import FormatError
from ...frames import rotations
from ...samples.chunks import Samples
from ...samples.ephemeris_data import EphemerisData
from .. import date_text, schema
from ..text_reader import finite_number
from ..text_rows import texts
from . import spin
from .epochs import EPOCH, RowError, Timestamps, parse_epochs
from .keywords import ATTITUDE_TYPES, Keywords


class RowWriter:
    """Writes the rows of an AEM's segments, in order, in either syntax.

    segments : all of the file's
    kind : ATTITUDE_TYPE
    sequence : of Euler angles, EULER_ROT_SEQ
    number_count : numbers in a row
    """

    def __init__(self, segments: Sequence[Samples], kind: str, sequence: str = ""):
        self.segments, self.kind, self.sequence = segments, ATTITUDE_TYPES[kind], sequence
        self.number_count = len(self.kind.attitude + self.kind.rate)
        self._last_epoch = b""
        self._last_attitude: np.ndarray | None = None

    def write(self, segment: Samples, separators: list[bytes]) -> Iterator[bytes]:
        """Text of a segment's rows, block by block: epoch, quaternion and angular velocity.

        separators : what stands before the epoch, between it and the numbers, and after the last

        Raises FormatError for instants that do not increase by a nanosecond, and for a segment that begins
        before the one before it ends.
        """
        left = segment.count
        for piece in segment.chunks():
            epochs, is_begin = epoch_texts(piece).copy(), left == segment.count
            left -= len(piece)
            if left == 0:
                epochs[-1] = self.last_epoch(segment)
            # a segment may begin at the last epoch of the one before
            before = np.concatenate([[self._last_epoch], epochs[:-1]])
            late = epochs <= before
            if is_begin:
                late[0] = epochs[0] < before[0]
            if late.any():
                i = int(np.argmax(late))
                order = f"{epochs[i].decode()} follows {bytes(before[i]).decode()}"
                raise FormatError(f"an AEM needs instants that increase by a nanosecond or more; {order}")
            self._last_epoch = epochs[-1]
            # Adding 0.0 makes -0.0 positive: the standard has no -0 (6.8.5).
            yield texts(self._numbers(piece) + 0.0, separators, epochs)

    def _numbers(self, piece: EphemerisData) -> np.ndarray:
        """(number_count, n) of the rows."""
        if self.kind.attitude is Keywords.SPIN:
            return spin.numbers(piece, self.kind.rate)
        columns = np.empty((self.number_count, len(piece)))
        count = len(self.kind.attitude)
        if self.kind.attitude is Keywords.ANGLES:
            columns[:count] = rotations.euler_angles(piece.quaternion("wxyz"), self.sequence).T
            np.rad2deg(columns[:count], out=columns[:count])
        else:
            q = rotations.sign_continuous(piece.quaternion("xyzw"), self._last_attitude)
            self._last_attitude = q[-1]
            columns[:count] = q.T
        if self.kind.rate:
            columns[count:] = schema.degrees(piece).T
        return columns

    def last_epoch(self, segment: Samples) -> bytes:
        """Last epoch of a segment: where the next one begins if both are the same when rounded."""
        following = self.segments[self.segments.index(segment) + 1 :][:1]
        last = segment.last.elapsed[0]
        # dates are written to the nanosecond
        if following and following[0].first.elapsed[0] <= max(last + 4e-10, np.nextafter(last, np.inf)):
            return bytes(epoch_texts(following[0].first)[0])
        return bytes(epoch_texts(segment.last)[0])


def epoch_texts(piece: EphemerisData) -> np.ndarray:
    """(n,) dates to the nanosecond; FormatError outside the years 1 to 9999."""
    epochs = date_text.dates(piece.instants)
    if epochs.dtype.itemsize != date_text.ISO_BYTES or epochs[0] < b"0001":
        raise FormatError("an AEM has dates of the years 1 to 9999")
    return epochs


def parse_rows(rows: list[bytes], columns: tuple[str, ...], system: str) -> tuple[Timestamps, np.ndarray]:
    """Parse rows one by one, to name what is wrong with one: timestamps and (columns, n) doubles.

    rows : epoch and numbers between blanks

    Raises RowError for the first row that is invalid.
    """
    epochs, numbers = [], np.empty((len(columns), len(rows)))
    for i, row in enumerate(rows):
        epoch, *words = row.split()
        epochs.append(epoch)
        if len(words) != len(columns):
            if EPOCH.fullmatch(epoch) is None:
                shown = epoch[:40].decode("ascii", "replace")
                raise RowError(i, f"{shown!r} where an epoch or DATA_STOP belongs")
            missing = f", no {columns[len(words)]}" if len(words) < len(columns) else ""
            raise RowError(i, f"{len(words)} numbers where {' '.join(columns)} belong{missing}")
        for j, (word, name) in enumerate(zip(words, columns, strict=True)):
            numbers[j, i] = finite_number(word.decode("latin-1"))
            if np.isnan(numbers[j, i]):
                shown = word[:40].decode("ascii", "replace")
                raise RowError(i, f"{name} is {shown!r}, not a finite number")
    return parse_epochs(epochs, system), numbers
