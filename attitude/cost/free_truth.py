"""Truth of free motion: attitudes to fifty digits at some instants, conserved energy and momentum at all.

`load`, `truths` and `quantities` have their like in `torque_truth`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from threading import Lock
from types import ModuleType
from typing import Any

import numpy as np

from .. import stopping
from ..errors import AttitudeError
from ..motion import TorqueFreeMotion
from ..rigid_body.body import RigidBody
from ..times.instants import as_instants
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


_one_thread = Lock()


@contextmanager
def exclusive_oracle() -> Iterator[ModuleType]:
    """The oracle, for one thread at a time: mpmath has one working precision for all of them.

    Its computations end where the stop is set.
    """
    truth = oracle()
    from mpmath import mp

    while not _one_thread.acquire(timeout=0.1):
        stopping.check()
    precision = mp.prec
    try:
        with stopping.checked_calls():
            yield truth
    finally:
        mp.prec = precision
        _one_thread.release()


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
            return cls(indices, true_attitudes(problem, t[indices], "taylor"), "Taylor")
        except ArithmeticError:  # too many Taylor steps
            return cls(indices, true_attitudes(problem, t[indices], "theta"), "theta")

    def error(self, attitudes: np.ndarray) -> float:
        """Largest angle, rad, between quaternions (n, 4) at the samples and the truth."""
        sampled = attitudes[self.indices].tolist()
        with exclusive_oracle() as truth:
            return max(truth.attitude_error(q, p) for q, p in zip(sampled, self.attitudes, strict=True))


def random_indices(count: int, random: np.random.Generator) -> np.ndarray:
    """Up to MAX_TRUTH_INSTANTS indices below `count`, drawn at random, ascending, the last one included."""
    others = random.choice(count - 1, min(MAX_TRUTH_INSTANTS, count) - 1, replace=False)
    return np.append(np.sort(others), count - 1)


def true_attitudes(problem: InitialValueProblem, t: np.ndarray, route: str) -> list[Any]:
    """Quaternions of mpf at instants (n,), s, by one of the oracle's routes: "taylor" or "theta"."""
    rate, attitude = problem.angular_velocity.tolist(), problem.attitude.tolist()
    with exclusive_oracle() as truth:
        if problem.moments is None:
            exact = partial(truth.attitude_and_rate_of_tensor, problem.tensor.tolist(), rate, attitude)
        else:
            exact = partial(truth.attitude_and_rate, problem.moments.tolist(), rate, attitude)
        return [exact(seconds, route=route)[0] for seconds in t.tolist()]


def load(problem: InitialValueProblem) -> None:
    """Import the oracle, and compile the library's kernels, or load them from disk: once in a process."""
    oracle()
    body = RigidBody(problem.tensor if problem.moments is None else problem.moments)
    motion = TorqueFreeMotion(body, problem.attitude, problem.angular_velocity, order="wxyz")
    motion.ephemeris(as_instants([0.0], None), rate=True)


def truths(problem: InitialValueProblem, grids: Sequence[np.ndarray], seed: int) -> list[Truth]:
    """One Truth for each grid of instants, s."""
    return [
        Truth.at_random_samples(t, problem, np.random.default_rng([seed, j])) for j, t in enumerate(grids)
    ]


def quantities(problem: InitialValueProblem, _: Truth) -> TrueQuantities:
    """Energy and momentum at the epoch, which are conserved."""
    state = problem.attitude[None], problem.angular_velocity[None]
    return TrueQuantities(problem, *state, indices=slice(None))


class TrueQuantities:
    """Kinetic energy and inertial angular momentum of a body, and the errors of samples against them.

    Parameters
    ----------
    attitudes, rates : (m, 4), (m, 3), the truth; one row where the quantities are conserved
    indices : of the samples at the same instants
    """

    def __init__(
        self,
        problem: InitialValueProblem,
        attitudes: np.ndarray,
        rates: np.ndarray,
        indices: np.ndarray | slice,
    ):
        self.indices = indices
        self.tensor = problem.tensor.astype(LONG) / LONG(np.abs(problem.tensor).max())
        self.second = 1.0 / (float(np.abs(rates).max()) or 1.0)
        self.energy, self.momentum = self._energy_and_momentum(attitudes, rates)

    def errors(self, attitudes: np.ndarray, rates: np.ndarray) -> tuple[float, float]:
        """Largest errors of energy and momentum vector, relative to the largest; scaled ones for rest."""
        attitudes, rates = attitudes[self.indices], rates[self.indices]
        energy_off, momentum_off = LONG(0.0), LONG(0.0)
        for first in range(
            0, len(rates), 1 << 14
        ):  # in numbers of 16 bytes; one, where the truth has many rows
            stopping.check()
            block = slice(first, first + (1 << 14))
            energy, momentum = self._energy_and_momentum(attitudes[block], rates[block])
            energy_off = max(energy_off, np.abs(energy - self.energy).max())
            momentum_off = max(momentum_off, np.sqrt(((momentum - self.momentum) ** 2).sum(axis=-1)).max())
        size = np.sqrt((self.momentum**2).sum(axis=-1)).max() or LONG(1.0)
        largest = np.abs(self.energy).max() or LONG(1.0)
        return float(energy_off / largest), float(momentum_off / size)

    def _energy_and_momentum(self, attitudes: np.ndarray, rates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(n,) energies and (n, 3) inertial momenta."""
        w = rates.astype(LONG) * LONG(self.second)
        momentum = (self.tensor * w[:, None, :]).sum(axis=-1)
        return 0.5 * (w * momentum).sum(axis=-1), rotated(attitudes.astype(LONG), momentum)


def rotated(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """q v conj(q) / abs(q)^2, rows of (n, 4) and (n, 3): the quaternion's length does not matter."""
    scalar, vector = q[:, :1], q[:, 1:]
    twice = 2.0 * np.cross(vector, v) / (q**2).sum(axis=1, keepdims=True)
    return v + scalar * twice + np.cross(vector, twice)
