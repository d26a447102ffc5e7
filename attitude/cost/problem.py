"""What every method is given: one body, its state and what acts on it, as the doubles they are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..dynamics.angular_rates import max_angular_rates
from ..dynamics.arcs import Arc, arcs
from ..dynamics.batch_states import Bodies
from ..errors import InputError
from ..problem.initial_state import InitialState
from ..problem.torque_model import CachedTorque

if TYPE_CHECKING:
    from ..effects.effect import Effect, Torque
    from ..motion import TorqueFreeMotion
    from ..orbit.orbit import OrbitDefinition
    from ..scene.document import Scene

SPANS = "spans of the scene"


@dataclass(frozen=True)
class World:
    """The torques of a scene, and what they depend on.

    Attributes
    ----------
    initial_state : body, state, and the span that horizons are parts of
    effects : those that are simulated; torques : the same, as solvers take them
    orbit : the document's, or None
    solver : the kind that the document names, or None
    """

    initial_state: InitialState
    effects: tuple[Torque, ...]
    torques: tuple[CachedTorque, ...]
    orbit: OrbitDefinition | None
    solver: str | None

    @cached_property
    def pace(self) -> float:
        """rad/s of the fastest motion there is."""
        body = Bodies.of(self.initial_state)
        return float(max_angular_rates(self.initial_state, body, self.torques)[0])

    def legs(self, stop: float) -> list[Arc]:
        """From the epoch to an instant (s) within the span, cut where torques begin or end."""
        return arcs(self.initial_state, self.torques, (), stop)


@dataclass(frozen=True)
class Problem:
    """A body at its epoch.

    Attributes
    ----------
    tensor : (3, 3), kg m2; moments : (3,), kg m2, or None where the tensor is not diagonal
    attitude : (4,), wxyz, body to inertial; angular_velocity : (3,), rad/s, body frame
    unit : s; what horizons are counted in: the polhode period, or the turn 2 pi / abs(omega) where
        there is none (constant rate, separatrix), or 1 s for a body at rest; under torques the scene's span
    unit_name : str
    world : what acts on the body; None for a free one
    """

    tensor: np.ndarray
    moments: np.ndarray | None
    attitude: np.ndarray
    angular_velocity: np.ndarray
    unit: float
    unit_name: str
    world: World | None = None

    @classmethod
    def of_motion(cls, motion: TorqueFreeMotion) -> Problem:
        if motion.shape:
            raise InputError("motion", f"shape {motion.shape}", "one body")
        tensor, rate = motion.body.tensor, motion._batch.rates
        unit = _unit(float(motion.polhode_period), rate)
        return cls(tensor, _diagonal(tensor), motion._batch.attitudes, rate, *unit)

    @classmethod
    def of_scene(cls, scene: Scene) -> Problem:
        """With its torques, if it has any.

        Raises
        ------
        InputError : an effect at instants, or the user's own; torques, and no span after the epoch.
        """
        from ..effects.effect import Torque
        from ..scene.simulation import resolve as route

        for i, effect in enumerate(scene.effects):
            _check_effect(effect, f"effects[{i}].type")
        way = route(scene)
        if not way.torques:
            return cls.of_motion(scene.motion())
        initial_state = way.initial_state
        if not initial_state.stop > 0.0:
            raise InputError(
                "times", f"until {initial_state.stop:g} s", "instants after the epoch, under torques"
            )
        tensor = np.asarray(initial_state.body.tensor)
        attitude = initial_state.attitude / np.linalg.norm(initial_state.attitude)
        simulated = zip(scene.effects, way.effects, strict=True)
        effects = [e for e, plan in simulated if plan.simulated and isinstance(e, Torque)]
        world = World(initial_state, tuple(effects), way.torques, scene.orbit, scene.wanted_solver)
        return cls(tensor, _diagonal(tensor), attitude, initial_state.rate, initial_state.stop, SPANS, world)


def of_world(problem: Problem) -> World:
    """What acts on a body that something acts on."""
    assert problem.world is not None
    return problem.world


def _check_effect(effect: Effect, field: str) -> None:
    if effect.ACTS_ON == "instants":
        expected = (
            "effects that act all the time: what the cost compares cannot change a momentum at an instant"
        )
        raise InputError(field, effect.type, expected)
    if effect.type == "user":
        raise InputError(field, effect.type, "an effect of the library's own: no truth knows any other")


def _diagonal(tensor: np.ndarray) -> np.ndarray | None:
    """The moments, where the tensor holds nothing else."""
    moments = np.diag(tensor).copy()
    return moments if np.array_equal(tensor, np.diag(moments)) else None


def counted(number: float, unit_name: str) -> str:
    """ "1 polhode period", "10000 polhode periods"."""
    first, space, rest = unit_name.partition(" of ")
    return f"{number:.15g} {first.removesuffix('s') if number == 1.0 else first}{space}{rest}"


def _unit(period: float, rate: np.ndarray) -> tuple[float, str]:
    if np.isfinite(period):
        return period, "polhode periods"
    speed = float(np.linalg.norm(rate))
    return (2.0 * np.pi / speed, "turns of the body rate") if speed > 0.0 else (1.0, "seconds")
