"""Impulses and nothing else: the closed form between them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import InputError, ToleranceError
from ..frames import rotations
from ..problem.initial_state import InitialState
from ..problem.torque_model import AppliedImpulse
from ..problem.torque_rows import turned
from ..rigid_body.body import RigidBody
from ..rigid_body.constants_of_motion import Batch, check_rates
from ..times.instants import Instants
from .arcs import Arc, instants_within, legs
from .batch_states import Bodies, named
from .integration import two_part
from .momentum import inertial
from .solvers import OUTPUTS


def coast(initial_state: InitialState, kicks: Sequence[AppliedImpulse], instants: Instants) -> np.ndarray:
    """(OUTPUTS, m): attitude, rate and momentum at the instants.

    The momentum is the sum of that at the epoch and of the impulses, and nothing else ever changes it.
    """
    return _rows(
        initial_state, initial_state.body, initial_state.attitude, initial_state.rate, kicks, instants
    )


def coast_each(
    like: InitialState, bodies: Bodies, kicks: Sequence[AppliedImpulse], instants: Instants
) -> np.ndarray:
    """(n, OUTPUTS, m): `coast` of many bodies, side by side.

    Raises
    ------
    InputError, ToleranceError : as `TorqueFreeMotion`, of the first body that it cannot take, named.
    """
    try:
        return _rows(like, bodies.body, bodies.attitude, bodies.rate, kicks, instants)
    except (InputError, ToleranceError):
        rows = np.empty((len(bodies), OUTPUTS, instants.seconds.size))
        for i in range(len(bodies)):
            with named(bodies, i):
                rows[i] = coast(bodies.initial_state(like, i), kicks, instants)
        return rows


def _rows(
    like: InitialState,
    body: RigidBody,
    attitude: np.ndarray,
    rate: np.ndarray,
    kicks: Sequence[AppliedImpulse],
    instants: Instants,
) -> np.ndarray:
    """(..., OUTPUTS, m), of one body or of many."""
    seconds, rest = two_part(instants)
    rows = np.empty((*body.shape, OUTPUTS, seconds.size))
    for stop, mine in ((like.start, seconds < 0.0), (like.stop, seconds >= 0.0)):
        if mine.any():
            cut = legs(like, (), kicks, stop)
            _coast(body, attitude, rate, cut, (seconds, rest), np.flatnonzero(mine), rows)
    return rows


def _coast(
    body: RigidBody,
    attitude: np.ndarray,
    rate: np.ndarray,
    cut: list[Arc],
    instants: tuple[np.ndarray, np.ndarray],
    mine: np.ndarray,
    rows: np.ndarray,
) -> None:
    """From the epoch in one direction, for the instants at the places `mine`."""
    seconds, rest = instants
    tensor, sign = body.tensor, 1.0 if cut[-1].stop >= 0.0 else -1.0
    momentum = rotations.rotate(attitude, turned(tensor, rate))
    for leg, place in zip(cut, instants_within(cut, seconds[mine], rest[mine]), strict=True):
        for kick in leg.kicks:
            momentum = momentum + sign * inertial(kick, attitude)
        if leg.kicks:
            body_momentum = rotations.rotate(rotations.conjugate(attitude), momentum)
            rate = np.linalg.solve(tensor, body_momentum[..., None])[..., 0]
        motion = Batch(body, attitude, check_rates(rate), body.shape)
        here = mine[place]
        at = _since(leg.start, np.append(seconds[here], leg.stop), np.append(rest[here], 0.0))
        quaternion, turning = motion.sample(at, quaternion=True, rate=True)
        rows[..., :4, here] = np.swapaxes(quaternion[..., :-1, :], -1, -2)
        rows[..., 4:7, here] = np.swapaxes(turning[..., :-1, :], -1, -2)
        rows[..., 7:, here] = momentum[..., None]
        attitude, rate = (np.ascontiguousarray(one[..., -1, :]) for one in (quaternion, turning))


def _since(start: float, seconds: np.ndarray, rest: np.ndarray) -> Instants:
    """Two-part time since the start of a leg."""
    time = seconds - start
    part = time - seconds
    return Instants(time, (seconds - (time - part)) - (start + part) + rest, None)
