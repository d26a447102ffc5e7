"""How bodies x instants are cut into chunks: a task computes one of them and stores it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, overload

from ...errors import InputError

SAMPLE = 7 * 8  # bytes: a quaternion and a rate
USUAL_BODIES = 4096
USUAL_BYTES = 2**25  # 32 MiB: a few of these for each thread are far below a gigabyte
MOST_BYTES = 2**30


class Part(NamedTuple):
    """One chunk: bodies from `first` to `last`, instants from `start` to `stop`, ends excluded."""

    number: int
    first: int
    last: int
    start: int
    stop: int


@dataclass(frozen=True)
class Chunks(Sequence[Part]):
    """All parts of so many bodies at so many instants; those of the same bodies follow each other."""

    bodies: int
    instants: int
    bodies_at_once: int
    instants_at_once: int

    @property
    def columns(self) -> int:
        """Chunks along the instants."""
        return -(-self.instants // self.instants_at_once)

    @property
    def shape(self) -> list[int]:
        return [self.bodies_at_once, self.instants_at_once]

    def __len__(self) -> int:
        return -(-self.bodies // self.bodies_at_once) * self.columns

    @overload
    def __getitem__(self, number: int) -> Part: ...
    @overload
    def __getitem__(self, number: slice) -> Sequence[Part]: ...
    def __getitem__(self, number: int | slice) -> Part | Sequence[Part]:
        if isinstance(number, slice):
            return [self[i] for i in range(*number.indices(len(self)))]
        if not 0 <= number < len(self):
            raise IndexError(number)
        row, column = divmod(number, self.columns)
        first, start = row * self.bodies_at_once, column * self.instants_at_once
        last = min(first + self.bodies_at_once, self.bodies)
        return Part(number, first, last, start, min(start + self.instants_at_once, self.instants))


def chunked(bodies: int, instants: int, at_once: int | None = None, together: bool = False) -> Chunks:
    """In chunks of `at_once` bodies; by default of 4096, or fewer where there are many instants.

    Instants are cut too where those of so many bodies would be more than 1 GiB (by default: those of
    one body more than 32 MiB), unless they are to stay `together`.

    Raises InputError where `at_once` is not a whole number, at least 1, or a chunk would be more than 1 GiB.
    """
    if at_once is None:
        at_once, room = USUAL_BODIES, USUAL_BYTES
        while at_once > 1 and at_once * instants * SAMPLE > room:
            at_once //= 2
    elif isinstance(at_once, bool) or not isinstance(at_once, int) or at_once < 1:
        raise InputError("chunk", at_once, "a whole number of bodies, at least 1")
    else:
        room = MOST_BYTES
    at_once = min(at_once, bodies)
    least = (instants if together else 1) * SAMPLE
    if least > MOST_BYTES:
        most = MOST_BYTES // SAMPLE
        raise InputError("times", f"{instants} instants", f"at most {most} of bodies that effects turn")
    if at_once * least > MOST_BYTES:
        raise InputError("chunk", at_once, f"at most {MOST_BYTES // least} bodies (1 GiB of numbers)")
    cut = instants if together else max(1, min(instants, room // (SAMPLE * at_once)))
    return Chunks(bodies, instants, at_once, cut)
