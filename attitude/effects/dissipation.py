"""Internal friction: kinetic energy is dissipated, angular momentum is conserved."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np

from ..documents.quantities import NOT_BELOW_ZERO, DissipationCoefficient
from ..kernels.layout import EffectCode
from ..problem.initial_state import InitialState, Spin
from .effect import BodyDependentTorque, row


class Dissipation(BodyDependentTorque):
    """`{"type": "dissipation", "coefficient": {"value": 1e-3, "unit": "1/(N m s)"}}`.

    The double bracket dm/dt = m x w + alpha m x (m x w), m the body's angular momentum, w = I^-1 m,
    alpha the coefficient: energy is lost at the rate alpha (m x w)^2 (Bloch, Krishnaprasad, Marsden and
    Ratiu 1996).
    """

    REASON: ClassVar[str] = "takes energy at constant momentum, from inside"

    type: Literal["dissipation"]
    coefficient: Annotated[DissipationCoefficient, NOT_BELOW_ZERO]

    def rows(self, initial_state: InitialState) -> np.ndarray:
        """One row: the coefficient."""
        return row(EffectCode.DISSIPATION, self.coefficient.si)[None]

    def sizes(self, initial_state: InitialState, moments: np.ndarray, spin: Spin) -> np.ndarray:
        """Bound on alpha abs(m) abs(m x w).

        Without rotors at most alpha L^3 (1/I_min - 1/I_max) / 2, reached halfway between the axes; rotors
        of momentum h add h to m and h w to m x w.
        """
        spread = 1.0 / moments.min(axis=-1) - 1.0 / moments.max(axis=-1)
        across = 0.5 * spin.momentum**2 * spread + spin.rotors * spin.rate
        return self.coefficient.si * (spin.momentum + spin.rotors) * across
