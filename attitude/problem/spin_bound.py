"""How fast bodies can turn: what torques that depend on the spin are judged by.

Moments and rates, (..., 3), are those along the principal axes, kg m2 and rad/s.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..kernels import layout
from .initial_state import InitialState
from .torque_rows import own_rows

if TYPE_CHECKING:
    from .torque_model import AppliedImpulse

# Rows whose torque is nothing on a body at rest: they need others to spin it up.
BY_SPIN = (layout.WHEELS, layout.DISSIPATION, layout.EDDY)
# Rows whose torque has a potential: it swings a body and cannot wind it up.  How far apart the least and the
# greatest potential are, over the size of the torque.
SWINGING = {layout.GRAVITY_GRADIENT: 1.0, layout.MAGNETIC: 2.0}


class Spin(NamedTuple):
    """Upper bounds, (...) each.

    Attributes
    ----------
    rate : rad/s
    momentum : N m s, of the body without the rotors in it
    rotors : N m s, of the rotors relative to the body
    """

    rate: Any
    momentum: Any
    rotors: Any = 0.0


def free_spin(moments: np.ndarray, rates: np.ndarray) -> Spin:
    """Bounds of free rotation: sqrt(2E / I), I the least moment, and the momentum itself."""
    rate = np.sqrt((rates * (moments * rates)).sum(axis=-1) / moments.min(axis=-1))
    return Spin(rate, np.sqrt(((moments * rates) ** 2).sum(axis=-1)))


def reached_spin(
    initial_state: InitialState, torques: Iterable[Any], kicks: Sequence[AppliedImpulse]
) -> Spin:
    """Bounds over the whole span of one body, with everything that acts on it.

    A torque T changes sqrt(2E) by at most T / sqrt(I) a second, I the least moment, and an impulse J by
    J / sqrt(I).  Torques with a potential add to E no more than that gives, in a field that turns with the
    orbit.  Eddies and a sink take energy forwards and give it backwards; rotors keep it.
    """
    moments, span = initial_state.moments, max(abs(initial_state.start), abs(initial_state.stop))
    least, greatest = float(moments.min()), float(moments.max())
    free = free_spin(moments, initial_state.axes @ initial_state.rate)
    rotors, sink, damping = 0.0, 0.0, 0.0
    wound, swung, potential = sum(float(np.linalg.norm(kick.angular)) for kick in kicks), 0.0, 0.0
    for torque in torques:
        rows = own_rows(torque, initial_state)
        codes = {int(code) for code in rows[:, 0]}
        if codes <= set(BY_SPIN):
            rotors += float(np.linalg.norm(rows[rows[:, 0] == layout.WHEELS, 1:4], axis=1).sum())
            sink += float(rows[rows[:, 0] == layout.DISSIPATION, 1].sum())
            damping += sum(_greatest(row) for row in rows if row[0] == layout.EDDY)
        elif codes <= set(SWINGING):
            size = float(torque.size(initial_state))
            swung, potential = swung + size, potential + size * max(SWINGING[code] for code in codes)
        else:
            wound += float(torque.size(initial_state)) * span
    with np.errstate(over="ignore"):  # infinite where eddies are followed far back
        momentum = (free.momentum + wound + swung * span + 2.0 * rotors) * np.exp(damping / least * span)
        energy = (free.rate * np.sqrt(least) + wound / np.sqrt(least)) ** 2 + 2.0 * potential
        if swung and initial_state.course is not None:
            energy += least * (4.0 * np.pi / initial_state.course.period) ** 2
        if initial_state.start < 0.0:
            energy = (
                np.inf
                if sink and energy > 0.0
                else energy * np.exp(-2.0 * damping / least * initial_state.start)
            )
    rate = min(float(np.sqrt(energy / least)), float(momentum / least))
    return Spin(rate, min(float(np.sqrt(energy * greatest)), float(momentum)), rotors)


def _greatest(row: np.ndarray) -> float:
    """N m s: greatest eigenvalue of the tensor of eddies."""
    return float(np.linalg.eigvalsh(row[1:10].reshape(3, 3))[-1])
