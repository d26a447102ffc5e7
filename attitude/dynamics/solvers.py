"""The solvers of scenes with torques: each steps a block of bodies over a span and writes their states.

Chosen settings are steps (s) for splitting and collocation, the error of a step (rad) for Runge-Kutta.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import NamedTuple

import numpy as np

from .. import stopping
from ..errors import ToleranceError
from ..kernels import layout
from ..problem.initial_state import InitialState
from ..problem.torque_model import CachedTorque
from ..runtime import compiled
from . import schemes
from .batch_states import Bodies
from .solver_arguments import SolverArguments, ascending, most_symmetric

OUTPUTS = 10  # attitude (4), rate (3), momentum (3)
STRIDE = 1.5  # steps of the coarser solution over those of the answer
# Collocation in steps so long that the two differ by more than this (rad) is far from its order; splitting
# in steps of more than so many radians meets resonances, where a finer solution may be the worse one.
MAX_DIFFERENCE_OF_ORDER, MAX_RADIANS_OF_ORDER = 1e-6, 1.0
MAX_STEPS = 1e8


class SolverSpan(NamedTuple):
    """From start to stop (s), with the two-part instants (2, m) within, in that direction.

    With `coarsely`, in two thirds of the steps, or with ten times the tolerance: for the error's estimate.
    After `max_steps` a solver that chooses its own gives up.
    """

    start: float
    stop: float
    instants: np.ndarray
    coarsely: bool = False
    max_steps: float = MAX_STEPS


class SolverTask(NamedTuple):
    """Some bodies of a block, to be stepped over a span.

    Attributes
    ----------
    arguments : of the whole block, n; which : (k,), indices of the bodies to step
    states : (n, STATE), at the start; changed into those at the end
    settings : (n,)
    out : (n, OUTPUTS, m), written
    """

    arguments: SolverArguments
    which: np.ndarray
    states: np.ndarray
    span: SolverSpan
    settings: np.ndarray
    out: np.ndarray


class SolverWork(NamedTuple):
    """Work of a solver, (k,) each: steps, torques computed, and steps that did not reach their exactness."""

    steps: np.ndarray
    torques: np.ndarray
    failed: np.ndarray


@dataclass(frozen=True)
class Solver:
    """A numerical method.

    Attributes
    ----------
    name : as documents and plans have it
    order : of the error in the step, as far as it is known beforehand; for `dop853`, 1: in the tolerance
    stages : kicks of a step of splitting, else 0
    prepare : (template, bodies, torques) -> SolverArguments, with axes as it needs them
    step : the compiled solver
    """

    name: str
    order: int
    stages: int
    prepare: Callable[[InitialState, Bodies, Sequence[CachedTorque]], SolverArguments]
    step: Callable[[SolverTask], SolverWork]

    @property
    def coarser(self) -> float:
        """What the setting is multiplied by for the solution that the answer is compared with."""
        return 10.0 if self.kind == "dop853" else STRIDE

    @property
    def kind(self) -> str:
        """Kind of solver: "splitting", "gauss" or "dop853"."""
        return self.name.split(",")[0]

    def gain(self, smooth: bool, difference: np.ndarray | float, stride: np.ndarray | float) -> np.ndarray:
        """By what factor, at least, the answer is better than the coarser solution.

        difference : rad, of the two; stride : rad, of a step; (...) each

        Half of what order 8, or a splitting's own, would gain, unless steps are so long that no order is
        what it will be.  Where torques break within steps, errors are of any sign and size from step to
        step, and the two may agree by chance: then less than one.
        """
        if not smooth:
            return np.asarray(0.1)
        if self.kind == "dop853":
            return np.asarray(1.0)
        if self.kind == "gauss":
            return np.where(np.asarray(difference) > MAX_DIFFERENCE_OF_ORDER, 4.0, 12.0)
        full = max(1.0, 0.5 * (self.coarser**self.order - 1.0))
        return np.where(np.asarray(stride) > MAX_RADIANS_OF_ORDER, 0.3, full)

    def integrate(self, task: SolverTask, torques: Sequence[CachedTorque]) -> SolverWork:
        """Step the bodies of a task; raises what a user's function raised while stepping, and Stopped."""
        try:
            work = self.step(task)
            stopping.current().check()
            return work
        finally:
            for torque in torques:
                torque.raise_failure()


def can_take(solver: Solver, arguments: SolverArguments) -> np.ndarray:
    """(n,): whether a solver's error has the order it is said to have, for each body.

    Splitting freezes the attitude under the torque: what depends on the rate otherwise than linearly, or
    turns the body besides, is not for it; and of its schemes those for two parts are not for three.
    """
    if solver.kind != "splitting":
        return np.ones(len(arguments.body), np.bool_)
    if layout.USER in arguments.codes:
        return np.zeros(len(arguments.body), np.bool_)
    able = ~arguments.has_dissipation
    if "(" in solver.name:
        eddies = arguments.body[:, layout.EDDIES :].any(axis=1)
        has_torque = eddies | (arguments.effects.shape[1] > 0)
        able &= ~(arguments.has_rotors & ~arguments.symmetric & has_torque)
    return able


def endless_steps(setting: float) -> ToleranceError:
    """The error of a scene whose steps shrink to nothing under `dop853`, at a tolerance of a step, rad."""
    return ToleranceError(
        "tolerance: dop853 needs steps without end; the torque is not continuous, or not finite, or far "
        f"too great for the body, or an error of {setting:.1g} rad a step is more than a double can keep"
    )


# -- the compiled solvers -----------------------------------------------------------------------------


def _collocate(task: SolverTask) -> SolverWork:
    records = _records(task)
    compiled.collocate(records, *_arguments(task, schemes.gauss().copy()))
    task.states[task.which] = records["state"]
    sweeps, failed, _ = records["counts"].astype(np.int64).T
    return SolverWork(records["steps"], sweeps * layout.NODES, failed)


def _split(composition: schemes.Composition, task: SolverTask) -> SolverWork:
    records = _records(task)
    scheme = np.stack([composition.drifts, np.append(composition.kicks, 0.0)])
    span, *others = _arguments(task, np.empty((6, layout.NODES)))
    compiled.split(records, span, scheme, *others)
    task.states[task.which] = records["state"]
    steps = records["steps"]
    return SolverWork(steps, steps * len(composition.kicks), np.zeros_like(steps))


def _runge_kutta(task: SolverTask) -> SolverWork:
    records = _records(task)
    span, *others = _arguments(task, np.empty(13 * 7))
    compiled.dormand_prince(records, span, dormand_prince_table(), *others)
    task.states[task.which] = records["state"]
    accepted, refused, failed = records["counts"].astype(np.int64).T
    return SolverWork(accepted, 12 * (accepted + refused), failed)


def _records(task: SolverTask) -> np.ndarray:
    """(k,) records of STEPPED: the bodies of a task, with the steps that their settings ask for."""
    span, settings = task.span, task.settings[task.which]
    records = np.zeros(len(task.which), layout.STEPPED)
    records["index"], records["state"] = task.which, task.states[task.which]
    records["body"] = task.arguments.body[task.which]
    records["symmetric"] = task.arguments.symmetric[task.which]
    records["max_steps"] = span.max_steps
    length = span.stop - span.start
    # equal steps: none longer than asked for; at least two, so that there is something coarser
    steps = np.maximum(2, np.ceil(np.minimum(abs(length) / settings * (1.0 - 1e-12), 2.0**62))).astype(
        np.int64
    )
    records["steps"] = (steps / STRIDE).astype(np.int64) if span.coarsely else steps
    # steps by tolerance
    records["tolerance"] = settings * RUNGE_KUTTA.coarser if span.coarsely else settings
    inverses = records["body"][:, layout.INVERSES : layout.INVERSES + 3]
    momentum = records["state"][:, layout.MOMENTUM : layout.MOMENTUM + 3]
    rate = vector_lengths(inverses) * vector_lengths(momentum)
    with np.errstate(divide="ignore"):
        records["first_step"] = np.copysign(np.minimum(abs(length), 0.1 / rate), length)
    return records


def _arguments(task: SolverTask, work: np.ndarray) -> tuple[np.ndarray, ...]:
    """Span, instants, where to write, scratch, the flag that stops, effects and surroundings."""
    span = np.array([task.span.start, task.span.stop])
    world = task.arguments.effects, *task.arguments.surroundings
    return span, task.span.instants, task.out, work, stopping.current().flag, *world


def vector_lengths(vectors: np.ndarray) -> np.ndarray:
    """(n,), of (n, 3): sums are written out, for the same bits whatever n is."""
    x, y, z = (vectors * vectors).T
    length: np.ndarray = np.sqrt((x + y) + z)
    return length


@cache
def dormand_prince_table() -> np.ndarray:
    """(16, 12): A, B, C and both error estimates of Dormand and Prince's method, as scipy has them."""
    from scipy.integrate import DOP853

    return np.concatenate([DOP853.A, [DOP853.B, DOP853.C, DOP853.E3[:12], DOP853.E5[:12]]])


def _splitting(name: str) -> Solver:
    composition = schemes.COMPOSITIONS[name]
    step = partial(_split, composition)
    return Solver(f"splitting, {name}", composition.order, len(composition.kicks), ascending, step)


COLLOCATION = Solver("gauss, order 16", 16, 0, most_symmetric, _collocate)
RUNGE_KUTTA = Solver("dop853", 1, 0, ascending, _runge_kutta)
SPLITTINGS = tuple(_splitting(name) for name in schemes.COMPOSITIONS)
SOLVERS = {solver.name: solver for solver in (COLLOCATION, RUNGE_KUTTA, *SPLITTINGS)}
