"""Points: where a body axis meets the Earth's ellipsoid, and where a target stands above the body."""

from __future__ import annotations

from typing import Any, NamedTuple

import erfa
import numpy as np

from ..frames import rotations
from ..frames.earth_fixed import WGS84
from ..samples.ephemeris_data import EphemerisData
from ..samples.transform import in_frame
from .targets import direction, position, target


class GroundPoints(NamedTuple):
    """Where an axis meets the ground.

    longitude, latitude : (...,) rad, geodetic, WGS84; masked where the axis misses the Earth
    distance : (...,) m from the body; masked likewise
    """

    longitude: np.ma.MaskedArray
    latitude: np.ma.MaskedArray
    distance: np.ma.MaskedArray


def ground_points(data: EphemerisData, axis: Any) -> GroundPoints:
    """The first points of the Earth's ellipsoid along a body axis, from a body in an orbit about the Earth.

    Raises RegimeError without an orbit; InputError without dates.
    """
    fixed = in_frame(data, "ITRF")
    start, along = position(fixed), direction(fixed, axis)
    a, f = erfa.eform(WGS84)
    scale = np.array([1.0, 1.0, 1.0 / (1.0 - f)])  # to a sphere of radius a
    p, v = start * scale, along * scale
    vv, pv = (v * v).sum(axis=-1), (p * v).sum(axis=-1)
    root = pv * pv - vv * ((p * p).sum(axis=-1) - a * a)
    distance = (-pv - np.sqrt(np.maximum(root, 0.0))) / vv
    misses = (root < 0.0) | (distance < 0.0)
    point = start + distance[..., None] * along
    longitude, latitude, _ = erfa.gc2gd(WGS84, point)
    return GroundPoints(*(np.ma.masked_array(values, misses) for values in (longitude, latitude, distance)))


def sub_point(data: EphemerisData, to: Any) -> tuple[np.ndarray, np.ndarray]:
    """Longitude and latitude, (...,) rad, of a target in the body axes: sub-solar point, sub-observer point.

    to : as in `targets.target`
    """
    q = data.quaternion("wxyz")
    x, y, z = np.moveaxis(rotations.rotate(rotations.conjugate(q), target(data, to)), -1, 0)
    return np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))
