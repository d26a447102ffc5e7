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
COARSER_DECAY = 10.0  # the same of what a step may be off by
LEAST_DECAY = 1e-15  # below which coefficients are rounding
# Sweeps end when the next would change the attitude by less: rounding of a symmetric body, whose rate is
# carried; of others this part of what a step may be off by, or rounding, which their rate remembers.
LEAST_CHANGE_SYMMETRIC, SHARE_OF_SWEEPS, LEAST_CHANGE = 1e-17, 1e-5, 1e-19
# Sweeps that the finer solution makes besides: what the coarser one's leave is in their difference then, and
# not by chance the same in both.
SWEEPS_AFTER = 1
SPUN_UP = 1.5  # growth of the momentum that steps take without being halved
MAX_STEPS = 1e8
# Steps of every arc: of three, two coarser ones are not the halves of one another; of six, which the library
# takes, the coarser solution's, one less, are not much longer.
FEWEST_STEPS, MIN_STEPS = 3, 6


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
    min_steps : (n,), of every arc, however short
    """

    step: np.ndarray
    decay: np.ndarray
    dense: bool | np.ndarray = False
    coarsely: bool | np.ndarray = False
    momentum: np.ndarray | float = np.inf
    dense_coarsely: bool = False
    min_steps: np.ndarray | float = FEWEST_STEPS


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
    max_steps: float = MAX_STEPS


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
    records, arguments = _records(task), task.arguments
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


def _records(task: SolverTask) -> np.ndarray:
    """(k,) records of STEPPED: the bodies of a task, with the steps that their settings ask for."""
    which, setting = task.which, task.setting

    def own(value: Any) -> Any:
        return value[which] if isinstance(value, np.ndarray) else value

    coarsely = own(setting.coarsely)
    records = np.zeros(len(which), STEPPED)
    records["index"], records["state"] = which, task.states[which]
    records["body"] = task.arguments.body[which]
    records["symmetric"] = task.arguments.symmetric[which]
    records["max_steps"], records["dense"] = task.max_steps, own(setting.dense)
    # none longer than asked for; 0.3 keeps the coarser ones, of few, at 1.17 to 1.5 times the length
    length = abs(task.stop - task.start)
    steps = np.maximum(length / setting.step[which], own(setting.min_steps)) * (1.0 - 1e-12)
    steps = np.ceil(np.minimum(steps, 2.0**62))
    records["steps"] = steps = np.where(coarsely, steps / STRIDE + 0.3, steps).astype(np.int64)
    records["reach"] = SPUN_UP * (max(length, 1e-300) / steps) * own(setting.momentum)  # s N m s
    decay = setting.decay[which]
    change = np.maximum(SHARE_OF_SWEEPS * decay, LEAST_CHANGE)
    symmetric = records["symmetric"] != 0
    records["aim"] = np.where(symmetric, LEAST_CHANGE_SYMMETRIC, change)
    records["after"] = np.where(symmetric | coarsely | (change <= LEAST_CHANGE), 0, SWEEPS_AFTER)
    records["decay"] = np.maximum(decay * np.where(coarsely, COARSER_DECAY, 1.0), LEAST_DECAY)
    if task.arguments.is_smooth:
        records["decay"] = np.inf
    return records


def vector_lengths(vectors: np.ndarray) -> np.ndarray:
    """(n,), of (n, 3): sums are written out, for the same bits whatever n is."""
    x, y, z = (vectors * vectors).T
    length: np.ndarray = np.sqrt((x + y) + z)
    return length


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
