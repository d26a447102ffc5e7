"""A situation and its torques as the arrays that the compiled solvers step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..frames import rotations
from ..kernels import layout
from ..problem.initial_state import InitialState
from ..problem.torque_model import AppliedImpulse, TorqueModel
from .momentum import inertial

# Moments that differ by less are those of a symmetric body: this is rounding of the inertia given.
SAME = 1e-15
# Rows that act without a torque of their own, or linearly: they become part of the body.
ABSORBED = (layout.WHEELS, layout.DISSIPATION, layout.EDDY)
# Torques that come and go while the body turns: not smooth in time.
BROKEN = (layout.SOLAR_PLATE, layout.DRAG_PLATE, layout.USER)


@dataclass(frozen=True)
class SolverArguments:
    """Arguments of the solvers.

    Attributes
    ----------
    body : (STEPPED_BODY,); symmetric : whether about the third axis
    to_axes : (4,) the turn from the body's frame to the axes
    world : effects (n, EFFECT_WIDTH), orbit, pieces, sun, its pieces
    """

    body: np.ndarray
    symmetric: bool
    to_axes: np.ndarray
    world: tuple[np.ndarray, ...]

    @property
    def codes(self) -> set[int]:
        return {int(code) for code in self.world[0][:, 0]}

    @property
    def has_rotors(self) -> bool:
        return bool(self.body[layout.ROTORS : layout.ROTORS + 3].any())

    @property
    def has_sink(self) -> bool:
        return bool(self.body[layout.ALPHA] != 0.0)

    @property
    def is_smooth(self) -> bool:
        return is_smooth(self.codes)

    def state(self, attitude: np.ndarray, momentum: np.ndarray, rate: np.ndarray | None = None) -> np.ndarray:
        """(STATE,) of a body of that attitude (of its own frame, to inertial) and momentum (inertial).

        rate : (3,) rad/s, body frame, from which the momentum along an axis of symmetry is good to its own
            rounding; read off the whole momentum it would be good to that of the whole
        """
        state = np.zeros(layout.STATE)
        state[layout.ATTITUDE : layout.ATTITUDE + 4] = rotations.product(
            attitude, rotations.conjugate(self.to_axes)
        )
        state[layout.MOMENTUM : layout.MOMENTUM + 3] = momentum
        if rate is None or not self.symmetric:
            state[layout.AXIAL] = rotations.rotate(rotations.conjugate(state[:4]), momentum)[2]
        else:
            along = rotations.rotate(self.to_axes, rate)[2]
            state[layout.AXIAL] = self.body[layout.MOMENTS + 2] * along + self.body[layout.ROTORS + 2]
        return state

    def push(self, state: np.ndarray, attitude: np.ndarray, kick: AppliedImpulse, sign: float) -> None:
        """Change a state by an impulse, or take it back (sign -1); attitude : (4,), that of the state."""
        state[layout.MOMENTUM : layout.MOMENTUM + 3] += sign * inertial(kick, attitude)
        own = rotations.rotate(rotations.conjugate(attitude), kick.angular) if kick.inertial else kick.angular
        state[layout.AXIAL] += sign * rotations.rotate(self.to_axes, own)[2]


def is_smooth(codes: set[int]) -> bool:
    """Whether torques of these kinds all are, in time."""
    return not codes & set(BROKEN)


def ascending(initial_state: InitialState, torques: Sequence[TorqueModel]) -> SolverArguments:
    """With axes as splitting needs them: that of symmetry last; without one, moments in ascending order."""
    least, middle, greatest = np.argsort(initial_state.body.moments, kind="stable").tolist()
    if _are_same(initial_state, middle, greatest):
        around = stepped(initial_state, torques, (middle, greatest, least))
        if around.symmetric:
            return around
    return stepped(initial_state, torques, (least, middle, greatest))


def most_symmetric(initial_state: InitialState, torques: Sequence[TorqueModel]) -> SolverArguments:
    """With axes as collocation wants them: the two of most similar moments first."""
    return stepped(initial_state, torques, _most_symmetric(initial_state))


def _most_symmetric(initial_state: InitialState) -> tuple[int, int, int]:
    least, middle, greatest = np.argsort(initial_state.body.moments, kind="stable").tolist()
    moments = np.asarray(initial_state.body.moments)
    inverses = 1.0 / moments[[least, middle, greatest]]
    if inverses[0] - inverses[1] < inverses[1] - inverses[2]:
        return least, middle, greatest
    return middle, greatest, least


def _are_same(initial_state: InitialState, i: int, j: int) -> bool:
    moments = np.asarray(initial_state.body.moments)
    return bool(abs(moments[i] - moments[j]) <= SAME * moments[j])


def stepped(
    initial_state: InitialState, torques: Sequence[TorqueModel], order: tuple[int, int, int]
) -> SolverArguments:
    """Everything of a situation that a solver reads, with its axes in an order."""
    initial_state = initial_state.ordered(order)
    rows = [torque.rows(initial_state) for torque in torques]
    table = np.concatenate([np.zeros((0, layout.EFFECT_WIDTH)), *rows])
    absorbed = np.isin(table[:, 0], ABSORBED)
    to_axes = rotations.from_matrix(initial_state.axes)
    body = _body(initial_state, table[absorbed], to_axes)
    symmetric = _are_same(initial_state, order[0], order[1]) and _keeps_axis(body)
    effects = np.ascontiguousarray(table[~absorbed])
    return SolverArguments(
        body, symmetric, to_axes, (effects, *course_of(initial_state), *sun_of(initial_state, torques))
    )


def _keeps_axis(body: np.ndarray) -> bool:
    """Whether the momentum along the third axis changes by torques alone: rotors across it, and a sink, which
    turns the body, change it too."""
    return not (body[layout.ROTORS : layout.ROTORS + 2].any() or body[layout.ALPHA])


def _body(initial_state: InitialState, absorbed: np.ndarray, to_axes: np.ndarray) -> np.ndarray:
    body = np.zeros(layout.STEPPED_BODY)
    moments = initial_state.moments
    if _are_same(initial_state, initial_state.order[0], initial_state.order[1]):
        moments[:2] = moments[:2].mean()
    body[layout.MOMENTS : layout.MOMENTS + 3] = moments
    body[layout.INVERSES : layout.INVERSES + 3] = 1.0 / moments
    body[layout.TO_AXES : layout.TO_AXES + 4] = to_axes
    for row in absorbed:
        if row[0] == layout.WHEELS:
            body[layout.ROTORS : layout.ROTORS + 3] += row[1:4]
        elif row[0] == layout.DISSIPATION:
            body[layout.ALPHA] += row[1]
        else:
            body[layout.EDDIES : layout.EDDIES + 9] += row[1:10]
    return body


def course_of(initial_state: InitialState) -> tuple[np.ndarray, np.ndarray]:
    if initial_state.orbit_path is None:
        return np.zeros(layout.ORBIT_WIDTH), np.zeros((1, 3, 1))
    return initial_state.orbit_path.numbers, np.ascontiguousarray(initial_state.orbit_path.coefficients)


def sun_of(initial_state: InitialState, torques: Sequence[TorqueModel]) -> tuple[np.ndarray, np.ndarray]:
    """(start, length, whether there is one), pieces: one Sun for all, the effects ask for the same."""
    for torque in torques:
        pieces = torque.sun(initial_state)
        if pieces is not None:
            return np.array([pieces.start, pieces.length, 1.0]), np.ascontiguousarray(pieces.coefficients)
    return np.array([0.0, 1.0, 0.0]), np.zeros((1, 3, 1))
