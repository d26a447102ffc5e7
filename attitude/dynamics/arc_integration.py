"""A block of bodies stepped by a solver from the epoch outwards, arc by arc."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..frames import rotations
from ..problem.torque_model import CachedTorque
from ..times.instants import Instants
from .angular_rates import max_angular_rates
from .arcs import Arc, instants_within
from .batch_states import Bodies, TorqueProblem
from .momentum import initial_momenta
from .plate_solver import take_arcs
from .solver import OUTPUTS, SolverTask, StepSetting, take_steps, vector_lengths
from .solver_arguments import SolverArguments, most_symmetric

# By this part of its size the momentum that the coarser solution starts with is turned: what both solutions
# share of rounding, and how the motion makes it grow, is in their difference too.
ROUNDING_OF_MOMENTUM = 2.0**-50


class Solution(NamedTuple):
    """The motion of n bodies at m instants.

    Attributes
    ----------
    rows : (n, OUTPUTS, m): attitude wxyz (4), rate (3, body), momentum (3, inertial); NaN where steps failed
    steps, sweeps, failed : (n,), as `SolverWork` has them
    symmetric : (n,), whether the body is, for the solver; smooth : whether every torque is
    plates : whether arcs end at the edges of plates; edges : (n,) rad/s, as `SolverWork` has them
    """

    rows: np.ndarray
    steps: np.ndarray
    sweeps: np.ndarray
    failed: np.ndarray
    symmetric: np.ndarray
    smooth: bool
    plates: bool
    edges: np.ndarray


def two_part(instants: Instants) -> np.ndarray:
    """(2, m): seconds since the epoch, and what their rounding left, as kernels take them."""
    flat = instants.flattened()
    return np.array([flat.seconds, flat.low])


def integrate(problem: TorqueProblem, bodies: Bodies, instants: np.ndarray, setting: StepSetting) -> Solution:
    """All bodies at all instants (2, m), forwards and backwards from the epoch.

    A body is stepped as if it were alone: no bit of its rows depends on the others.
    """
    n, (seconds, low) = len(bodies), instants
    work = np.zeros((3, n), np.int64)
    rows, symmetric, edges = np.full((n, OUTPUTS, seconds.size), np.nan), np.ones(n, np.bool_), np.zeros(n)
    smooth, plates = True, False
    for path in problem.arcs:
        within = np.flatnonzero(seconds < 0.0 if path[-1].stop < 0.0 else seconds >= 0.0)
        if within.size:
            outwards = _Outwards(problem, bodies, setting, path[0])
            indices = instants_within(path, seconds[within], low[within])
            for arc, index in zip(path, indices, strict=True):
                rows[:, :, within[index]] = outwards.over(arc, instants[:, within[index]])
            work += outwards.work
            symmetric &= outwards.symmetric
            smooth, plates = smooth and outwards.smooth, plates or outwards.plates
            edges += outwards.edges
    return Solution(rows, work[0], work[1], work[2], symmetric, smooth, plates, edges)


def rounding(
    bodies: Bodies, momenta: np.ndarray, rates: np.ndarray | float = 0.0, aside: bool = False
) -> np.ndarray:
    """(n, 3), inertial: a change of momenta across them, the more along an axis the less its moment.

    Momenta count for no less than torques and impulses will make of them: (n,) rad/s, the greatest rates.

    aside : across both the momentum and that change instead
    """
    moments, axes = np.asarray(bodies.body.moments), bodies.axes
    first, second, third = np.sqrt(moments.min(axis=1, keepdims=True) / moments).T[:, :, None]
    change = rotations.rotate(
        bodies.attitude, (first * axes[:, 0] + second * axes[:, 1]) + third * axes[:, 2]
    )
    own = vector_lengths(momenta)[:, None]
    direction = momenta / np.where(own > 0.0, own, 1.0)
    size = np.maximum(own, (rates * moments.min(axis=1))[:, None])
    x, y, z = (change * direction).T[:, :, None]
    turned: np.ndarray = ROUNDING_OF_MOMENTUM * size * (change - ((x + y) + z) * direction)
    return np.cross(direction, turned) if aside else turned


class _Outwards:
    """All bodies on their way from the epoch in one direction."""

    def __init__(self, problem: TorqueProblem, bodies: Bodies, setting: StepSetting, first: Arc):
        self._problem, self._bodies, self._setting = problem, bodies, setting
        squares = (bodies.attitude * bodies.attitude).T
        length = np.sqrt((squares[0] + squares[1]) + (squares[2] + squares[3]))
        self._attitude = bodies.attitude / length[:, None]
        self.work = np.zeros((3, len(bodies)), np.int64)  # steps, sweeps, failures
        self.symmetric, self.edges = np.ones(len(bodies), np.bool_), np.zeros(len(bodies))
        self.smooth, self.plates = True, False
        self._prepared: dict[tuple[int, ...], SolverArguments] = {}
        momenta = initial_momenta(problem.template, bodies, first.torques)
        if setting.coarsely:
            rates = max_angular_rates(problem.template, bodies, problem.torques, problem.impulses)
            momenta = momenta + rounding(bodies, momenta, rates)
        self._states = self._under(first.torques).states(self._attitude, momenta, bodies.rate)

    def over(self, arc: Arc, instants: np.ndarray) -> np.ndarray:
        """(n, OUTPUTS, m): over the next arc, at the instants (2, m) in it."""
        arguments = self._under(arc.torques)
        for impulse in arc.impulses:
            sign = 1.0 if arc.stop >= 0.0 else -1.0
            arguments.add_impulse(self._states, self._attitude, impulse, sign)
        # the last column is the end of the arc
        at = np.ascontiguousarray(np.concatenate([instants, [[arc.stop], [0.0]]], axis=1))
        out = np.full((len(self._bodies), OUTPUTS, at.shape[1]), np.nan)
        finite = (self.work[2] == 0) & np.isfinite(self._states).all(axis=1)
        which = np.flatnonzero(finite)
        task = SolverTask(arguments, which, self._states, arc.start, arc.stop, at, self._setting, out)
        take = take_steps if arguments.plates is None else take_arcs
        work = take(task, arc.torques)
        self.work[:, which] += work[:3]
        self.edges[which] += work.edges
        self._attitude = out[:, :4, -1]
        return out[:, :, :-1]

    def _under(self, torques: Sequence[CachedTorque]) -> SolverArguments:
        key = tuple(id(torque) for torque in torques)
        if key not in self._prepared:
            arguments = most_symmetric(self._problem.template, self._bodies, torques)
            self._prepared[key] = arguments
            self.symmetric &= arguments.symmetric
            self.smooth = self.smooth and arguments.is_smooth
            self.plates = self.plates or arguments.plates is not None
        return self._prepared[key]
