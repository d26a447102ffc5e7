"""Bounds on how fast bodies turn, from which the size of torques that depend on the spin is estimated.

Moments and rates, (..., 3), are those along the principal axes, kg m2 and rad/s.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ..kernels.layout import EffectCode
from .initial_state import InitialState, Spin
from .torque_model import AppliedImpulse, CachedTorque

# Torques that vanish on a body at rest: others have to spin it up first.
SPIN_DEPENDENT = {EffectCode.WHEELS, EffectCode.DISSIPATION, EffectCode.EDDY}
# Torques with a potential: range of the potential over the greatest torque.
POTENTIAL_PER_TORQUE: dict[int, float] = {
    EffectCode.GRAVITY_GRADIENT: 1.0,
    EffectCode.MAGNETIC: 2.0,
}


def free_spin(moments: np.ndarray, rates: np.ndarray) -> Spin:
    """Bounds of free rotation: sqrt(2E / I), I the least moment, and the momentum itself."""
    rate = np.sqrt((rates * (moments * rates)).sum(axis=-1) / moments.min(axis=-1))
    return Spin(rate, np.sqrt(((moments * rates) ** 2).sum(axis=-1)))


def greatest_free_rate(moments: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """(...) rad/s: the greatest that the rate of a free body reaches, where its polhode meets a plane.

    Of bodies of energy E and momentum L, omega^2 <= (2 E (I_lo + I_hi) - L^2) / (I_lo I_hi), since for each
    moment 1 <= I (I_lo + I_hi - I) / (I_lo I_hi); equal where the component along the middle axis is zero.
    """
    least, greatest = moments.min(axis=-1, keepdims=True), moments.max(axis=-1, keepdims=True)
    shares = moments / least * ((least + greatest - moments) / greatest)
    return np.asarray(np.sqrt((shares * rates**2).sum(axis=-1)))


def reached_spin(
    initial_state: InitialState, torques: Iterable[CachedTorque], impulses: Sequence[AppliedImpulse]
) -> Spin:
    """Bounds over the whole span for one body under all torques and impulses.

    A torque T changes sqrt(2E) by at most T / sqrt(I) a second, I the least moment, and an impulse J by
    J / sqrt(I).  Torques with a potential add to E no more than its range, in a field that turns with the
    orbit.  Eddy currents and dissipation take energy forwards and give it backwards; rotors keep it.
    """
    moments, span = initial_state.moments, max(abs(initial_state.start), abs(initial_state.stop))
    least, greatest = float(moments.min()), float(moments.max())
    free = free_spin(moments, initial_state.axes @ initial_state.rate)
    rotors, dissipation, damping = 0.0, 0.0, 0.0
    angular_impulse = sum(float(np.linalg.norm(impulse.angular)) for impulse in impulses)
    conservative, potential = 0.0, 0.0
    for torque in torques:
        rows = torque.own_rows
        codes = {int(code) for code in rows[:, 0]}
        if codes <= SPIN_DEPENDENT:
            rotors += float(np.linalg.norm(rows[rows[:, 0] == EffectCode.WHEELS, 1:4], axis=1).sum())
            dissipation += float(rows[rows[:, 0] == EffectCode.DISSIPATION, 1].sum())
            tensors = rows[rows[:, 0] == EffectCode.EDDY, 1:10].reshape(-1, 3, 3)
            damping += sum(float(np.linalg.eigvalsh(tensor)[-1]) for tensor in tensors)
        elif codes <= POTENTIAL_PER_TORQUE.keys():
            size = float(torque.size(initial_state))
            conservative += size
            potential += size * max(POTENTIAL_PER_TORQUE[code] for code in codes)
        else:
            angular_impulse += float(torque.size(initial_state)) * span
    with np.errstate(over="ignore"):  # infinite where eddy damping is followed far backwards
        momentum = free.momentum + angular_impulse + conservative * span + 2.0 * rotors
        momentum = momentum * np.exp(damping / least * span)
        energy = (free.rate * np.sqrt(least) + angular_impulse / np.sqrt(least)) ** 2 + 2.0 * potential
        if conservative and initial_state.orbit_path is not None:
            energy += least * (4.0 * np.pi / initial_state.orbit_path.period) ** 2
        if initial_state.start < 0.0 and dissipation and energy > 0.0:
            energy = np.inf
        elif initial_state.start < 0.0:
            energy = energy * np.exp(-2.0 * damping / least * initial_state.start)
    rate = min(float(np.sqrt(energy / least)), float(momentum / least))
    return Spin(rate, min(float(np.sqrt(energy * greatest)), float(momentum)), rotors)
