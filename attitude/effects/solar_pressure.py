"""Sunlight on flat plates, outside the central body's shadow."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from ..documents.fields import Chosen
from ..errors import InputError
from ..frames.celestial import SUN_RADIUS, au
from ..kernels.layout import EffectCode
from ..kernels.solvers.plate_layout import ShadowModel
from ..problem.initial_state import InitialState, Passages, PiecewisePolynomial
from . import sun as sunlight
from .effect import Torque, required_orbit_path, row
from .plates import OpticalPlate, Surfaces
from .shadow import passages


class SolarPressure(Torque):
    """`{"type": "solar_pressure", "plates": [...], "sun": "astropy"}`.

    `sun`: "astropy" (about the Earth; needs an epoch) or `{"direction": [..3]}`, from the central body, 1 au
    away; where the scene has an orbit, the light comes from there to the body on it.  `shadow` of the central
    body: "conical", with a penumbra (if left out), "cylindrical" (or true), or false.
    """

    REASON: ClassVar[str] = "a torque at every instant outside the shadow"

    type: Literal["solar_pressure"]
    plates: Annotated[list[OpticalPlate], Field(min_length=1, fail_fast=True)]
    source: Annotated[Any, Chosen(sunlight.parse, sunlight.classes, ("astropy",)), Field(alias="sun")]
    shadow: bool | Literal["conical", "cylindrical"] = "conical"

    @property
    def needs_orbit(self) -> bool:
        """Whether there is a shadow."""
        return self.shadow is not False

    @property
    def uses_orbit(self) -> bool:
        """True: the light comes from the Sun to the body, wherever it is on its orbit."""
        return True

    @property
    def needs_epoch(self) -> bool:
        """Whether the position of the Sun is computed."""
        return bool(self.source == "astropy")

    def check(self, initial_state: InitialState) -> None:
        """Refuse a central body whose radius or Sun direction is needed and not known."""
        central = initial_state.central_body
        if central is None:
            return
        if self.needs_orbit:
            self._shadow_and_radius(initial_state)
        if self.source == "astropy" and not central.is_earth:
            expected = "the direction of the Sun, where the central body is not the Earth"
            raise InputError("sun", self.source, expected)

    def rows(self, initial_state: InitialState) -> np.ndarray:
        """One row a plate."""
        pressure, model, radius, sun_radius = sunlight.pressure(), ShadowModel.NONE, 0.0, 0.0
        if self.needs_orbit:
            (model, radius), sun_radius = self._shadow_and_radius(initial_state), SUN_RADIUS
        return np.stack(
            [
                row(
                    EffectCode.SOLAR_PLATE,
                    *plate.along(initial_state.axes),
                    *(plate.area.si, plate.specular, plate.diffuse, pressure, model, radius, sun_radius),
                )
                for plate in self.plates
            ]
        )

    def _shadow_and_radius(self, initial_state: InitialState) -> tuple[ShadowModel, float]:
        """The form of the shadow, and the radius of the body that casts it, m."""
        central = initial_state.central_body
        if central is None or central.radius is None:
            expected = "a radius of the central body in orbit, which is that of its shadow"
            raise InputError("shadow", self.shadow, expected)
        is_conical = self.shadow == "conical"
        return ShadowModel.CONICAL if is_conical else ShadowModel.CYLINDRICAL, central.radius

    def passages(self, initial_state: InitialState) -> Passages | None:
        """Passages through the shadow; None without one."""
        if not self.needs_orbit:
            return None
        orbit_path, sun = required_orbit_path(initial_state), self.sun(initial_state)
        span = initial_state.start, initial_state.stop
        shadow, radius = self._shadow_and_radius(initial_state)
        return passages(orbit_path, sun, radius, span, shadow)

    def sun(self, initial_state: InitialState) -> PiecewisePolynomial:
        """Vector from the central body to the Sun, m."""
        if isinstance(self.source, sunlight.FixedSun):
            return self.source.vector()
        if initial_state.epoch is None:
            raise InputError("epoch", None, "an epoch, for the position of the Sun")
        return sunlight.from_earth(
            initial_state.epoch, initial_state.frame, initial_state.start, initial_state.stop
        )

    def size(self, initial_state: InitialState) -> float:
        """Bound for light from the worst direction, the Sun at its nearest; slightly above it."""
        sun = self.sun(initial_state)
        t = sun.start + sun.length * np.arange(len(sun.coefficients) + 1)
        nearest = float(np.sqrt((sun(t) ** 2).sum(axis=1).min()))
        pressure = sunlight.pressure() * (au() / nearest) ** 2
        return pressure * Surfaces.of(self.plates).greatest_torque()
