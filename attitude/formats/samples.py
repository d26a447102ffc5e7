"""An ephemeris as writers take it: its beginning, its end, and its instants piece by piece."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property
from typing import TYPE_CHECKING

from .. import units

if TYPE_CHECKING:
    from ..ephemeris import Ephemeris

BLOCK = 1 << 16  # instants in a piece

Progress = Callable[[float], None]


def no_progress(done: float) -> None:
    pass


class Samples:
    """Pieces of one ephemeris, cut from it or computed when their turn comes.

    Attributes
    ----------
    count : int, instants along the first of their dimensions
    cut : from a first instant to a last, excluded: the Ephemeris of these
    progress : called with the fraction that is done
    """

    def __init__(self, count: int, cut: Callable[[int, int], Ephemeris], progress: Progress | None = None):
        self.count, self.cut = count, cut
        self.progress = progress or no_progress

    @classmethod
    def of(cls, ephemeris: Ephemeris, progress: Progress | None = None) -> Samples:
        """Of an ephemeris in memory; one of a single instant is a piece on its own."""
        if not ephemeris.instants.shape:
            return cls(1, lambda first, last: ephemeris, progress)
        return cls(len(ephemeris), lambda first, last: ephemeris[first:last], progress)

    @cached_property
    def head(self) -> Ephemeris:
        """At the first instant: what all instants share is read off it."""
        return self.cut(0, 1)

    @cached_property
    def tail(self) -> Ephemeris:
        """At the last instant."""
        return self.cut(self.count - 1, self.count)

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

    def whole(self) -> Ephemeris:
        """All of it at once."""
        return self.cut(0, self.count)

    def pieces(self, part: int = 0, of: int = 1) -> Iterator[Ephemeris]:
        """In turn, at most `BLOCK` instants each; of a writer that needs several turns, `part` of so many."""
        for first in range(0, self.count, BLOCK):
            last = min(first + BLOCK, self.count)
            yield self.cut(first, last)
            self.progress((part + last / self.count) / of)

    def turned(self, turn: Callable[[Ephemeris], Ephemeris]) -> Samples:
        """The same, each piece as `turn` makes it."""
        return Samples(self.count, lambda first, last: turn(self.cut(first, last)), self.progress)

    @cached_property
    def has_rest(self) -> bool:
        """Whether any instant's seconds need their second part."""
        return any(
            piece.instants.rest is not None and piece.instants.rest.any() for piece in self._silently()
        )

    @cached_property
    def span(self) -> tuple[float, float]:
        """s; the least and the greatest of the instants, in whatever order they are."""
        extremes = [units.extremes(piece.elapsed) for piece in self._silently()]
        return min(least for least, _ in extremes), max(greatest for _, greatest in extremes)

    def _silently(self) -> Iterator[Ephemeris]:
        return (self.cut(first, min(first + BLOCK, self.count)) for first in range(0, self.count, BLOCK))
