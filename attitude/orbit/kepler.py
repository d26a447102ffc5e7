"""Keplerian elements: exact motion of two bodies, on ellipses and hyperbolas, or secular rates of J2."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from pydantic import Field, StrictBool, model_validator

from ..documents.fields import Number, exactly_one
from ..documents.quantities import Angle, Length
from ..errors import InputError
from ..kernels.layout import ORBIT_WIDTH, Ellipse, OrbitCode
from ..problem.initial_state import CentralBody, OrbitPath
from ..times import turn_rates
from ..times.two_part import two_sum
from .orbit import AboutABody
from .path_states import eccentric_anomaly, hyperbolic_anomaly
from .piecewise_polynomial import PIECES_PER_REVOLUTION, function_path

if TYPE_CHECKING:
    from astropy.time import Time

NO_ANGLE = Angle(value=0.0, unit="rad")
# EGM2008 (tide-free): J2 and the radius it is for, m.
EARTH_J2, EARTH_J2_RADIUS = 1.0826261738522e-3, 6378136.3


class Kepler(AboutABody):
    """Elements at the epoch, relative to the axes of the scene's frame; angles left out are 0.

    `semi_major_axis`, negative for a hyperbola, or `altitude` of a circular orbit above the central body's
    `radius`; `true_anomaly` or `mean_anomaly`.  `j2`: true for the Earth's, or a number: the elements are
    mean ones, and node, pericentre and mean anomaly have its secular rates about the frame's z axis.
    """

    FORM: ClassVar[str] = "Keplerian elements"

    semi_major_axis: Length | None = None
    altitude: Length | None = None
    eccentricity: Annotated[Number, Field(ge=0.0)] = 0.0
    inclination: Angle = NO_ANGLE
    raan: Angle = NO_ANGLE
    argument_of_pericentre: Angle = NO_ANGLE
    true_anomaly: Angle | None = None
    mean_anomaly: Angle | None = None
    j2: StrictBool | Annotated[Number, Field(gt=-1.0, lt=1.0)] = False

    @model_validator(mode="after")
    def _check(self) -> Kepler:
        exactly_one(self, ("semi_major_axis", "altitude"))
        if self.true_anomaly is not None and self.mean_anomaly is not None:
            raise InputError("mean_anomaly", self.mean_anomaly.value, "no mean_anomaly beside true_anomaly")
        if self.altitude is not None and self.eccentricity != 0.0:
            raise InputError("eccentricity", self.eccentricity, "0 beside altitude (else a semi_major_axis)")
        central = self.central()
        a = self._semi_major_axis(central)
        self._check_conic(a)
        self._check_j2(central)
        if central.radius is not None and a * (1.0 - self.eccentricity) <= central.radius:
            field = "semi_major_axis" if self.altitude is None else "altitude"
            above = f"a pericentre above the central body's radius ({central.radius:g} m)"
            raise InputError(f"{field}.value", getattr(self, field).value, above)
        return self

    def _check_conic(self, a: float) -> None:
        """Refuse a parabola, a size of the wrong sign, and an anomaly beyond the asymptotes."""
        e, anomaly = self.eccentricity, self.true_anomaly
        if e == 1.0:
            raise InputError("eccentricity", e, "less than 1 or greater: a parabola has no semi_major_axis")
        if not a * (1.0 - e) > 0.0 and self.semi_major_axis is not None:
            sign = "greater than 0" if e < 1.0 else "less than 0, of a hyperbola"
            raise InputError("semi_major_axis.value", self.semi_major_axis.value, f"a number {sign}")
        if e > 1.0 and anomaly is not None:
            limit = math.acos(-1.0 / e)
            if not abs(math.remainder(anomaly.si, math.tau)) < limit:
                expected = f"within the asymptotes, {math.degrees(limit):.6g} deg from the pericentre"
                raise InputError("true_anomaly.value", anomaly.value, expected)

    def _check_j2(self, central: CentralBody) -> None:
        if self.j2 is False:
            return
        if self.eccentricity > 1.0:
            raise InputError("j2", self.j2, "no j2 beside a hyperbola, which has no secular rates")
        if self.j2 is True and not central.is_earth:
            raise InputError("j2", self.j2, "the number J2 of the central body, which is not the Earth")
        if central.radius is None:
            raise InputError("radius", None, "the radius of the central body, which j2 is for")

    def _semi_major_axis(self, central: CentralBody) -> float:
        if self.semi_major_axis is not None:
            return self.semi_major_axis.si
        if central.radius is None:
            raise InputError("radius", None, "the radius of the central body, which altitude is above")
        return central.radius + (0.0 if self.altitude is None else self.altitude.si)

    def summary(self) -> str:
        """The form of the orbit and its gravitational parameter, for people."""
        j2 = EARTH_J2 if self.j2 is True else self.j2
        return super().summary() + ("" if self.j2 is False else f"; secular rates of J2 = {j2:.10g}")

    def path(self, start: float, stop: float, epoch: Time | None, frame: str) -> OrbitPath:
        """Return the ellipse; the same over any span, along the axes of the scene's frame."""
        central, e = self.central(), self.eccentricity
        a = self._semi_major_axis(central)
        if e > 1.0 or self.j2 is not False:
            return self._interpolated(start, stop, a, central)
        high, low, rate = turn_rates.mean_motion(central.mu, a)
        numbers = np.zeros(ORBIT_WIDTH)
        numbers[: Ellipse.P] = OrbitCode.KEPLER, a, e, self.initial_mean_anomaly(), high, low, rate
        numbers[Ellipse.P : Ellipse.Q], numbers[Ellipse.Q : Ellipse.Q + 3] = self.perifocal_axes()
        return OrbitPath(numbers, np.zeros((1, 3, 1)), 1.0 / high, central)

    def _interpolated(self, start: float, stop: float, a: float, central: CentralBody) -> OrbitPath:
        """The hyperbola, or the ellipse that turns, over the span and a little more on either side."""
        e = self.eccentricity
        fastest = math.sqrt(central.mu * (1.0 + e) / (a * (1.0 - e)) ** 3)  # rad/s, at the pericentre
        mean_motion = math.sqrt(central.mu / abs(a) ** 3)
        period = math.tau / (fastest if e > 1.0 else mean_motion)
        margin = period / PIECES_PER_REVOLUTION
        first, last = start - margin, stop + margin
        tolerance = 1e-12  # of the distance, of what polynomials leave
        if e > 1.0:
            position = partial(self._on_hyperbola, a, mean_motion)
        else:
            position = partial(self._on_turning_ellipse, a, central)
            # far from the epoch an instant's rounding alone moves the body by more
            tolerance = max(tolerance, 1e-15 * fastest * max(abs(first), abs(last)))
        return function_path(position, (first, last), period, central, tolerance, "semi_major_axis")

    def _on_hyperbola(self, a: float, mean_motion: float, t: np.ndarray) -> np.ndarray:
        """(n, 3) m."""
        e = self.eccentricity
        H = hyperbolic_anomaly(math.tau * self.initial_mean_anomaly() + mean_motion * t, e)
        x, y = -a * (e - np.cosh(H)), -a * math.sqrt((e - 1.0) * (e + 1.0)) * np.sinh(H)
        P, Q = self.perifocal_axes()
        return np.asarray(x[:, None] * P + y[:, None] * Q)

    def _on_turning_ellipse(self, a: float, central: CentralBody, t: np.ndarray) -> np.ndarray:
        """(n, 3) m: on the ellipse, whose axes turn at the secular rates of J2."""
        e = self.eccentricity
        high, low, mean_motion = turn_rates.mean_motion(central.mu, a)
        along, node_rate, argument_rate = self.secular_rates(a, mean_motion, central)
        high, rounding = two_sum(high, along / math.tau)
        turns = self.initial_mean_anomaly() + turn_rates.fraction_of_turn(t, high, low + rounding)
        E = eccentric_anomaly(math.tau * (turns - np.round(turns)), e)
        x, y = a * (np.cos(E) - e), a * math.sqrt((1.0 - e) * (1.0 + e)) * np.sin(E)
        node, argument = self.raan.si + node_rate * t, self.argument_of_pericentre.si + argument_rate * t
        P, Q = perifocal_axes(node, argument, self.inclination.si)
        return np.asarray(x[:, None] * P + y[:, None] * Q)

    def secular_rates(self, a: float, mean_motion: float, central: CentralBody) -> tuple[float, float, float]:
        """What J2 adds to the rates of mean anomaly, node and argument of pericentre, rad/s, to first order.

        Source: Vallado, Fundamentals of Astrodynamics and Applications, 4th ed., section 9.6.1.
        """
        is_earths = self.j2 is True
        j2, radius = (EARTH_J2, EARTH_J2_RADIUS) if is_earths else (float(self.j2), central.radius or 0.0)
        e, cosine = self.eccentricity, math.cos(self.inclination.si)
        factor = 0.75 * mean_motion * j2 * (radius / (a * (1.0 - e * e))) ** 2
        along = factor * math.sqrt(1.0 - e * e) * (3.0 * cosine**2 - 1.0)
        return along, -2.0 * factor * cosine, factor * (5.0 * cosine**2 - 1.0)

    def initial_mean_anomaly(self) -> float:
        """Mean anomaly at the epoch, turns: of an ellipse from -0.5 to 0.5, of a hyperbola of any size."""
        e = self.eccentricity
        if self.true_anomaly is None:
            mean = NO_ANGLE.si if self.mean_anomaly is None else self.mean_anomaly.si
            return (mean if e > 1.0 else math.remainder(mean, math.tau)) / math.tau
        if e > 1.0:
            half = 0.5 * math.remainder(self.true_anomaly.si, math.tau)
            H = 2.0 * math.atanh(math.sqrt((e - 1.0) / (e + 1.0)) * math.tan(half))
            return (e * math.sinh(H) - H) / math.tau
        half = 0.5 * self.true_anomaly.si
        eccentric = 2.0 * math.atan2(math.sqrt(1.0 - e) * math.sin(half), math.sqrt(1.0 + e) * math.cos(half))
        mean = math.remainder(eccentric, math.tau) - e * math.sin(eccentric)
        return mean / math.tau

    def perifocal_axes(self) -> tuple[np.ndarray, np.ndarray]:
        """Perifocal unit vectors at the epoch, (3,) each, as `perifocal_axes` has them."""
        node, argument = np.array([self.raan.si]), np.array([self.argument_of_pericentre.si])
        P, Q = perifocal_axes(node, argument, self.inclination.si)
        return P[0], Q[0]


def perifocal_axes(node: np.ndarray, argument: np.ndarray, i: float) -> tuple[np.ndarray, np.ndarray]:
    """Perifocal unit vectors P, to the pericentre, and Q, along the velocity there (Vallado 2.6), (n, 3).

    node, argument : (n,), longitude of the node and argument of the pericentre; i : inclination; rad
    """
    zero, one = np.zeros_like(node), np.ones_like(node)
    along_node = np.stack([np.cos(node), np.sin(node), zero], axis=1)
    across = np.stack([-np.sin(node) * math.cos(i), np.cos(node) * math.cos(i), one * math.sin(i)], axis=1)
    c, s = np.cos(argument)[:, None], np.sin(argument)[:, None]
    return c * along_node + s * across, c * across - s * along_node
