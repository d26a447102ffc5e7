"""Motion of a block of bodies: in closed form, or simulated under the effects of their scene."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..motion import TorqueFreeMotion
from ..scene.scene import Scene
from ..times.instants import Instants
from .sources.states import States, StateSource


class BlockMotion(NamedTuple):
    """Motion of n bodies at m instants.

    quaternion : (n, m, 4), wxyz, body to inertial
    rate : (n, m, 3), rad/s, body frame; or None
    regime : (n + lost,), index into `kernels.layout.REGIMES`, of the free motion from the state at the epoch
    lost : indices of bodies that cannot be integrated, whose rows are left out
    """

    quaternion: np.ndarray
    rate: np.ndarray | None
    regime: np.ndarray
    lost: tuple[int, ...] = ()


def is_free(scene: Scene | None) -> bool:
    """Whether the bodies of a scene rotate freely; None is a scene without effects."""
    return scene is None or all(effect.ACTS_ON == "translation" for effect in scene.effects)


def solver_choice(scene: Scene | None, source: StateSource, instants: Instants) -> Any:
    """Return the solver for all bodies and all instants; None where bodies are free.

    Raises InputError where an effect cannot be simulated over the span of the instants.
    """
    if scene is None or is_free(scene):
        return None
    from .effects_simulation import choose  # late: free bodies need no solvers

    return choose(scene, instants, source.part(0, min(8, source.size)))


def motion_of(
    scene: Scene | None,
    states: States,
    instants: Instants,
    first: int = 0,
    rate: bool = True,
    choice: Any = None,
    leave_out: bool = False,
) -> BlockMotion:
    """Return the motion of a block of bodies at all of the instants.

    Parameters
    ----------
    scene : whose effects act on each body; None for free bodies
    states : at the epoch
    instants : (m,)
    first : index of the first body, by which errors name bodies
    rate : whether to return body rates
    choice : `solver_choice` of the scene
    leave_out : bodies that cannot be integrated to the scene's tolerance, or that come to rest on the ground
        before the last instant, instead of raising an error for the first of them

    Raises
    ------
    InputError, ToleranceError : as `TorqueFreeMotion` and the scene's solver raise them.
    """
    motion = free_motion(states, first)
    if scene is None or is_free(scene):
        with body_named(first):
            ephemeris = motion.ephemeris(instants, rate=rate)
        rates = ephemeris.angular_velocity if rate else None
        return BlockMotion(ephemeris.quaternion("wxyz"), rates, regimes(motion))
    from .effects_simulation import simulated

    lost: list[int] | None = [] if leave_out else None
    quaternion, rates = simulated(scene, states, instants, choice, first, lost)
    if lost:
        rows = np.delete(np.arange(len(quaternion)), np.array(lost) - first)
        quaternion, rates = quaternion[rows], rates[rows]
    return BlockMotion(quaternion, rates if rate else None, regimes(motion), tuple(lost or ()))


def free_motion(states: States, first: int = 0) -> TorqueFreeMotion:
    """Return the closed form from these states.  Raises InputError that names a body by its index."""
    with body_named(first):
        return TorqueFreeMotion(states.body, states.attitude, states.angular_velocity, order="wxyz")


def regimes(motion: TorqueFreeMotion) -> np.ndarray:
    """(n,), int8: index into `kernels.layout.REGIMES`."""
    return motion._batch.fields("regime")["regime"].astype(np.int8)


@contextmanager
def body_named(first: int) -> Iterator[None]:
    """Errors name a body of a block, which begins at body `first`, by its index in the ensemble."""
    try:
        yield
    except InputError as error:
        name, *steps = error.steps
        if not steps or not isinstance(steps[0], int):
            raise
        indices = "".join(f"[{step}]" for step in steps[1:])
        raise InputError(f"bodies[{first + steps[0]}].{name}{indices}", error.value, error.expected) from None
