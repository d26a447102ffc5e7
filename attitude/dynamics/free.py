"""Impulses and nothing else: the closed form between them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .. import orientation
from ..elapsed import Instants
from ..motion import TorqueFreeMotion
from .acting import Kick
from .legs import instants_within, legs
from .momentum import inertial
from .situation import Situation
from .solvers import OUTPUTS


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


def _since(start: float, seconds: np.ndarray, rest: np.ndarray) -> Instants:
    """Two-part time since the start of a leg."""
    time = seconds - start
    part = time - seconds
    return Instants(time, (seconds - (time - part)) - (start + part) + rest, None)
