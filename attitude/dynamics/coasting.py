"""Impulses and nothing else: the closed form between them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .. import stopping
from ..errors import InputError, ToleranceError
from ..frames import rotations
from ..problem.initial_state import InitialState
from ..problem.torque_model import AppliedImpulse
from ..problem.torque_rows import turned
from ..rigid_body.body import RigidBody
from ..rigid_body.constants_of_motion import Batch, check_rates
from ..times.instants import Instants
from .arc_integration import two_part
from .arcs import Arc, arcs_by_direction, instants_within
from .batch_states import Bodies, named
from .momentum import inertial_components
from .solver import OUTPUTS


def coast(
    template: InitialState, bodies: Bodies, impulses: Sequence[AppliedImpulse], instants: Instants
) -> np.ndarray:
    """(n, OUTPUTS, m): attitude, rate and momentum of each body at the instants.

    The momentum is the sum of that at the epoch and of the impulses, and nothing else ever changes it.

    Raises
    ------
    InputError, ToleranceError : as `TorqueFreeMotion`, of the first body whose rate is out of range, named.
    """
    paths, at = arcs_by_direction(template, (), impulses), two_part(instants)
    try:
        return _coast(bodies.body, bodies.attitude, bodies.rate, paths, at)
    except (InputError, ToleranceError):
        rows = np.empty((len(bodies), OUTPUTS, at.shape[1]))
        for i in range(len(bodies)):
            with named(bodies, i):
                rows[i] = _coast(bodies.body[i], bodies.attitude[i], bodies.rate[i], paths, at)
        return rows


def _coast(
    body: RigidBody, attitude: np.ndarray, rate: np.ndarray, paths: Sequence[list[Arc]], at: np.ndarray
) -> np.ndarray:
    """(..., OUTPUTS, m), of bodies (...)."""
    seconds, low = at
    rows = np.empty((*body.shape, OUTPUTS, seconds.size))
    for path in paths:
        within = np.flatnonzero(seconds < 0.0 if path[-1].stop < 0.0 else seconds >= 0.0)
        if not within.size:
            continue
        sign, q, w = 1.0 if path[-1].stop >= 0.0 else -1.0, attitude, rate
        momentum = rotations.rotate(q, turned(body.tensor, w))
        for arc, index in zip(path, instants_within(path, seconds[within], low[within]), strict=True):
            stopping.check()
            for impulse in arc.impulses:
                momentum = momentum + sign * inertial_components(impulse, q)
            if arc.impulses:
                body_momentum = rotations.rotate(rotations.conjugate(q), momentum)
                w = np.linalg.solve(body.tensor, body_momentum[..., None])[..., 0]
            motion, here = Batch(body, q, check_rates(w), body.shape), within[index]
            since = _since(arc.start, np.append(seconds[here], arc.stop), np.append(low[here], 0.0))
            quaternion, turning = motion.sample(since, quaternion=True, rate=True)
            rows[..., :4, here] = np.swapaxes(quaternion[..., :-1, :], -1, -2)
            rows[..., 4:7, here] = np.swapaxes(turning[..., :-1, :], -1, -2)
            rows[..., 7:, here] = momentum[..., None]
            q, w = (np.ascontiguousarray(one[..., -1, :]) for one in (quaternion, turning))
    return rows


def _since(start: float, seconds: np.ndarray, low: np.ndarray) -> Instants:
    """Two-part time since the start of an arc."""
    time = seconds - start
    part = time - seconds
    return Instants(time, (seconds - (time - part)) - (start + part) + low, None)
