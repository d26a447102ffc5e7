"""Impulses and nothing else: the closed form between them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .. import orientation
from ..elapsed import Instants
from ..errors import InputError, ToleranceError
from ..motion import TorqueFreeMotion
from .acting import Kick
from .bodies import Bodies, named
from .legs import instants_within, legs
from .momentum import inertial
from .rows import turned
from .situation import Situation
from .solvers import OUTPUTS
from .torqued import two_part


def coast(situation: Situation, kicks: Sequence[Kick], instants: Instants) -> np.ndarray:
    """(OUTPUTS, n): attitude, rate and momentum at the instants.

    The momentum is the sum of that at the epoch and of the impulses, and nothing else ever changes it.
    """
    seconds = np.ascontiguousarray(instants.seconds).reshape(-1)
    rest = np.zeros_like(seconds) if instants.rest is None else instants.rest.reshape(-1)
    rows = np.empty((OUTPUTS, seconds.size))
    for stop, mine in ((situation.start, seconds < 0.0), (situation.stop, seconds >= 0.0)):
        if mine.any():
            _coast(situation, kicks, stop, seconds, rest, np.flatnonzero(mine), rows)
    return rows


def _coast(
    situation: Situation,
    kicks: Sequence[Kick],
    stop: float,
    seconds: np.ndarray,
    rest: np.ndarray,
    mine: np.ndarray,
    rows: np.ndarray,
) -> None:
    """From the epoch in one direction, for the instants at the places `mine`."""
    attitude, rate = situation.attitude, situation.rate
    momentum = orientation.rotate(attitude, situation.body.tensor @ rate)
    sign = 1.0 if stop >= 0.0 else -1.0
    cut = legs(situation, (), kicks, stop)
    for leg, place in zip(cut, instants_within(cut, seconds[mine], rest[mine]), strict=True):
        for kick in leg.kicks:
            momentum = momentum + sign * inertial(kick, attitude)
        if leg.kicks:
            body_momentum = orientation.rotate(orientation.conjugate(attitude), momentum)
            rate = np.linalg.solve(situation.body.tensor, body_momentum)
        motion = TorqueFreeMotion(situation.body, attitude, rate, order="wxyz", frame=situation.frame)
        here = mine[place]
        at = _since(leg.start, np.append(seconds[here], leg.stop), np.append(rest[here], 0.0))
        answer = motion.ephemeris(at, rate=True)
        quaternion = answer.quaternion("wxyz")
        rows[:4, here], rows[4:7, here] = quaternion[:-1].T, answer.angular_velocity[:-1].T
        rows[7:, here] = momentum[:, None]
        attitude, rate = quaternion[-1], answer.angular_velocity[-1]


def coast_each(like: Situation, bodies: Bodies, kicks: Sequence[Kick], instants: Instants) -> np.ndarray:
    """(n, 7, m): attitude and rate of many bodies at the instants, `coast` of each side by side.

    Raises
    ------
    InputError, ToleranceError : as `TorqueFreeMotion`, of the first body that it cannot take, named.
    """
    seconds, rest = two_part(instants)
    rows = np.empty((len(bodies), 7, seconds.size))
    try:
        for stop, mine in ((like.start, seconds < 0.0), (like.stop, seconds >= 0.0)):
            if mine.any():
                _coast_each(like, bodies, kicks, stop, seconds, rest, np.flatnonzero(mine), rows)
    except (InputError, ToleranceError):
        for i in range(len(bodies)):
            with named(bodies, i):
                rows[i] = coast(bodies.situation(like, i), kicks, instants)[:7]
    return rows


def _coast_each(
    like: Situation,
    bodies: Bodies,
    kicks: Sequence[Kick],
    stop: float,
    seconds: np.ndarray,
    rest: np.ndarray,
    mine: np.ndarray,
    rows: np.ndarray,
) -> None:
    """`_coast` of each."""
    attitude, rate, tensor = bodies.attitude, bodies.rate, bodies.body.tensor
    momentum = orientation.rotate(attitude, turned(tensor, rate))
    sign = 1.0 if stop >= 0.0 else -1.0
    cut = legs(like, (), kicks, stop)
    for leg, place in zip(cut, instants_within(cut, seconds[mine], rest[mine]), strict=True):
        for kick in leg.kicks:
            momentum = momentum + sign * inertial(kick, attitude)
        if leg.kicks:
            body_momentum = orientation.rotate(orientation.conjugate(attitude), momentum)
            rate = np.linalg.solve(tensor, body_momentum[:, :, None])[:, :, 0]
        motion = TorqueFreeMotion(bodies.body, attitude, rate, order="wxyz", frame=like.frame)
        here = mine[place]
        at = _since(leg.start, np.append(seconds[here], leg.stop), np.append(rest[here], 0.0))
        answer = motion.ephemeris(at, rate=True)
        quaternion, turning = answer.quaternion("wxyz"), answer.angular_velocity
        rows[:, :4, here] = np.swapaxes(quaternion[:, :-1], 1, 2)
        rows[:, 4:, here] = np.swapaxes(turning[:, :-1], 1, 2)
        attitude, rate = (np.ascontiguousarray(one[:, -1]) for one in (quaternion, turning))


def _since(start: float, seconds: np.ndarray, rest: np.ndarray) -> Instants:
    """Two-part time since the start of a leg."""
    time = seconds - start
    part = time - seconds
    return Instants(time, (seconds - (time - part)) - (start + part) + rest, None)
