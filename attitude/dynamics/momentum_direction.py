"""Torques that leave the momentum its direction: decided exactly, on the numbers as they are given.

Two kinds do so.  Eddies whose tensor is in proportion to that of inertia (a sphere's, for the ordinary one)
do it to any motion.  All others do it to rotation about an axis that stands still, in the body and in space:
of a sphere about any axis, of any body about a principal one, where they act along it; also from rest.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from ..kernels.layout import EffectCode
from ..problem.initial_state import InitialState
from ..rigid_body.driven_motion import MomentumLaw
from ..times.two_part import two_part


def momentum_law(
    initial_state: InitialState, rows: np.ndarray, impulses: bool
) -> tuple[MomentumLaw, np.ndarray] | None:
    """The law of the momentum's size, and the rate (3,) rad/s that it multiplies; None where it turns.

    Parameters
    ----------
    rows : (k, EffectRow.WIDTH), along the axes of the body's own frame, that act at all times
    impulses : whether impulses will change the state: then only what keeps the direction of any motion serves
    """
    if not np.isin(
        rows[:, 0],
        (EffectCode.CONSTANT_BODY, EffectCode.CONSTANT_INERTIAL, EffectCode.EDDY),
    ).all():
        return None
    eddies = exact(rows[rows[:, 0] == EffectCode.EDDY, 1:10])
    inertia, damping = exact(initial_state.body.tensor), eddies.sum(axis=0).reshape(3, 3)
    rate, torques = exact(initial_state.rate), _torques(initial_state, rows)
    ratio = damping[0, 0] / inertia[0, 0]
    if (damping == ratio * inertia).all() and not torques.any():  # any motion keeps its direction
        size_law: tuple[Fraction, ...] | None = Fraction(1), Fraction(0), ratio
    else:
        size_law, rate = (None, rate) if impulses else _about_an_axis(inertia, damping, rate, torques)
    if size_law is None:
        return None
    start, spin_up, decay = size_law
    if -float(decay) * initial_state.start > 50.0:  # at the beginning the momentum was e^50 of itself
        return None
    return MomentumLaw(float(start), two_part(spin_up), two_part(decay)), rate.astype(float)


def _about_an_axis(
    inertia: np.ndarray, damping: np.ndarray, rate: np.ndarray, torques: np.ndarray
) -> tuple[tuple[Fraction, ...] | None, np.ndarray]:
    """The law where the axis of rotation, or of the torque on a body at rest, is one that stands still.

    Of the momentum's size: at the epoch, by torques and by damping a second; and the rate of reference.

    torques : (2, 3), fixed in the body, and in space; each has to be along the axis, since one of them turns
    """
    turns, torque = rate.any(), torques.sum(axis=0)
    axis = rate if turns else torque
    momentum, resistance = inertia @ axis, damping @ axis
    if not axis.any() or np.cross(axis, [momentum, resistance, *torques]).any():
        return None, rate
    size = axis @ momentum
    spin_up, decay = axis @ torque / size, axis @ resistance / size
    if turns:
        return (Fraction(1), spin_up, decay), rate
    # from rest the rate of reference is along the torque, in doubles
    unit = Fraction(2) ** -math.frexp(float(np.abs(axis).max()))[1]
    reference = exact((unit * axis).astype(float))
    if np.cross(reference, inertia @ reference).any():
        return None, rate
    spin_up *= (axis @ reference) / (reference @ reference)
    return (Fraction(0), spin_up, decay), reference


def _torques(initial_state: InitialState, rows: np.ndarray) -> np.ndarray:
    """(2, 3): the constant torques fixed in the body, and in space, along the body's axes at the epoch.

    Exactly but for the length of the quaternion.
    """
    w, x, y, z = exact(initial_state.attitude)
    # rows are the inertial components of the body's axes, times the square of the quaternion's length
    axes = np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)],
            [2 * (x * y - w * z), w * w - x * x + y * y - z * z, 2 * (y * z + w * x)],
            [2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z],
        ]
    )
    own, inertial = (
        exact(rows[rows[:, 0] == code, 1:4]).sum(axis=0)
        for code in (EffectCode.CONSTANT_BODY, EffectCode.CONSTANT_INERTIAL)
    )
    return np.array([own, axes @ inertial / (w * w + x * x + y * y + z * z)])


def exact(values: np.ndarray) -> np.ndarray:
    """Fractions equal to doubles, (...)."""
    return np.asarray(np.frompyfunc(Fraction, 1, 1)(np.asarray(values, dtype=float)))
