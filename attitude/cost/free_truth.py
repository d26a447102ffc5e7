"""Truth of free motion: attitudes to fifty digits at some instants, conserved energy and momentum at all."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from types import ModuleType
from typing import Any

import numpy as np

from ..errors import AttitudeError
from .initial_value_problem import InitialValueProblem

MAX_TRUTH_INSTANTS = 30
# Errors are computed in the longest floats, on moments and rates scaled to order one: on most machines the
# rounding of the computation itself is then below that of the methods.
LONG = np.longdouble


def oracle() -> ModuleType:
    """The module `attitude.oracle.truth`.

    Raises
    ------
    AttitudeError : mpmath is not installed.
    """
    try:
        from ..oracle import truth
    except ModuleNotFoundError as error:
        if error.name != "mpmath":
            raise
        raise AttitudeError("the cost needs mpmath for its truth: pip install 'attitude[cost]'") from None
    return truth


@dataclass(frozen=True)
class Truth:
    """True attitudes at a few of a horizon's samples.

    Attributes
    ----------
    indices : (m,), of the samples; the last sample is always among them
    attitudes : m quaternions of mpf, wxyz, to fifty digits; of doubles where `off` is not 0
    route : "Taylor", which shares no formula with any closed form, or "theta" beyond its reach;
        under torques one of `torque_truth`
    rates : (m, 3), rad/s; None for a free body, whose conserved quantities judge its rates
    off : rad, estimated error of these attitudes
    """

    indices: np.ndarray
    attitudes: list[Any]
    route: str
    rates: np.ndarray | None = None
    off: float = 0.0

    @classmethod
    def at_random_samples(
        cls, t: np.ndarray, problem: InitialValueProblem, random: np.random.Generator
    ) -> Truth:
        """Truth at up to MAX_TRUTH_INSTANTS of the instants t (n,), s, drawn at random."""
        indices = random_indices(t.size, random)
        try:
            return cls(indices, _attitudes(problem, t[indices], "taylor"), "Taylor")
        except ArithmeticError:  # too many Taylor steps
            return cls(indices, _attitudes(problem, t[indices], "theta"), "theta")

    def error(self, attitudes: np.ndarray) -> float:
        """Largest angle, rad, between quaternions (n, 4) at the samples and the truth."""
        angle = oracle().attitude_error
        sampled = attitudes[self.indices].tolist()
        return max(angle(q, p) for q, p in zip(sampled, self.attitudes, strict=True))


def random_indices(count: int, random: np.random.Generator) -> np.ndarray:
    """Up to MAX_TRUTH_INSTANTS indices below `count`, drawn at random, ascending, the last one included."""
    others = random.choice(count - 1, min(MAX_TRUTH_INSTANTS, count) - 1, replace=False)
    return np.append(np.sort(others), count - 1)


def _attitudes(problem: InitialValueProblem, t: np.ndarray, route: str) -> list[Any]:
    rate, attitude = problem.angular_velocity.tolist(), problem.attitude.tolist()
    if problem.moments is None:
        exact = partial(oracle().attitude_and_rate_of_tensor, problem.tensor.tolist(), rate, attitude)
    else:
        exact = partial(oracle().attitude_and_rate, problem.moments.tolist(), rate, attitude)
    return [exact(seconds, route=route)[0] for seconds in t.tolist()]


class ConservedQuantities:
    """Kinetic energy and inertial angular momentum of a free body, and the errors of samples against them."""

    def __init__(self, problem: InitialValueProblem):
        self.tensor = scaled(problem.tensor)
        self.second = 1.0 / (np.abs(problem.angular_velocity).max() or 1.0)
        start = problem.attitude[None], problem.angular_velocity[None]
        energy, momentum = self._energy_and_momentum(*start)
        self.energy, self.momentum = energy[0], momentum[0]

    def errors(self, attitudes: np.ndarray, rates: np.ndarray) -> tuple[float, float]:
        """Largest relative errors of energy and of the momentum vector; scaled absolute ones for rest."""
        energy, momentum = self._energy_and_momentum(attitudes, rates)
        off = np.sqrt(((momentum - self.momentum) ** 2).sum(axis=-1)).max()
        size = np.sqrt((self.momentum**2).sum()) or LONG(1.0)
        return (
            float(np.abs(energy - self.energy).max() / (self.energy or LONG(1.0))),
            float(off / size),
        )

    def _energy_and_momentum(self, attitudes: np.ndarray, rates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(n,) energies and (n, 3) inertial momenta."""
        w = rates.astype(LONG) * LONG(self.second)
        momentum = (self.tensor * w[:, None, :]).sum(axis=-1)
        return 0.5 * (w * momentum).sum(axis=-1), rotated(attitudes.astype(LONG), momentum)


def scaled(tensor: np.ndarray) -> np.ndarray:
    """The tensor over its largest entry, in long doubles."""
    return tensor.astype(LONG) / LONG(np.abs(tensor).max())


def rotated(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """q v conj(q) / abs(q)^2, rows of (n, 4) and (n, 3): the quaternion's length does not matter."""
    scalar, vector = q[:, :1], q[:, 1:]
    twice = 2.0 * np.cross(vector, v) / (q**2).sum(axis=1, keepdims=True)
    return v + scalar * twice + np.cross(vector, twice)
