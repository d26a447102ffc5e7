"""Drag of a thin atmosphere on flat plates."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from ..documents.quantities import Length, MassDensity, Rate, check_positive
from ..errors import InputError
from ..kernels import layout
from ..orbit.path_states import position, samples, velocity
from ..problem.initial_state import InitialState, OrbitPath
from . import central_body_rotation as turning
from .effect import Torque, row
from .plates import DragPlate, Surfaces

# What the greatest of the samples of a revolution may lie below the greatest between them.
BETWEEN_SAMPLES = 1.01


class Drag(Torque):
    """`{"type": "drag", "plates": [...], "density": {"value": 1e-12, "unit": "kg/m3"}}`.

    The same density everywhere; or that at `reference_altitude` (above the central body's radius, a
    sphere's), falling by a factor e every `scale_height`.  `corotating`: whether the air turns with the
    central body (left out, it does), at `rotation`, the Earth's if left out.
    On a plate that the flow meets, along the flow: density v^2 / 2 times area, coefficient and cosine.
    """

    NEEDS_ORBIT: ClassVar[bool] = True

    type: Literal["drag"]
    plates: Annotated[list[DragPlate], Field(min_length=1)]
    density: MassDensity
    reference_altitude: Length | None = None
    scale_height: Length | None = None
    corotating: bool = True
    rotation: Rate | None = None

    @model_validator(mode="after")
    def _check(self) -> Drag:
        check_positive(self, "density", "scale_height")
        for given, missing in (
            ("scale_height", "reference_altitude"),
            ("reference_altitude", "scale_height"),
        ):
            if getattr(self, given) is not None and getattr(self, missing) is None:
                raise InputError(missing, None, f"a {missing} beside {given}")
        if self.rotation is not None and not self.corotating:
            raise InputError(
                "rotation", self.rotation.value, "no rotation where the air does not turn (corotating)"
            )
        return self

    def check(self, initial_state: InitialState) -> None:
        central = None if initial_state.course is None else initial_state.course.central
        if central is None:
            return
        if self.scale_height is not None and central.radius is None:
            raise InputError(
                "reference_altitude", None, "a radius of the central body in orbit, to count it from"
            )
        if self.corotating and self.rotation is None and not central.is_earth:
            raise InputError("rotation", None, "the rotation of the central body, which is not the Earth")

    def rows(self, initial_state: InitialState) -> np.ndarray:
        radius, height = self._profile(initial_state)
        air = self.density.si, radius, height, self._turning(initial_state)
        return np.stack(
            [
                row(
                    layout.DRAG_PLATE,
                    *plate.along(initial_state.axes),
                    plate.area.si * plate.coefficient,
                    *air,
                )
                for plate in self.plates
            ]
        )

    def _profile(self, initial_state: InitialState) -> tuple[float, float]:
        """m: radius at which the density is the one given, and scale height."""
        if self.scale_height is None or self.reference_altitude is None:
            return 0.0, math.inf
        central = None if initial_state.course is None else initial_state.course.central
        if central is None or central.radius is None:
            raise InputError("reference_altitude", None, "an orbit about a body with a radius")
        return central.radius + self.reference_altitude.si, self.scale_height.si

    def _turning(self, initial_state: InitialState) -> np.ndarray:
        """(3,) rad/s, of the air, inertial."""
        if not self.corotating:
            return np.zeros(3)
        rate = turning.earth_rate() if self.rotation is None else self.rotation.si
        return rate * turning.equator(initial_state)[2]

    def size(self, initial_state: InitialState) -> float:
        """The greatest dynamic pressure of the orbit on the worst side of the body; a few percent above."""
        if initial_state.course is None:
            raise InputError("orbit", None, "an orbit")
        pressure = 0.5 * self._greatest_flow(initial_state, initial_state.course)
        return BETWEEN_SAMPLES * pressure * Surfaces.facing_flow(self.plates).greatest_torque()

    def _greatest_flow(self, initial_state: InitialState, course: OrbitPath) -> float:
        """kg/(m s2): greatest density times squared speed through the air."""
        t = samples(course)
        r = position(course, t)
        v = velocity(course, t) - np.cross(self._turning(initial_state), r)
        radius, height = self._profile(initial_state)
        thinning = (
            (np.sqrt((r**2).sum(axis=1)) - radius) / height if math.isfinite(height) else np.zeros(len(t))
        )
        return float((self.density.si * np.exp(-thinning) * (v**2).sum(axis=1)).max())
