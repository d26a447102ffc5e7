"""Bodies that fly freely, get impulses, and bounce on a plane: the closed form between events.

Between two events attitude and rate are those of torque-free motion and the centre of mass moves on its
parabola, both exact; contacts are found to the last digits (`kernels.contact.clearance`) and change the
momentum at an instant (`kernels.contact.impact`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .. import stopping
from ..errors import InputError
from ..frames import rotations
from ..kernels.layout import (
    INVARIANTS,
    RIM_POINTS,
    BounceState,
    ContactRow,
    CornerKind,
    FlightEnd,
    FlightRow,
    TouchRow,
    workspace,
)
from ..problem.initial_state import InitialState
from ..problem.torque_model import AppliedImpulse
from ..rigid_body.error_bounds import max_phase_rate, refuse_too_far
from ..runtime import compiled
from ..samples.event import Event
from ..samples.translation import parabola
from ..times.two_part import two_sum

# A body may be in the ground by the rounding of its position: depth relative to its size.
MAX_RELATIVE_DEPTH = 1e-12
MAX_CONTACTS = 100_000

NON_NEGATIVE_TIME = "an instant from 0 s on: scenes with ground support t >= 0 only"


class RoundedHull(NamedTuple):
    """The convex hull of corners, each with a ball or a disc about it.

    Attributes
    ----------
    corners : (n, 3), m, from the centre of mass, body frame
    corner_radius : of the balls or discs, m; zero for a polyhedron
    axis : (3,) unit vector, body frame, normal to the discs; None for balls
    """

    corners: np.ndarray
    corner_radius: float = 0.0
    axis: np.ndarray | None = None

    @property
    def reach(self) -> float:
        """Greatest distance from the centre of mass of a point that moves with the attitude, m."""
        if self.axis is None:
            return float(np.linalg.norm(self.corners, axis=1).max())
        axial = self.corners @ self.axis
        radial = np.linalg.norm(self.corners - axial[:, None] * self.axis, axis=1) + self.corner_radius
        return float(np.hypot(axial, radial).max())

    @property
    def size(self) -> float:
        """Greatest distance of a point from the centre of mass, m."""
        return self.reach + (self.corner_radius if self.axis is None else 0.0)


def box(lengths: ArrayLike, centre: ArrayLike = (0.0, 0.0, 0.0)) -> RoundedHull:
    """Box with edges along the body axes, m."""
    signs = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return RoundedHull(np.asarray(centre, dtype=float) + signs * np.asarray(lengths, dtype=float))


def cylinder(
    radius: float, height: float, axis: ArrayLike, centre: ArrayLike = (0.0, 0.0, 0.0)
) -> RoundedHull:
    """Cylinder, m, about an axis of any length."""
    unit = np.asarray(axis, dtype=float) / np.linalg.norm(np.asarray(axis))
    ends = np.asarray(centre, dtype=float) + np.outer((-0.5 * height, 0.5 * height), unit)
    return RoundedHull(ends, radius, unit)


def sphere(radius: float, centre: ArrayLike = (0.0, 0.0, 0.0)) -> RoundedHull:
    """Sphere, m."""
    return RoundedHull(np.asarray(centre, dtype=float).reshape(1, 3), radius)


class GroundPlane(NamedTuple):
    """A plane, and how a body of some shape bounces on it.

    Attributes
    ----------
    normal : (3,), inertial, away from the ground, of any length
    height : m, of the plane along the normal
    shape : RoundedHull of the body
    restitution : 0 to 1, the normal impulse of restitution over that of compression (Poisson)
    friction : Coulomb's coefficient, from 0
    """

    normal: np.ndarray
    height: float
    shape: RoundedHull
    restitution: float
    friction: float = 0.0

    @property
    def unit_normal(self) -> np.ndarray:
        """(3,), inertial."""
        return np.asarray(self.normal, dtype=float) / np.linalg.norm(self.normal)

    def clearance(self, quaternion: np.ndarray, position: np.ndarray) -> np.ndarray:
        """(...), m: height of the body's lowest point over the plane; (..., 4) wxyz and (..., 3) m."""
        up, shape = self.unit_normal, self.shape
        inverse = quaternion * (1.0, -1.0, -1.0, -1.0)
        normal = rotations.rotate(inverse, np.broadcast_to(up, position.shape))
        depth = np.full(position.shape[:-1], shape.corner_radius)
        if shape.axis is not None:
            depth *= np.linalg.norm(np.cross(normal, shape.axis), axis=-1)
        return position @ up - self.height + (normal @ shape.corners.T).min(axis=-1) - depth

    def numbers(self, mass: float, gravity: np.ndarray) -> np.ndarray:
        """Plane, gravity, mass and shape as kernels take them (`kernels.layout.GroundRow`)."""
        shape, axis = self.shape, self.shape.axis
        rounded = CornerKind.BALL if axis is None else CornerKind.RIM
        kind = rounded if shape.corner_radius > 0.0 else CornerKind.SHARP
        laws = self.height, self.restitution, self.friction, kind, shape.corner_radius
        direction = np.zeros(3) if axis is None else axis
        return np.concatenate(
            [[mass], gravity, self.unit_normal, laws, direction, [shape.reach, shape.size]], dtype=float
        )


@dataclass(frozen=True)
class Flight:
    """A body's motion at the requested instants, up to its rest on the ground.

    Attributes
    ----------
    quaternion (k, 4) wxyz, rate (k, 3) rad/s body frame, position (k, 3) m, velocity (k, 3) m/s
    seconds : (k,), s, the instants up to the end; rest : their second part, or None
    events : impulses, contacts and, where the body comes to rest on the ground, the end
    starts : (m, FlightRow.WIDTH), of each flight (`kernels.layout`); records : (m,) of INVARIANTS
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
        """Number of flights between events."""
        return len(self.starts)


def fly(
    initial_state: InitialState,
    ground: GroundPlane,
    gravity: np.ndarray,
    seconds: np.ndarray,
    impulses: Sequence[AppliedImpulse] = (),
    rest: np.ndarray | None = None,
) -> Flight:
    """Motion over a plane, sampled.

    Parameters
    ----------
    initial_state : with mass, position and velocity
    gravity : (3,), m/s2, inertial
    seconds : (n,), s since the epoch, ascending from 0 on; rest : their second part
    impulses : in any order; those after the last instant have no effect

    The state at the instant of an event is the one after it.

    Raises
    ------
    InputError : a mass, position or velocity that is missing; a body in the ground at the epoch; an
        instant before it, or before its predecessor; restitution or friction out of range; more
        contacts than MAX_CONTACTS.
    ToleranceError : a flight so long that phases lose digits.
    """
    _check(initial_state, ground, seconds)
    log = _FlightLog(initial_state, ground, np.asarray(gravity, dtype=float))
    last = float(seconds[-1]), 0.0 if rest is None else float(rest[-1])
    for impulse in sorted(impulses, key=lambda impulse: impulse.seconds):
        if impulse.seconds < 0.0:
            raise InputError("time", impulse.seconds, NON_NEGATIVE_TIME)
        if (impulse.seconds, 0.0) > last or not log.fly_until(impulse.seconds, 0.0):
            break
        log.apply(impulse)
    log.fly_until(*last)
    return log.sampled(np.asarray(seconds, dtype=float), rest)


def _check(initial_state: InitialState, ground: GroundPlane, seconds: np.ndarray) -> None:
    if initial_state.mass is None or not initial_state.mass > 0.0:
        raise InputError("body.mass", initial_state.mass, "a positive mass, in a scene with ground")
    if initial_state.position is None or initial_state.velocity is None:
        name = "position" if initial_state.position is None else "velocity"
        raise InputError(name, None, f"a {name}, in a scene with ground")
    if not 0.0 <= ground.restitution <= 1.0:
        raise InputError("restitution", ground.restitution, "a number from 0 to 1")
    if not 0.0 <= ground.friction < np.inf:
        raise InputError("friction", ground.friction, "a number from 0")
    if len(seconds) == 0 or seconds[0] < 0.0:
        raise InputError("times", float(seconds[0]) if len(seconds) else None, NON_NEGATIVE_TIME)
    descending = np.flatnonzero(np.diff(seconds) < 0.0)
    if descending.size:
        i = int(descending[0]) + 1
        raise InputError(f"times[{i}]", float(seconds[i]), "instants in ascending order")
    height = float(ground.clearance(initial_state.attitude, initial_state.position))
    if height < -MAX_RELATIVE_DEPTH * ground.shape.size:
        expected = f"a body above the ground at t = 0 (its lowest point is {-height:.6g} m under it)"
        raise InputError("position", np.asarray(initial_state.position).tolist(), expected)


class _FlightLog:
    """Flights so far, and the events between them."""

    def __init__(self, initial_state: InitialState, ground: GroundPlane, gravity: np.ndarray):
        body, corners = initial_state.body, np.array(ground.shape.corners, dtype=float)
        self.mass, self.gravity, self.tensor = initial_state.mass or 0.0, gravity, np.array(body.tensor)
        self._inputs = (
            *(self.tensor[None], body._two_part_moments[None].copy(), body._two_part_axes[None].copy()),
            *(corners, ground.numbers(self.mass, gravity)),
        )
        self._scratch = (
            *workspace(),
            *(np.empty((1, 3)), np.empty((1, 4))),
            *(np.empty(1), np.empty((4, 1, 1)), np.empty((3, 1, 1))),
            np.empty((len(corners) * RIM_POINTS, TouchRow.WIDTH)),
        )
        self._state = np.zeros(BounceState.WIDTH)
        state = initial_state.attitude, initial_state.rate, initial_state.position, initial_state.velocity
        self._start = np.concatenate([(0.0, 0.0), *state])
        self._starts: list[np.ndarray] = []
        self._records: list[np.ndarray] = []
        self.events: list[Event] = []
        self.end: tuple[float, float] | None = None  # when the body came to rest

    def fly_until(self, hi: float, lo: float) -> bool:
        """Fly until hi + lo, s; False if the body comes to rest before."""
        while True:
            size = 512 if self._records else 64  # flights that the log of this call has room for
            records, starts = np.zeros(size, INVARIANTS), np.empty((size + 1, FlightRow.WIDTH))
            contacts = np.empty((size, ContactRow.WIDTH))
            starts[0], self._state[BounceState.UNTIL :] = self._start, (hi, lo)
            stop = stopping.current()
            compiled.bounce(*self._inputs, self._state, stop.flag, records, starts, contacts, *self._scratch)
            stop.check()
            outcome, count = int(self._state[BounceState.END]), int(self._state[BounceState.CONTACTS])
            self._refuse(outcome, starts[count])
            self._append(records, starts, contacts[:count], outcome)
            if outcome == FlightEnd.TIME_IS_UP:
                return True
            if outcome == FlightEnd.AT_REST:
                self.end = self._ended()
                text = (
                    "bounces accumulate: from here on the body stays in contact with the ground, which is "
                    "not simulated, and the ephemeris ends"
                )
                self.events.append(Event(self.end[0], "rest", text))
                return False

    def _append(self, records: np.ndarray, starts: np.ndarray, contacts: np.ndarray, outcome: int) -> None:
        flights = len(contacts) + (outcome != FlightEnd.NO_ROOM)
        self._records.append(records[:flights])
        self._starts.append(starts[:flights])
        self._start = starts[len(contacts)]
        durations = np.diff(starts[:flights, FlightRow.TIME], append=self._ended()[0])
        refuse_too_far(max_phase_rate(records[:flights]), float(durations.max()))
        self._append_contacts(contacts, starts[1 : len(contacts) + 1])
        if len(self.events) > MAX_CONTACTS:
            exceeded = self._start[FlightRow.TIME]
            expected = f"a span with at most {MAX_CONTACTS} contacts (exceeded at {exceeded:.6g} s)"
            raise InputError("times", f"more than {MAX_CONTACTS} contacts", expected)

    def _append_contacts(self, contacts: np.ndarray, after: np.ndarray) -> None:
        """Append events for contacts, (k, ContactRow.WIDTH), and the flights that begin with them."""
        velocity, rate = _vector(contacts, ContactRow.VELOCITY), _vector(contacts, ContactRow.RATE)
        velocity_after, rate_after = _vector(after, FlightRow.VELOCITY), _vector(after, FlightRow.RATE)
        lost = self._energy(velocity, rate) - self._energy(velocity_after, rate_after)
        for i, row in enumerate(contacts):
            count, speed = int(row[ContactRow.POINTS]), float(row[ContactRow.SPEED])
            details = {
                "points": count,
                "normal_speed": speed,
                "impulse": _vector(row, ContactRow.IMPULSE),
                "point": _vector(row, ContactRow.CENTRE),
                "energy_lost": float(lost[i]),
                "rate_before": rate[i],
                "rate_after": rate_after[i],
                "velocity_before": velocity[i],
                "velocity_after": velocity_after[i],
            }
            text = f"contact with the ground at {count} point{'s'[: count > 1]}, {speed:.6g} m/s"
            self.events.append(Event(float(after[i, FlightRow.TIME]), "contact", text, details))

    def _ended(self) -> tuple[float, float]:
        """When the last call ended, s, in two parts."""
        return float(self._state[BounceState.TIME]), float(self._state[BounceState.TIME + 1])

    def _energy(self, velocity: np.ndarray, rate: np.ndarray) -> np.ndarray:
        linear, angular = (velocity * velocity).sum(axis=1), ((rate @ self.tensor) * rate).sum(axis=1)
        return 0.5 * (self.mass * linear + angular)

    def _refuse(self, outcome: int, start: np.ndarray) -> None:
        if outcome == FlightEnd.OUT_OF_RANGE:
            expected = "a motion that stays within the range of a double"
            raise InputError("angular_velocity", _vector(start, FlightRow.RATE).tolist(), expected)
        if outcome == FlightEnd.TOO_LONG:
            expected = (
                f"a shorter span (from {start[FlightRow.TIME]:.6g} s on the body rotates close to the ground)"
            )
            raise InputError("times", self._ended()[0], expected)

    def apply(self, impulse: AppliedImpulse) -> None:
        """Change the momentum at the end of the last flight."""
        hi, lo = self._ended()
        start, record = self._starts[-1][-1], self._records[-1][-1:]
        time = np.array([(hi - start[FlightRow.TIME]) + (lo - start[FlightRow.TIME_LOW])])
        q, w = np.empty((4, 1, 1)), np.empty((3, 1, 1))
        compiled.sample(record, time, None, q, w, 0, 0, 1)
        attitude, rate = q[:, 0, 0], w[:, 0, 0]
        position, velocity = parabola(
            _vector(start, FlightRow.POSITION), _vector(start, FlightRow.VELOCITY), self.gravity, time[0]
        )
        angular, linear = np.asarray(impulse.angular, dtype=float), np.asarray(impulse.linear, dtype=float)
        if impulse.inertial:
            angular = rotations.rotate(attitude * (1.0, -1.0, -1.0, -1.0), angular)
        else:
            linear = rotations.rotate(attitude, linear)
        rate = rate + np.linalg.solve(self.tensor, angular)
        self._start = np.concatenate([(hi, lo), attitude, rate, position, velocity + linear / self.mass])
        self._state[BounceState.QUICK_CONTACTS] = 0.0
        details = {"angular_impulse": angular, "impulse": linear}
        self.events.append(Event(hi, "impulse", "impulse by a thruster", details))

    def sampled(self, seconds: np.ndarray, rest: np.ndarray | None) -> Flight:
        """Sample the flights up to the end."""
        starts, records = np.concatenate(self._starts), np.concatenate(self._records)
        low = np.zeros(len(seconds)) if rest is None else np.asarray(rest, dtype=float)
        if self.end is not None:
            count = int(((seconds - self.end[0]) + (low - self.end[1]) <= 0.0).sum())
            seconds, low = seconds[:count], low[:count]
        flight, time, time_low = _since_start(starts, seconds, low)
        q, w = np.empty((4, 1, len(seconds))), np.empty((3, 1, len(seconds)))
        bounds = [*np.flatnonzero(np.diff(flight, prepend=-1)).tolist(), len(seconds)]
        for first, last in pairwise(bounds):
            stopping.check()
            record = records[flight[first] : flight[first] + 1]
            compiled.sample(record, time, time_low, q, w, 0, first, last)
        start = starts[flight]
        position, velocity = parabola(
            _vector(start, FlightRow.POSITION), _vector(start, FlightRow.VELOCITY), self.gravity, time
        )
        rest = None if rest is None else low
        return Flight(q[:, 0].T, w[:, 0].T, position, velocity, seconds, rest, self.events, starts, records)


def _vector(rows: np.ndarray, first: int) -> np.ndarray:
    """(..., 3): numbers of each row, from `first` on."""
    return rows[..., first : first + 3]


def _since_start(
    starts: np.ndarray, seconds: np.ndarray, low: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Index of the last flight that has begun at each instant, and the time since then in two parts."""
    flight = np.searchsorted(starts[:, FlightRow.TIME], seconds, side="right") - 1
    while True:
        stopping.check()
        hi, lo = starts[flight, FlightRow.TIME], starts[flight, FlightRow.TIME_LOW]
        early = ((seconds - hi) + (low - lo) < 0.0) & (flight > 0)
        if not early.any():
            break
        flight[early] -= 1
    time, rounding = two_sum(seconds, -hi)
    return flight, time, rounding + (low - lo)
