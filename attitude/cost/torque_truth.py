"""Truth of motion under torques: attitudes, energy and momentum.

The Taylor oracle integrates the torques it knows.  For the others (sunlight, drag, orbits by table or TLE,
torques that begin and end) extrapolation in doubles with a two-part state serves, with an estimate of its own
error.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .free_truth import LONG, TrueQuantities, Truth, exclusive_oracle, random_indices
from .initial_value_problem import InitialValueProblem, TorqueEnvironment, environment_of
from .methods import library_solvers, torques

if TYPE_CHECKING:
    from ..orbit.kepler import Kepler

TOLERANCE = 1e-14  # error of the extrapolation in a radian


def reach(problem: InitialValueProblem, budget: float) -> float:
    """The longest horizon, in spans of the scene, that there is a truth for in the budget; at most 1.

    By the radians of the fastest motion: that at the epoch, or the body's own where torques make it faster.
    """
    environment = environment_of(problem)
    # seconds for a radian of the fastest motion; at most 0.3 of the budget is spent on the truth
    seconds = 0.008 if is_known(environment) else 0.001
    max_radians, pace = 0.3 * budget / seconds, environment.pace
    part = min(1.0, max_radians / (pace * problem.unit)) if pace else 1.0
    t = np.linspace(0.0, part * problem.unit, 65)
    _, rates = library_solvers.integrate(problem, 1.0 / (pace or 1.0), t, decay=1e-6)
    faster = np.maximum(pace, np.linalg.norm(rates, axis=1))
    radians = np.cumsum(faster[1:]) * (t[1] - t[0])
    return (
        part
        if radians[-1] <= 1.01 * max_radians
        else part * float(np.interp(max_radians, radians, t[1:] / t[-1]))
    )


def load(problem: InitialValueProblem) -> None:
    """Compile, or load from disk, the kernels of the solvers and of the truth."""
    library_solvers.load(problem)
    environment = environment_of(problem)
    if not is_known(environment):
        extrapolate(problem, np.array([1e-3 / environment.pace]), TOLERANCE)


def truths(problem: InitialValueProblem, grids: Sequence[np.ndarray], seed: int) -> list[Truth]:
    """One Truth for each grid of instants (s, from 0), all from one integration."""
    route_of = by_oracle if is_known(environment_of(problem)) else by_extrapolation
    indices = [random_indices(t.size, np.random.default_rng([seed, j])) for j, t in enumerate(grids)]
    instants = np.unique(np.concatenate([t[index] for t, index in zip(grids, indices, strict=True)]))
    attitudes, rates, route, off = route_of(problem, instants)
    results = []
    for t, index in zip(grids, indices, strict=True):
        positions = np.searchsorted(instants, t[index])
        results.append(Truth(index, [attitudes[i] for i in positions], route, rates[positions], off))
    return results


def quantities(problem: InitialValueProblem, truth: Truth) -> TrueQuantities:
    """Energy and momentum at the instants of truth."""
    assert truth.rates is not None
    attitudes = np.array([[long_double(component) for component in q] for q in truth.attitudes], dtype=LONG)
    return TrueQuantities(problem, attitudes, truth.rates, truth.indices)


def long_double(value: Any) -> Any:
    """A double, or an mpf to the digits of a long double, as a long double."""
    if isinstance(value, float):
        return LONG(value)
    high = float(value)
    return LONG(high) + LONG(float(value - high))


TrueSamples = tuple[list[Any], np.ndarray, str, float]
"""Attitudes, rates, route, estimated error (rad)."""


# -- by the oracle ----------------------------------------------------------------------------------


def is_known(environment: TorqueEnvironment) -> bool:
    """Whether the oracle knows all torques and the orbit."""
    from ..orbit.kepler import Kepler

    steady = all(torque.intervals(environment.initial_state) is None for torque in environment.torques)
    two_body = environment.orbit is None or isinstance(environment.orbit, Kepler)
    return steady and two_body and all(torque.type in ORACLE_TORQUES for torque in environment.torques)


def by_oracle(problem: InitialValueProblem, instants: np.ndarray) -> TrueSamples:
    """Truths by the Taylor oracle."""
    environment = environment_of(problem)
    terms = [ORACLE_TORQUES[effect.type](effect, environment) for effect in environment.effects]
    inertia = problem.tensor if problem.moments is None else problem.moments
    own = problem.angular_velocity.tolist()
    if any(name == "dissipation" for name, *_ in terms):
        # the document's rate is W, from which dissipation makes w = I^-1 (m - h) differ
        equations = torques.TorqueEquations.of(problem)
        own = equations.axes.apply(equations.start[4:] * equations.second).tolist()
    alpha = sum(numbers[0] for name, *numbers in terms if name == "dissipation")

    def attitude_rate(state: Any) -> Any:
        """W = w + alpha m x w."""
        (x, y, z), (a, b, c) = state.rate, state.momentum
        return x + alpha * (b * z - c * y), y + alpha * (c * x - a * z), z + alpha * (a * y - b * x)

    digits = 18
    with exclusive_oracle():
        from mpmath import mp

        from ..oracle.torque_motion import TorqueMotion

        motion = TorqueMotion(
            inertia.tolist(), own, problem.attitude.tolist(), terms, orbit_of(environment), digits
        )
        states = motion.states(instants.tolist())
        with mp.workdps(digits + 10):
            rates = np.array([[long_double(w) for w in attitude_rate(state)] for state in states], dtype=LONG)
    return [state.attitude for state in states], rates, "Taylor, eighteen digits", 0.0


def orbit_of(environment: TorqueEnvironment) -> Any:
    """The orbit as the oracle takes it; None without one."""
    from ..oracle.torque_motion import KeplerianOrbit

    if environment.orbit is None or environment.initial_state.orbit_path is None:
        return None
    orbit: Kepler = environment.orbit  # type: ignore[assignment]
    numbers, mu = environment.initial_state.orbit_path.numbers, orbit.central().mu
    anomaly = 2.0 * np.pi * float(numbers[3])
    angles = orbit.inclination.si, orbit.raan.si, orbit.argument_of_pericentre.si
    return KeplerianOrbit(mu, float(numbers[1]), float(numbers[2]), *angles, anomaly)


def magnetic_dipole(torque: Any, environment: TorqueEnvironment) -> tuple[Any, ...]:
    """Name and numbers of a magnetic dipole.

    The row holds the axis of the central body's dipole as a + b cos + c sin of its rotation angle.
    """
    row = torque.rows(environment.initial_state)[0]
    a, b, c = row[5:8], row[8:11], row[11:14]
    across = np.cross(b, c)
    size = float(np.linalg.norm(across))
    rotation = 2.0 * np.pi * (row[14] + row[15]) * across / size if size else np.zeros(3)
    return "magnetic", torque.dipole.si.tolist(), float(row[4]), (a + b).tolist(), rotation.tolist()


# Effects that the oracle knows, as the name and numbers that it takes.
ORACLE_TORQUES: dict[str, Callable[[Any, TorqueEnvironment], tuple[Any, ...]]] = {
    "constant_torque": lambda torque, _: (f"constant_{torque.frame}", torque.torque.si.tolist()),
    "gravity_gradient": lambda _, environment: ("gravity_gradient", orbit_of(environment).mu),
    "eddy_damping": lambda torque, _: ("eddy", (0.5 * (torque.C + torque.C.T)).tolist()),
    "dissipation": lambda torque, _: ("dissipation", torque.coefficient.si),
    "wheels": lambda torque, _: ("wheels", torque.momentum.si.tolist()),
    "magnetic_dipole": magnetic_dipole,
}


# -- by extrapolation -------------------------------------------------------------------------------


def by_extrapolation(problem: InitialValueProblem, instants: np.ndarray) -> TrueSamples:
    """Truths by the finer of two integrations; their difference estimates its error, rounding included."""
    attitudes, rates = extrapolate(problem, instants, TOLERANCE)
    rough, _ = extrapolate(problem, instants, 10.0 * TOLERANCE)
    with exclusive_oracle() as truth:
        pairs = zip(attitudes.tolist(), rough.tolist(), strict=True)
        off = max(truth.attitude_error(q, p) for q, p in pairs)
    return attitudes.tolist(), rates.astype(LONG), "extrapolation in doubles", float(off)


def extrapolate(
    problem: InitialValueProblem, instants: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Quaternions (n, 4) and rates (n, 3) by extrapolation in doubles, arc by arc."""
    return torques.over_arcs(
        problem, instants, lambda equations, *arc: equations.extrapolated(*arc, tolerance)
    )
