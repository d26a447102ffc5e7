"""Momentum at the epoch, and what an impulse adds to it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import InputError
from ..frames import rotations
from ..kernels import layout
from ..problem.initial_state import InitialState
from ..problem.torque_model import AppliedImpulse, TorqueModel

SINK_ITERATIONS = 100
# Neighbouring doubles may take turns for ever: found, if they differ by no more than this part of the rate.
IN_TURNS = 1e-15
TOO_STRONG = "a coefficient so small that energy falls over more than a turn"


def initial_momentum(initial_state: InitialState, torques: Sequence[TorqueModel]) -> np.ndarray:
    """(3,), inertial: that of the turning body, and of the rotors in it.

    A sink inside turns the body too: the rate that the document gives is the whole one, from which the
    momentum follows by iteration.
    """
    rotors, alpha = np.zeros(3), 0.0
    for torque in torques:
        for row in torque.rows(initial_state):
            if row[0] == layout.WHEELS:
                rotors = rotors + initial_state.axes.T @ row[1:4]
            elif row[0] == layout.DISSIPATION:
                alpha += row[1]
    tensor = initial_state.body.tensor
    rate = before = initial_state.rate
    most = 1e3 * float(np.abs(rate).max())
    for _ in range(SINK_ITERATIONS if alpha else 0):
        before, rate = rate, initial_state.rate - alpha * np.cross(tensor @ rate + rotors, rate)
        if np.abs(rate - before).max() <= 1e-16 * np.abs(rate).max():
            break
        if not np.abs(rate).max() <= most:  # away from any solution, and on to infinity
            raise InputError("dissipation", alpha, TOO_STRONG)
    else:
        if alpha and not np.abs(rate - before).max() <= IN_TURNS * np.abs(rate).max():
            raise InputError("dissipation", alpha, TOO_STRONG)
    return rotations.rotate(initial_state.attitude, tensor @ rate + rotors)


def gained(kicks: Sequence[AppliedImpulse], attitude: np.ndarray) -> list[np.ndarray]:
    """(..., 3) each, N m s, inertial: what impulses have added, at the epoch and after each outwards from it.

    attitude : (..., 4) wxyz, the body's at the epoch: as if it did not turn
    """
    sums = [np.zeros((*attitude.shape[:-1], 3))]
    for sign, met in (
        (1.0, [k for k in kicks if k.seconds >= 0.0]),
        (-1.0, [k for k in kicks if k.seconds < 0.0]),
    ):
        total = sums[0]
        for kick in sorted(met, key=lambda kick: sign * kick.seconds):
            total = total + sign * inertial(kick, attitude)
            sums.append(total)
    return sums


def inertial(kick: AppliedImpulse, attitude: np.ndarray) -> np.ndarray:
    """(3,), N m s, inertial components of the angular impulse."""
    return kick.angular if kick.inertial else rotations.rotate(attitude, kick.angular)
