"""Torques that leave the momentum its direction: decided exactly, on the numbers as they are given.

Two kinds do so.  Eddies whose tensor is in proportion to that of inertia (a sphere's, for the ordinary one)
do it to any motion.  All others do it to rotation about an axis that stands still, in the body and in space:
of a sphere about any axis, of any body about a principal one, where they act along it; also from rest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from ..kernels.layout import EffectCode
from ..problem.initial_state import InitialState
from ..rigid_body.driven_motion import MomentumLaw
from ..times.two_part import two_part

Vector = list[Fraction]
MAX_DECAY = 50.0  # times of decay before the epoch, when the momentum was e^50 of itself


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
    inertia, damping = [_exact(row) for row in initial_state.body.tensor], _damping(rows)
    rate, torques = _exact(initial_state.rate), _torques(initial_state, rows)
    ratio = damping[0][0] / inertia[0][0]
    is_proportional = damping == [[ratio * element for element in row] for row in inertia]
    any_motion = is_proportional and not any(map(any, torques))
    if any_motion:
        law: MomentumLaw | None = _law(Fraction(1), Fraction(0), ratio)
    else:
        law, rate = (None, rate) if impulses else _about_an_axis(inertia, damping, rate, torques)
    if law is None or -law.damping[0] * initial_state.start > MAX_DECAY:
        return None
    return law, np.array([float(component) for component in rate])


def _about_an_axis(
    inertia: list[Vector], damping: list[Vector], rate: Vector, torques: tuple[Vector, Vector]
) -> tuple[MomentumLaw | None, Vector]:
    """The law where the axis of rotation, or of the torque on a body at rest, is one that stands still.

    torques : fixed in the body, and in space; each has to be along the axis, since one of them turns
    """
    turns = any(rate)
    torque = [a + b for a, b in zip(*torques, strict=True)]
    axis = rate if turns else torque
    momentum, resistance = _times(inertia, axis), _times(damping, axis)
    if not any(axis) or any(any(_cross(axis, other)) for other in (momentum, resistance, *torques)):
        return None, rate
    size = _dot(axis, momentum)
    spin_up = _dot(axis, torque) / size
    if turns:
        return _law(Fraction(1), spin_up, _dot(axis, resistance) / size), rate
    # from rest the rate of reference is along the torque, in doubles
    unit = Fraction(2) ** -math.frexp(float(max(map(abs, axis))))[1]
    reference = _exact([float(unit * component) for component in axis])
    if any(_cross(reference, _times(inertia, reference))):
        return None, rate
    spin_up *= _dot(axis, reference) / _dot(reference, reference)
    return _law(Fraction(0), spin_up, _dot(axis, resistance) / size), reference


def _damping(rows: np.ndarray) -> list[Vector]:
    """The sum of the eddies' tensors."""
    eddies = rows[rows[:, 0] == EffectCode.EDDY]
    tensors = [[_exact(row[first : first + 3]) for first in (1, 4, 7)] for row in eddies]
    return [[sum((tensor[i][j] for tensor in tensors), Fraction(0)) for j in range(3)] for i in range(3)]


def _law(start: Fraction, torque: Fraction, damping: Fraction) -> MomentumLaw:
    return MomentumLaw(float(start), two_part(torque), two_part(damping))


def _torques(initial_state: InitialState, rows: np.ndarray) -> tuple[Vector, Vector]:
    """The constant torques fixed in the body, and in space, along the body's axes at the epoch.

    Exactly but for the length of the quaternion.
    """
    own, inertial = [Fraction(0)] * 3, [Fraction(0)] * 3
    w, x, y, z = _exact(initial_state.attitude)
    norm = w * w + x * x + y * y + z * z
    # columns of R(q): inertial components of the body's axes, times the square of the quaternion's length
    columns = (
        (w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)),
        (2 * (x * y - w * z), w * w - x * x + y * y - z * z, 2 * (y * z + w * x)),
        (2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z),
    )
    for row in rows:
        vector = _exact(row[1:4])
        if row[0] == EffectCode.CONSTANT_BODY:
            own = [a + b for a, b in zip(own, vector, strict=True)]
        elif row[0] == EffectCode.CONSTANT_INERTIAL:
            inertial = [a + _dot(column, vector) / norm for a, column in zip(inertial, columns, strict=True)]
    return own, inertial


def _exact(values: Sequence[float] | np.ndarray) -> Vector:
    return [Fraction(float(value)) for value in values]


def _times(matrix: list[Vector], vector: Vector) -> Vector:
    return [_dot(row, vector) for row in matrix]


def _dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def _cross(a: Vector, b: Vector) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
