"""Truth of motion under torques: attitudes, energy and momentum.

The Taylor oracle integrates the torques it knows.  For the others (sunlight, drag, orbits by table or TLE,
torques that begin and end) extrapolation in doubles with a two-part state serves, with an estimate of its own
error.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..dynamics.solvers import RUNGE_KUTTA
from .free_truth import LONG, Truth, oracle, random_indices, rotated, scaled
from .initial_value_problem import InitialValueProblem, TorqueEnvironment, environment_of
from .methods import library_solvers, torques

if TYPE_CHECKING:
    from ..orbit.kepler import Kepler

TAYLOR_DIGITS = 18
TAYLOR, EXTRAPOLATED = "Taylor, eighteen digits", "extrapolation in doubles"
TOLERANCE = 1e-14  # error of the extrapolation in a radian


def reach(problem: InitialValueProblem, environment: TorqueEnvironment, budget: float) -> float:
    """The longest horizon, in spans of the scene, that there is a truth for in the budget; at most 1.

    By the radians of the fastest motion: that at the epoch, or the body's own where torques make it faster.
    """
    # seconds for a radian of the fastest motion; at most 0.3 of the budget is spent on the truth
    seconds = 0.008 if _is_known(environment) else 0.001
    max_radians, pace = 0.3 * budget / seconds, environment.pace
    part = min(1.0, max_radians / (pace * problem.unit)) if pace else 1.0
    t = np.linspace(0.0, part * problem.unit, 65)
    _, rates = library_solvers.integrate(problem, RUNGE_KUTTA, 1e-6, t)
    faster = np.maximum(pace, np.sqrt((rates**2).sum(axis=1)))
    radians = np.cumsum(faster[1:]) * (t[1] - t[0])
    return (
        part
        if radians[-1] <= 1.01 * max_radians
        else part * float(np.interp(max_radians, radians, t[1:] / t[-1]))
    )


def load(problem: InitialValueProblem, environment: TorqueEnvironment) -> None:
    """Compile, or load from disk, the kernels of the truth."""
    if not _is_known(environment):
        _integrated(problem, np.array([1e-3 / environment.pace]), TOLERANCE)


def truths(
    problem: InitialValueProblem, environment: TorqueEnvironment, grids: Sequence[np.ndarray], seed: int
) -> list[Truth]:
    """One Truth for each grid of instants (s, from 0), all from one integration."""
    indices = [random_indices(t.size, np.random.default_rng([seed, j])) for j, t in enumerate(grids)]
    instants = np.unique(np.concatenate([t[index] for t, index in zip(grids, indices, strict=True)]))
    attitudes, rates, route, off = (_taylor if _is_known(environment) else _extrapolated)(problem, instants)
    results = []
    for t, index in zip(grids, indices, strict=True):
        positions = np.searchsorted(instants, t[index])
        results.append(Truth(index, [attitudes[i] for i in positions], route, rates[positions], off))
    return results


class TrueQuantities:
    """Kinetic energy and momentum of a body under torques, and the errors of samples against them."""

    def __init__(self, problem: InitialValueProblem, truth: Truth):
        assert truth.rates is not None
        self.indices, self.tensor = truth.indices, scaled(problem.tensor)
        self.second = 1.0 / (float(np.abs(truth.rates).max()) or 1.0)
        attitudes = np.array([[_long(component) for component in q] for q in truth.attitudes], dtype=LONG)
        self.energy, self.momentum = self._energy_and_momentum(attitudes, truth.rates)

    def errors(self, attitudes: np.ndarray, rates: np.ndarray) -> tuple[float, float]:
        """Largest errors of energy and momentum vector at the instants of truth, relative to the largest."""
        energy, momentum = self._energy_and_momentum(
            attitudes[self.indices].astype(LONG), rates[self.indices].astype(LONG)
        )
        off = np.sqrt(((momentum - self.momentum) ** 2).sum(axis=-1)).max()
        size = np.sqrt((self.momentum**2).sum(axis=-1)).max() or LONG(1.0)
        largest = np.abs(self.energy).max() or LONG(1.0)
        return float(np.abs(energy - self.energy).max() / largest), float(off / size)

    def _energy_and_momentum(self, attitudes: np.ndarray, rates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        w = rates * LONG(self.second)
        momentum = (self.tensor * w[:, None, :]).sum(axis=-1)
        return 0.5 * (w * momentum).sum(axis=-1), rotated(attitudes, momentum)


def _long(value: Any) -> Any:
    """A double, or an mpf to the digits of a long double, as a long double."""
    if isinstance(value, float):
        return LONG(value)
    high = float(value)
    return LONG(high) + LONG(float(value - high))


TrueSamples = tuple[list[Any], np.ndarray, str, float]
"""Attitudes, rates, route, estimated error (rad)."""


# -- by the oracle ----------------------------------------------------------------------------------


def _is_known(environment: TorqueEnvironment) -> bool:
    from ..orbit.kepler import Kepler

    steady = all(torque.intervals(environment.initial_state) is None for torque in environment.torques)
    two_body = environment.orbit is None or isinstance(environment.orbit, Kepler)
    return steady and two_body and all(torque.type in ORACLE_TORQUES for torque in environment.torques)


def _taylor(problem: InitialValueProblem, instants: np.ndarray) -> TrueSamples:
    oracle()
    environment = environment_of(problem)
    from mpmath import mp

    from ..oracle.torque_motion import TorqueMotion

    terms = [ORACLE_TORQUES[effect.type](effect, environment) for effect in environment.effects]
    own = _own_rate(problem, environment)
    motion = TorqueMotion(
        _inertia(problem), own, problem.attitude.tolist(), terms, _orbit(environment), TAYLOR_DIGITS
    )
    states = motion.states(instants.tolist())
    alpha = sum(numbers[0] for name, *numbers in terms if name == "dissipation")
    with mp.workdps(TAYLOR_DIGITS + 10):
        rates = np.array([[_long(w) for w in _attitude_rate(state, alpha)] for state in states], dtype=LONG)
    return [state.attitude for state in states], rates, TAYLOR, 0.0


def _inertia(problem: InitialValueProblem) -> Any:
    return problem.tensor.tolist() if problem.moments is None else problem.moments.tolist()


def _own_rate(problem: InitialValueProblem, environment: TorqueEnvironment) -> list[float]:
    """w = I^-1 (m - h): the document's rate is W, from which dissipation makes it differ."""
    if all(effect.type != "dissipation" for effect in environment.effects):
        return problem.angular_velocity.tolist()
    equations = torques.TorqueEquations.of(problem)
    return equations.axes.apply(equations.start[4:] * equations.second).tolist()


def _attitude_rate(state: Any, alpha: float) -> Any:
    """W = w + alpha m x w."""
    (x, y, z), (a, b, c) = state.rate, state.momentum
    return x + alpha * (b * z - c * y), y + alpha * (c * x - a * z), z + alpha * (a * y - b * x)


def _orbit(environment: TorqueEnvironment) -> Any:
    from ..oracle.torque_motion import KeplerianOrbit

    if environment.orbit is None or environment.initial_state.orbit_path is None:
        return None
    orbit: Kepler = environment.orbit  # type: ignore[assignment]
    numbers, mu = environment.initial_state.orbit_path.numbers, orbit.central().mu
    anomaly = 2.0 * np.pi * float(numbers[3])
    angles = orbit.inclination.si, orbit.raan.si, orbit.argument_of_pericentre.si
    return KeplerianOrbit(mu, float(numbers[1]), float(numbers[2]), *angles, anomaly)


def _magnetic(torque: Any, environment: TorqueEnvironment) -> tuple[Any, ...]:
    """The row holds the axis of the central body's dipole as a + b cos + c sin of its rotation angle."""
    row = torque.rows(environment.initial_state)[0]
    a, b, c = row[5:8], row[8:11], row[11:14]
    across = np.cross(b, c)
    size = float(np.linalg.norm(across))
    rotation = 2.0 * np.pi * (row[14] + row[15]) * across / size if size else np.zeros(3)
    return "magnetic", torque.dipole.si.tolist(), float(row[4]), (a + b).tolist(), rotation.tolist()


# Effects that the oracle knows, as the name and numbers that it takes.
ORACLE_TORQUES: dict[str, Callable[[Any, TorqueEnvironment], tuple[Any, ...]]] = {
    "constant_torque": lambda torque, _: (f"constant_{torque.frame}", torque.torque.si.tolist()),
    "gravity_gradient": lambda _, environment: ("gravity_gradient", _orbit(environment).mu),
    "eddy_damping": lambda torque, _: ("eddy", (0.5 * (torque.C + torque.C.T)).tolist()),
    "dissipation": lambda torque, _: ("dissipation", torque.coefficient.si),
    "wheels": lambda torque, _: ("wheels", torque.momentum.si.tolist()),
    "magnetic_dipole": _magnetic,
}


# -- by extrapolation -------------------------------------------------------------------------------


def _extrapolated(problem: InitialValueProblem, instants: np.ndarray) -> TrueSamples:
    """By the finer of two integrations; their difference estimates its error, rounding included."""
    attitudes, rates = _integrated(problem, instants, TOLERANCE)
    rough, _ = _integrated(problem, instants, 10.0 * TOLERANCE)
    angle = oracle().attitude_error
    off = max(angle(q, p) for q, p in zip(attitudes.tolist(), rough.tolist(), strict=True))
    return attitudes.tolist(), rates.astype(LONG), EXTRAPOLATED, float(off)


def _integrated(
    problem: InitialValueProblem, instants: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    return torques.over_arcs(
        problem, instants, lambda equations, *arc: equations.extrapolated(*arc, tolerance)
    )
