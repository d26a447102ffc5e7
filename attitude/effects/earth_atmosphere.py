"""What models of the Earth's thermosphere share: geodetic places on the orbit, and their range."""

from __future__ import annotations

from typing import ClassVar

import erfa
import numpy as np

from ..errors import InputError
from ..frames.earth_fixed import WGS84, celestial_pole, itrf, scene_axes, since_j2000
from ..frames.rotations import rotate
from ..orbit.path_states import position
from ..problem.initial_state import InitialState
from ..times.instants import Instants
from .atmosphere import Atmosphere
from .effect import required_orbit_path

PURPOSE = "the density of the Earth's atmosphere"


class EarthAtmosphere(Atmosphere):
    """A model of the Earth's atmosphere between geodetic altitudes; needs an epoch.

    The pole is that of the date (IAU 2006/2000A), without polar motion; UTC is taken for UT1 (within 13.5
    arcseconds of longitude).
    """

    RANGE: ClassVar[tuple[float, float]] = (100e3, 1000e3)
    PIECE_SECONDS: ClassVar[float] = 1.5e-4

    def check(self, initial_state: InitialState) -> None:
        """Refuse another central body, a scene without epoch, and a frame that is not known."""
        if initial_state.epoch is None:
            raise InputError("epoch", None, f"an epoch, which {self.name()} needs")
        scene_axes(initial_state.frame, initial_state.epoch, PURPOSE)
        central = initial_state.central_body
        if central is not None and not central.is_earth:
            expected = "a constant density or a table: the central body is not the Earth"
            raise InputError("model", self.name(), expected)

    def range(self) -> tuple[float, float]:
        """Altitudes of the model, m."""
        return self.RANGE

    def altitude_along(self, initial_state: InitialState, t: np.ndarray) -> np.ndarray:
        """(n,) m, above the ellipsoid of WGS 84."""
        return geodetic(along_pole(initial_state, t, celestial_positions(initial_state, t)))[2]


def celestial_positions(initial_state: InitialState, t: np.ndarray) -> np.ndarray:
    """(n, 3) m, on the orbit, along the axes of GCRF."""
    r = position(required_orbit_path(initial_state), t)
    return np.asarray(r @ scene_axes(initial_state.frame, initial_state.epoch, PURPOSE))


def along_pole(initial_state: InitialState, t: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """(n, 3): vectors (n, 3), along the axes of GCRF, along axes whose third is the pole of the date."""
    days = since_j2000(Instants(t, None, initial_state.epoch))
    return np.asarray(rotate(celestial_pole(days)[0].quaternion, vectors))


def earth_fixed(initial_state: InitialState, t: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """(n, 3): vectors (n, 3), along the axes of GCRF, along those of ITRF."""
    return np.asarray(rotate(itrf(Instants(t, None, initial_state.epoch), "utc").quaternion, vectors))


def geodetic(r: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(n,) each: longitude and latitude, rad, and altitude, m, over WGS 84, of positions (n, 3)."""
    longitude, latitude, altitude = erfa.gc2gd(WGS84, r)
    return longitude, latitude, altitude
