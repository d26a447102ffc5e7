"""Keplerian elements: exact two-body motion."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import Field, model_validator

from ..documents.fields import Number, exactly_one
from ..documents.quantities import Angle, Length, check_positive
from ..errors import InputError
from ..kernels import layout
from ..problem.initial_state import CentralBody, OrbitPath
from ..times import turn_rates
from .orbit import AboutABody

if TYPE_CHECKING:
    from astropy.time import Time

NO_ANGLE = Angle(value=0.0, unit="rad")


class Kepler(AboutABody):
    """Elements at the epoch, relative to the axes of the scene's frame; angles left out are 0.

    `semi_major_axis`, or `altitude` of a circular orbit above the central body's `radius`;
    `true_anomaly` or `mean_anomaly`.
    """

    semi_major_axis: Length | None = None
    altitude: Length | None = None
    eccentricity: Annotated[Number, Field(ge=0.0, lt=1.0)] = 0.0
    inclination: Angle = NO_ANGLE
    raan: Angle = NO_ANGLE
    argument_of_pericentre: Angle = NO_ANGLE
    true_anomaly: Angle | None = None
    mean_anomaly: Angle | None = None

    @model_validator(mode="after")
    def _check(self) -> Kepler:
        exactly_one(self, ("semi_major_axis", "altitude"))
        if self.true_anomaly is not None and self.mean_anomaly is not None:
            raise InputError("mean_anomaly", self.mean_anomaly.value, "no mean_anomaly beside true_anomaly")
        if self.altitude is not None and self.eccentricity != 0.0:
            raise InputError("eccentricity", self.eccentricity, "0 beside altitude (else a semi_major_axis)")
        check_positive(self, "semi_major_axis")
        central = self.central()
        a = self._semi_major_axis(central)
        if central.radius is not None and a * (1.0 - self.eccentricity) <= central.radius:
            field = "semi_major_axis" if self.altitude is None else "altitude"
            above = f"a pericentre above the central body's radius ({central.radius:g} m)"
            raise InputError(f"{field}.value", getattr(self, field).value, above)
        return self

    def _semi_major_axis(self, central: CentralBody) -> float:
        if self.semi_major_axis is not None:
            return self.semi_major_axis.si
        if central.radius is None:
            raise InputError("radius", None, "the radius of the central body, which altitude is above")
        return central.radius + (0.0 if self.altitude is None else self.altitude.si)

    def path(self, start: float, stop: float, epoch: Time | None, frame: str) -> OrbitPath:
        """Return the ellipse; the same over any span, along the axes of the scene's frame."""
        central, e = self.central(), self.eccentricity
        a = self._semi_major_axis(central)
        high, low, rate = turn_rates.mean_motion(central.mu, a)
        numbers = np.zeros(layout.ORBIT_WIDTH)
        numbers[:7] = layout.KEPLER, a, e, self.initial_mean_anomaly(), high, low, rate
        numbers[7:10], numbers[10:13] = self.perifocal_axes()
        return OrbitPath(numbers, np.zeros((1, 3, 1)), 1.0 / high, central)

    def initial_mean_anomaly(self) -> float:
        """Mean anomaly at the epoch, turns, from -0.5 to 0.5."""
        if self.true_anomaly is None:
            mean = NO_ANGLE.si if self.mean_anomaly is None else self.mean_anomaly.si
            return math.remainder(mean, math.tau) / math.tau
        half, e = 0.5 * self.true_anomaly.si, self.eccentricity
        eccentric = 2.0 * math.atan2(math.sqrt(1.0 - e) * math.sin(half), math.sqrt(1.0 + e) * math.cos(half))
        mean = math.remainder(eccentric, math.tau) - e * math.sin(eccentric)
        return mean / math.tau

    def perifocal_axes(self) -> tuple[np.ndarray, np.ndarray]:
        """Perifocal unit vectors P, to the pericentre, and Q, along the velocity there (Vallado 2.6)."""
        node, argument, i = self.raan.si, self.argument_of_pericentre.si, self.inclination.si
        along_node = np.array([math.cos(node), math.sin(node), 0.0])
        across = np.array([-math.sin(node) * math.cos(i), math.cos(node) * math.cos(i), math.sin(i)])
        c, s = math.cos(argument), math.sin(argument)
        return c * along_node + s * across, c * across - s * along_node
