"""Many bodies under the same effects, as the arrays that the compiled solvers step; each as if alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..errors import InputError, RegimeError, ToleranceError
from ..frames import rotations
from ..kernels import layout
from ..problem.initial_state import InitialState
from ..problem.torque_model import AppliedImpulse, CachedTorque
from ..problem.torque_rows import turned, turned_rows
from ..rigid_body.body import RigidBody
from .momentum import IN_TURNS, SINK_ITERATIONS, inertial, initial_momentum
from .solver_arguments import ABSORBED, SAME, SolverArguments, course_of, is_smooth, sun_of
from .solvers import Solver, can_take

Torques = Sequence[CachedTorque]


@dataclass(frozen=True)
class Bodies:
    """Bodies with their states at the epoch.

    Attributes
    ----------
    body : RigidBody, (n,)
    attitude : (n, 4) wxyz, body to inertial; rate : (n, 3) rad/s, body components; both at t = 0
    place : (n,), by what errors name them
    """

    body: RigidBody
    attitude: np.ndarray
    rate: np.ndarray
    place: np.ndarray

    def __len__(self) -> int:
        return len(self.rate)

    def some(self, which: np.ndarray | slice) -> Bodies:
        return Bodies(self.body[which], self.attitude[which], self.rate[which], self.place[which])

    def initial_state(self, like: InitialState, i: int) -> InitialState:
        """That of one of them, in the surroundings and span of another."""
        return replace(like, body=self.body[i], attitude=self.attitude[i], rate=self.rate[i])

    def along_axes(self, vectors: np.ndarray) -> np.ndarray:
        """(n, 3): vectors of the body's frame along its principal axes, in the order of its moments."""
        return turned(_right_handed(np.array(self.body.axes)), vectors)


@contextmanager
def named(bodies: Bodies, i: int, lost: list[int] | None = None) -> Iterator[None]:
    """What is wrong with one of the bodies names it by its place.

    One that cannot be followed is put into the list of the lost, where there is one, and nothing is raised.
    """
    place = int(bodies.place[i])
    try:
        yield
    except InputError as error:
        raise InputError(f"bodies[{place}].{error.field}", error.value, error.expected) from None
    except (ToleranceError, RegimeError) as error:
        if lost is None:
            raise type(error)(f"bodies[{place}]: {error}") from None
        lost.append(place)


class Prepared(NamedTuple):
    """Arguments of the solvers, `stepped.SolverArguments` for each of n bodies.

    Attributes
    ----------
    body : (n, STEPPED_BODY); symmetric : (n,) 0 or 1; to_axes : (n, 4)
    effects : (n, k, EFFECT_WIDTH); world : orbit, pieces, sun, its pieces
    smooth : whether every torque is
    """

    body: np.ndarray
    symmetric: np.ndarray
    to_axes: np.ndarray
    effects: np.ndarray
    world: tuple[np.ndarray, ...]
    smooth: bool

    def can_be_taken_by(self, solver: Solver) -> np.ndarray:
        """(n,): `solvers.can_take` of each."""
        one = SolverArguments(
            self.body[0], bool(self.symmetric[0]), self.to_axes[0], (self.effects[0], *self.world)
        )
        differ = np.unique(self.symmetric)
        able = {int(kind): can_take(solver, replace(one, symmetric=bool(kind))) for kind in differ}
        return np.array([able[kind] for kind in self.symmetric.tolist()])

    def states(
        self, attitude: np.ndarray, momentum: np.ndarray, rate: np.ndarray | None = None
    ) -> np.ndarray:
        """(n, STATE): of attitudes (n, 4) of the body's own frame and momenta (n, 3), both inertial.

        rate : (n, 3), rad/s, body frame, as `SolverArguments.state` takes it
        """
        states = np.zeros((len(self.body), layout.STATE))
        own = rotations.product(attitude, rotations.conjugate(self.to_axes))
        states[:, layout.ATTITUDE : layout.ATTITUDE + 4] = own
        states[:, layout.MOMENTUM : layout.MOMENTUM + 3] = momentum
        states[:, layout.AXIAL] = rotations.rotate(rotations.conjugate(own), momentum)[:, 2]
        if rate is not None:
            along = rotations.rotate(self.to_axes, rate)[:, 2]
            axial = self.body[:, layout.MOMENTS + 2] * along + self.body[:, layout.ROTORS + 2]
            states[:, layout.AXIAL] = np.where(self.symmetric == 1, axial, states[:, layout.AXIAL])
        return states

    def push(self, states: np.ndarray, attitude: np.ndarray, kick: AppliedImpulse, sign: float) -> None:
        """Change states by an impulse, as `SolverArguments.push`; attitude : (n, 4), those of the states."""
        states[:, layout.MOMENTUM : layout.MOMENTUM + 3] += sign * inertial(kick, attitude)
        angular = np.broadcast_to(kick.angular, (len(states), 3))
        own = rotations.rotate(rotations.conjugate(attitude), angular) if kick.inertial else angular
        states[:, layout.AXIAL] += sign * rotations.rotate(self.to_axes, own)[:, 2]


# -- axes and rows ------------------------------------------------------------------------------------


def ascending(like: InitialState, bodies: Bodies, torques: Torques) -> Prepared:
    """Each with axes as splitting needs them, `stepped.ascending`."""
    least, middle, greatest = _sorted(bodies)
    plain = prepared(like, bodies, torques, np.stack([least, middle, greatest], axis=1))
    moments = np.asarray(bodies.body.moments)
    alike = _are_same(_taken(moments, middle), _taken(moments, greatest))
    if not alike.any():
        return plain
    around = prepared(like, bodies, torques, np.stack([middle, greatest, least], axis=1))
    is_around = alike & (around.symmetric == 1)

    def chosen(one: np.ndarray, other: np.ndarray) -> np.ndarray:
        return np.where(is_around.reshape(-1, *[1] * (one.ndim - 1)), one, other)

    body, symmetric, to_axes, effects = (
        chosen(one, other) for one, other in zip(around[:4], plain[:4], strict=True)
    )
    return Prepared(body, symmetric, to_axes, effects, plain.world, plain.smooth)


def most_symmetric(like: InitialState, bodies: Bodies, torques: Torques) -> Prepared:
    """Each with axes as collocation wants them, `stepped.most_symmetric`."""
    least, middle, greatest = _sorted(bodies)
    moments = np.asarray(bodies.body.moments)
    inverses = [1.0 / _taken(moments, place) for place in (least, middle, greatest)]
    thin = (inverses[0] - inverses[1] < inverses[1] - inverses[2])[:, None]
    order = np.where(
        thin, np.stack([least, middle, greatest], axis=1), np.stack([middle, greatest, least], axis=1)
    )
    return prepared(like, bodies, torques, order)


def _sorted(bodies: Bodies) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    least, middle, greatest = np.argsort(bodies.body.moments, axis=1, kind="stable").T
    return least, middle, greatest


def _taken(moments: np.ndarray, place: np.ndarray) -> np.ndarray:
    taken: np.ndarray = np.take_along_axis(moments, place[:, None], axis=1)[:, 0]
    return taken


def _are_same(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    same: np.ndarray = np.abs(one - other) <= SAME * other
    return same


def _right_handed(axes: np.ndarray) -> np.ndarray:
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    return axes


def prepared(like: InitialState, bodies: Bodies, torques: Torques, order: np.ndarray) -> Prepared:
    """With the axes of each in an order, (n, 3)."""
    moments = np.take_along_axis(np.asarray(bodies.body.moments), order, axis=1)
    axes = _right_handed(np.take_along_axis(np.asarray(bodies.body.axes), order[:, :, None], axis=1))
    table = np.concatenate(
        [
            np.zeros((len(bodies), 0, layout.EFFECT_WIDTH)),
            *(rows_of(like, bodies, torque, axes, order) for torque in torques),
        ],
        axis=1,
    )
    codes = table[0, :, 0] if len(table) else np.zeros(0)
    absorbed = np.isin(codes, ABSORBED)
    to_axes = rotations.from_matrix(axes)
    same = _are_same(moments[:, 0], moments[:, 1])
    body = _stepped_bodies(moments, same, to_axes, table[:, absorbed])
    tilted = body[:, layout.ROTORS : layout.ROTORS + 2].any(axis=1) | (body[:, layout.ALPHA] != 0.0)
    effects = np.ascontiguousarray(table[:, ~absorbed])
    world = (*course_of(like), *sun_of(like, torques))
    smooth = is_smooth({int(code) for code in codes[~absorbed]})
    return Prepared(body, (same & ~tilted).astype(np.int64), to_axes, effects, world, smooth)


def _stepped_bodies(
    moments: np.ndarray, same: np.ndarray, to_axes: np.ndarray, absorbed: np.ndarray
) -> np.ndarray:
    body = np.zeros((len(moments), layout.STEPPED_BODY))
    middle = 0.5 * (moments[:, 0] + moments[:, 1])
    moments[same, 0] = moments[same, 1] = middle[same]
    body[:, layout.MOMENTS : layout.MOMENTS + 3] = moments
    body[:, layout.INVERSES : layout.INVERSES + 3] = 1.0 / moments
    body[:, layout.TO_AXES : layout.TO_AXES + 4] = to_axes
    for k in range(absorbed.shape[1]):
        code, numbers = absorbed[0, k, 0], absorbed[:, k]
        if code == layout.WHEELS:
            body[:, layout.ROTORS : layout.ROTORS + 3] += numbers[:, 1:4]
        elif code == layout.DISSIPATION:
            body[:, layout.ALPHA] += numbers[:, 1]
        else:
            body[:, layout.EDDIES : layout.EDDIES + 9] += numbers[:, 1:10]
    return body


def rows_of(
    like: InitialState, bodies: Bodies, torque: CachedTorque, axes: np.ndarray, order: np.ndarray
) -> np.ndarray:
    """(n, k, EFFECT_WIDTH): the rows of a torque for each body, along axes (n, 3, 3).

    Those along the axes of the body's frame, turned; asked for body by body where the torque's numbers
    depend on more than its axes.
    """
    if torque.follows_axes:
        return turned_rows(torque.own_rows, axes)
    each = []
    for i in range(len(bodies)):
        places = order[i].tolist()
        each.append(torque.rows(bodies.initial_state(like, i).ordered((places[0], places[1], places[2]))))
    return np.stack(each)


# -- momentum -----------------------------------------------------------------------------------------


def initial_momenta(like: InitialState, bodies: Bodies, torques: Torques) -> np.ndarray:
    """(n, 3), inertial: `momentum.initial_momentum` of each.

    Raises InputError, naming the body by its place, where a sink is too strong for it.
    """
    if not all(torque.follows_axes for torque in torques):
        return np.stack([_initial_momentum(like, bodies, i, torques) for i in range(len(bodies))])
    rotors, alpha = _inside(torques)
    rate = _whole_rates(bodies, rotors, alpha) if alpha else bodies.rate
    for i in np.flatnonzero(~np.isfinite(rate).all(axis=1)).tolist():
        _initial_momentum(like, bodies, i, torques)
    return rotations.rotate(bodies.attitude, turned(bodies.body.tensor, rate) + rotors)


def _initial_momentum(like: InitialState, bodies: Bodies, i: int, torques: Torques) -> np.ndarray:
    with named(bodies, i):
        return initial_momentum(bodies.initial_state(like, i), torques)


def _inside(torques: Torques) -> tuple[np.ndarray, float]:
    """Momentum of the rotors (3,), body frame, and coefficient of the sink: the same in every body."""
    rotors, alpha = np.zeros(3), 0.0
    for row in (row for torque in torques for row in torque.own_rows):
        if row[0] == layout.WHEELS:
            rotors = rotors + row[1:4]
        elif row[0] == layout.DISSIPATION:
            alpha += float(row[1])
    return rotors, alpha


def _whole_rates(bodies: Bodies, rotors: np.ndarray, alpha: float) -> np.ndarray:
    """(n, 3): rates whose momentum it is; nan where the iteration finds none."""
    tensor, given = bodies.body.tensor, bodies.rate
    rate, most = np.array(given), 1e3 * np.abs(given).max(axis=1)
    left, off = np.arange(len(bodies)), np.zeros(0)  # those that move still, and by what part of the rate
    for _ in range(SINK_ITERATIONS):
        before = rate[left]
        inner = np.cross(turned(tensor[left], before) + rotors, before)
        now = rate[left] = given[left] - alpha * inner
        size, change = np.abs(now).max(axis=1), np.abs(now - before).max(axis=1)
        far = ~(size <= most[left])
        rate[left[far]] = np.nan
        on = ~far & (change > 1e-16 * size)
        left, off = left[on], change[on] / size[on]
        if not left.size:
            break
    rate[left[off > IN_TURNS]] = np.nan
    return rate
