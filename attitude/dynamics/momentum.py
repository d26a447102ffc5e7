"""Momentum at the epoch, and what an impulse adds to it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .. import stopping
from ..errors import InputError
from ..frames import rotations
from ..kernels.layout import EffectCode
from ..problem.initial_state import InitialState
from ..problem.torque_model import AppliedImpulse, CachedTorque
from ..problem.torque_rows import turned
from .batch_states import Bodies, named, once_for_bodies
from .vector_sums import dot


@once_for_bodies
def initial_momenta(template: InitialState, bodies: Bodies, torques: Sequence[CachedTorque]) -> np.ndarray:
    """(n, 3), inertial: momentum of each body and of the rotors in it.

    Dissipation inside turns the body too: the rate that the document gives is the whole one, from which the
    momentum follows by iteration.

    Raises
    ------
    InputError : dissipation that takes the energy within a turn.
    """
    rotors, alpha = rotors_and_dissipation(template, bodies, torques)
    rate = _momentum_rates(bodies, rotors, alpha) if alpha.any() else bodies.rate
    for i in np.flatnonzero(~np.isfinite(rate).all(axis=1)).tolist():
        with named(bodies, i):
            expected = "a coefficient so small that energy falls over more than a turn"
            raise InputError("dissipation", float(alpha[i]), expected)
    return rotations.rotate(bodies.attitude, turned(bodies.body.tensor, rate) + rotors)


@once_for_bodies
def rotors_and_dissipation(
    template: InitialState, bodies: Bodies, torques: Sequence[CachedTorque]
) -> tuple[np.ndarray, np.ndarray]:
    """Momentum of the rotors (n, 3), body frame, and coefficient of the dissipation (n,)."""
    rotors, alpha = np.zeros((len(bodies), 3)), np.zeros(len(bodies))
    for torque in torques:
        if torque.follows_axes:
            rows, axes = np.repeat(torque.own_rows[None], len(bodies), axis=0), None
        else:
            states = [bodies.initial_state(template, i) for i in range(len(bodies))]
            rows, axes = np.stack([torque.rows(state) for state in states]), bodies.axes
        for k in range(rows.shape[1]):
            if rows[0, k, 0] == EffectCode.WHEELS:
                added = rows[:, k, 1:4]
                rotors = rotors + (added if axes is None else turned(np.swapaxes(axes, 1, 2), added))
            elif rows[0, k, 0] == EffectCode.DISSIPATION:
                alpha = alpha + rows[:, k, 1]
    return rotors, alpha


def nutation_rates(moments: np.ndarray, rotors: np.ndarray) -> np.ndarray:
    """(n,) rad/s, of bodies at rest but for rotors (n, 3) N m s: frequency of I w' = h x w; (n, 3) kg m2."""
    product = moments[:, 0] * moments[:, 1] * moments[:, 2]
    return np.asarray(np.sqrt(dot(rotors * rotors, moments) / product))


def _momentum_rates(bodies: Bodies, rotors: np.ndarray, alpha: np.ndarray) -> np.ndarray:
    """(n, 3): rates w that the momentum belongs to; nan where the iteration does not converge.

    The document's rate is w + alpha m x w, with m = I w + h.
    """
    tensor, whole = bodies.body.tensor, bodies.rate
    rate, limit = np.array(whole), 1e3 * np.abs(whole).max(axis=1)
    left, change = np.arange(len(bodies)), np.zeros(0)  # those that still move; by what part of the rate
    for _ in range(100):
        before = rate[left]
        inner = np.cross(turned(tensor[left], before) + rotors[left], before)
        now = rate[left] = whole[left] - alpha[left, None] * inner
        size, step = np.abs(now).max(axis=1), np.abs(now - before).max(axis=1)
        diverged = ~(size <= limit[left])
        rate[left[diverged]] = np.nan
        on = ~diverged & (step > 1e-16 * size)
        left, change = left[on], step[on] / size[on]
        if not left.size:
            break
    rate[left[change > 1e-15]] = np.nan  # else two neighbouring doubles take turns
    return rate


def impulse_sums(impulses: Sequence[AppliedImpulse], attitude: np.ndarray) -> list[np.ndarray]:
    """(..., 3) each, N m s, inertial: momentum added at the epoch (none), and after each impulse outwards.

    attitude : (..., 4) wxyz, the body's at the epoch: as if it did not turn
    """
    sums = [np.zeros((*attitude.shape[:-1], 3))]
    for sign in (1.0, -1.0):
        total = sums[0]
        outwards = sorted(
            (impulse for impulse in impulses if (impulse.seconds >= 0.0) == (sign > 0.0)),
            key=lambda impulse: sign * impulse.seconds,
        )
        for impulse in outwards:
            stopping.check()
            total = total + sign * inertial_components(impulse, attitude)
            sums.append(total)
    return sums


def inertial_components(impulse: AppliedImpulse, attitude: np.ndarray) -> np.ndarray:
    """(..., 3), N m s: the angular impulse in the inertial frame."""
    return impulse.angular if impulse.inertial else rotations.rotate(attitude, impulse.angular)
