"""Translation of the centre of mass: the exact parabola under uniform gravity, with impulses."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from .. import stopping

Pushes = Iterable[tuple[float, np.ndarray]]


class Translation(NamedTuple):
    """Inertial position (..., 3), m, and velocity (..., 3), m/s, of the centre of mass."""

    position: np.ndarray
    velocity: np.ndarray

    def part(self, key: Any) -> Translation:
        """The translation at some of the instants."""
        return Translation(self.position[key], self.velocity[key])


def parabola(
    position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray, seconds: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity, (..., 3), m and m/s, after so many seconds (...,).

    position, velocity : (..., 3) at zero; acceleration : (3,), m/s2, constant
    """
    t = np.asarray(seconds, dtype=float)[..., None]
    return position + (velocity + 0.5 * acceleration * t) * t, velocity + acceleration * t


def pushed(start: Translation, acceleration: np.ndarray, seconds: np.ndarray, pushes: Pushes) -> Translation:
    """The parabola, broken by sudden changes of the velocity.

    start : at zero; seconds : (...,), of either sign; pushes : (s, change of velocity (3,), m/s, inertial)

    At its instant a push has happened; at zero not yet, whatever happens then.
    """
    position, velocity = parabola(*start, acceleration, seconds)
    t = np.asarray(seconds, dtype=float)[..., None]
    for at, change in pushes:
        stopping.check()
        done = (t >= at).astype(float) if at >= 0.0 else -(t < at).astype(float)
        position = position + done * change * (t - at)
        velocity = velocity + done * change
    return Translation(position, velocity)
