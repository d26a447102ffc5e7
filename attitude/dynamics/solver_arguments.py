"""Bodies and their torques as the arrays that the compiled solvers read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..frames import rotations
from ..kernels.layout import ORBIT_WIDTH, BodyRow, EffectCode, EffectRow, StepState
from ..problem.initial_state import InitialState
from ..problem.torque_model import AppliedImpulse, CachedTorque
from ..problem.torque_rows import number_pieces, turned_rows
from .batch_states import Bodies, once_for_bodies, right_handed
from .momentum import inertial_components
from .plate_arguments import PLATES, PlateArguments, plate_arguments

# Rows that act without a torque of their own, or linearly: they become part of the body.
ABSORBED = (EffectCode.WHEELS, EffectCode.DISSIPATION, EffectCode.EDDY)


@dataclass(frozen=True)
class SolverArguments:
    """What solvers read of n bodies and their torques.

    Attributes
    ----------
    body : (n, BodyRow.WIDTH); symmetric : (n,), whether about the third axis
    to_axes : (n, 4), the turn from the body's frame to the axes
    effects : (n, k, EffectRow.WIDTH); surroundings : orbit, its pieces, sun, its pieces
    plates : what the march between the edges of plates reads, where there are any
    """

    body: np.ndarray
    symmetric: np.ndarray
    to_axes: np.ndarray
    effects: np.ndarray
    surroundings: tuple[np.ndarray, ...]
    plates: PlateArguments | None = None

    @property
    def codes(self) -> set[int]:
        """Kinds of the torques: the same for all bodies."""
        return {int(code) for code in self.effects[0, :, 0]}

    @property
    def is_smooth(self) -> bool:
        """Whether all torques are, in time; a user's may come and go while the body turns."""
        return EffectCode.USER not in self.codes

    def repeated(self, times: int) -> SolverArguments:
        """The arguments of each body so many times."""
        fields = (self.body, self.symmetric, self.to_axes, self.effects)
        body, symmetric, to_axes, effects = (np.repeat(field, times, axis=0) for field in fields)
        return replace(self, body=body, symmetric=symmetric, to_axes=to_axes, effects=effects)

    def pushed(self, momenta: np.ndarray) -> SolverArguments:
        """Arguments of bodies that are pushed along their rate, (n,) N m s; a symmetric body is not."""
        body = self.body.copy()
        diagonal = [BodyRow.EDDIES, BodyRow.EDDIES + 4, BodyRow.EDDIES + 8]
        body[:, diagonal] -= np.where(self.symmetric, 0.0, momenta)[:, None]
        return replace(self, body=body)

    def states(
        self, attitude: np.ndarray, momentum: np.ndarray, rate: np.ndarray | None = None
    ) -> np.ndarray:
        """(n, StepState.WIDTH): of attitudes (n, 4) of the body's own frame and momenta (n, 3), inertial.

        rate : (n, 3) rad/s, body frame, from which the momentum along an axis of symmetry is good to its own
            rounding; read off the whole momentum it would be good to that of the whole
        """
        states = np.zeros((len(self.body), StepState.WIDTH))
        own = rotations.product(attitude, rotations.conjugate(self.to_axes))
        states[:, StepState.ATTITUDE : StepState.ATTITUDE + 4] = own
        states[:, StepState.MOMENTUM : StepState.MOMENTUM + 3] = momentum
        states[:, StepState.AXIAL] = rotations.rotate(rotations.conjugate(own), momentum)[:, 2]
        if rate is not None:
            along = rotations.rotate(self.to_axes, rate)[:, 2]
            axial = self.body[:, BodyRow.MOMENTS + 2] * along + self.body[:, BodyRow.ROTORS + 2]
            states[:, StepState.AXIAL] = np.where(self.symmetric, axial, states[:, StepState.AXIAL])
        return states

    def add_impulse(
        self, states: np.ndarray, attitude: np.ndarray, impulse: AppliedImpulse, sign: float
    ) -> None:
        """Change states by an impulse, or take it back (sign -1); attitude : (n, 4), those of the states."""
        states[:, StepState.MOMENTUM : StepState.MOMENTUM + 3] += sign * inertial_components(
            impulse, attitude
        )
        angular = np.broadcast_to(impulse.angular, (len(states), 3))
        own = rotations.rotate(rotations.conjugate(attitude), angular) if impulse.inertial else angular
        states[:, StepState.AXIAL] += sign * rotations.rotate(self.to_axes, own)[:, 2]


@once_for_bodies
def most_symmetric(
    template: InitialState, bodies: Bodies, torques: Sequence[CachedTorque]
) -> SolverArguments:
    """Arguments with axes in the order that the solver needs: the two of most similar moments first."""
    ascending = np.argsort(bodies.body.moments, axis=1, kind="stable")
    a, b, c = 1.0 / np.sort(bodies.body.moments, axis=1).T
    last_is_least = ascending[:, [1, 2, 0]]
    order = np.where((a - b < b - c)[:, None], ascending, last_is_least)
    return solver_arguments(template, bodies, torques, order)


def solver_arguments(
    template: InitialState, bodies: Bodies, torques: Sequence[CachedTorque], order: np.ndarray
) -> SolverArguments:
    """Arguments with the axes of each body in an order, (n, 3)."""
    each = np.arange(len(bodies))[:, None]
    moments, axes = bodies.body.moments[each, order], right_handed(bodies.body.axes[each, order])
    rows = [_rows_of(template, bodies, torque, axes, order) for torque in torques]
    air = number_pieces(rows, torques, template)
    table = np.concatenate([np.zeros((len(bodies), 0, EffectRow.WIDTH)), *rows], axis=1)
    absorbed = np.isin(table[0, :, 0], ABSORBED)
    to_axes = rotations.from_matrix(axes)
    # moments that differ by rounding of the inertia given are those of a symmetric body
    same = np.abs(moments[:, 0] - moments[:, 1]) <= 1e-15 * moments[:, 1]
    moments[same, :2] = 0.5 * (moments[same, 0] + moments[same, 1])[:, None]
    body = _body(moments, to_axes, table[:, absorbed])
    # momentum along the third axis: rotors across it, and dissipation, which turns the body, change it too
    across = body[:, BodyRow.ROTORS : BodyRow.ROTORS + 2].any(axis=1) | (body[:, BodyRow.ALPHA] != 0.0)
    effects = np.ascontiguousarray(table[:, ~absorbed])
    surroundings = _surroundings(template, torques)
    if np.isin(effects[0, :, 0], PLATES).any():  # the march keeps no momentum along an axis of symmetry
        plates = plate_arguments(template, torques, body, effects, air)
        return SolverArguments(body, np.zeros_like(same), to_axes, effects, surroundings, plates)
    return SolverArguments(body, same & ~across, to_axes, effects, surroundings)


def _body(moments: np.ndarray, to_axes: np.ndarray, absorbed: np.ndarray) -> np.ndarray:
    """(n, BodyRow.WIDTH), of moments (n, 3), turns (n, 4) and absorbed rows (n, k, EffectRow.WIDTH)."""
    body = np.zeros((len(moments), BodyRow.WIDTH))
    body[:, BodyRow.MOMENTS : BodyRow.MOMENTS + 3] = moments
    body[:, BodyRow.INVERSES : BodyRow.INVERSES + 3] = 1.0 / moments
    body[:, BodyRow.TO_AXES : BodyRow.TO_AXES + 4] = to_axes
    for row in np.moveaxis(absorbed, 1, 0):
        if row[0, 0] == EffectCode.WHEELS:
            body[:, BodyRow.ROTORS : BodyRow.ROTORS + 3] += row[:, 1:4]
        elif row[0, 0] == EffectCode.DISSIPATION:
            body[:, BodyRow.ALPHA] += row[:, 1]
        else:
            body[:, BodyRow.EDDIES : BodyRow.EDDIES + 9] += row[:, 1:10]
    return body


def _rows_of(
    template: InitialState, bodies: Bodies, torque: CachedTorque, axes: np.ndarray, order: np.ndarray
) -> np.ndarray:
    """(n, k, EffectRow.WIDTH): the rows of a torque for each body, along axes (n, 3, 3).

    Those along the axes of the body's frame, rotated; asked for body by body where the torque's numbers
    depend on more than its axes.
    """
    if torque.follows_axes:
        return turned_rows(torque.own_rows, axes)
    each = []
    for i in range(len(bodies)):
        first, second, third = order[i].tolist()
        each.append(torque.rows(bodies.initial_state(template, i).ordered((first, second, third))))
    return np.stack(each)


def _surroundings(template: InitialState, torques: Sequence[CachedTorque]) -> tuple[np.ndarray, ...]:
    """Orbit, its pieces; sun (start, length, whether there is one), its pieces: the effects ask for one."""
    orbit: tuple[np.ndarray, np.ndarray] = np.zeros(ORBIT_WIDTH), np.zeros((1, 3, 1))
    if template.orbit_path is not None:
        orbit = template.orbit_path.numbers, np.ascontiguousarray(template.orbit_path.coefficients)
    suns = (torque.sun(template) for torque in torques)
    sun = next((pieces for pieces in suns if pieces is not None), None)
    if sun is None:
        return *orbit, np.array([0.0, 1.0, 0.0]), np.zeros((1, 3, 1))
    return *orbit, np.array([sun.start, sun.length, 1.0]), np.ascontiguousarray(sun.coefficients)
