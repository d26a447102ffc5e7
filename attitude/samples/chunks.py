"""An ephemeris as writers take it: its beginning, its end, and its instants piece by piece."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cached_property, partial
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from ..times.instants import Instants
    from .ephemeris_data import EphemerisData

BLOCK = 1 << 16  # instants in a piece

Progress = Callable[[float], None]


def no_progress(done: float) -> None:
    pass


class _Survey(NamedTuple):
    """What is known of all instants together: their extremes (s), the places of these, and the digits."""

    least: float
    greatest: float
    first: int
    last: int
    has_rest: bool


class Samples:
    """Pieces of one ephemeris, cut from it or computed when their turn comes.

    Attributes
    ----------
    count : int, instants along the first of their dimensions
    cut : from a first instant to a last, excluded: the EphemerisData of these
    progress : called with the fraction that is done
    instants : as `cut`, the instants alone, where they cost less than the EphemerisData
    is_held : whether pieces are cut from an ephemeris in memory, and cost nothing to take again
    """

    def __init__(
        self,
        count: int,
        cut: Callable[[int, int], EphemerisData],
        progress: Progress | None = None,
        instants: Callable[[int, int], Instants] | None = None,
        is_held: bool = True,
    ):
        self.count, self.cut, self.is_held = count, cut, is_held
        self.progress = progress or no_progress
        self.instants = instants or (lambda first, last: cut(first, last).instants)

    @classmethod
    def of(cls, ephemeris: EphemerisData, progress: Progress | None = None) -> Samples:
        """Of an ephemeris in memory; one of a single instant is a piece on its own."""
        if not ephemeris.instants.shape:
            return cls(1, lambda first, last: ephemeris, progress)
        count, instants = len(ephemeris), ephemeris.instants

        def cut(first: int, last: int) -> EphemerisData:
            return ephemeris if last - first == count else ephemeris[first:last]

        return cls(count, cut, progress, lambda first, last: instants[first:last])

    @cached_property
    def head(self) -> EphemerisData:
        """At the first instant: what all instants share is read off it."""
        return self.cut(0, 1)

    @cached_property
    def tail(self) -> EphemerisData:
        """At the last instant."""
        return self.cut(self.count - 1, self.count)

    @property
    def is_short(self) -> bool:
        """Whether it is one piece."""
        return self.count <= BLOCK

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch dimensions, then those of the instants."""
        head = self.head
        if not head.instants.shape:
            return head.shape
        return (*head.batch_shape, self.count, *head.instants.shape[1:])

    @property
    def is_list(self) -> bool:
        """Whether this is one body at a list of instants, all that most formats hold."""
        return len(self.shape) == 1 and not self.head.batch_shape

    def whole(self) -> EphemerisData:
        """All of it at once."""
        return self.cut(0, self.count)

    def pieces(self, part: int = 0, of: int = 1) -> Iterator[EphemerisData]:
        """In turn, at most `BLOCK` instants each; of a writer that needs several turns, `part` of so many."""
        for first in range(0, self.count, BLOCK):
            last = min(first + BLOCK, self.count)
            yield self.cut(first, last)
            self.progress((part + last / self.count) / of)

    def turned(self, turn: Callable[[EphemerisData], EphemerisData]) -> Samples:
        """The same, each piece as `turn` makes it."""
        return Samples(
            self.count,
            lambda first, last: turn(self.cut(first, last)),
            self.progress,
            self.instants,
            self.is_held,
        )

    @property
    def ends(self) -> tuple[Samples, Samples]:
        """The least and the greatest instant, each alone: what both allow, all between them do."""
        least, greatest = (
            Samples(1, partial(self._at, place)) for place in (self._survey.first, self._survey.last)
        )
        return least, greatest

    def _at(self, place: int, first: int, last: int) -> EphemerisData:
        return self.cut(place + first, place + last)

    @property
    def has_rest(self) -> bool:
        """Whether any instant's seconds need their second part."""
        return self._survey.has_rest

    @property
    def span(self) -> tuple[float, float]:
        """s; the least and the greatest of the instants, in whatever order they are."""
        return self._survey.least, self._survey.greatest

    @cached_property
    def _survey(self) -> _Survey:
        """Found in one turn: to make the instants takes longer than to look through them."""
        least, greatest, has_rest = (math.inf, 0), (-math.inf, 0), False
        for first in range(0, self.count, BLOCK):
            piece = self.instants(first, min(first + BLOCK, self.count))
            seconds = piece.seconds.reshape(-1)
            row = max(1, math.prod(piece.shape[1:]))
            low, high = int(seconds.argmin()), int(seconds.argmax())
            least = min(least, (float(seconds[low]), first + low // row))
            greatest = max(greatest, (float(seconds[high]), first + high // row))
            has_rest = has_rest or (piece.seconds_low is not None and bool(piece.seconds_low.any()))
        return _Survey(least[0], greatest[0], least[1], greatest[1], has_rest)
