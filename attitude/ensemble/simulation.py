"""Bodies of an ensemble under the effects of its scene: torques, impulses, ground.

What is the same for all bodies (orbit, Sun, spans of the torques, which solver and how fine) is found once,
and each body then follows its own motion, to the scene's tolerance: `Scene.run` of it would give the same
within that.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, Protocol
from uuid import uuid4

import numpy as np

from ..dynamics import batch_integration, coasting, contact
from ..dynamics.batch_states import Bodies, named
from ..dynamics.solver_selection import Candidate
from ..dynamics.solvers import OUTPUTS
from ..errors import RegimeError
from ..rigid_body.body import RigidBody
from ..scene import simulation
from ..scene.document import Scene, Times
from ..scene.simulation import SimulationInputs
from ..times.instants import Instants

# Bodies whose motions between impulses are computed side by side: numbers of their rows.
ROOM = 1 << 20


class HasStates(Protocol):
    """Bodies, (n,), with attitudes (n, 4) wxyz and rates (n, 3), rad/s, body frame, at the epoch."""

    @property
    def body(self) -> RigidBody: ...
    @property
    def attitude(self) -> np.ndarray: ...
    @property
    def angular_velocity(self) -> np.ndarray: ...


@dataclass(frozen=True)
class Choice:
    """How all bodies of an ensemble are followed; small, and sent to who follows them.

    Attributes
    ----------
    solver : its name, or None where no torque acts
    setting : its step, s, or tolerance of a step, rad
    start, stop : s since the epoch, the span that effects are prepared for
    key : by which a process knows again what it has prepared
    """

    solver: str | None
    setting: float
    start: float
    stop: float
    key: str = field(default_factory=lambda: uuid4().hex)


def is_needed(scene: Scene) -> bool:
    """Whether anything but free rotation turns the bodies of a scene."""
    return any(effect.ACTS_ON != "translation" for effect in scene.effects)


def choose(scene: Scene, instants: Instants, probes: HasStates | None = None) -> Choice:
    """For all bodies of an ensemble and all its instants, found once.

    probes : a few of the bodies, the same however the ensemble is cut; without, the scene's own is asked

    Raises
    ------
    InputError, ToleranceError : as `Scene.run`, for effects that cannot be taken over this span.
    """
    start, stop = scene.times.span(scene.epoch.build() if scene.epoch is not None else None)
    seconds = instants.seconds
    start, stop = min(start, float(seconds.min())), max(stop, float(seconds.max()))
    choice = Choice(None, 0.0, start, stop)
    way = _way(scene, choice)
    if not way.torques:
        return choice
    few = None if probes is None else _bodies(probes, 0)
    candidate = batch_integration.choose(_problem(scene, way, instants), instants, few)
    return replace(choice, solver=candidate.solver.name, setting=candidate.setting)


def simulated(
    scene: Scene,
    states: HasStates,
    instants: Instants,
    choice: Choice,
    first: int = 0,
    lost: list[int] | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Attitudes (n, m, 4) wxyz and rates (n, m, 3), rad/s, body frame, of bodies at instants.

    The same bits for a body whichever others are given with it.

    Parameters
    ----------
    instants : (m,); choice : by `choose`, for this scene and these instants
    first : place of the first body in the ensemble, by which errors name it: bodies[first] ...
    lost : takes the places of bodies that cannot be followed, in place of an error; their rows are NaN

    Raises
    ------
    ToleranceError : a body whose attitudes cannot be computed to the scene's tolerance.
    InputError : a body that an effect cannot take, or that is in the ground at the epoch.
    RegimeError : a body that comes to rest on the ground before the last instant.
    """
    bodies, way = _bodies(states, first), _way(scene, choice)
    if way.ground is not None:
        return _bounced(way, bodies, instants, lost)
    if way.torques:
        candidate = Candidate(batch_integration.SOLVERS[str(choice.solver)], choice.setting, 0.0, 0.0)
        return _told(
            batch_integration.solve(_problem(scene, way, instants), bodies, instants, candidate, lost)
        )
    like, parts = _over(way, instants), _parts(len(bodies), ROOM // (OUTPUTS * max(1, instants.seconds.size)))
    return _told(
        np.concatenate([coasting.coast_each(like, bodies.some(part), way.kicks, instants) for part in parts])
    )


def _parts(count: int, size: int) -> Iterator[slice]:
    size = max(1, size)
    return (slice(first, first + size) for first in range(0, count, size))


def _told(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of rows (n, 7 or more, m)."""
    each = np.swapaxes(rows, 1, 2)
    return np.ascontiguousarray(each[:, :, :4]), np.ascontiguousarray(each[:, :, 4:7])


def _bodies(states: HasStates, first: int) -> Bodies:
    count = len(states.attitude)
    place = np.arange(first, first + count)
    attitude, rate = np.asarray(states.attitude), np.asarray(states.angular_velocity)
    return Bodies(states.body, np.ascontiguousarray(attitude), np.ascontiguousarray(rate), place)


def _bounced(
    way: SimulationInputs, bodies: Bodies, instants: Instants, lost: list[int] | None
) -> tuple[np.ndarray, np.ndarray]:
    assert way.ground is not None
    seconds, ground = instants.seconds.reshape(-1), way.ground.numbers()
    shape = len(bodies), seconds.size
    quaternion, rate = np.full((*shape, 4), np.nan), np.full((*shape, 3), np.nan)
    like = _over(way, instants)
    for i in range(len(bodies)):
        with named(bodies, i, lost):
            flight = contact.fly(
                bodies.initial_state(like, i), ground, way.gravity, seconds, way.kicks, instants.seconds_low
            )
            told = len(flight.seconds)
            if told < seconds.size:
                raise RegimeError(
                    f"times: the body comes to rest on the ground at {flight.events[-1].seconds:.6g} s, and "
                    f"is not simulated further; ask for instants up to then (not {seconds[told]:.6g} s)"
                )
            quaternion[i], rate[i] = flight.quaternion, flight.rate
    return quaternion, rate


# -- what is the same for all bodies --------------------------------------------------------------------


def _problem(scene: Scene, way: SimulationInputs, instants: Instants) -> batch_integration.Problem:
    like = _over(way, instants)
    return batch_integration.Problem(like, way.torques, way.kicks, scene.asked_tolerance, scene.wanted_solver)


def _over(way: SimulationInputs, instants: Instants) -> Any:
    """The scene's situation, over the span of these instants alone."""
    seconds = instants.seconds
    start, stop = min(0.0, float(seconds.min())), max(0.0, float(seconds.max()))
    return replace(way.initial_state, start=start, stop=stop)


class _Prepared:
    """A scene, known again by the key of a choice."""

    def __init__(self, scene: Scene, choice: Choice):
        self.scene, self.choice = scene, choice

    def __hash__(self) -> int:
        return hash(self.choice.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Prepared) and self.choice.key == other.choice.key


def _way(scene: Scene, choice: Choice) -> SimulationInputs:
    return _route(_Prepared(scene, choice))


@lru_cache(maxsize=4)
def _route(prepared: _Prepared) -> SimulationInputs:
    """To find every passage through the shadow in a year takes longer than to follow a body meanwhile."""
    span = [prepared.choice.start, prepared.choice.stop]
    times = Times.model_validate({"elapsed": span, "unit": "s"})
    return simulation.route(prepared.scene.model_copy(update={"times": times}), any_body=True)
