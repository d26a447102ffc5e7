"""Torques and impulses as the solvers take them."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from . import torque_rows
from .initial_state import DensityProfile, InitialState, Passages, PiecewisePolynomial, Spin


class CachedTorque:
    """A torque whose intervals, passages through the shadow, Sun vector, density and size (if it is the same
    for all bodies) are computed once, for the state that it is made with.

    Finding every passage through the shadow in a year takes longer than integrating the body over that year.
    """

    def __init__(self, torque: Any, initial_state: InitialState):
        self.type: str = torque.type
        self.effect = torque
        self._initial_state = initial_state
        self._results: dict[str, Any] = {}

    def _once(self, name: str) -> Any:
        """What a method of the effect returned when it was first asked."""
        if name not in self._results:
            self._results[name] = getattr(self.effect, name)(self._initial_state)
        return self._results[name]

    def rows(self, initial_state: InitialState) -> np.ndarray:
        """Return the rows of the effect, (k, EffectRow.WIDTH)."""
        return self.effect.rows(initial_state)

    def intervals(self, initial_state: InitialState) -> list[tuple[float, float]] | None:
        """Return the cached intervals, s."""
        return self._once("intervals")

    def passages(self, initial_state: InitialState) -> Passages | None:
        """Return the cached passages through the shadow."""
        return self._once("passages")

    def sun(self, initial_state: InitialState) -> PiecewisePolynomial | None:
        """Return the cached vector to the Sun, m."""
        return self._once("sun")

    def air(self, initial_state: InitialState) -> DensityProfile | None:
        """Return the cached density along the orbit."""
        return self._once("air")

    def size(self, initial_state: InitialState, spin: Spin | None = None) -> float:
        """Upper bound, N m: of this body if the torque depends on the body, else the cached one.

        spin : bound on how fast it turns; without, it turns freely
        """
        own = hasattr(self.effect, "sizes")
        return float(self.effect.size(initial_state, spin) if own else self._once("size"))

    def sizes(self, moments: np.ndarray, spin: Spin) -> np.ndarray:
        """(n,), N m: upper bounds for bodies with moments (n, 3) and bounds of their spin, (n,)."""
        if hasattr(self.effect, "sizes"):
            return self.effect.sizes(self._initial_state, moments, spin)
        return np.full(len(moments), float(self._once("size")))

    @cached_property
    def own_rows(self) -> np.ndarray:
        """(k, EffectRow.WIDTH): along the axes of the body's own frame."""
        return torque_rows.own_rows(self.effect, self._initial_state)

    @cached_property
    def follows_axes(self) -> bool:
        """Whether the rows depend on the body through its principal axes only."""
        return torque_rows.follows_axes(self.effect, self.own_rows, self._initial_state)

    def raise_failure(self) -> None:
        """Raise the exception that a user's function raised, if it did."""
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
