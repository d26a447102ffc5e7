"""An ensemble of which no more is known than how many bodies it has and how they are at the epoch."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from attitude import RigidBody
from attitude.ensemble.sources.states import States
from attitude.times.instants import as_instants


@dataclass(frozen=True)
class Drawn:
    """A source: a few numbers, and every body made of them and its own index."""

    size: int
    seed: int = 7

    def part(self, first: int, last: int) -> States:
        index = np.arange(first, last) + 0.1 * self.seed
        moments = 1.0 + np.stack([0.1 * np.sin(index), 0.5 + 0.1 * np.cos(index), np.ones(last - first)], -1)
        rate = np.stack([0.3 * np.sin(3.0 * index), np.cos(index), np.full(last - first, 0.2)], -1)
        attitude = np.broadcast_to([1.0, 0.0, 0.0, 0.0], (last - first, 4))
        return States(RigidBody.from_moments(moments), attitude, rate)

    def identity(self):
        return {"seed": self.seed}


@dataclass(frozen=True)
class Many:
    source: Any
    scene: Any = None
    frame: str = "ICRF"

    @property
    def size(self) -> int:
        return self.source.size

    def instants(self, times):
        return as_instants(times, None)


def many(size: int, seed: int = 7) -> Many:
    return Many(Drawn(size, seed))


class Stop(Exception):  # noqa: N818
    """Of a person, half-way."""


def stop_at(fraction: float):
    """Progress that is stopped at this fraction."""

    def progress(done: float) -> None:
        if done >= fraction:
            raise Stop

    return progress
