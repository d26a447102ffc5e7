"""What a model of the air's density answers."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ..documents.fields import Part
from ..problem.initial_state import InitialState


class Atmosphere(Part):
    """A density that depends on the place and the date.

    TOLERANCE : of the density's logarithm, to which it is interpolated along an orbit
    ROUNDING : of the density's logarithm, with which the second solution is made
    PIECES_PER_REVOLUTION : polynomials, at the least and at the most
    PIECE_SECONDS : s, what one of them takes to make, measured
    """

    TOLERANCE: ClassVar[float] = 3e-12
    ROUNDING: ClassVar[float] = 1e-12
    PIECES_PER_REVOLUTION: ClassVar[tuple[int, int]] = (12, 200)
    PIECE_SECONDS: ClassVar[float] = 1e-5

    def __hash__(self) -> int:
        return id(self)  # profiles are kept for the very object

    def check(self, initial_state: InitialState) -> None:
        """Refuse a scene in which the density is not defined; fields are relative to `density`."""

    def range(self) -> tuple[float, float]:
        """Altitudes, m, between which the density is known."""
        raise NotImplementedError

    def levels(self) -> np.ndarray:
        """(k,) m, ascending: altitudes at which a derivative of the density has a jump."""
        return np.zeros(0)

    def jumps(self, initial_state: InitialState) -> np.ndarray:
        """(j,) s since the epoch: instants of the span at which the density has a jump."""
        return np.zeros(0)

    def altitude_along(self, initial_state: InitialState, t: np.ndarray) -> np.ndarray:
        """(n,) m on the orbit at instants (n,), s since the epoch."""
        raise NotImplementedError

    def log_densities(self, initial_state: InitialState, t: np.ndarray) -> np.ndarray:
        """(n,): logarithms of the densities, kg/m3, on the orbit at instants (n,), s since the epoch."""
        raise NotImplementedError

    def name(self) -> str:
        """The model and its parameters, for plans."""
        raise NotImplementedError
