"""A block of bodies stepped by a solver from the epoch outwards, arc by arc."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..frames import rotations
from ..problem.torque_model import CachedTorque
from ..problem.torque_rows import turned
from ..times.instants import Instants
from .angular_rates import max_angular_rates
from .arcs import Arc, instants_within
from .batch_states import Bodies, TorqueProblem
from .momentum import initial_momenta, rotors_and_dissipation
from .plate_solver import take_arcs
from .solver import OUTPUTS, SolverTask, StepSetting, take_steps
from .solver_arguments import SolverArguments, most_symmetric
from .vector_sums import dot, lengths, unit

# By this part of its size the momentum of the coarser solution is changed: at the epoch along itself, and
# across it between both other directions of `rounding`; and by half as much on the way, along the rate, since
# the motion may multiply later roundings more than the first.  What the two solutions share of rounding, and
# what the motion makes of it, is in their difference then.
ROUNDING_OF_MOMENTUM = 2.0**-50
ALONG_AND_ACROSS = (1.0, 0.5**0.5, 0.5**0.5)


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
    bodies: Bodies,
    rotors: np.ndarray,
    weights: tuple[float, float, float],
    sizes: np.ndarray,
) -> np.ndarray:
    """Change of momenta (n, 3), body frame, by rounding in the directions of which motions make most.

    Along the momentum; across it along the gradient of the energy, which is the rate: another energy is
    another period, or the other side of a separatrix; and across both, along the momentum's own path in the
    body, with the sign with which free motion stretches the sum of the two, as it does beside a middle axis.
    The directions are of a state that is off by 2^-40, more along one axis than another: of rotation about an
    axis, and of rest, there are none.  Of the rate a further part is off, for those of a sphere.

    rotors : (..., 3) N m s, body frame; weights : of these three
    sizes : (n,) N m s, of the momenta
    """
    axes, moments = bodies.axes, np.asarray(bodies.body.moments)
    rates, size = turned(axes, bodies.rate), sizes[:, None]
    off = size * (2.0**-40 * np.array([1.0, 0.5, 0.25]))
    along = unit(moments * rates + turned(axes, rotors) + off)
    rates = rates + off / moments + 2.0**-5 * off / moments.min(axis=1, keepdims=True)
    energy = unit(rates - dot(rates, along)[:, None] * along)
    (a, b, c), (x, y, z) = along.T, energy.T
    path = np.array([b * z - c * y, c * x - a * z, a * y - b * x]).T
    sign = np.copysign(1.0, dot(energy * energy - path * path, 1.0 / moments))[:, None]
    change = weights[0] * along + weights[1] * energy + weights[2] * sign * path
    return turned(axes.swapaxes(1, 2), ROUNDING_OF_MOMENTUM * size * change)


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
        self._pushed: np.ndarray | None = None  # N m s, negative eddies of the coarser solution
        if setting.coarsely:
            momenta = momenta + self._disturb(momenta, first)
        self._states = self._under(first.torques).states(self._attitude, momenta, bodies.rate)

    def _disturb(self, momenta: np.ndarray, first: Arc) -> np.ndarray:
        """(n, 3), inertial: the change of the momenta at the epoch; also sets that on the way.

        Momenta count for no less than torques and impulses will make of them.
        """
        problem, bodies = self._problem, self._bodies
        speeds = max_angular_rates(problem.template, bodies, problem.torques, problem.impulses)
        least = np.asarray(bodies.body.moments).min(axis=1)
        sizes = np.maximum(lengths(momenta), least * speeds)
        end = problem.template.stop if first.stop >= 0.0 else problem.template.start
        radians = np.maximum(speeds * abs(end), 1.0)  # spans may be of no length
        self._pushed = np.copysign(0.5 * ROUNDING_OF_MOMENTUM, end) * sizes / radians
        rotors, _ = rotors_and_dissipation(problem.template, bodies, first.torques)
        change = rounding(bodies, rotors, ALONG_AND_ACROSS, sizes)
        turned_change: np.ndarray = rotations.rotate(bodies.attitude, change)
        return turned_change

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
            if self._pushed is not None:
                arguments = arguments.pushed(self._pushed)
            self._prepared[key] = arguments
            self.symmetric &= arguments.symmetric
            self.smooth = self.smooth and arguments.is_smooth
            self.plates = self.plates or arguments.plates is not None
        return self._prepared[key]
