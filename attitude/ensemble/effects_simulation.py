"""Simulation of the bodies of an ensemble under the effects of its scene: torques, impulses, ground.

What all bodies share (orbit, Sun, spans of the torques, solver and step) is computed once.  Each body is then
integrated by itself, to the scene's tolerance: `Scene.run` of that body gives the same within it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache
from uuid import uuid4

import numpy as np

from ..dynamics import integration
from ..dynamics.batch_states import Bodies
from ..dynamics.step_selection import Candidate
from ..errors import InputError
from ..rigid_body.gyrostat_constants import GyrostatBatch
from ..scene import simulation
from ..scene.batch_simulation import problem, simulate
from ..scene.document_parts import Times
from ..scene.scene import Scene
from ..scene.simulation import SimulationInputs
from ..times.instants import Instants
from .sources.states import States


@dataclass(frozen=True)
class SolverChoice:
    """How all bodies of an ensemble are stepped; small, and sent to the workers.

    Attributes
    ----------
    candidate : the steps, or None where no torque acts
    start, stop : s since the epoch, the span that effects are prepared for
    key : under which a process caches the inputs that it has prepared
    """

    candidate: Candidate | None
    start: float
    stop: float
    key: str = field(default_factory=lambda: uuid4().hex)


def choose(scene: Scene, instants: Instants, trial_states: States | None = None) -> SolverChoice:
    """Return the steps for all bodies of an ensemble and all its instants.

    trial_states : of a few bodies, the same however the ensemble is divided; by default the scene's body

    Raises
    ------
    InputError, ToleranceError : as `Scene.run`, for effects that cannot be simulated over this span.
    """
    start, stop = scene.times.span(scene.epoch.build() if scene.epoch is not None else None)
    seconds = instants.seconds
    start, stop = min(start, float(seconds.min())), max(stop, float(seconds.max()))
    choice = SolverChoice(None, start, stop)
    inputs = _inputs(_CachedScene(scene, choice))
    if inputs.ground is not None or inputs.exact_for_all is not None:
        return choice
    trial_bodies = None if trial_states is None else _bodies(trial_states, 0)
    candidate = integration.choose_for_all(problem(inputs, instants), instants, trial_bodies)
    return replace(choice, candidate=candidate)


def simulated(
    scene: Scene,
    states: States,
    instants: Instants,
    choice: SolverChoice,
    first: int = 0,
    lost: list[int] | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Attitudes (n, m, 4) wxyz and rates (n, m, 3), rad/s, body frame, of bodies at instants.

    The bits of a body do not depend on which others are computed with it.

    Parameters
    ----------
    instants : (m,); choice : by `choose`, for this scene and these instants
    first : index of the first body in the ensemble, by which errors name bodies: bodies[first] ...
    lost : extended by the indices of bodies that cannot be integrated, in place of an error; their rows
        are NaN

    Raises
    ------
    ToleranceError : a body whose attitudes cannot be computed to the scene's tolerance.
    InputError : a body that an effect refuses, or that is in the ground at the epoch.
    RegimeError : a body that comes to rest on the ground before the last instant.
    """
    inputs = _inputs(_CachedScene(scene, choice))
    return simulate(inputs, _bodies(states, first), instants, choice.candidate, lost)


def gyrostats(scene: Scene, states: States, first: int = 0) -> GyrostatBatch:
    """The motion of bodies that rotors alone turn; arguments as of `simulated`.

    Raises InputError where other effects turn them, RegimeError as `GyrostatBatch`.
    """
    inputs = simulation.resolve(scene, any_body=True)
    exact, bodies = inputs.exact_for_all, _bodies(states, first)
    if exact is None or exact.is_free or inputs.kicks or inputs.ground is not None:
        raise InputError("scene.effects", "effects that turn the body", "none, or wheels alone, for flips")
    motion = exact.of(bodies.body, bodies.attitude, bodies.rate)
    assert isinstance(motion, GyrostatBatch)
    return motion


def _bodies(states: States, first: int) -> Bodies:
    indices = np.arange(first, first + len(states.attitude))
    attitude, rate = np.asarray(states.attitude), np.asarray(states.angular_velocity)
    return Bodies(states.body, np.ascontiguousarray(attitude), np.ascontiguousarray(rate), indices)


# -- what all bodies share ------------------------------------------------------------------------------


class _CachedScene:
    """A scene, hashed and compared by the key of a choice."""

    def __init__(self, scene: Scene, choice: SolverChoice):
        self.scene, self.choice = scene, choice

    def __hash__(self) -> int:
        return hash(self.choice.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _CachedScene) and self.choice.key == other.choice.key


@lru_cache(maxsize=4)
def _inputs(cached: _CachedScene) -> SimulationInputs:
    """Resolve the scene, once: a year's shadow passages take longer to find than a body to integrate."""
    span = [cached.choice.start, cached.choice.stop]
    times = Times.model_validate({"elapsed": span, "unit": "s"})
    return simulation.resolve(cached.scene.model_copy(update={"times": times}), any_body=True)
