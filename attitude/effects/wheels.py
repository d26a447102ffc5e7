"""Wheels that spin at a constant rate in the body: a gyrostat."""

from __future__ import annotations

from typing import Literal

import numpy as np

from ..documents.quantities import AngularImpulseVector
from ..kernels import layout
from ..problem.initial_state import InitialState
from ..problem.spin_bound import Spin
from .effect import BodyDependentTorque, row


class Wheels(BodyDependentTorque):
    """`{"type": "wheels", "momentum": {"value": [0, 0, 5], "unit": "N m s"}}`.

    The angular momentum of all rotors together relative to the body, along the body's axes; constant, as
    motors keep it.  The body's moments are those with the rotors locked (Hughes 2004, section 3.5).
    """

    type: Literal["wheels"]
    momentum: AngularImpulseVector

    def rows(self, initial_state: InitialState) -> np.ndarray:
        return row(layout.WHEELS, initial_state.axes @ self.momentum.si)[None]

    def sizes(self, initial_state: InitialState, moments: np.ndarray, spin: Spin) -> np.ndarray:
        """abs(h x omega) at most: h times the greatest rate."""
        size: np.ndarray = float(np.linalg.norm(self.momentum.si)) * spin.rate
        return size
