"""The solvers of scenes with torques: each marches a state over a span, and writes the instants within it.

Chosen settings are steps (s) for splitting and collocation, the error of a step (rad) for Runge-Kutta.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from .. import stopping
from ..errors import ToleranceError
from ..kernels import layout
from ..problem.initial_state import InitialState
from ..problem.torque_model import TorqueModel
from ..runtime import compiled
from . import schemes
from .solver_arguments import SolverArguments, ascending, most_symmetric

OUTPUTS = 10  # attitude (4), rate (3), momentum (3)
STRIDE = 1.5  # steps of the coarser solution over those of the answer
# Collocation in steps so long that the two differ by more than this (rad) is far from its order; splitting
# in steps of more than so many radians meets resonances, where a finer solution may be the worse one.
FAR, LONG = 1e-6, 1.0
MOST_STEPS = 1e8


class Part(NamedTuple):
    """What is asked of a solver: from start to stop (s), the two-part instants within, in that direction.

    With `coarsely`, in two thirds of the steps, or with ten times the tolerance: what the error is told by.
    After `most` steps a solver that chooses its own gives up.
    """

    start: float
    stop: float
    seconds: np.ndarray
    rest: np.ndarray
    coarsely: bool = False
    most: float = MOST_STEPS


class Work(NamedTuple):
    """What it took: steps, torques computed, and steps that could not be made as exact as intended."""

    steps: int
    torques: int
    failed: int


@dataclass(frozen=True)
class Solver:
    """A way to follow a rotation.

    Attributes
    ----------
    name : as documents and plans have it
    order : of the error in the step, as far as it is known beforehand; for `dop853`, 1: in the tolerance
    stages : kicks of a step of splitting, else 0
    prepare : (situation, torques) -> Stepped, with axes as it needs them
    march : (stepped, state, part, setting, out) -> Work; changes the state, writes (OUTPUTS, n)
    """

    name: str
    order: int
    stages: int
    prepare: Callable[[InitialState, Sequence[TorqueModel]], SolverArguments]
    march: Callable[[SolverArguments, np.ndarray, Part, float, np.ndarray], Work]

    @property
    def coarser(self) -> float:
        """What the setting is multiplied by for the solution that the answer is compared with."""
        return 10.0 if self.kind == "dop853" else STRIDE

    def gain(self, smooth: bool, apart: float, stride: float) -> float:
        """By how much, at least, the answer is better than that one, from which it is `apart` (rad).

        stride : rad, of a step.  Half of what order 8, or a splitting's own, would gain, unless steps are so
        long that no order is what it will be.  Where torques break within steps, errors are of any sign and
        size from step to step, and the two may agree by chance: then less than one.
        """
        if not smooth:
            return 0.1
        if self.kind == "dop853":
            return 1.0
        if self.kind == "gauss":
            return 4.0 if apart > FAR else 12.0
        return 0.3 if stride > LONG else max(1.0, 0.5 * (self.coarser**self.order - 1.0))

    def follow(
        self,
        torques: Sequence[TorqueModel],
        stepped: SolverArguments,
        state: np.ndarray,
        part: Part,
        setting: float,
        out: np.ndarray,
    ) -> Work:
        """`march`; what a function of the user's raised meanwhile is raised here, and Stopped."""
        try:
            work = self.march(stepped, state, part, setting, out)
            stopping.current().check()
            return work
        finally:
            for torque in torques:
                if hasattr(torque, "raise_failure"):
                    torque.raise_failure()

    @property
    def kind(self) -> str:
        """ "splitting", "gauss" or "dop853"."""
        return self.name.split(",")[0]


def steps_of(part: Part, step: float) -> int:
    """So many equal steps, none longer than asked for; at least two, so that there is something coarser."""
    steps = max(2, int(np.ceil(abs(part.stop - part.start) / step * (1.0 - 1e-12))))
    return int(steps / STRIDE) if part.coarsely else steps


def _grid(part: Part, step: float) -> tuple[int, tuple[Any, ...]]:
    """(steps, what a solver of equal steps is told of them: start, length, number)."""
    steps = steps_of(part, step)
    return steps, (np.array([part.start, 0.0]), (part.stop - part.start) / steps, steps)


def _asked(stepped: SolverArguments, part: Part, out: np.ndarray, states: int = 1) -> tuple[Any, ...]:
    """What every solver is told, and where it writes: effects, instants, rows, room for so many states."""
    return (*stepped.world, part.seconds, part.rest, out, np.empty(states * layout.STATE))


def _split(
    composition: schemes.Composition,
    stepped: SolverArguments,
    state: np.ndarray,
    part: Part,
    setting: float,
    out: np.ndarray,
) -> Work:
    steps, grid = _grid(part, setting)
    shares = composition.drifts, composition.kicks
    body, work = (stepped.body, int(stepped.symmetric)), np.empty((6, layout.NODES))
    compiled.split(state, *grid, *shares, *body, *_asked(stepped, part, out), work, stopping.current().flag)
    return Work(steps, steps * len(composition.kicks), 0)


def _collocate(
    stepped: SolverArguments, state: np.ndarray, part: Part, setting: float, out: np.ndarray
) -> Work:
    (steps, grid), counts = _grid(part, setting), np.zeros(2)
    body, work = (stepped.body, int(stepped.symmetric)), schemes.gauss().copy()
    compiled.collocate(
        state, *grid, *body, *_asked(stepped, part, out), work, counts, stopping.current().flag
    )
    return Work(steps, int(counts[0]) * layout.NODES, int(counts[1]))


@cache
def dormand_prince() -> np.ndarray:
    """(16, 12): A, B, C and both error estimates of Dormand and Prince's method, as scipy has them."""
    from scipy.integrate import DOP853

    return np.concatenate([DOP853.A, [DOP853.B, DOP853.C, DOP853.E3[:12], DOP853.E5[:12]]])


def _runge_kutta(
    stepped: SolverArguments, state: np.ndarray, part: Part, setting: float, out: np.ndarray
) -> Work:
    counts = np.zeros(3)
    rate = np.linalg.norm(stepped.body[layout.INVERSES : layout.INVERSES + 3]) * np.linalg.norm(state[4:7])
    first = min(abs(part.stop - part.start), 0.1 / rate if rate > 0.0 else np.inf)
    compiled.runge_kutta(
        state,
        np.array([part.start, 0.0]),
        np.array([part.stop, 0.0]),
        float(np.copysign(first, part.stop - part.start)),
        setting * RUNGE_KUTTA.coarser if part.coarsely else setting,
        dormand_prince(),
        stepped.body,
        *_asked(stepped, part, out, states=2),
        np.empty(13 * 7),
        counts,
        part.most,
        stopping.current().flag,
    )
    if counts[2]:
        raise ToleranceError(
            "tolerance: dop853 needs steps without end; the torque is not continuous, or not finite, or far "
            f"too great for the body, or an error of {setting:.1g} rad a step is more than a double can keep"
        )
    return Work(int(counts[0]), 12 * int(counts.sum()), 0)


def _splitting(name: str) -> Solver:
    composition = schemes.COMPOSITIONS[name]

    def march(
        stepped: SolverArguments, state: np.ndarray, part: Part, setting: float, out: np.ndarray
    ) -> Work:
        return _split(composition, stepped, state, part, setting, out)

    return Solver(f"splitting, {name}", composition.order, len(composition.kicks), ascending, march)


COLLOCATION = Solver("gauss, order 16", 16, 0, most_symmetric, _collocate)
RUNGE_KUTTA = Solver("dop853", 1, 0, ascending, _runge_kutta)
SPLITTINGS = tuple(_splitting(name) for name in schemes.COMPOSITIONS)


def can_take(solver: Solver, stepped: SolverArguments) -> bool:
    """Whether a solver's error has the order it is said to have.

    Splitting freezes the attitude under the torque: what depends on the rate otherwise than linearly, or
    turns the body besides, is not for it; and of its schemes those for two parts are not for three.
    """
    if solver.kind != "splitting":
        return True
    if stepped.has_sink or layout.USER in stepped.codes:
        return False
    three_parts = (
        stepped.has_rotors
        and not stepped.symmetric
        and (len(stepped.world[0]) > 0 or bool(stepped.body[layout.EDDIES :].any()))
    )
    return not (three_parts and "(" in solver.name)
