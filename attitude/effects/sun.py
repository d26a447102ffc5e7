"""Position of the Sun, and the pressure of its light."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..documents.fields import Part
from ..documents.quantities import Direction, unit_vector
from ..errors import InputError
from ..frames.celestial import au, sun_from_earth
from ..frames.earth_fixed import scene_axes
from ..orbit.piecewise_polynomial import interpolated
from ..problem.initial_state import PiecewisePolynomial
from ..times.julian_dates import DAY

if TYPE_CHECKING:
    from astropy.time import Time

SOLAR_CONSTANT = 1361.0  # W/m2 at 1 au (IAU 2015 resolution B3, nominal total solar irradiance)


class FixedSun(Part):
    """`{"direction": [..3]}`: towards the Sun, components in the scene's frame; 1 au away."""

    direction: Direction

    def vector(self) -> PiecewisePolynomial:
        """Return the constant vector to the Sun, m."""
        to_sun = au() * unit_vector(self.direction, "direction")
        return PiecewisePolynomial(0.0, 1.0, to_sun[None, :, None])


def parse(value: Any) -> Any:
    """Return a FixedSun, or the word "astropy"."""
    if isinstance(value, FixedSun) or value == "astropy":
        return value
    if not isinstance(value, dict):
        raise InputError("", value, '"astropy", or an object with the direction of a fixed Sun')
    return FixedSun.model_validate(value)


def classes() -> list[type[Part]]:
    """Return the classes of `sun`."""
    return [FixedSun]


def pressure() -> float:
    """Return the pressure of sunlight on an absorbing plate at 1 au, N/m2."""
    from astropy.constants import c

    return SOLAR_CONSTANT / float(c.value)


def from_earth(epoch: Time, frame: str, start: float, stop: float) -> PiecewisePolynomial:
    """Vector from the Earth to the Sun, m, in `frame`, within 1e-9 of `celestial.sun_from_earth`."""
    rotation = scene_axes(frame, epoch, "the position of the Sun")
    tdb = float(epoch.tdb.jd1), float(epoch.tdb.jd2)

    def position(t: np.ndarray) -> np.ndarray:
        return np.asarray(sun_from_earth(tdb, t) @ rotation.T)

    # the rounding of the series itself is 7e-11
    return interpolated(position, start - DAY, stop + DAY, 4.0 * DAY, 1e-9, "sun")
