"""Sums over bodies from which statistics follow; nothing of the motion is stored.

A block is a fixed range of body indices: its sums are made in their order, and become whole numbers, which
are added without rounding.  So no bit depends on how bodies are divided into tasks, or on the order of these.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..kernels.layout import BODIES_PER_BLOCK, LIMB_BITS, LIMB_FIRST, REGIMES, ROW_STRIDE
from ..motion import TorqueFreeMotion
from ..rigid_body.error_bounds import max_phase_rate, refuse_too_far
from ..runtime import compiled
from ..scene.scene import Scene
from ..times.instants import Instants
from .block_motion import body_named, free_motion, is_free, motion_of, regimes
from .sources.states import States, StateSource

CACHED_SAMPLES = 2**14  # of closed forms, 512 KiB, that stay in a processor's cache until they are added
BATCH_BODIES = 16 * BODIES_PER_BLOCK  # 4096, whose constants take 3 MiB
MAX_SIMULATED_SAMPLES = 2**20  # 56 MiB

Range = tuple[int, int]
# By block of bodies: the number of a range of instants, and quaternions (4, n, k) at them.
BlockSamples = Callable[[Range], Iterator[tuple[int, np.ndarray]]]


def ranges(length: int, size: int) -> list[Range]:
    """(first, last) of ranges of that size, the last one of what remains."""
    return [(first, min(first + size, length)) for first in range(0, length, size)]


class MomentSums:
    """Whole-number sums over bodies of the products of quaternion components.

    limbs : one (3, 10, k) for each ROW_STRIDE instants, int64
    regimes : (4,), bodies in each of `REGIMES`
    lost : indices of bodies that are not in the sums
    """

    def __init__(self, instants: int):
        self.limbs = [np.zeros((3, 10, b - a), np.int64) for a, b in ranges(instants, ROW_STRIDE)]
        self.regimes = np.zeros(len(REGIMES), np.int64)
        self.lost: list[int] = []

    def add(self, other: MomentSums) -> None:
        """Add the sums over other bodies at the same instants, exactly."""
        for own, others in zip(self.limbs, other.limbs, strict=True):
            np.add(own, others, out=own)
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
class MomentAccumulation:
    """The work of a task: called with (first, last), whole blocks of bodies, it gives their `MomentSums`.

    source : of states; scene : whose effects act, or None; choice : of the solver
    instants : (m,)
    reference : (m, 4), wxyz: attitudes near which most are, so that small differences keep their digits
    leave_out : bodies that cannot be integrated, instead of raising an error
    """

    source: StateSource
    scene: Scene | None
    choice: Any
    instants: Instants
    reference: np.ndarray
    leave_out: bool = False

    def __call__(self, bodies: Range) -> MomentSums:
        """Return the sums over bodies from first to last."""
        total, (begin, end) = MomentSums(len(self.instants.seconds)), bodies
        for first in range(begin, end, BATCH_BODIES):
            self._add(total, first, min(first + BATCH_BODIES, end))
        return total

    @property
    def _instant_ranges(self) -> list[Range]:
        return ranges(len(self.instants.seconds), ROW_STRIDE)

    def _add(self, total: MomentSums, first: int, last: int) -> None:
        states = self.source.part(first, last)
        motion = free_motion(states, first)
        total.regimes += np.bincount(regimes(motion), minlength=len(REGIMES))
        if is_free(self.scene):
            samples = self._free(motion, first)
        else:
            samples = self._simulated(states, first, total.lost)
        references = [np.zeros((4, ROW_STRIDE)) for _ in self._instant_ranges]
        for rows, (a, b) in zip(references, self._instant_ranges, strict=True):
            rows[:, : b - a] = self.reference[a:b].T
        sums = [np.zeros(10 * ROW_STRIDE) for _ in references]
        for block in ranges(last - first, BODIES_PER_BLOCK):
            for number, quaternions in samples(block):
                compiled.accumulate(quaternions, references[number].reshape(-1), sums[number])
            for block_sums, limbs in zip(sums, total.limbs, strict=True):
                compiled.add_exactly(block_sums, limbs)

    def _free(self, motion: TorqueFreeMotion, index: int) -> BlockSamples:
        batch, seconds, rest = motion._batch, self.instants.seconds, self.instants.seconds_low
        with body_named(index):
            ((_, records),) = batch.blocks(0, batch.size)  # few enough to be cached
        refuse_too_far(max_phase_rate(records), float(np.abs(seconds).max()))
        parts = [(seconds[a:b], None if rest is None else rest[a:b]) for a, b in self._instant_ranges]

        def samples(block: Range) -> Iterator[tuple[int, np.ndarray]]:
            for number, (high, low) in enumerate(parts):
                size = max(CACHED_SAMPLES // len(high), 1)
                for first in range(*block, size):
                    bodies = records[first : min(first + size, block[1])]
                    out = np.empty((4, len(bodies), len(high)))
                    compiled.sample(bodies, high, low, out, None, 0, 0, len(high))
                    yield number, out

        return samples

    def _simulated(self, states: States, index: int, lost: list[int]) -> BlockSamples:
        size = max(MAX_SIMULATED_SAMPLES // len(self.instants.seconds), 1)

        def samples(block: Range) -> Iterator[tuple[int, np.ndarray]]:
            for first in range(*block, size):
                part = states[first : min(first + size, block[1])]
                motion = motion_of(
                    self.scene, part, self.instants, index + first, False, self.choice, self.leave_out
                )
                lost.extend(motion.lost)
                for number, (a, b) in enumerate(self._instant_ranges):
                    yield number, np.ascontiguousarray(np.moveaxis(motion.quaternion[:, a:b], -1, 0))

        return samples
