"""Functions of a motion whose zeros are crossings of a condition, with bounds on how fast they change."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from astropy.time import Time

from .. import stopping
from ..errors import InputError, RegimeError
from ..frames.celestial import shadow_heights
from ..pointing import targets
from ..samples.ephemeris_data import EphemerisData, OrbitLimits
from ..times.instants import Instants
from .condition import AngleBelow, Elementary
from .root_search import BoundedFunction, Sample

MAX_EARTH_SPEED = 31e3  # m/s, relative to the Sun, for two thousand years about J2000.0
# rad/s: of the Earth's rotation, and of the Sun seen from it, with the axes of frames of date
MAX_EARTH_RATE, MAX_SUN_RATE = 7.3e-5, 2.2e-7
MARGIN = 1.0 + 1e-6  # of bounds: the rounding of what they are computed from


@dataclass(frozen=True)
class BoundedMotion:
    """A motion over a span, with bounds on how fast the body turns.

    Attributes
    ----------
    epoch : Time or None
    start, stop : s since the epoch
    at : the ephemeris at instants
    rate : (n,) rad/s, bounds at instants, of the ephemeris there
    growth : rad/s2, by which such a bound may grow in the time after
    torque : N m, bound on what changes the angular momentum
    cuts : s, instants at which the rate jumps
    """

    epoch: Time | None
    start: float
    stop: float
    at: Callable[[Instants], EphemerisData]
    rate: Callable[[EphemerisData], np.ndarray]
    growth: float = 0.0
    torque: float = 0.0
    cuts: tuple[float, ...] = ()

    def sampled(self, seconds: np.ndarray, seconds_low: np.ndarray) -> EphemerisData:
        """The ephemeris at instants (n,), s since the epoch in two parts."""
        stopping.check()
        return self.at(Instants(seconds, seconds_low, self.epoch))

    def orbit_limits(self, data: EphemerisData) -> OrbitLimits:
        """Bounds on the motion along the orbit; zero without one."""
        if data.orbit is None:
            return OrbitLimits(speed=0.0, acceleration=0.0, distance=np.inf, moment=0.0)
        return data.orbit.limits(self.start, self.stop)


def bounded_function(motion: BoundedMotion, condition: Elementary) -> BoundedFunction:
    """The function that is negative where the condition holds.

    Raises InputError or RegimeError where the motion lacks what the condition needs: dates, an orbit ...
    """
    if isinstance(condition, AngleBelow):
        return AngleFunction(motion, condition)
    return ShadowFunction(motion, condition.kind)


class AngleFunction:
    """The angle between a body axis and a target, less a threshold, rad.

    It changes by no more than the body turns and the target's direction moves.  A vector v that changes by at
    most s a second turns, in a time d after it is v, by at most s / (abs(v) - s d) a second.
    """

    def __init__(self, motion: BoundedMotion, condition: AngleBelow):
        self.motion, self.axis, self.threshold = motion, condition.axis, condition.threshold
        self.to = json.loads(condition.target)
        first = motion.sampled(np.array([motion.start]), np.zeros(1))
        self.speed, self.drift = self._target_limits(motion.orbit_limits(first))

    def _target_limits(self, orbit: OrbitLimits) -> tuple[float, float]:
        """Bounds on how fast the target's vector changes, SI units, and its direction besides, rad/s."""
        kind = next(iter(self.to)) if isinstance(self.to, dict) else self.to
        if kind == "magnetic_field":
            # the field of a dipole turns by at most three times the angle that the position moves by
            moving = orbit.speed / max(orbit.distance, 1.0) + MAX_EARTH_RATE
            return 0.0, 3.0 * moving + MAX_EARTH_RATE
        speeds = {
            "sun": MAX_EARTH_SPEED + orbit.speed,
            "earth": orbit.speed,
            "position": orbit.speed,
            "velocity": orbit.acceleration,
            "orbit_normal": orbit.moment,
            "momentum": self.motion.torque,
        }
        return speeds.get(kind, 0.0) if isinstance(kind, str) else 0.0, 0.0

    def __call__(self, seconds: np.ndarray, seconds_low: np.ndarray) -> Sample:
        """(n,) rad; and of each instant the bound on the body's rate, rad/s, and the target's distance."""
        data = self.motion.sampled(seconds, seconds_low)
        vector = targets.target_vector(data, self.to)
        towards = targets.unit_vectors(vector, f"the direction of {self.to!r:.40}")
        values = targets.angle_between(targets.direction(data, self.axis), towards) - self.threshold
        distance = np.linalg.norm(vector, axis=-1)
        state = np.stack([self.motion.rate(data), np.broadcast_to(distance, values.shape)], axis=-1)
        return Sample(values, state)

    def max_rate(self, state: np.ndarray, duration: np.ndarray) -> np.ndarray:
        """(n,) rad/s over durations (n,), s; infinite where the target may be met."""
        least = state[:, 1] - self.speed * duration
        turning: Any = 0.0
        if self.speed:
            with np.errstate(divide="ignore"):
                turning = np.where(least > 0.0, self.speed / np.maximum(least, 0.0), np.inf)
        return np.asarray(MARGIN * (state[:, 0] + self.motion.growth * duration + turning + self.drift))


class ShadowFunction:
    """Distance of the body from a surface of the shadow over the central body's radius, negative within."""

    def __init__(self, motion: BoundedMotion, kind: str):
        self.motion, self.side = motion, {"umbra": -1.0, "penumbra": 1.0, "cylinder": 0.0}[kind]
        first = motion.sampled(np.array([motion.start]), np.zeros(1))
        if first.orbit is None:
            raise RegimeError("shadow: this motion is of no scene that has an orbit")
        radius = first.orbit.central_radius
        if radius is None:
            raise InputError("orbit.radius", None, "the radius of the central body, which is its shadow's")
        self.radius, self.speed = radius, motion.orbit_limits(first).speed

    def __call__(self, seconds: np.ndarray, seconds_low: np.ndarray) -> Sample:
        """(n,); and of each instant the distance from the central body, m."""
        data = self.motion.sampled(seconds, seconds_low)
        position, sun = targets.position(data), targets.sun_from_centre(data)
        heights, edge = shadow_heights(position, sun, self.radius, self.side)
        if self.side < 0.0:  # behind the tip of the umbra the Sun is a ring, and gives light
            heights = heights - 2.0 * np.minimum(edge, 0.0)
        return Sample(heights / self.radius, np.linalg.norm(position, axis=1)[:, None])

    def max_rate(self, state: np.ndarray, duration: np.ndarray) -> np.ndarray:
        """(n,) per s over durations (n,), s: of the body, and of the shadow at its distance."""
        swept = MAX_SUN_RATE * (state[:, 0] + self.speed * duration)
        return np.asarray(MARGIN * (self.speed + swept + MAX_SUN_RATE * self.radius) / self.radius)
