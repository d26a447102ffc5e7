"""From states to motion: the closed form of a block of bodies, or their scene with its effects."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..motion import TorqueFreeMotion
from ..scene.document import Scene
from ..times.instants import Instants
from .sources.states import Source, States

PROBES = 8  # bodies that a solver is chosen by


class Block(NamedTuple):
    """What some bodies do at some instants.

    quaternion : (n, m, 4), wxyz, body to inertial
    rate : (n, m, 3), rad/s, body frame; or None
    lost : places of bodies that cannot be followed, whose rows are not among them; (n + lost) were asked for
    regime : (n + lost,), index into `kernels.layout.REGIMES`, of the free motion from the state at the epoch
    """

    quaternion: np.ndarray
    rate: np.ndarray | None
    regime: np.ndarray
    lost: tuple[int, ...] = ()


def is_free(scene: Scene | None) -> bool:
    """Whether nothing but free rotation turns the bodies of a scene; None is one without effects."""
    return scene is None or all(effect.ACTS_ON == "translation" for effect in scene.effects)


def choice_of(scene: Scene | None, source: Source, instants: Instants) -> Any:
    """How the bodies are followed, found once for all of them and all instants; None where they are free.

    Raises InputError where an effect cannot be simulated over the span of the instants.
    """
    if scene is None or is_free(scene):
        return None
    from .simulation import choose

    return choose(scene, instants, source.part(0, min(PROBES, source.size)))


def motion_of(
    scene: Scene | None,
    states: States,
    instants: Instants,
    first: int = 0,
    rate: bool = True,
    choice: Any = None,
    leave_out: bool = False,
) -> Block:
    """The motion of a block of bodies at all of the instants.

    Parameters
    ----------
    scene : of which the effects act on each body; None for none
    states : at the epoch
    instants : (m,)
    first : index of the first body, for errors to name the one they are about
    rate : whether the body rate is wanted
    choice : `choice_of` the scene, where it has effects
    leave_out : bodies that cannot be followed to the scene's tolerance, or that come to rest on the ground
        before the last instant, instead of stopping at the first of them

    Raises
    ------
    InputError, ToleranceError : as `TorqueFreeMotion` and the scene's solver raise them.
    """
    motion = free_motion(states, first)
    if scene is None or is_free(scene):
        with naming(first):
            ephemeris = motion.ephemeris(instants, rate=rate)
        return Block(
            ephemeris.quaternion("wxyz"), ephemeris.angular_velocity if rate else None, regimes(motion)
        )
    from .simulation import simulated

    lost: list[int] | None = [] if leave_out else None
    quaternion, found = simulated(scene, states, instants, choice, first, lost)
    if lost:
        kept = np.ones(len(quaternion), np.bool_)
        kept[np.array(lost) - first] = False
        quaternion, found = quaternion[kept], found[kept]
    return Block(quaternion, found if rate else None, regimes(motion), tuple(lost or ()))


def free_motion(states: States, first: int = 0) -> TorqueFreeMotion:
    """The closed form from these states.  Raises InputError that names a body by its index."""
    with naming(first):
        return TorqueFreeMotion(states.body, states.attitude, states.angular_velocity, order="wxyz")


def regimes(motion: TorqueFreeMotion) -> np.ndarray:
    return motion._batch.fields("regime")["regime"].astype(np.int8)


@contextmanager
def naming(first: int) -> Iterator[None]:
    """Gives an error about a body of a block the index that it has among all."""
    try:
        yield
    except InputError as error:
        name, *steps = error.steps
        if not steps or not isinstance(steps[0], int):
            raise
        rest = "".join(f"[{step}]" for step in steps[1:])
        raise InputError(f"bodies[{first + steps[0]}].{name}{rest}", error.value, error.expected) from None
