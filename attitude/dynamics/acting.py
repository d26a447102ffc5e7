"""What the solvers ask of an effect that acts at every instant, and an impulse between instants."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from .situation import Pieces, Situation


class Acting(Protocol):
    """A torque; `attitude.effects.effect.Torque` says what each of these is."""

    def rows(self, situation: Situation) -> np.ndarray: ...

    def intervals(self, situation: Situation) -> list[tuple[float, float]] | None: ...

    def sun(self, situation: Situation) -> Pieces | None: ...

    def size(self, situation: Situation) -> float: ...


class Kick(NamedTuple):
    """An impulse.

    Attributes
    ----------
    seconds : s since the epoch
    angular : (3,), N m s, about the centre of mass
    linear : (3,), N s
    inertial : whether both are inertial components, else along the body's axes at that instant
    """

    seconds: float
    angular: np.ndarray
    linear: np.ndarray
    inertial: bool
