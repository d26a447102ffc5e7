"""Motion in closed form between impulses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .. import stopping
from ..errors import InputError, RegimeError, ToleranceError
from ..frames import rotations
from ..problem.initial_state import InitialState
from ..problem.torque_model import AppliedImpulse
from ..rigid_body.body import RigidBody
from ..times.instants import Instants
from ..times.two_part import two_sum
from .arc_integration import ROUNDING_OF_MOMENTUM, rounding, two_part
from .arcs import Arc, arcs_by_direction, instants_within
from .batch_states import Bodies, named
from .error_estimate import angles, compared_instants
from .exact_motion import FREE_ROTATION, ExactMotion
from .momentum import inertial_components
from .solver import OUTPUTS
from .vector_sums import lengths


def coast(
    template: InitialState,
    bodies: Bodies,
    impulses: Sequence[AppliedImpulse],
    instants: Instants,
    motion: ExactMotion = FREE_ROTATION,
    disturbed: int = 0,
) -> np.ndarray:
    """(n, OUTPUTS, m): attitude, rate and momentum of each body at the instants.

    Where no torque acts, the momentum is the sum of that at the epoch and of the impulses.

    disturbed : by a rounding at every impulse, for what the motion makes of it, in one direction (1) or
        another (2)

    Raises
    ------
    InputError, ToleranceError : as `TorqueFreeMotion`, of the first body whose rate is out of range, named.
    RegimeError : as `ExactMotion.of`.
    """
    paths, at = arcs_by_direction(template, (), impulses), two_part(instants)
    try:
        return _coast(motion, bodies.body, bodies.attitude, bodies.rate, paths, at, disturbed)
    except (InputError, ToleranceError, RegimeError):
        rows = np.empty((len(bodies), OUTPUTS, at.shape[1]))
        for i in range(len(bodies)):
            with named(bodies, i):
                rows[i] = _coast(motion, bodies.body[i], bodies.attitude[i], bodies.rate[i], paths, at)
        return rows


def growth_of_rounding(
    template: InitialState,
    bodies: Bodies,
    impulses: Sequence[AppliedImpulse],
    instants: Instants,
    motion: ExactMotion,
) -> np.ndarray:
    """(n,) rad: what the motion makes, at the worst of some of the instants, of the rounding at impulses."""
    if not impulses:
        return np.zeros(len(bodies))
    at = two_part(instants)[:, compared_instants(instants.seconds.size)]
    exact, *others = (
        coast(template, bodies, impulses, Instants(at[0], at[1], None), motion, disturbed)[:, :4]
        for disturbed in (0, 1, 2)
    )
    # four times the difference that a rounding at every impulse makes
    return 4.0 * np.hypot(*(angles(exact, other).max(axis=1) for other in others))


def _coast(
    exact: ExactMotion,
    body: RigidBody,
    attitude: np.ndarray,
    rate: np.ndarray,
    paths: Sequence[list[Arc]],
    at: np.ndarray,
    disturbed: int = 0,
) -> np.ndarray:
    """(..., OUTPUTS, m), of bodies (...)."""
    seconds, low = at
    rows = np.empty((*body.shape, OUTPUTS, seconds.size))
    for path in paths:
        within = np.flatnonzero(seconds < 0.0 if path[-1].stop < 0.0 else seconds >= 0.0)
        if not within.size:
            continue
        sign, q, w = 1.0 if path[-1].stop >= 0.0 else -1.0, attitude, rate
        momentum = rotations.rotate(q, exact.momentum(body, w))
        for arc, index in zip(path, instants_within(path, seconds[within], low[within]), strict=True):
            stopping.check()
            for impulse in arc.impulses:
                momentum = momentum + sign * inertial_components(impulse, q)
            if arc.impulses:
                own = rotations.rotate(rotations.conjugate(q), momentum)
                w = exact.rate(body, own)
                if disturbed:  # what rotors have of the momentum is taken off again, but not its rounding
                    across = 0.0, float(disturbed == 1), float(disturbed == 2)
                    change = rounding(Bodies(body, q, w), exact.rotors, across, lengths(own))
                    w = exact.rate(body, own + change + ROUNDING_OF_MOMENTUM * exact.rotors)
            motion, here = exact.of(body, q, w), within[index]
            time, rest = two_sum(-arc.start, np.append(seconds[here], arc.stop))
            since_start = Instants(time, rest + np.append(low[here], 0.0), None)
            quaternion, turning = motion.sample(since_start, quaternion=True, rate=True)
            rows[..., :4, here] = np.swapaxes(quaternion[..., :-1, :], -1, -2)
            rows[..., 4:7, here] = np.swapaxes(turning[..., :-1, :], -1, -2)
            if exact.law is not None:
                momenta = rotations.rotate(quaternion, exact.momentum(body, turning))
                rows[..., 7:, here] = np.swapaxes(momenta[..., :-1, :], -1, -2)
                momentum = momenta[..., -1, :]
            else:
                rows[..., 7:, here] = momentum[..., None]
            q, w = (np.ascontiguousarray(one[..., -1, :]) for one in (quaternion, turning))
    return rows
