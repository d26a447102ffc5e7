"""An orbit given by a table of positions, interpolated by a spline."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import Field, model_validator

from .. import units
from ..documents.fields import Number, Vector
from ..documents.quantities import Measured
from ..errors import InputError
from ..kernels import layout
from ..problem.initial_state import CentralBody, OrbitPath, PiecewisePolynomial
from .orbit import AboutABody
from .path_states import evaluate
from .piecewise_polynomial import interpolated

if TYPE_CHECKING:
    from astropy.time import Time

MIN_POINTS = 4


class OrbitTimes(Measured):
    """Elapsed times of a table of positions, with their unit."""

    LIKE: ClassVar[Any] = units.SECOND
    value: Annotated[list[Number], Field(min_length=MIN_POINTS, fail_fast=True)]


class OrbitPositions(Measured):
    """Positions of a table, with their unit."""

    LIKE: ClassVar[Any] = units.LENGTH
    value: Annotated[list[Vector], Field(min_length=MIN_POINTS, fail_fast=True)]


class OrbitTable(AboutABody):
    """`times` (elapsed since the epoch) and `positions` from the central body, in the scene's frame.

    At least four points; the spline through them is of degree 7 where there are eight.
    """

    times: OrbitTimes
    positions: OrbitPositions

    @model_validator(mode="after")
    def _check(self) -> OrbitTable:
        times, points = self._arrays()
        if len(times) != len(points):
            expected = f"{len(times)}, one for each of times"
            raise InputError("positions.value", f"{len(points)} positions", expected)
        if not (np.diff(times) > 0.0).all():
            i = int(np.argmin(np.diff(times) > 0.0)) + 1
            expected = "instants in ascending order, none twice"
            raise InputError(f"times.value[{i}]", self.times.value[i], expected)
        central = self.central()
        least = 0.0 if central.radius is None else central.radius
        inside = np.sqrt((points**2).sum(axis=1)) <= least
        if inside.any():
            i = int(np.argmax(inside))
            outside = f"a position outside the central body (radius {least:g} m)"
            raise InputError(f"positions.value[{i}]", self.positions.value[i], outside)
        return self

    def _arrays(self) -> tuple[np.ndarray, np.ndarray]:
        """(n,) s and (n, 3) m."""
        times, positions = self.times, self.positions
        return np.array(times.value) * times.factor, np.array(positions.value) * positions.factor

    def path(self, start: float, stop: float, epoch: Time | None, frame: str) -> OrbitPath:
        """Interpolate the spline over the span and one step of the table on either side."""
        (times, points), central = self._arrays(), self.central()
        if start < times[0] or stop > times[-1]:
            table_span = f"{times[0].item()!r} s to {times[-1].item()!r} s"
            expected = f"a table over the whole span, {start!r} s to {stop!r} s"
            raise InputError("times.value", table_span, expected)
        step = float(np.diff(times).max())
        first, last = max(float(times[0]), start - step), min(float(times[-1]), stop + step)
        curve = spline(times, points)
        polynomial = interpolated(curve, first, last, step, 1e-10, "times")
        return tabulated_path(polynomial, osculating_period(polynomial, start, central.mu), central)


def tabulated_path(polynomial: PiecewisePolynomial, period: float, central: CentralBody) -> OrbitPath:
    """Return the path on piecewise polynomials; period in s."""
    numbers = np.zeros(layout.ORBIT_WIDTH)
    numbers[:3] = layout.TABLE, polynomial.start, polynomial.length
    return OrbitPath(numbers, polynomial.coefficients, period, central)


def spline(times: np.ndarray, points: np.ndarray) -> Any:
    """(n,) s -> (n, 3) m.  InputError where points are too far apart for the positions between them."""
    from scipy.interpolate import make_interp_spline

    degree = min(7, len(times) - 1)
    degree -= 1 - degree % 2
    curve = make_interp_spline(times, points, k=degree)
    lower_degree = make_interp_spline(times, points, k=max(1, degree - 2))
    middles = 0.5 * (times[1:] + times[:-1])
    difference = np.sqrt(((curve(middles) - lower_degree(middles)) ** 2).sum(axis=1))
    relative = difference / np.sqrt((curve(middles) ** 2).sum(axis=1))
    i = int(np.argmax(relative))
    if not relative[i] <= 1e-3:  # the difference from a spline of lower degree, relative to the distance
        expected = "points close enough to interpolate the positions between them"
        raise InputError(f"times.value[{i + 1}]", f"{(times[i + 1] - times[i]).item():g} s apart", expected)
    return curve


def osculating_period(polynomial: PiecewisePolynomial, t: float, mu: float) -> float:
    """Period of the osculating ellipse at t, s; without one, the span of the whole table."""
    r, v = (evaluate(polynomial, np.array([t]), derivative)[0] for derivative in (0, 1))
    inverse = 2.0 / float(np.sqrt(r @ r)) - float(v @ v) / mu
    if inverse <= 0.0:
        return polynomial.length * len(polynomial.coefficients)
    return float(2.0 * np.pi / np.sqrt(mu * inverse**3))
