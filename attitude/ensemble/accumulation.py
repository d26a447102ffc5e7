"""Sums over bodies, leaf by leaf, from which statistics follow; nothing of the motion is kept.

A leaf is a fixed range of body indices: its sums are made in their order, and become whole numbers, which
are added without rounding.  So no bit depends on how bodies are cut into tasks, or on who is ready first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..kernels.layout import LEAF, LIMB_BITS, LIMB_FIRST, PITCH, REGIMES
from ..motion import TorqueFreeMotion
from ..rigid_body.phase_limit import refuse_too_far
from ..runtime import compiled
from ..scene.document import Scene
from ..times.instants import Instants
from .motion import Block, free_motion, is_free, motion_of, naming, regimes
from .sources.states import Source, States

AT_ONCE = 2**14  # samples of closed forms, 512 KiB, that stay in a processor's cache until they are added
BLOCK = 16 * LEAF  # bodies, 4096, whose constants take 3 MiB
HELD = 2**20  # samples of simulated bodies, 56 MiB

Cut = tuple[int, int]


def cuts(length: int, size: int) -> list[Cut]:
    """(first, last) of parts of so many, the last one of what is left."""
    return [(first, min(first + size, length)) for first in range(0, length, size)]


class Sums:
    """Whole-number sums over bodies.

    limbs : one (3, 10, k) for each PITCH instants, int64
    regimes : (4,), bodies in each of `REGIMES`
    lost : places of bodies that are not in the sums
    """

    def __init__(self, instants: int):
        self.limbs = [np.zeros((3, 10, b - a), np.int64) for a, b in cuts(instants, PITCH)]
        self.regimes = np.zeros(len(REGIMES), np.int64)
        self.lost: list[int] = []

    def add(self, other: Sums) -> None:
        for ours, theirs in zip(self.limbs, other.limbs, strict=True):
            ours += theirs
        self.regimes += other.regimes
        self.lost += other.lost

    def products(self) -> np.ndarray:
        """(m, 4, 4): mean over bodies of p p^T, p = conj(reference) q, of trace one."""
        limbs = np.concatenate(self.limbs, axis=-1).astype(np.float64)
        scales = [2.0 ** -(LIMB_FIRST + i * LIMB_BITS) for i in range(3)]
        total = (limbs[2] * scales[2] + limbs[1] * scales[1]) + limbs[0] * scales[0]
        out = np.empty((total.shape[1], 4, 4))
        for row, i, j in zip(total, *np.triu_indices(4), strict=True):
            out[:, i, j] = out[:, j, i] = row
        return out / np.trace(out, axis1=1, axis2=2)[:, None, None]


@dataclass(frozen=True)
class Gathering:
    """The work of a task: called with (first, last), leaves of bodies, it gives their `Sums`.

    source : of states; scene : whose effects act, or None; choice : of a solver
    seconds, rest : (m,), s, two-part instants
    reference : (m, 4), wxyz: attitudes near which most are, so that what is small is summed as such
    leave_out : bodies that cannot be followed, instead of stopping at them
    """

    source: Source
    scene: Scene | None
    choice: Any
    seconds: np.ndarray
    rest: np.ndarray | None
    reference: np.ndarray
    leave_out: bool = False

    def __call__(self, part: Cut) -> Sums:
        total, (begin, end) = Sums(len(self.seconds)), part
        for first in range(begin, end, BLOCK):
            self._add(total, first, min(first + BLOCK, end))
        return total

    def _add(self, total: Sums, first: int, last: int) -> None:
        states = self.source.part(first, last)
        motion = free_motion(states, first)
        found = regimes(motion)
        total.regimes += np.bincount(found, minlength=len(REGIMES))
        if is_free(self.scene):
            pieces = self._free(motion, first)
        else:
            pieces = self._simulated(states, first, total.lost)
        references = [self._rows(cut) for cut in self._cuts()]
        sums = [np.zeros(10 * PITCH) for _ in references]
        for leaf in cuts(last - first, LEAF):
            for which, quaternions in pieces(leaf):
                compiled.gather(quaternions, references[which], sums[which])
            for one, limbs in zip(sums, total.limbs, strict=True):
                compiled.settle(one, limbs)

    def _cuts(self) -> list[Cut]:
        return cuts(len(self.seconds), PITCH)

    def _rows(self, cut: Cut) -> np.ndarray:
        rows = np.zeros((4, PITCH))
        rows[:, : cut[1] - cut[0]] = self.reference[slice(*cut)].T
        return rows.reshape(-1)

    def _free(
        self, motion: TorqueFreeMotion, index: int
    ) -> Callable[[Cut], Iterator[tuple[int, np.ndarray]]]:
        """By leaf: (which cut of the instants, quaternions (4, n, k)), bodies in order for each cut."""
        batch, farthest = motion._batch, float(np.abs(self.seconds).max())
        with naming(index):
            ((_, records),) = batch.blocks(0, batch.size)  # a task's are kept
        refuse_too_far(batch.max_phase_rate(records), farthest)
        parts = [(self.seconds[a:b], None if self.rest is None else self.rest[a:b]) for a, b in self._cuts()]

        def pieces(leaf: Cut) -> Iterator[tuple[int, np.ndarray]]:
            for which, (seconds, rest) in enumerate(parts):
                size = max(AT_ONCE // len(seconds), 1)
                for first in range(*leaf, size):
                    bodies = records[first : min(first + size, leaf[1])]
                    out = np.empty((4, len(bodies), len(seconds)))
                    compiled.sample(bodies, seconds, rest, out, None, None, 0, 0, len(seconds))
                    yield which, out

        return pieces

    def _simulated(
        self, states: States, index: int, lost: list[int]
    ) -> Callable[[Cut], Iterator[tuple[int, np.ndarray]]]:
        instants = Instants(self.seconds, self.rest, None)
        size = max(HELD // len(self.seconds), 1)

        def pieces(leaf: Cut) -> Iterator[tuple[int, np.ndarray]]:
            for first in range(*leaf, size):
                part = slice(first, min(first + size, leaf[1]))
                block: Block = motion_of(
                    self.scene, states[part], instants, index + first, False, self.choice, self.leave_out
                )
                lost.extend(block.lost)
                for which, (a, b) in enumerate(self._cuts()):
                    yield which, np.ascontiguousarray(np.moveaxis(block.quaternion[:, a:b], -1, 0))

        return pieces
