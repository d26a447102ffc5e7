"""Sunlight on flat plates, outside the central body's shadow."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from ..documents.fields import Chosen
from ..errors import InputError
from ..kernels import layout
from ..orbit.path_states import evaluate
from ..problem.initial_state import InitialState, PiecewisePolynomial
from . import sun as sunlight
from .effect import Torque, row
from .plates import OpticalPlate, Surfaces
from .shadow import sunlit


class SolarPressure(Torque):
    """`{"type": "solar_pressure", "plates": [...], "sun": "astropy"}`.

    `sun`: "astropy" (about the Earth; needs an epoch) or `{"direction": [..3]}`, from the central body, 1 au
    away; where the scene has an orbit, the light comes from there to the body on it.  `shadow`: whether the
    central body's cylindrical shadow takes the light away; left out, it does.
    """

    type: Literal["solar_pressure"]
    plates: Annotated[list[OpticalPlate], Field(min_length=1)]
    source: Annotated[Any, Chosen(sunlight.pick, sunlight.kinds, ("astropy",)), Field(alias="sun")]
    shadow: bool = True

    @property
    def needs_orbit(self) -> bool:
        return self.shadow

    @property
    def uses_orbit(self) -> bool:
        """The light comes from the Sun to the body, wherever on its orbit that is."""
        return True

    @property
    def needs_epoch(self) -> bool:
        return bool(self.source == "astropy")

    def check(self, initial_state: InitialState) -> None:
        course = initial_state.course
        if course is None or course.central is None:
            return
        if self.shadow and course.central.radius is None:
            raise InputError(
                "shadow", self.shadow, "a radius of the central body in orbit, as wide as its shadow"
            )
        if self.source == "astropy" and not course.central.is_earth:
            raise InputError(
                "sun", self.source, "the direction of the Sun, where the central body is not the Earth"
            )

    def rows(self, initial_state: InitialState) -> np.ndarray:
        pressure = sunlight.pressure()
        return np.stack(
            [
                row(
                    layout.SOLAR_PLATE,
                    *plate.along(initial_state.axes),
                    plate.area.si,
                    plate.specular,
                    plate.diffuse,
                    pressure,
                )
                for plate in self.plates
            ]
        )

    def intervals(self, initial_state: InitialState) -> list[tuple[float, float]] | None:
        """The spans in sunlight."""
        if not self.shadow:
            return None
        course = initial_state.course
        if course is None or course.central is None or course.central.radius is None:
            raise InputError("orbit", None, "an orbit about a body with a radius")
        return sunlit(
            course, self._place(initial_state), course.central.radius, initial_state.start, initial_state.stop
        )

    def sun(self, initial_state: InitialState) -> PiecewisePolynomial:
        return self._place(initial_state)

    def _place(self, initial_state: InitialState) -> PiecewisePolynomial:
        if isinstance(self.source, sunlight.FixedSun):
            return self.source.place()
        if initial_state.epoch is None:
            raise InputError("epoch", None, "an epoch, for the position of the Sun")
        return sunlight.from_earth(
            initial_state.epoch, initial_state.frame, initial_state.start, initial_state.stop
        )

    def size(self, initial_state: InitialState) -> float:
        """Light from the worst direction, the Sun at its nearest: a few percent above what that gives."""
        sun = self._place(initial_state)
        t = sun.start + sun.length * np.arange(len(sun.coefficients) + 1)
        nearest = float(np.sqrt((evaluate(sun, t) ** 2).sum(axis=1).min()))
        pressure = sunlight.pressure() * (sunlight.au() / nearest) ** 2
        return pressure * Surfaces.of(self.plates).greatest_torque()
