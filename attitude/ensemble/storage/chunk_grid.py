"""The regular grid of chunks that bodies x instants are stored in; a task computes and writes one chunk."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, overload

from ...errors import InputError, whole_number

SAMPLE_BYTES = 7 * 8  # a quaternion and a rate
DEFAULT_CHUNK_BYTES = 2**25  # 32 MiB: a few of these for each thread are far below a gigabyte
MAX_CHUNK_BYTES = 2**30


class Chunk(NamedTuple):
    """Bodies from `first` to `last`, instants from `start` to `stop`, ends excluded."""

    number: int
    first: int
    last: int
    start: int
    stop: int


@dataclass(frozen=True)
class ChunkGrid(Sequence[Chunk]):
    """All chunks of so many bodies at so many instants; those of the same bodies follow each other."""

    bodies: int
    instants: int
    chunk_bodies: int
    chunk_instants: int

    @property
    def columns(self) -> int:
        """Chunks along the instants."""
        return -(-self.instants // self.chunk_instants)

    @property
    def shape(self) -> list[int]:
        """Bodies and instants of a chunk."""
        return [self.chunk_bodies, self.chunk_instants]

    def __len__(self) -> int:
        return -(-self.bodies // self.chunk_bodies) * self.columns

    @overload
    def __getitem__(self, number: int) -> Chunk: ...
    @overload
    def __getitem__(self, number: slice) -> Sequence[Chunk]: ...
    def __getitem__(self, number: int | slice) -> Chunk | Sequence[Chunk]:
        if isinstance(number, slice):
            return [self[i] for i in range(*number.indices(len(self)))]
        if not 0 <= number < len(self):
            raise IndexError(number)
        row, column = divmod(number, self.columns)
        first, start = row * self.chunk_bodies, column * self.chunk_instants
        last = min(first + self.chunk_bodies, self.bodies)
        return Chunk(number, first, last, start, min(start + self.chunk_instants, self.instants))

    def of_bodies(self, first: int, last: int) -> range:
        """Numbers of the chunks that hold bodies from first to last."""
        return range(first // self.chunk_bodies * self.columns, -(-last // self.chunk_bodies) * self.columns)


def chunk_grid(
    bodies: int, instants: int, chunk_bodies: int | None = None, all_instants: bool = False
) -> ChunkGrid:
    """Return a grid of chunks of `chunk_bodies`; by default 4096, or fewer where there are many instants.

    Instants are divided too where those of so many bodies would be more than 1 GiB (by default: those of
    one body more than 32 MiB), unless a chunk has to hold `all_instants`.

    Raises InputError where `chunk_bodies` is not a whole number, at least 1, or a chunk would be more than
    1 GiB.
    """
    if chunk_bodies is None:
        chunk_bodies, max_bytes = 4096, DEFAULT_CHUNK_BYTES
        while chunk_bodies > 1 and chunk_bodies * instants * SAMPLE_BYTES > max_bytes:
            chunk_bodies //= 2
    else:
        chunk_bodies = whole_number(chunk_bodies, "chunk", "a whole number of bodies")
        max_bytes = MAX_CHUNK_BYTES
    chunk_bodies = min(chunk_bodies, bodies)
    body_bytes = (instants if all_instants else 1) * SAMPLE_BYTES
    if body_bytes > MAX_CHUNK_BYTES:
        limit = MAX_CHUNK_BYTES // SAMPLE_BYTES
        raise InputError("times", f"{instants} instants", f"at most {limit} of bodies that effects turn")
    if chunk_bodies * body_bytes > MAX_CHUNK_BYTES:
        limit = MAX_CHUNK_BYTES // body_bytes
        raise InputError("chunk", chunk_bodies, f"at most {limit} bodies (1 GiB of numbers)")
    if all_instants:
        return ChunkGrid(bodies, instants, chunk_bodies, instants)
    chunk_instants = max(1, min(instants, max_bytes // (SAMPLE_BYTES * chunk_bodies)))
    return ChunkGrid(bodies, instants, chunk_bodies, chunk_instants)
