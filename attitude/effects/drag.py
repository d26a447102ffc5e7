"""Drag of a thin atmosphere on flat plates."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from ..documents.fields import Chosen, field_within
from ..documents.quantities import ABOVE_ZERO, Length, Rate
from ..errors import InputError
from ..kernels.layout import EffectCode
from ..orbit.path_states import position, samples, velocity
from ..problem.initial_state import DensityProfile, InitialState
from . import central_body_rotation, density_profile
from .atmosphere import Atmosphere
from .density_models import density_classes, parse_density
from .effect import Torque, required_orbit_path, row
from .plates import DragPlate, Surfaces


class Drag(Torque):
    """`{"type": "drag", "plates": [...], "density": {"value": 1e-12, "unit": "kg/m3"}}`.

    `density` everywhere; or that at `reference_altitude` (above the central body's radius, a sphere's),
    falling by a factor e every `scale_height`; or a table, or a model of the Earth's atmosphere,
    whose altitudes cover those of the orbit.  `corotating`: whether the air rotates with the central body
    (if left out, it does), at `rotation`, the Earth's if left out.
    On a plate that faces the flow, along the flow: density v^2 / 2 times area, coefficient and cosine.
    """

    NEEDS_ORBIT: ClassVar[bool] = True

    type: Literal["drag"]
    plates: Annotated[list[DragPlate], Field(min_length=1, fail_fast=True)]
    density: Annotated[Any, Chosen(parse_density, density_classes)]
    reference_altitude: Length | None = None
    scale_height: Annotated[Length, ABOVE_ZERO] | None = None
    corotating: bool = True
    rotation: Rate | None = None

    @model_validator(mode="after")
    def _check(self) -> Drag:
        if isinstance(self.density, Atmosphere):
            for name in ("scale_height", "reference_altitude"):
                if getattr(self, name) is not None:
                    expected = f"no {name} beside {self.density.name()}"
                    raise InputError(name, getattr(self, name).value, expected)
        names = ("scale_height", "reference_altitude")
        for present, missing in (names, names[::-1]):
            if getattr(self, present) is not None and getattr(self, missing) is None:
                raise InputError(missing, None, f"a {missing} beside {present}")
        if self.rotation is not None and not self.corotating:
            raise InputError("rotation", self.rotation.value, "no rotation beside corotating: false")
        return self

    def check(self, initial_state: InitialState) -> None:
        """Refuse a central body whose radius or rotation is needed and not known, and altitudes whose density
        is not.
        """
        central = initial_state.central_body
        if central is None:
            return
        if isinstance(self.density, Atmosphere):
            with field_within("density"):
                self.density.check(initial_state)
                self.air(initial_state)
        self._profile(initial_state)
        if self.corotating and self.rotation is None and not central.is_earth:
            raise InputError("rotation", None, "the rotation of the central body, which is not the Earth")

    def rows(self, initial_state: InitialState) -> np.ndarray:
        """One row a plate: area times drag coefficient, and the atmosphere."""
        air = *self._profile(initial_state), self._air_rotation(initial_state)
        return np.stack(
            [
                row(
                    EffectCode.DRAG_PLATE,
                    *plate.along(initial_state.axes),
                    plate.area.si * plate.coefficient,
                    *air,
                )
                for plate in self.plates
            ]
        )

    def air(self, initial_state: InitialState) -> DensityProfile | None:
        """Density along the orbit, by a table or a model."""
        if isinstance(self.density, Atmosphere):
            return density_profile.along(self.density, initial_state)
        return None

    def summary(self, initial_state: InitialState) -> str:
        """What gives the density, and what it is along the orbit."""
        air = self.air(initial_state)
        if air is None:
            kind = "the same everywhere" if self.scale_height is None else "exponential"
            return f"density {kind}"
        rho = density_profile.evaluate(air, density_profile.instants_of(air))
        return f"density by {self.density.name()}, {rho.min():.3g} to {rho.max():.3g} kg/m3 along the orbit"

    def _profile(self, initial_state: InitialState) -> tuple[float, float, float]:
        """Density, kg/m3, at a radius, m, and scale height, m; of a density by time 1 everywhere."""
        if isinstance(self.density, Atmosphere):
            return 1.0, 0.0, math.inf
        if self.scale_height is None or self.reference_altitude is None:
            return self.density.si, 0.0, math.inf
        central = initial_state.central_body
        if central is None or central.radius is None:
            expected = "a radius of the central body in orbit, from which the altitude is measured"
            raise InputError("reference_altitude", None, expected)
        return self.density.si, central.radius + self.reference_altitude.si, self.scale_height.si

    def _air_rotation(self, initial_state: InitialState) -> np.ndarray:
        """Angular velocity of the air, (3,), rad/s, inertial."""
        if not self.corotating:
            return np.zeros(3)
        rate = central_body_rotation.earth_rate() if self.rotation is None else self.rotation.si
        return rate * central_body_rotation.equator(initial_state)[2]

    def size(self, initial_state: InitialState) -> float:
        """Greatest dynamic pressure on the orbit times the torque of the worst attitude; slightly above."""
        orbit_path = required_orbit_path(initial_state)
        air = self.air(initial_state)
        t = samples(orbit_path) if air is None else density_profile.instants_of(air)
        r = position(orbit_path, t)
        v = velocity(orbit_path, t) - np.cross(self._air_rotation(initial_state), r)
        density, radius, height = self._profile(initial_state)
        distance = np.sqrt((r**2).sum(axis=1))
        exponent = (distance - radius) / height if math.isfinite(height) else np.zeros(len(t))
        rho = density * np.exp(-exponent) if air is None else density_profile.evaluate(air, t)
        flow = float((rho * (v**2).sum(axis=1)).max())
        margin = 1.01  # the maximum over an orbit exceeds the greatest of its samples by less
        return margin * (0.5 * flow) * Surfaces.of(self.plates).greatest_torque()
