"""Errors of a method's answers: against the 50-digit oracle at some instants, of what is conserved at all."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from types import ModuleType
from typing import Any

import numpy as np

from ..errors import AttitudeError
from .problem import Problem

INSTANTS = 30
# The motion is scaled to moments and rates of order one, and followed in the longest floats there are:
# on most machines the rounding of the measurement itself is then out of sight.
LONG = np.longdouble


def oracle() -> ModuleType:
    """The oracle, or one line on how to come by what it needs."""
    try:
        from ..oracle import truth
    except ModuleNotFoundError as error:
        if error.name != "mpmath":
            raise
        raise AttitudeError("the cost needs mpmath for its truth: pip install 'attitude[cost]'") from None
    return truth


@dataclass(frozen=True)
class Truth:
    """Attitudes to fifty digits at a few of a horizon's samples.

    Attributes
    ----------
    indices : (m,), which samples; the last one is always among them
    attitudes : m quaternions of mpf, wxyz; of doubles where `off` is not 0
    route : "Taylor", which shares no formula with any closed form, or "theta" where that cannot reach;
        under torques as `followed` has it
    rates : (m, 3), rad/s, or None: a free body's are told by what is conserved
    off : rad, how far these attitudes themselves may be off
    """

    indices: np.ndarray
    attitudes: list[Any]
    route: str
    rates: np.ndarray | None = None
    off: float = 0.0

    @classmethod
    def at_some(cls, t: np.ndarray, problem: Problem, random: np.random.Generator) -> Truth:
        """At up to INSTANTS of the instants t, drawn at random."""
        indices = chosen(t.size, random)
        try:
            return cls(indices, _attitudes(problem, t[indices], "taylor"), "Taylor")
        except ArithmeticError:  # more Taylor steps than it is given
            return cls(indices, _attitudes(problem, t[indices], "theta"), "theta")

    def error(self, attitudes: np.ndarray) -> float:
        """Largest angle, rad, between quaternions (n, 4) at the samples and the truth."""
        angle = oracle().attitude_error
        found = attitudes[self.indices].tolist()
        return max(angle(q, p) for q, p in zip(found, self.attitudes, strict=True))


def chosen(count: int, random: np.random.Generator) -> np.ndarray:
    """Up to INSTANTS of so many samples, drawn at random, ascending; the last one is always among them."""
    others = random.choice(count - 1, min(INSTANTS, count) - 1, replace=False)
    return np.append(np.sort(others), count - 1)


def _attitudes(problem: Problem, t: np.ndarray, route: str) -> list[Any]:
    rate, attitude = problem.angular_velocity.tolist(), problem.attitude.tolist()
    if problem.moments is None:
        exact = partial(oracle().attitude_and_rate_of_tensor, problem.tensor.tolist(), rate, attitude)
    else:
        exact = partial(oracle().attitude_and_rate, problem.moments.tolist(), rate, attitude)
    return [exact(seconds, route=route)[0] for seconds in t.tolist()]


class Conserved:
    """Kinetic energy and inertial angular momentum of a problem, and how far answers are from them."""

    def __init__(self, problem: Problem):
        self.tensor = scaled(problem.tensor)
        self.second = 1.0 / (np.abs(problem.angular_velocity).max() or 1.0)
        start = problem.attitude[None], problem.angular_velocity[None]
        energy, momentum = self._of(*start)
        self.energy, self.momentum = energy[0], momentum[0]

    def errors(self, attitudes: np.ndarray, rates: np.ndarray) -> tuple[float, float]:
        """Largest relative errors of energy and of the momentum vector; scaled absolute ones for rest."""
        energy, momentum = self._of(attitudes, rates)
        off = np.sqrt(((momentum - self.momentum) ** 2).sum(axis=-1)).max()
        size = np.sqrt((self.momentum**2).sum()) or LONG(1.0)
        return (
            float(np.abs(energy - self.energy).max() / (self.energy or LONG(1.0))),
            float(off / size),
        )

    def _of(self, attitudes: np.ndarray, rates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(n,) energies and (n, 3) inertial momenta."""
        w = rates.astype(LONG) * LONG(self.second)
        momentum = (self.tensor * w[:, None, :]).sum(axis=-1)
        return 0.5 * (w * momentum).sum(axis=-1), rotated(attitudes.astype(LONG), momentum)


def scaled(tensor: np.ndarray) -> np.ndarray:
    return tensor.astype(LONG) / LONG(np.abs(tensor).max())


def rotated(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """q v conj(q) / abs(q)^2: an attitude is what its quaternion points to, whatever its length."""
    scalar, vector = q[:, :1], q[:, 1:]
    twice = 2.0 * np.cross(vector, v) / (q**2).sum(axis=1, keepdims=True)
    return v + scalar * twice + np.cross(vector, twice)
