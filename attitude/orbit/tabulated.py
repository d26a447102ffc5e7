"""A table of positions: the course is the smooth curve through its points."""

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
from .piecewise_polynomial import sampled

if TYPE_CHECKING:
    from astropy.time import Time

LEAST_POINTS, DEGREE = 4, 7
# Between the points the spline is believed where one of lower degree says the same to this part of r.
COARSEST = 1e-3
TOLERANCE = 1e-10


class Instants(Measured):
    LIKE: ClassVar[Any] = units.SECOND
    value: Annotated[list[Number], Field(min_length=LEAST_POINTS)]


class Positions(Measured):
    LIKE: ClassVar[Any] = units.LENGTH
    value: Annotated[list[Vector], Field(min_length=LEAST_POINTS)]


class Table(AboutABody):
    """`times` (elapsed since the epoch) and `positions` from the central body, in the scene's frame.

    At least four points; the spline through them is of degree 7 where there are eight.
    """

    times: Instants
    positions: Positions

    @model_validator(mode="after")
    def _check(self) -> Table:
        times, points = self._times(), self._points()
        if len(times) != len(points):
            raise InputError(
                "positions.value", f"{len(points)} positions", f"{len(times)}, one for each of times"
            )
        if not (np.diff(times) > 0.0).all():
            i = int(np.argmin(np.diff(times) > 0.0)) + 1
            raise InputError(
                f"times.value[{i}]", self.times.value[i], "instants in ascending order, none twice"
            )
        central = self.central()
        least = 0.0 if central.radius is None else central.radius
        inside = np.sqrt((points**2).sum(axis=1)) <= least
        if inside.any():
            i = int(np.argmax(inside))
            outside = f"a position outside the central body (radius {least:g} m)"
            raise InputError(f"positions.value[{i}]", self.positions.value[i], outside)
        return self

    def _times(self) -> np.ndarray:
        return np.array(self.times.value) * self.times.factor

    def _points(self) -> np.ndarray:
        return np.array(self.positions.value) * self.positions.factor

    def course(self, start: float, stop: float, epoch: Time | None, frame: str) -> OrbitPath:
        times, points, central = self._times(), self._points(), self.central()
        if start < times[0] or stop > times[-1]:
            found = f"{times[0].item()!r} s to {times[-1].item()!r} s"
            raise InputError("times.value", found, f"a table over the whole span, {start!r} s to {stop!r} s")
        curve = _spline(times, points)
        step = float(np.diff(times).max())
        first, last = max(float(times[0]), start - step), min(float(times[-1]), stop + step)
        pieces = sampled(curve, first, last, step, TOLERANCE, "times")
        return course_of(pieces, _period(pieces, start, central.mu), central)


def course_of(pieces: PiecewisePolynomial, period: float, central: CentralBody) -> OrbitPath:
    numbers = np.zeros(layout.ORBIT_WIDTH)
    numbers[:3] = layout.TABLE, pieces.start, pieces.length
    return OrbitPath(numbers, pieces.coefficients, period, central)


def _spline(times: np.ndarray, points: np.ndarray) -> Any:
    """(n,) s -> (n, 3) m.  Refuses points too far apart to tell what is between them."""
    from scipy.interpolate import make_interp_spline

    degree = min(DEGREE, len(times) - 1)
    degree -= 1 - degree % 2
    curve = make_interp_spline(times, points, k=degree)
    coarser = make_interp_spline(times, points, k=max(1, degree - 2))
    middles = 0.5 * (times[1:] + times[:-1])
    off = np.sqrt(((curve(middles) - coarser(middles)) ** 2).sum(axis=1))
    unsure = off / np.sqrt((curve(middles) ** 2).sum(axis=1))
    i = int(np.argmax(unsure))
    if not unsure[i] <= COARSEST:
        found = f"{(times[i + 1] - times[i]).item():g} s apart"
        raise InputError(
            f"times.value[{i + 1}]", found, "points close enough to tell the positions between them"
        )
    return curve


def _period(pieces: PiecewisePolynomial, t: float, mu: float) -> float:
    """s: of the ellipse on which the body is at t; without one, the whole table's span."""
    r, v = (evaluate(pieces, np.array([t]), derivative)[0] for derivative in (0, 1))
    inverse = 2.0 / float(np.sqrt(r @ r)) - float(v @ v) / mu
    if inverse <= 0.0:
        return pieces.length * len(pieces.coefficients)
    return float(2.0 * np.pi / np.sqrt(mu * inverse**3))
