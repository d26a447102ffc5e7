"""The initial value problem that every method solves: one body, its state and torques, in doubles."""

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
    from ..effects.effect import Torque
    from ..motion import TorqueFreeMotion
    from ..orbit.orbit import OrbitDefinition
    from ..scene.scene import Scene


@dataclass(frozen=True)
class TorqueEnvironment:
    """The torques of a scene, with the orbit of its document.

    Attributes
    ----------
    initial_state : body, state, span of the scene
    effects : the simulated ones; torques : the same, as solvers take them
    orbit : of the document, or None
    """

    initial_state: InitialState
    effects: tuple[Torque, ...]
    torques: tuple[CachedTorque, ...]
    orbit: OrbitDefinition | None

    @cached_property
    def pace(self) -> float:
        """Greatest phase rate of the motion at the epoch, rad/s."""
        body = Bodies.of(self.initial_state)
        return float(max_angular_rates(self.initial_state, body, self.torques)[0])

    def arcs(self, stop: float) -> list[Arc]:
        """Arcs from the epoch to `stop` (s), cut where torques begin or end."""
        return arcs(self.initial_state, self.torques, (), stop)


@dataclass(frozen=True)
class InitialValueProblem:
    """A body at its epoch.

    Attributes
    ----------
    tensor : (3, 3), kg m2; moments : (3,), kg m2, or None where the tensor is not diagonal
    attitude : (4,), wxyz, body to inertial; angular_velocity : (3,), rad/s, body frame
    unit : s; unit of the horizons: the polhode period; the turn 2 pi / abs(omega) where there is none
        (constant rate, separatrix); 1 s for a body at rest; under torques the span of the scene
    unit_name : str
    environment : the torques; None for a free body
    """

    tensor: np.ndarray
    moments: np.ndarray | None
    attitude: np.ndarray
    angular_velocity: np.ndarray
    unit: float
    unit_name: str
    environment: TorqueEnvironment | None = None

    @classmethod
    def of_motion(cls, motion: TorqueFreeMotion) -> InitialValueProblem:
        """The problem of one free body; InputError for a batch."""
        if motion.shape:
            raise InputError("motion", f"shape {motion.shape}", "one body")
        tensor, rate = motion.body.tensor, motion._batch.rates
        unit, name = float(motion.polhode_period), "polhode periods"
        if not np.isfinite(unit):
            speed = float(np.linalg.norm(rate))
            unit, name = (2.0 * np.pi / speed, "turns of the body rate") if speed else (1.0, "seconds")
        return cls(tensor, _diagonal(tensor), motion._batch.attitudes, rate, unit, name)

    @classmethod
    def of_scene(cls, scene: Scene) -> InitialValueProblem:
        """The body of a scene and its torques, if any.

        Raises
        ------
        InputError : an effect at instants, or a user's own; torques without a span after the epoch.
        """
        from ..effects.effect import Torque
        from ..scene.simulation import resolve

        for i, effect in enumerate(scene.effects):
            if effect.ACTS_ON == "instants":
                expected = "effects that act all the time: the compared methods take no impulses"
                raise InputError(f"effects[{i}].type", effect.type, expected)
            if effect.type == "user":
                expected = "an effect of the library's own: there is no truth for a user's torque"
                raise InputError(f"effects[{i}].type", effect.type, expected)
        inputs = resolve(scene)
        if not inputs.torques:
            return cls.of_motion(scene.motion())
        initial_state = inputs.initial_state
        if not initial_state.stop > 0.0:
            raise InputError(
                "times", f"until {initial_state.stop:g} s", "instants after the epoch, under torques"
            )
        tensor = np.asarray(initial_state.body.tensor)
        attitude = initial_state.attitude / np.linalg.norm(initial_state.attitude)
        simulated = zip(scene.effects, inputs.effects, strict=True)
        effects = [e for e, plan in simulated if plan.simulated and isinstance(e, Torque)]
        environment = TorqueEnvironment(initial_state, tuple(effects), inputs.torques, scene.orbit)
        return cls(
            tensor,
            _diagonal(tensor),
            attitude,
            initial_state.rate,
            initial_state.stop,
            "spans of the scene",
            environment,
        )


def environment_of(problem: InitialValueProblem) -> TorqueEnvironment:
    """The torques of a problem that has torques."""
    assert problem.environment is not None
    return problem.environment


def _diagonal(tensor: np.ndarray) -> np.ndarray | None:
    """The moments of a diagonal tensor; None for any other."""
    moments = np.diag(tensor).copy()
    return moments if np.array_equal(tensor, np.diag(moments)) else None


def counted(number: float, unit_name: str) -> str:
    """Number and unit: "1 polhode period", "10000 polhode periods"."""
    noun, of, complement = unit_name.partition(" of ")
    return f"{number:.15g} {noun.removesuffix('s') if number == 1.0 else noun}{of}{complement}"
