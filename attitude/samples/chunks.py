"""The samples of an ephemeris in chunks of instants, as every writer reads them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from .. import stopping

if TYPE_CHECKING:
    from ..times.instants import Instants
    from .ephemeris_data import EphemerisData

CHUNK_INSTANTS = 1 << 14  # instants in a chunk, at most: a writer holds one, as numbers and as text

Progress = Callable[[float], None]


class Extremes(NamedTuple):
    """The least and the greatest instant: s, and their indices."""

    least: float
    greatest: float
    least_index: int
    greatest_index: int


class Samples:
    """Chunks of one ephemeris, sliced from it or computed on request.

    Attributes
    ----------
    count : int, instants along the first of their dimensions
    chunk : function of a first index and a last, exclusive, that returns the EphemerisData of these instants
    progress : called with the fraction that is done
    instants : as `chunk`, the Instants alone, where they cost less than the EphemerisData
    in_memory : whether chunks are slices of an ephemeris in memory, and cost nothing to read again
    """

    def __init__(
        self,
        count: int,
        chunk: Callable[[int, int], EphemerisData],
        progress: Progress | None = None,
        instants: Callable[[int, int], Instants] | None = None,
        in_memory: bool = True,
    ):
        self.count, self.chunk, self.in_memory = count, chunk, in_memory
        self.progress = progress or (lambda _: None)
        self.instants = instants or (lambda first, last: chunk(first, last).instants)

    @classmethod
    def of(cls, ephemeris: EphemerisData, progress: Progress | None = None) -> Samples:
        """Samples of an ephemeris in memory; one of a single instant is one chunk."""
        instants = ephemeris.instants
        if not instants.shape:
            return cls(1, lambda *_: ephemeris, progress)
        count = instants.shape[0]

        def chunk(first: int, last: int) -> EphemerisData:
            return ephemeris if last - first == count else ephemeris[first:last]

        return cls(count, chunk, progress, lambda first, last: instants[first:last])

    @cached_property
    def first(self) -> EphemerisData:
        """The first instant alone; what all instants share is read from it."""
        return self.chunk(0, 1)

    @cached_property
    def last(self) -> EphemerisData:
        """The last instant alone."""
        return self.chunk(self.count - 1, self.count)

    @property
    def is_one_chunk(self) -> bool:
        """Whether all instants are one chunk."""
        return self.count <= CHUNK_INSTANTS

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Batch dimensions, then those of the instants."""
        first = self.first
        if not first.instants.shape:
            return first.shape
        return (*first.batch_shape, self.count, *first.instants.shape[1:])

    @property
    def is_list(self) -> bool:
        """Whether this is one body at a list of instants, all that most formats hold."""
        return len(self.shape) == 1 and not self.first.batch_shape

    def ephemeris(self) -> EphemerisData:
        """All instants as one EphemerisData."""
        return self.chunk(0, self.count)

    def chunks(self, step: int = 0, steps: int = 1) -> Iterator[EphemerisData]:
        """Chunks in order; a writer that reads them several times reports progress as `step` of `steps`."""
        for first in range(0, self.count, CHUNK_INSTANTS):
            stopping.check()
            last = min(first + CHUNK_INSTANTS, self.count)
            yield self.chunk(first, last)
            self.progress((step + last / self.count) / steps)

    def transformed(self, transform: Callable[[EphemerisData], EphemerisData]) -> Samples:
        """The same samples, with `transform` applied to each chunk."""
        return Samples(
            self.count,
            lambda first, last: transform(self.chunk(first, last)),
            self.progress,
            self.instants,
            self.in_memory,
        )

    def least_and_greatest(self) -> tuple[Samples, Samples]:
        """The least and the greatest instant, each as Samples: a format that can hold both can hold all."""
        least, greatest = self.extremes.least_index, self.extremes.greatest_index
        return (
            Samples(1, lambda first, last: self.chunk(least + first, least + last)),
            Samples(1, lambda first, last: self.chunk(greatest + first, greatest + last)),
        )

    @cached_property
    def extremes(self) -> Extremes:
        """The least and the greatest instant, in whatever order they are, found in one pass."""
        least, greatest = (math.inf, 0), (-math.inf, 0)
        for first in range(0, self.count, CHUNK_INSTANTS):
            stopping.check()
            chunk = self.instants(first, min(first + CHUNK_INSTANTS, self.count))
            seconds = chunk.seconds.reshape(-1)
            row_size = max(1, math.prod(chunk.shape[1:]))
            low, high = int(seconds.argmin()), int(seconds.argmax())
            least = min(least, (float(seconds[low]), first + low // row_size))
            greatest = max(greatest, (float(seconds[high]), first + high // row_size))
        return Extremes(least[0], greatest[0], least[1], greatest[1])
