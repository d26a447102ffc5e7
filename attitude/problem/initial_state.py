"""The numbers of a scene that effects and solvers share."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..rigid_body.body import RigidBody

if TYPE_CHECKING:
    from astropy.time import Time


class PiecewisePolynomial(NamedTuple):
    """A vector as a polynomial in time, piece by piece (`kernels.layout`, TABLE).

    Attributes
    ----------
    start, length : s; of the first piece, and of each; times before and after belong to the outermost
    coefficients : (pieces, 3, degree + 1), m, in powers of (t - start of the piece) / length
    """

    start: float
    length: float
    coefficients: np.ndarray


class CentralBody(NamedTuple):
    """The body that is orbited.

    Attributes
    ----------
    mu : gravitational parameter, m3/s2
    radius : m, or None where nobody said
    is_earth : whether what is known of the Earth (its field, its rotation) holds
    """

    mu: float
    radius: float | None
    is_earth: bool


class OrbitPath(NamedTuple):
    """Where the centre of mass is on its orbit, as kernels take it.

    Attributes
    ----------
    numbers : (ORBIT_WIDTH,), `kernels.layout`
    pieces : (pieces, 3, degree + 1); (1, 3, 1) zeros for a Keplerian orbit
    period : s, of one revolution, at least roughly
    central : the body that is orbited; None where nothing asks for more than positions
    """

    numbers: np.ndarray
    pieces: np.ndarray
    period: float
    central: CentralBody | None = None


@dataclass(frozen=True)
class InitialState:
    """A body, its state at the epoch, and the span of time in question.

    Attributes
    ----------
    body : RigidBody, one
    attitude : (4,) wxyz, body to inertial; rate : (3,) rad/s, body components; both at t = 0
    start, stop : s since the epoch, the span that the instants cover together with t = 0
    epoch : Time or None; frame : str
    mass : kg, or None
    position, velocity : (3,), m and m/s, inertial, of the centre of mass at t = 0, or None
    course : OrbitPath or None
    order : which principal axis of the body stands first, second, third in `axes`
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
    course: OrbitPath | None = None
    order: tuple[int, int, int] = (0, 1, 2)

    @property
    def moments(self) -> np.ndarray:
        """(3,), kg m2, in the order of `axes`."""
        return np.asarray(self.body.moments)[list(self.order)]

    @property
    def axes(self) -> np.ndarray:
        """(3, 3), right-handed: rows are the principal axes; axes @ v: components along them."""
        axes = np.asarray(self.body.axes)[list(self.order)]
        axes[2] = np.cross(axes[0], axes[1])
        return axes

    def ordered(self, order: tuple[int, int, int]) -> InitialState:
        """The same with its principal axes in another order."""
        return replace(self, order=order)
