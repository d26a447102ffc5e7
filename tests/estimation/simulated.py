"""Observations of a known motion, with Gaussian errors of known size."""

import numpy as np
from scipy.spatial.transform import Rotation

from attitude import RigidBody, TorqueFreeMotion
from attitude.estimation import Attitudes, BodyRates, Directions, RangeOffsets

SIGMA = 1e-3  # rad
TENSOR = np.array([[10.0, 0.5, -0.2], [0.5, 13.0, 0.7], [-0.2, 0.7, 17.0]])
MOMENTS = (10.0, 13.0, 17.0)
RATE = (0.02, -0.03, 0.05)  # rad/s
SECONDS = np.arange(0.0, 1000.0, 10.0)


def motion(inertia=MOMENTS, rate=RATE):
    return TorqueFreeMotion(RigidBody(inertia), (1.0, 0.0, 0.0, 0.0), rate, order="wxyz")


def attitudes(truth, random, seconds=SECONDS, sigma=SIGMA):
    errors = Rotation.from_rotvec(sigma * random.normal(size=(len(seconds), 3)))
    return Attitudes(seconds, sigma, attitude=truth.at(seconds).rotation * errors)


def rates(truth, random, seconds=SECONDS, sigma=1e-4, bias=(0.0, 0.0, 0.0), has_bias=False):
    observed = truth.at(seconds).angular_velocity + bias + sigma * random.normal(size=(len(seconds), 3))
    return BodyRates(seconds, sigma, rate=observed, has_bias=has_bias)


def sightings(truth, random, inertial, seconds=SECONDS, sigma=SIGMA, label=""):
    """A direction of inertial space seen along body axes."""
    seen = truth.at(seconds).rotation.inv().apply(np.array(inertial) / np.linalg.norm(inertial))
    return Directions(
        seconds, sigma, label, body=seen + sigma * random.normal(size=seen.shape), inertial=inertial
    )


def axis_seen(truth, random, axis, seconds=SECONDS, sigma=SIGMA):
    """A body axis seen from outside."""
    seen = truth.at(seconds).rotation.apply(axis)
    return Directions(seconds, sigma, body=axis, inertial=seen + sigma * random.normal(size=seen.shape))


def ranges(truth, random, point=(0.5, 0.3, 1.0), seconds=SECONDS, sigma=1e-3, bias=0.0, has_bias=False):
    sight = np.stack([np.cos(seconds / 800.0), np.sin(seconds / 800.0), 0.2 + 0.0 * seconds], axis=1)
    sight /= np.linalg.norm(sight, axis=1, keepdims=True)
    offset = (truth.at(seconds).rotation.apply(point) * sight).sum(axis=1)
    offset += bias + sigma * random.normal(size=len(seconds))
    return RangeOffsets(seconds, sigma, offset=offset, point=point, line_of_sight=sight, has_bias=has_bias)
