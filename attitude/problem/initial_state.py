"""Initial state of a body, its orbit and a bound on its spin: what effects and solvers share."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..kernels.layout import Ellipse, OrbitCode, TableOrbit
from ..rigid_body.body import RigidBody

if TYPE_CHECKING:
    from astropy.time import Time


class PiecewisePolynomial(NamedTuple):
    """A vector as a function of time, one polynomial on each of equal intervals (`kernels.layout`, TABLE).

    Attributes
    ----------
    start, length : start of the first interval and length of each, s; the outermost polynomials extrapolate
    coefficients : (intervals, 3, degree + 1), m, in powers of the time from the middle of the interval over
        half its length
    """

    start: float
    length: float
    coefficients: np.ndarray

    def __call__(self, t: np.ndarray, derivative: int = 0) -> np.ndarray:
        """(n, 3): the vector at t (n,) s, or a derivative of it by time."""
        count, degree = self.coefficients.shape[0], self.coefficients.shape[2] - 1
        scaled = (t - self.start) / self.length
        interval = np.clip(np.floor(scaled), 0, count - 1).astype(np.int64)
        x, coefficients = 2.0 * (scaled - interval) - 1.0, self.coefficients[interval]
        value = np.zeros((t.size, coefficients.shape[1]))
        for k in range(degree, derivative - 1, -1):
            value = value * x[:, None] + math.perm(k, derivative) * coefficients[:, :, k]
        return value / (0.5 * self.length) ** derivative


class Passages(NamedTuple):
    """Where the light of the Sun changes along an orbit.

    Attributes
    ----------
    shadow : CYLINDRICAL or CONICAL (`kernels.solvers.plate_layout`)
    edges : (n,) s, ascending, where one kind of light ends and another begins
    kinds : (n + 1,), DARK, PARTIAL or FULL_STRENGTH, between them
    cuts : (m,) s, ascending: the edges, and where arcs end in a penumbra besides
    """

    shadow: int
    edges: np.ndarray
    kinds: np.ndarray
    cuts: np.ndarray


class DensityProfile(NamedTuple):
    """The density of the air along an orbit, as a function of time.

    Attributes
    ----------
    pieces : (n, AirPiece.WIDTH), of its logarithm (`kernels.layout`, AIR); the outermost extrapolate
    cuts : (c,) s, ascending, where it or a derivative of it has a jump
    cost : s, of making it, as a plan predicts it
    """

    pieces: np.ndarray
    cuts: np.ndarray
    cost: float


class CentralBody(NamedTuple):
    """The body that is orbited.

    Attributes
    ----------
    mu : gravitational parameter, m3/s2
    radius : m; None if not given
    is_earth : whether the Earth's magnetic field, rotation and Sun direction apply
    """

    mu: float
    radius: float | None
    is_earth: bool


class OrbitPath(NamedTuple):
    """Orbit of the centre of mass, as kernels take it.

    Attributes
    ----------
    numbers : (ORBIT_WIDTH,), `kernels.layout`
    coefficients : (intervals, 3, degree + 1), of a PiecewisePolynomial; (1, 3, 1) zeros for a Keplerian orbit
    period : s, of one revolution; approximate for a table
    central : the body that is orbited; None if only positions are needed
    refined : a more exact path, by which the error of this one is estimated; None where it has none
    velocities : as coefficients, m/s, where a model states velocities that are not the derivative of its
        positions (SGP4): those of local frames and outputs
    """

    numbers: np.ndarray
    coefficients: np.ndarray
    period: float
    central: CentralBody | None = None
    refined: OrbitPath | None = None
    velocities: np.ndarray | None = None

    @property
    def is_keplerian(self) -> bool:
        """Whether this is an ellipse in closed form, and not piecewise polynomials."""
        return bool(self.numbers[0] == OrbitCode.KEPLER)

    @property
    def polynomial(self) -> PiecewisePolynomial:
        """The polynomials of the positions, m, of a path that is not Keplerian."""
        start, length = self.numbers[TableOrbit.START], self.numbers[TableOrbit.LENGTH]
        return PiecewisePolynomial(float(start), float(length), self.coefficients)

    @property
    def velocity_polynomial(self) -> PiecewisePolynomial | None:
        """The polynomials of the velocities, m/s, that a model states beside its positions; or None."""
        if self.velocities is None:
            return None
        return self.polynomial._replace(coefficients=self.velocities)

    @property
    def max_rate(self) -> float:
        """Speed over distance where it is greatest, rad/s; of a table in the middle of an interval."""
        if self.is_keplerian:
            e, mean_motion = self.numbers[Ellipse.ECCENTRICITY], self.numbers[Ellipse.MEAN_MOTION]
            return float(mean_motion * np.sqrt((1.0 + e) / (1.0 - e) ** 3))
        place, change = np.moveaxis(self.coefficients[:, :, :2], 2, 0)
        squares = (change * change).sum(axis=1) / (place * place).sum(axis=1)
        return float(np.sqrt(squares.max()) / (0.5 * self.numbers[TableOrbit.LENGTH]))


class Spin(NamedTuple):
    """Upper bounds on how fast bodies turn, (...) each.

    Attributes
    ----------
    rate : rad/s
    momentum : angular momentum of the body without its rotors, N m s
    rotors : angular momentum of the rotors relative to the body, N m s
    """

    rate: Any
    momentum: Any
    rotors: Any = 0.0


@dataclass(frozen=True, eq=False)
class InitialState:
    """A body, its state at the epoch, and the span of time that is asked for.

    Attributes
    ----------
    body : RigidBody, one
    attitude : (4,) wxyz, body to inertial; rate : (3,) rad/s, body components; both at t = 0
    start, stop : s since the epoch, the span that the instants cover together with t = 0
    epoch : Time or None; frame : str
    mass : kg, or None
    position, velocity : (3,), m and m/s, inertial, of the centre of mass at t = 0, or None
    orbit_path : OrbitPath or None
    order : indices of the body's principal axes, in the order of the rows of `axes`
    refined : whether what is interpolated along the orbit is so in finer pieces, to estimate its error
    """

    body: RigidBody
    attitude: np.ndarray
    rate: np.ndarray
    start: float
    stop: float
    epoch: Time | None = None
    frame: str = "ICRF"
    mass: float | None = None
    position: np.ndarray | None = None
    velocity: np.ndarray | None = None
    orbit_path: OrbitPath | None = None
    order: tuple[int, int, int] = (0, 1, 2)
    refined: bool = False

    @property
    def central_body(self) -> CentralBody | None:
        """The body that is orbited, if there is an orbit about a known one."""
        return None if self.orbit_path is None else self.orbit_path.central

    @property
    def moments(self) -> np.ndarray:
        """(3,), kg m2, in the order of `axes`."""
        return np.asarray(self.body.moments)[list(self.order)]

    @cached_property
    def axes(self) -> np.ndarray:
        """(3, 3), right-handed: rows are the principal axes; axes @ v: components along them."""
        axes = np.asarray(self.body.axes)[list(self.order)]
        (a, b, c), (x, y, z) = axes[:2].tolist()
        axes[2] = b * z - c * y, c * x - a * z, a * y - b * x
        axes.flags.writeable = False
        return axes

    def ordered(self, order: tuple[int, int, int]) -> InitialState:
        """Return this state with its principal axes in another order."""
        return replace(self, order=order)
