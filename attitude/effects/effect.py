"""Base classes of effects."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from ..documents.fields import Part
from ..errors import InputError
from ..kernels.layout import EffectRow
from ..problem.initial_state import (
    DensityProfile,
    InitialState,
    OrbitPath,
    Passages,
    PiecewisePolynomial,
    Spin,
)
from ..problem.spin_bound import free_spin


class Effect(Part):
    """An element of the document's `effects`, identified by its `type`.

    ACTS_ON decides how it is simulated: "translation" moves the centre of mass alone, "instants" change the
    momentum at points in time, "attitude" is a torque at every instant.  REASON is what plans say of it.
    """

    type: str
    ACTS_ON: ClassVar[Literal["translation", "instants", "attitude"]]
    REASON: ClassVar[str] = "a torque at every instant"
    NEEDS_ORBIT: ClassVar[bool] = False

    @property
    def label(self) -> str:
        """Name of the effect in plans."""
        return self.type

    @property
    def needs_orbit(self) -> bool:
        """Whether this effect, with its parameters, needs an orbit."""
        return self.NEEDS_ORBIT

    @property
    def uses_orbit(self) -> bool:
        """Whether the position on the orbit matters if there is one."""
        return self.needs_orbit

    @property
    def needs_epoch(self) -> bool:
        """Whether this effect, with its parameters, needs an epoch."""
        return False

    def check(self, initial_state: InitialState) -> None:
        """Validate the effect against the body, state and span of its scene.

        Raises InputError with the field relative to the effect (but "frame", "epoch", "orbit": the scene's).
        """


class Torque(Effect):
    """An effect that acts on the attitude at every instant, or in intervals."""

    ACTS_ON = "attitude"

    def rows(self, initial_state: InitialState) -> np.ndarray:
        """(n, EffectRow.WIDTH): the effect as kernels take it (`kernels.layout`)."""
        raise NotImplementedError

    def intervals(self, initial_state: InitialState) -> list[tuple[float, float]] | None:
        """Spans (s) in which it acts, ascending, disjoint; None for always."""
        return None

    def passages(self, initial_state: InitialState) -> Passages | None:
        """Passages through the central body's shadow; None if there is none."""
        return None

    def sun(self, initial_state: InitialState) -> PiecewisePolynomial | None:
        """Vector from the central body to the Sun, m, inertial; None if the effect does not need it."""
        return None

    def air(self, initial_state: InitialState) -> DensityProfile | None:
        """Density along the orbit, where it is a function of time; None where it is not or has no effect."""
        return None

    def summary(self, initial_state: InitialState) -> str:
        """What models the effect uses, for plans; "" where there is no choice of one."""
        return ""

    def size(self, initial_state: InitialState) -> float:
        """Upper bound on the torque in the span, N m, close to what is reached."""
        raise NotImplementedError

    def raise_failure(self) -> None:
        """Raise what a function of the user's raised while it was asked for the torque, once."""


class BodyDependentTorque(Torque):
    """A torque whose size depends on the body's moments or spin; that of any other is the same for all."""

    def sizes(self, initial_state: InitialState, moments: np.ndarray, spin: Spin) -> np.ndarray:
        """(...), N m: `size` of bodies by their moments, (..., 3), and the bounds of their spin, (...)."""
        raise NotImplementedError

    def size(self, initial_state: InitialState, spin: Spin | None = None) -> float:
        """`Torque.size` for a body that turns no faster than `spin`, or that turns freely from the epoch."""
        moments = initial_state.moments
        spin = free_spin(moments, initial_state.axes @ initial_state.rate) if spin is None else spin
        return float(self.sizes(initial_state, moments, spin))


def row(code: int, *numbers: object) -> np.ndarray:
    """One row: the code, then numbers and vectors one after the other, padded with zeros."""
    values = np.concatenate([np.ravel(np.asarray(number, dtype=float)) for number in numbers])
    out = np.zeros(EffectRow.WIDTH)
    out[0], out[1 : 1 + values.size] = code, values
    return out


def required_orbit_path(initial_state: InitialState) -> OrbitPath:
    """Return the orbit; InputError without one."""
    if initial_state.orbit_path is None:
        raise InputError("orbit", None, "an orbit")
    return initial_state.orbit_path
