"""The solver of scenes with torques: Gauss's collocation (docs/torques.md, section 3)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from .. import stopping
from ..kernels.gauss_legendre import gauss_scheme
from ..kernels.layout import HALF, NODES, ROWS_PER_EFFECT, STEPPED, StepRow
from ..problem.torque_model import CachedTorque
from ..runtime import compiled
from .solver_arguments import SolverArguments

NAME, ORDER = "gauss, order 32", 2 * NODES
OUTPUTS = 10  # attitude (4), rate (3), momentum (3)
STRIDE = 1.2  # steps of the coarser solution over those of the answer
LEAST_DECAY = 1e-15  # below which coefficients are rounding
# Steps of every arc: of six, the coarser solution's, one less, are not much longer.
MIN_STEPS = 6


class StepSetting(NamedTuple):
    """How finely bodies are stepped.

    Attributes
    ----------
    step : (n,) s, the longest that is asked for
    decay : (n,), what a step may be off by: sweeps end at a part of it, and a step is halved where torques
        break and its last Legendre coefficients are greater
    dense : whether instants within a step are read off its polynomial, else reached by the step, shortened;
        (n,), or for all bodies
    coarsely : in fewer steps, for the error's estimate; (n,), or for all; dense_coarsely : `dense` then
    momentum : (n,) N m s, for which the step is meant: one of a body that torques have spun up far beyond it
        is halved
    min_steps : (n,), of every arc, however short; at least 3, since of 2 steps the coarser solution's one is
        their double
    """

    step: np.ndarray
    decay: np.ndarray
    dense: bool | np.ndarray = False
    coarsely: bool | np.ndarray = False
    momentum: np.ndarray | float = np.inf
    dense_coarsely: bool = False
    min_steps: np.ndarray | float = 3


class SolverTask(NamedTuple):
    """Some bodies of a block, to be stepped over a span.

    Attributes
    ----------
    arguments : of the whole block, n; which : (k,), indices of the bodies to step
    states : (n, StepState.WIDTH), at the start; changed into those at the end
    start, stop : s; instants : (2, m), two-part, within, in that direction
    setting : StepSetting
    out : (n, OUTPUTS, m), written
    max_steps : after so many a body is given up
    """

    arguments: SolverArguments
    which: np.ndarray
    states: np.ndarray
    start: float
    stop: float
    instants: np.ndarray
    setting: StepSetting
    out: np.ndarray
    max_steps: float = 1e8

    def records(self) -> np.ndarray:
        """(k,) records of STEPPED: the bodies of a task, with the steps that their settings ask for."""
        which, setting = self.which, self.setting

        def own(value: Any) -> Any:
            return value[which] if isinstance(value, np.ndarray) else value

        coarsely = own(setting.coarsely)
        records = np.zeros(len(which), STEPPED)
        records["index"], records["state"] = which, self.states[which]
        records["body"] = self.arguments.body[which]
        records["symmetric"] = self.arguments.symmetric[which]
        records["max_steps"], records["dense"] = self.max_steps, own(setting.dense)
        # none longer than asked for; 0.3 keeps the coarser ones, of few, at 1.17 to 1.5 times the length
        length = abs(self.stop - self.start)
        steps = np.maximum(length / setting.step[which], own(setting.min_steps)) * (1.0 - 1e-12)
        steps = np.ceil(np.minimum(steps, 2.0**62))
        records["steps"] = steps = np.where(coarsely, steps / STRIDE + 0.3, steps).astype(np.int64)
        # the momentum may grow by half before steps are halved; s N m s
        records["reach"] = 1.5 * (max(length, 1e-300) / steps) * own(setting.momentum)
        decay, symmetric = setting.decay[which], records["symmetric"] != 0
        # Sweeps end when the next would change the attitude by less than rounding, of a symmetric body, whose
        # rate is carried; of others than rounding, which their rate remembers, or 1e-5 of `decay`.
        change = np.maximum(1e-5 * decay, 1e-19)
        records["aim"] = np.where(symmetric, 1e-17, change)
        # The finer solution makes one sweep more: what the sweeps of the coarser one leave is in their
        # difference then, and not by chance the same in both.
        records["after"] = np.where(symmetric | coarsely | (change <= 1e-19), 0, 1)
        records["decay"] = np.maximum(decay * np.where(coarsely, 10.0, 1.0), LEAST_DECAY)
        if self.arguments.is_smooth:
            records["decay"] = np.inf
        return records


class SolverWork(NamedTuple):
    """Work of the solver, (k,) each: steps, sweeps made in them, and failures.

    edges : rad/s, uncertainty of the rate from edges of plates that were missed
    """

    steps: np.ndarray
    sweeps: np.ndarray
    failed: np.ndarray
    edges: np.ndarray | float = 0.0


def take_steps(task: SolverTask, torques: Sequence[CachedTorque]) -> SolverWork:
    """Step the bodies of a task; raises what a user's function raised while stepping, and Stopped."""
    records, arguments = task.records(), task.arguments
    rows = StepRow.EFFECTS + ROWS_PER_EFFECT * arguments.effects.shape[1]
    work = workspace(rows * NODES, scheme())
    span, flag = np.array([task.start, task.stop]), stopping.current().flag
    orbit = arguments.surroundings[:2]
    try:
        compiled.collocate(records, span, task.instants, task.out, work, flag, arguments.effects, *orbit)
        stopping.current().check()
    finally:
        for torque in torques:
            torque.raise_failure()
    task.states[task.which] = records["state"]
    sweeps, failed, pieces = records["counts"].astype(np.int64).T
    return SolverWork(pieces, sweeps, failed)


def workspace(numbers: int, scheme: np.ndarray) -> np.ndarray:
    """(numbers,) for a kernel, the scheme first; its vectors do not reach over lines of the cache."""
    spare = np.zeros(numbers + 7)
    first = -(spare.ctypes.data // 8) % 8
    work = spare[first : first + numbers]
    work[: scheme.size] = scheme
    return work


@cache
def scheme() -> np.ndarray:
    """(StepRow.EFFECTS * NODES,): the collocation's workspace with Gauss's scheme in its rows.

    Each node of the first half is followed, half the nodes later, by the one that mirrors it.
    """
    half, numbers = HALF, np.arange(NODES)
    mirrored = np.concatenate([numbers[:half], numbers[:half][::-1] + half])
    gauss = gauss_scheme(NODES)
    to_coefficients = gauss.to_coefficients[mirrored]
    matrix = (to_coefficients @ gauss.integrals[:, mirrored])[:, :half]
    work = np.zeros((StepRow.EFFECTS, NODES))
    work[StepRow.NODE], work[StepRow.WEIGHT] = 0.5 * (1.0 + gauss.nodes[mirrored]), gauss.weights[mirrored]
    work[StepRow.MATRIX : StepRow.MATRIX + half, :half] = 0.5 * (matrix[:half] + matrix[half:])
    work[StepRow.MATRIX : StepRow.MATRIX + half, half:] = 0.5 * (matrix[:half] - matrix[half:])
    work[StepRow.LEGENDRE : StepRow.LEGENDRE + NODES] = to_coefficients
    work.flags.writeable = False
    return work.reshape(-1)
