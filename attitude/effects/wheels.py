"""Rotors that spin at a constant rate in the body: a gyrostat."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from ..documents.quantities import AngularImpulseVector
from ..kernels.layout import EffectCode
from ..problem.initial_state import InitialState, Spin
from .effect import BodyDependentTorque, row


class Wheels(BodyDependentTorque):
    """`{"type": "wheels", "momentum": {"value": [0, 0, 5], "unit": "N m s"}}`.

    Total angular momentum of the rotors relative to the body, along the body's axes; motors keep it
    constant.  The body's moments are those with the rotors locked (Hughes 2004, section 3.5).
    """

    REASON: ClassVar[str] = (
        "rotors turn the body by their momentum; energy is kept; exact without other torques"
    )

    type: Literal["wheels"]
    momentum: AngularImpulseVector

    def rows(self, initial_state: InitialState) -> np.ndarray:
        """One row: the momentum along the principal axes."""
        return row(EffectCode.WHEELS, initial_state.axes @ self.momentum.si)[None]

    def sizes(self, initial_state: InitialState, moments: np.ndarray, spin: Spin) -> np.ndarray:
        """Momentum of the rotors times the greatest rate."""
        return float(np.linalg.norm(self.momentum.si)) * spin.rate
