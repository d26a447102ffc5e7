"""Bodies that fly freely, are kicked, and bounce on a plane: the closed form between events.

Between two events attitude and rate are those of torque-free motion and the centre of mass keeps to
its parabola, both exact; contacts are found to the last digits (`kernels.surface`), and change
momentum at an instant (`kernels.impact`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..errors import InputError
from ..frames import rotations
from ..kernels import layout
from ..problem.initial_state import InitialState
from ..problem.torque_model import AppliedImpulse
from ..rigid_body.phase_limit import max_phase_rate, refuse_too_far
from ..runtime import compiled
from ..samples.event import Event
from ..samples.translation import parabola

# A body may be given this deep in the ground, in parts of its size: the rounding of who put it there.
SUNK = 1e-12
MAX_CONTACTS = 100_000
ROOM = (64, 512)  # flights for which there is room at first, and later

ON = "no contact before the epoch is known: an instant not before t = 0"
RESTS = (
    "bounces accumulate: from here on the body stays in contact with the ground, which is not simulated, "
    "and the ephemeris ends"
)


class Shape(NamedTuple):
    """The convex hull of corners, each with a ball or a disc about it.

    Attributes
    ----------
    corners : (n, 3), m, from the centre of mass, body frame
    radius : m; zero for a polyhedron
    axis : (3,) unit vector, body frame, across which the discs lie; None for balls
    """

    corners: np.ndarray
    radius: float = 0.0
    axis: np.ndarray | None = None

    @property
    def reach(self) -> float:
        """m; what moves with the attitude is no farther from the centre of mass."""
        if self.axis is None:
            return float(np.linalg.norm(self.corners, axis=1).max())
        along = self.corners @ self.axis
        across = np.linalg.norm(self.corners - along[:, None] * self.axis, axis=1) + self.radius
        return float(np.hypot(along, across).max())

    @property
    def size(self) -> float:
        """m; the farthest point from the centre of mass."""
        return self.reach + (self.radius if self.axis is None else 0.0)


def box(lengths: Sequence[float], centre: Sequence[float] = (0.0, 0.0, 0.0)) -> Shape:
    """A box with edges along the body axes, m."""
    signs = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return Shape(np.asarray(centre, dtype=float) + signs * np.asarray(lengths, dtype=float))


def cylinder(
    radius: float, height: float, axis: Sequence[float], centre: Sequence[float] = (0.0, 0.0, 0.0)
) -> Shape:
    """A cylinder, m, about an axis of any length."""
    unit = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    return Shape(
        np.asarray(centre, dtype=float) + np.outer((-0.5 * height, 0.5 * height), unit), radius, unit
    )


def sphere(radius: float, centre: Sequence[float] = (0.0, 0.0, 0.0)) -> Shape:
    return Shape(np.asarray(centre, dtype=float).reshape(1, 3), radius)


class Ground(NamedTuple):
    """A plane, and how a body of some shape bounces on it.

    Attributes
    ----------
    normal : (3,), inertial, away from the ground, of any length
    height : m, of the plane along the normal
    shape : Shape of the body
    restitution : 0 to 1, the normal impulse after compression over that of compression (Poisson)
    friction : Coulomb's coefficient, from 0
    """

    normal: np.ndarray
    height: float
    shape: Shape
    restitution: float
    friction: float = 0.0

    @property
    def up(self) -> np.ndarray:
        return np.asarray(self.normal, dtype=float) / np.linalg.norm(self.normal)

    def clearance(self, quaternion: np.ndarray, position: np.ndarray) -> np.ndarray:
        """(...), m: height of the body's lowest point over the plane; (..., 4) wxyz and (..., 3) m."""
        up, shape = self.up, self.shape
        inverse = quaternion * (1.0, -1.0, -1.0, -1.0)
        normal = rotations.rotate(inverse, np.broadcast_to(up, position.shape))
        depth = np.full(position.shape[:-1], shape.radius)
        if shape.axis is not None:
            depth *= np.linalg.norm(np.cross(normal, shape.axis), axis=-1)
        return position @ up - self.height + (normal @ shape.corners.T).min(axis=-1) - depth


@dataclass(frozen=True)
class Flight:
    """A body's motion at the instants asked for, as far as it could be followed.

    Attributes
    ----------
    quaternion (k, 4) wxyz, rate (k, 3) rad/s body frame, position (k, 3) m, velocity (k, 3) m/s
    seconds : (k,), s, the instants kept; rest : their second part, or None
    events : impulses, contacts and, where the body comes to rest on the ground, the end
    starts : (m, FLIGHT_WIDTH), of each flight (`kernels.layout`); records : (m,) of INVARIANTS
    """

    quaternion: np.ndarray
    rate: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    seconds: np.ndarray
    rest: np.ndarray | None
    events: list[Event]
    starts: np.ndarray
    records: np.ndarray

    @property
    def segments(self) -> int:
        """How many flights between events there are."""
        return len(self.starts)


def fly(
    initial_state: InitialState,
    ground: Ground,
    gravity: np.ndarray,
    seconds: np.ndarray,
    kicks: Sequence[AppliedImpulse] = (),
    rest: np.ndarray | None = None,
) -> Flight:
    """Motion at some instants over a plane.

    Parameters
    ----------
    initial_state : with mass, position and velocity
    gravity : (3,), m/s2, inertial
    seconds : (n,), s since the epoch, ascending from 0 on; rest : their second part
    kicks : impulses in any order; those after the last instant change nothing

    An instant at which something happens gets the state after it.

    Raises
    ------
    InputError : a mass, position or velocity that is missing; a body in the ground at the epoch; an
        instant before it, or before its predecessor; restitution or friction out of range; more
        contacts than MAX_CONTACTS.
    ToleranceError : a flight so long that phases lose digits.
    """
    _check(initial_state, ground, seconds)
    course = _Course(initial_state, ground, np.asarray(gravity, dtype=float))
    last = float(seconds[-1]), 0.0 if rest is None else float(rest[-1])
    for kick in sorted(kicks, key=lambda kick: kick.seconds):
        if kick.seconds < 0.0:
            raise InputError("time", kick.seconds, ON)
        if (kick.seconds, 0.0) > last or not course.go_on(kick.seconds, 0.0):
            break
        course.kick(kick)
    course.go_on(*last)
    return course.sampled(np.asarray(seconds, dtype=float), rest)


def _check(initial_state: InitialState, ground: Ground, seconds: np.ndarray) -> None:
    if initial_state.mass is None or not initial_state.mass > 0.0:
        raise InputError("body.mass", initial_state.mass, "a positive mass, where there is a ground")
    if initial_state.position is None or initial_state.velocity is None:
        name = "position" if initial_state.position is None else "velocity"
        raise InputError(name, None, f"a {name}, where there is a ground")
    if not 0.0 <= ground.restitution <= 1.0:
        raise InputError("restitution", ground.restitution, "a number from 0 to 1")
    if not 0.0 <= ground.friction < np.inf:
        raise InputError("friction", ground.friction, "a number from 0")
    if len(seconds) == 0 or seconds[0] < 0.0:
        raise InputError("times", float(seconds[0]) if len(seconds) else None, ON)
    if (np.diff(seconds) < 0.0).any():
        place = int(np.argmax(np.diff(seconds) < 0.0)) + 1
        raise InputError(f"times[{place}]", float(seconds[place]), "instants in ascending order")
    height = float(ground.clearance(initial_state.attitude, initial_state.position))
    if height < -SUNK * ground.shape.size:
        expected = f"a body above the ground at t = 0 (its lowest point is {-height:.6g} m under it)"
        raise InputError("position", np.asarray(initial_state.position).tolist(), expected)


class _Course:
    """The flights so far, and what happened between them."""

    def __init__(self, initial_state: InitialState, ground: Ground, gravity: np.ndarray):
        body = initial_state.body
        self.mass, self.gravity, self.tensor = initial_state.mass or 0.0, gravity, np.array(body.tensor)
        self._body = self.tensor[None], body._two_part_moments[None].copy(), body._two_part_axes[None].copy()
        self._world = np.array(ground.shape.corners, dtype=float), _numbers(self.mass, ground, gravity)
        self._points = np.empty((len(ground.shape.corners) * layout.RIM_POINTS, layout.TOUCH_WIDTH))
        self._state = np.zeros(6)
        self._space = (
            *layout.workspace(),
            *(np.empty((1, 3)), np.empty((1, 4)), np.empty(1, np.bool_)),
            *(np.empty(1), np.empty((4, 1, 1)), np.empty((3, 1, 1))),
        )
        state = initial_state.attitude, initial_state.rate, initial_state.position, initial_state.velocity
        self._start = np.concatenate([(0.0, 0.0), *state])
        self._starts: list[np.ndarray] = []
        self._records: list[np.ndarray] = []
        self.events: list[Event] = []
        self.end: tuple[float, float] | None = None  # when the body came to rest

    def go_on(self, hi: float, lo: float) -> bool:
        """Fly until then; False where the body came to rest before."""
        while True:
            room = ROOM[0] if not self._records else ROOM[1]
            records, starts = np.zeros(room, layout.INVARIANTS), np.empty((room + 1, layout.FLIGHT_WIDTH))
            contacts, until = np.empty((room, layout.CONTACT_WIDTH)), np.array([hi, lo])
            starts[0] = self._start
            arrays = records, starts, contacts, self._points, self._state
            compiled.bounce(*self._body, *self._world, until, *arrays, *self._space)
            ended, count = int(self._state[2]), int(self._state[3])
            self._refuse(ended, starts[count])
            self._keep(records, starts, contacts[:count], ended)
            if ended == layout.TIME_IS_UP:
                return True
            if ended == layout.AT_REST:
                self.end = float(self._state[4]), float(self._state[5])
                self.events.append(Event(self.end[0], "rest", RESTS))
                return False

    def _keep(self, records: np.ndarray, starts: np.ndarray, contacts: np.ndarray, ended: int) -> None:
        whole = len(contacts) + (ended != layout.NO_ROOM)
        self._records.append(records[:whole])
        self._starts.append(starts[:whole])
        self._start = starts[len(contacts)]
        rate = max_phase_rate(records[:whole])
        refuse_too_far(rate, float(np.diff(starts[:whole, 0], append=self._state[4]).max()))
        self._tell(contacts, starts[1 : len(contacts) + 1])
        if len(self.events) > MAX_CONTACTS:
            expected = (
                f"a span with at most {MAX_CONTACTS} contacts (they are past by {self._start[0]:.6g} s)"
            )
            raise InputError("times", f"more than {MAX_CONTACTS} contacts", expected)

    def _tell(self, contacts: np.ndarray, after: np.ndarray) -> None:
        """Contacts, (k, CONTACT_WIDTH), and the flights that begin with them, as events."""
        lost = self._energy(contacts[:, 11:14], contacts[:, 8:11])
        lost -= self._energy(after[:, 12:15], after[:, 6:9])
        for row, state, energy in zip(contacts, after, lost.tolist(), strict=True):
            count, speed = int(row[0]), float(row[1])
            details = {
                "points": count,
                "normal_speed": speed,
                "impulse": row[2:5],
                "point": row[5:8],
                "energy_lost": energy,
                "rate_before": row[8:11],
                "rate_after": state[6:9],
                "velocity_before": row[11:14],
                "velocity_after": state[12:15],
            }
            text = f"contact with the ground at {count} point{'s'[: count > 1]}, {speed:.6g} m/s"
            self.events.append(Event(float(state[0]), "contact", text, details))

    def _energy(self, velocity: np.ndarray, rate: np.ndarray) -> np.ndarray:
        moving, turning = (velocity * velocity).sum(axis=1), ((rate @ self.tensor) * rate).sum(axis=1)
        return 0.5 * (self.mass * moving + turning)

    def _refuse(self, ended: int, start: np.ndarray) -> None:
        if ended == layout.OUT_OF_RANGE:
            expected = "a motion that stays within the range of a double"
            raise InputError("angular_velocity", start[6:9].tolist(), expected)
        if ended == layout.TOO_LONG:
            expected = f"a shorter span (from {start[0]:.6g} s on the body turns beside the ground)"
            raise InputError("times", float(self._state[4]), expected)

    def kick(self, kick: AppliedImpulse) -> None:
        """Change the momentum where the last flight has come to."""
        hi, lo = float(self._state[4]), float(self._state[5])
        start, record = self._starts[-1][-1], self._records[-1][-1:]
        time = np.array([(hi - start[0]) + (lo - start[1])])
        q, w = np.empty((4, 1, 1)), np.empty((3, 1, 1))
        compiled.sample(record, time, None, q, w, None, 0, 0, 1)
        attitude, rate = q[:, 0, 0], w[:, 0, 0]
        position, velocity = parabola(start[9:12], start[12:15], self.gravity, time[0])
        angular, linear = np.asarray(kick.angular, dtype=float), np.asarray(kick.linear, dtype=float)
        if kick.inertial:
            angular = rotations.rotate(attitude * (1.0, -1.0, -1.0, -1.0), angular)
        else:
            linear = rotations.rotate(attitude, linear)
        rate = rate + np.linalg.solve(self.tensor, angular)
        self._start = np.concatenate([(hi, lo), attitude, rate, position, velocity + linear / self.mass])
        self._state[1] = 0.0
        details = {"angular_impulse": angular, "impulse": linear}
        self.events.append(Event(hi, "impulse", "impulse by a thruster", details))

    def sampled(self, seconds: np.ndarray, rest: np.ndarray | None) -> Flight:
        starts, records = np.concatenate(self._starts), np.concatenate(self._records)
        low = np.zeros(len(seconds)) if rest is None else np.asarray(rest, dtype=float)
        if self.end is not None:
            kept = int(((seconds - self.end[0]) + (low - self.end[1]) <= 0.0).sum())
            seconds, low = seconds[:kept], low[:kept]
        flight, time, time_low = _since_start(starts, seconds, low)
        q, w = np.empty((4, 1, len(seconds))), np.empty((3, 1, len(seconds)))
        bounds = [*np.flatnonzero(np.diff(flight, prepend=-1)).tolist(), len(seconds)]
        for first, last in pairwise(bounds):
            record = records[flight[first] : flight[first] + 1]
            compiled.sample(record, time, time_low, q, w, None, 0, first, last)
        of = starts[flight]
        position, velocity = parabola(of[:, 9:12], of[:, 12:15], self.gravity, time)
        rest = None if rest is None else low
        return Flight(q[:, 0].T, w[:, 0].T, position, velocity, seconds, rest, self.events, starts, records)


def _numbers(mass: float, ground: Ground, gravity: np.ndarray) -> np.ndarray:
    """The plane and the body as kernels take them (`kernels.layout`, WORLD_WIDTH)."""
    shape, axis = ground.shape, ground.shape.axis
    rounding = layout.BALL if axis is None else layout.RIM
    out = np.zeros(layout.WORLD_WIDTH)
    out[0], out[1:4], out[4:7], out[7] = mass, gravity, ground.up, ground.height
    out[8:10] = ground.restitution, ground.friction
    out[10], out[11] = rounding if shape.radius > 0.0 else layout.SHARP, shape.radius
    out[12:15] = (0.0, 0.0, 0.0) if axis is None else axis
    out[15:] = shape.reach, shape.size
    return out


def _since_start(
    starts: np.ndarray, seconds: np.ndarray, low: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """For each instant the last flight that has begun, and the time since then in two parts."""
    flight = np.searchsorted(starts[:, 0], seconds, side="right") - 1
    while True:
        hi, lo = starts[flight, 0], starts[flight, 1]
        early = ((seconds - hi) + (low - lo) < 0.0) & (flight > 0)
        if not early.any():
            break
        flight[early] -= 1
    time = seconds - hi
    part = time - seconds
    return flight, time, (seconds - (time - part)) - (hi + part) + (low - lo)
