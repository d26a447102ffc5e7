"""The truth of motions under torques, and how far energy and momentum are from it.

The Taylor oracle where it knows the torques.  Where it does not (sunlight, drag, orbits by table or TLE,
torques that begin and end) extrapolation in doubles, its state in two parts: with it comes how far it may be
off itself.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..dynamics.solvers import RUNGE_KUTTA
from .methods import stepping, torques
from .problem import Problem, World
from .truth import LONG, Truth, chosen, oracle, rotated, scaled

if TYPE_CHECKING:
    from ..orbit.kepler import Kepler

DIGITS = 18
TAYLOR, EXTRAPOLATED = "Taylor, eighteen digits", "extrapolation in doubles"
# Seconds for a radian of the fastest motion; and what part of a budget may be spent on the truth.
TAYLOR_SECONDS, EXTRAPOLATED_SECONDS, SHARE = 0.008, 0.001, 0.3
# Errors that extrapolation may make in a radian: for the truth, and for the one that tells how good that is.
FINE, ROUGH = 1e-14, 1e-13
ROUGHLY = 1e-6  # where only the radians are asked for


def reach(problem: Problem, world: World, budget: float) -> float:
    """The longest horizon, in spans of the scene, that there is a truth for in the budget; at most 1.

    By the radians of the fastest motion: that at the epoch, or the body's own where torques make it faster.
    """
    each = TAYLOR_SECONDS if _is_known(world) else EXTRAPOLATED_SECONDS
    most, pace = SHARE * budget / each, world.pace
    part = min(1.0, most / (pace * problem.unit)) if pace else 1.0
    t = np.linspace(0.0, part * problem.unit, 65)
    _, rates = stepping.march(problem, RUNGE_KUTTA, ROUGHLY, t)
    faster = np.maximum(pace, np.sqrt((rates**2).sum(axis=1)))
    radians = np.cumsum(faster[1:]) * (t[1] - t[0])
    return part if radians[-1] <= 1.01 * most else part * float(np.interp(most, radians, t[1:] / t[-1]))


def load(problem: Problem, world: World) -> None:
    """What of the truth is to be compiled, or read from disk."""
    if not _is_known(world):
        _integrated(problem, np.array([1e-3 / world.pace]), FINE)


def truths(problem: Problem, world: World, grids: Sequence[np.ndarray], seed: int) -> list[Truth]:
    """One for each grid of instants (s, from 0), all from one integration."""
    indices = [chosen(t.size, np.random.default_rng([seed, j])) for j, t in enumerate(grids)]
    instants = np.unique(np.concatenate([t[some] for t, some in zip(grids, indices, strict=True)]))
    attitudes, rates, route, off = (_taylor if _is_known(world) else _extrapolated)(problem, world, instants)
    found = []
    for t, some in zip(grids, indices, strict=True):
        places = np.searchsorted(instants, t[some])
        found.append(Truth(some, [attitudes[i] for i in places], route, rates[places], off))
    return found


class Followed:
    """Kinetic energy and momentum of the body, by its rate, against those of a truth."""

    def __init__(self, problem: Problem, truth: Truth):
        assert truth.rates is not None
        self.indices, self.tensor = truth.indices, scaled(problem.tensor)
        self.second = 1.0 / (float(np.abs(truth.rates).max()) or 1.0)
        attitudes = np.array([[_long(component) for component in q] for q in truth.attitudes], dtype=LONG)
        self.energy, self.momentum = self._of(attitudes, truth.rates)

    def errors(self, attitudes: np.ndarray, rates: np.ndarray) -> tuple[float, float]:
        """Largest errors of energy and of the momentum vector at the truth's samples, over the largest."""
        energy, momentum = self._of(attitudes[self.indices].astype(LONG), rates[self.indices].astype(LONG))
        off = np.sqrt(((momentum - self.momentum) ** 2).sum(axis=-1)).max()
        size = np.sqrt((self.momentum**2).sum(axis=-1)).max() or LONG(1.0)
        most = np.abs(self.energy).max() or LONG(1.0)
        return float(np.abs(energy - self.energy).max() / most), float(off / size)

    def _of(self, attitudes: np.ndarray, rates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        w = rates * LONG(self.second)
        momentum = (self.tensor * w[:, None, :]).sum(axis=-1)
        return 0.5 * (w * momentum).sum(axis=-1), rotated(attitudes, momentum)


def _long(value: Any) -> Any:
    """A double, or an mpf to all digits that a long double holds."""
    if isinstance(value, float):
        return LONG(value)
    high = float(value)
    return LONG(high) + LONG(float(value - high))


Found = tuple[list[Any], np.ndarray, str, float]


# -- by the oracle ----------------------------------------------------------------------------------


def _is_known(world: World) -> bool:
    from ..orbit.kepler import Kepler

    steady = all(torque.intervals(world.initial_state) is None for torque in world.torques)
    two_body = world.orbit is None or isinstance(world.orbit, Kepler)
    return steady and two_body and all(torque.type in TOLD for torque in world.torques)


def _taylor(problem: Problem, world: World, instants: np.ndarray) -> Found:
    oracle()
    from mpmath import mp

    from ..oracle.torqued import Torqued

    told = [TOLD[effect.type](effect, world) for effect in world.effects]
    own = _own_rate(problem, world)
    motion = Torqued(_inertia(problem), own, problem.attitude.tolist(), told, _orbit(world), DIGITS)
    states = motion.states(instants.tolist())
    alpha = sum(numbers[0] for name, *numbers in told if name == "dissipation")
    with mp.workdps(DIGITS + 10):
        rates = np.array([[_long(w) for w in _turning(state, alpha)] for state in states], dtype=LONG)
    return [state.attitude for state in states], rates, TAYLOR, 0.0


def _inertia(problem: Problem) -> Any:
    return problem.tensor.tolist() if problem.moments is None else problem.moments.tolist()


def _own_rate(problem: Problem, world: World) -> list[float]:
    """w of the momentum: the document's rate is W, which a sink makes another."""
    if all(effect.type != "dissipation" for effect in world.effects):
        return problem.angular_velocity.tolist()
    equations = torques.Equations.of(problem)
    return equations.axes.apply(equations.start[4:] * equations.second).tolist()


def _turning(state: Any, alpha: float) -> Any:
    """W = w + alpha m x w."""
    (x, y, z), (a, b, c) = state.rate, state.momentum
    return x + alpha * (b * z - c * y), y + alpha * (c * x - a * z), z + alpha * (a * y - b * x)


def _orbit(world: World) -> Any:
    from ..oracle.torqued import Orbit

    if world.orbit is None or world.initial_state.orbit_path is None:
        return None
    orbit: Kepler = world.orbit  # type: ignore[assignment]
    numbers, mu = world.initial_state.orbit_path.numbers, orbit.central().mu
    anomaly = 2.0 * np.pi * float(numbers[3])
    angles = orbit.inclination.si, orbit.raan.si, orbit.argument_of_pericentre.si
    return Orbit(mu, float(numbers[1]), float(numbers[2]), *angles, anomaly)


def _constant(torque: Any, world: World) -> tuple[Any, ...]:
    return f"constant_{torque.frame}", torque.torque.si.tolist()


def _gradient(torque: Any, world: World) -> tuple[Any, ...]:
    return "gravity_gradient", _orbit(world).mu


def _eddy(torque: Any, world: World) -> tuple[Any, ...]:
    return "eddy", (0.5 * (torque.C + torque.C.T)).tolist()


def _dissipation(torque: Any, world: World) -> tuple[Any, ...]:
    return "dissipation", torque.coefficient.si


def _wheels(torque: Any, world: World) -> tuple[Any, ...]:
    return "wheels", torque.momentum.si.tolist()


def _magnetic(torque: Any, world: World) -> tuple[Any, ...]:
    """The row holds the dipole's axis as a + b cos + c sin of its turning."""
    row = torque.rows(world.initial_state)[0]
    a, b, c = row[5:8], row[8:11], row[11:14]
    across = np.cross(b, c)
    size = float(np.linalg.norm(across))
    turning = 2.0 * np.pi * (row[14] + row[15]) * across / size if size else np.zeros(3)
    return "magnetic", torque.dipole.si.tolist(), float(row[4]), (a + b).tolist(), turning.tolist()


# Effects that the oracle knows, as it wants to be told of them.
TOLD: dict[str, Callable[[Any, World], tuple[Any, ...]]] = {
    "constant_torque": _constant,
    "gravity_gradient": _gradient,
    "eddy_damping": _eddy,
    "dissipation": _dissipation,
    "wheels": _wheels,
    "magnetic_dipole": _magnetic,
}


# -- by extrapolation -------------------------------------------------------------------------------


def _extrapolated(problem: Problem, world: World, instants: np.ndarray) -> Found:
    """Twice; what the two are apart tells how good the better one is, its rounding included."""
    attitudes, rates = _integrated(problem, instants, FINE)
    rough, _ = _integrated(problem, instants, ROUGH)
    angle = oracle().attitude_error
    off = max(angle(q, p) for q, p in zip(attitudes.tolist(), rough.tolist(), strict=True))
    return attitudes.tolist(), rates.astype(LONG), EXTRAPOLATED, float(off)


def _integrated(problem: Problem, instants: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    return torques.over_legs(
        problem, instants, lambda equations, *leg: equations.extrapolated(*leg, tolerance)
    )
