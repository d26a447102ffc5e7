"""The fastest angular rate of bodies under torques and impulses: what steps and spans are measured by."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .. import stopping
from ..frames import rotations
from ..problem.initial_state import InitialState
from ..problem.spin_bound import free_spin
from ..problem.torque_model import AppliedImpulse, CachedTorque
from ..problem.torque_rows import turned
from .batch_states import Bodies, once_for_bodies
from .momentum import impulse_sums, nutation_rates, rotors_and_dissipation
from .vector_sums import lengths


@once_for_bodies
def max_angular_rates(
    template: InitialState,
    bodies: Bodies,
    torques: Sequence[CachedTorque],
    impulses: Sequence[AppliedImpulse] = (),
) -> np.ndarray:
    """(n,) rad/s: the greatest of the spin, after every impulse, what torques make of it, the nutation that
    rotors make, and the orbit's.
    """
    moments = np.asarray(bodies.body.moments)
    axes = bodies.axes
    fastest = at_epoch = turned(axes, bodies.rate)
    own, momentum = lengths(at_epoch), lengths(moments * at_epoch)
    for added in impulse_sums(impulses, bodies.attitude)[1:]:
        stopping.check()
        back = rotations.rotate(rotations.conjugate(bodies.attitude), added)
        rates = at_epoch + turned(axes, back) / moments
        speed = lengths(rates)
        fastest = np.where((speed > own)[:, None], rates, fastest)
        own, momentum = np.maximum(own, speed), np.maximum(momentum, lengths(moments * rates))
    spin = free_spin(moments, fastest)
    size = sum((torque.sizes(moments, spin) for torque in torques), np.zeros(len(bodies)))
    orbit = 2.0 * np.pi / template.orbit_path.period if template.orbit_path is not None else 0.0
    with np.errstate(over="ignore"):  # infinite for a body that is thin enough
        swung = np.sqrt(size / moments.min(axis=1))
    turning = np.maximum(own, momentum / moments.max(axis=1))
    rotors = turned(axes, rotors_and_dissipation(template, bodies, torques)[0])
    nutation = nutation_rates(moments, rotors)
    greatest: np.ndarray = np.maximum(np.maximum(np.maximum(turning, nutation), swung), orbit)
    return greatest


def rates_after(bodies: Bodies, added: np.ndarray) -> np.ndarray:
    """(n, 3) rad/s, body frame: at the epoch's attitude, with inertial momenta (n, 3) added to the bodies."""
    back = rotations.rotate(rotations.conjugate(bodies.attitude), added)
    rates: np.ndarray = bodies.rate + np.linalg.solve(bodies.body.tensor, back[..., None])[..., 0]
    return rates
