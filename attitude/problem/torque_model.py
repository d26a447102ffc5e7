"""What the solvers ask of an effect that acts at every instant, and an impulse between instants."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np

from . import torque_rows
from .initial_state import InitialState, PiecewisePolynomial
from .spin_bound import Spin


class TorqueModel(Protocol):
    """A torque; `attitude.effects.effect.Torque` says what each of these is."""

    def rows(self, initial_state: InitialState) -> np.ndarray: ...

    def intervals(self, initial_state: InitialState) -> list[tuple[float, float]] | None: ...

    def sun(self, initial_state: InitialState) -> PiecewisePolynomial | None: ...

    def size(self, initial_state: InitialState) -> float: ...


class CachedTorque:
    """A torque asked for its spans and its Sun once, and for its size where no body changes it.

    To find every passage through the shadow in a year takes longer than to follow the body meanwhile.
    """

    def __init__(self, torque: Any, initial_state: InitialState):
        self.type: str = torque.type
        self.effect = torque
        self._situation = initial_state

    def rows(self, initial_state: InitialState) -> np.ndarray:
        found: np.ndarray = self.effect.rows(initial_state)
        return found

    def intervals(self, initial_state: InitialState) -> list[tuple[float, float]] | None:
        return self._spans

    def sun(self, initial_state: InitialState) -> PiecewisePolynomial | None:
        return self._sun

    def size(self, initial_state: InitialState) -> float:
        """That of a torque which depends on the body, for the body and state of the situation."""
        return float(self.effect.size(initial_state)) if hasattr(self.effect, "sizes") else self._size

    @cached_property
    def _spans(self) -> list[tuple[float, float]] | None:
        spans: list[tuple[float, float]] | None = self.effect.intervals(self._situation)
        return spans

    @cached_property
    def _sun(self) -> PiecewisePolynomial | None:
        pieces: PiecewisePolynomial | None = self.effect.sun(self._situation)
        return pieces

    @cached_property
    def _size(self) -> float:
        return float(self.effect.size(self._situation))

    def of(self, initial_state: InitialState) -> CachedTorque:
        """The same torque on another body over the same span: spans and Sun are those found already."""
        other = CachedTorque(self.effect, initial_state)
        other.__dict__.update(_spans=self._spans, _sun=self._sun)
        return other

    def sizes(self, moments: np.ndarray, spin: Spin) -> np.ndarray:
        """(n,), N m: its size for bodies by moments, (n, 3), and the bounds of their spin, (n,)."""
        if hasattr(self.effect, "sizes"):
            found: np.ndarray = self.effect.sizes(self._situation, moments, spin)
            return found
        return np.full(len(moments), self._size)

    @cached_property
    def own_rows(self) -> np.ndarray:
        """(k, EFFECT_WIDTH): along the axes of the body's own frame."""
        return torque_rows.own_rows(self.effect, self._situation)

    @cached_property
    def follows_axes(self) -> bool:
        """Whether of a body only its axes reach the rows."""
        return torque_rows.follows_axes(self.effect, self._situation)

    def raise_failure(self) -> None:
        """What a function of the user's raised, if it did."""
        if hasattr(self.effect, "raise_failure"):
            self.effect.raise_failure()


class AppliedImpulse(NamedTuple):
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
