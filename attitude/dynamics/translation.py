"""Where the centre of mass is: the exact parabola under uniform gravity."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np


class Translation(NamedTuple):
    """Of the centre of mass, inertial: position (..., 3), m, and velocity (..., 3), m/s."""

    position: np.ndarray
    velocity: np.ndarray

    def part(self, key: Any) -> Translation:
        """That of some of the instants."""
        return Translation(self.position[key], self.velocity[key])


def parabola(
    position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray, seconds: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity, (..., 3), m and m/s, after so many seconds (...,).

    position, velocity : (..., 3) at zero; acceleration : (3,), m/s2, constant
    """
    t = np.asarray(seconds, dtype=float)[..., None]
    return position + (velocity + 0.5 * acceleration * t) * t, velocity + acceleration * t
