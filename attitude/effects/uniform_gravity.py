"""Uniform gravity: the centre of mass moves on a parabola; no torque."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from ..documents.quantities import AccelerationVector
from .effect import Effect


class UniformGravity(Effect):
    """`{"type": "uniform_gravity", "acceleration": {"value": [0, 0, -9.81], "unit": "m/s2"}}`, inertial."""

    ACTS_ON: ClassVar[Literal["translation", "instants", "attitude"]] = "translation"

    type: Literal["uniform_gravity"]
    acceleration: AccelerationVector

    @property
    def vector(self) -> np.ndarray:
        """(3,), m/s2, inertial."""
        return self.acceleration.si
