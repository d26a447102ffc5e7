"""What parts of a scene need of each other, and exclude."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from ..errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .effect import Effect

# There is one central body, and one ground in this version.
ONLY_ONE = ("ground", "gravity_gradient")


class Parts(Protocol):
    """The fields of a scene that matter here."""

    @property
    def body(self) -> Any: ...
    @property
    def epoch(self) -> Any: ...
    @property
    def effects(self) -> Sequence[Effect]: ...
    @property
    def orbit(self) -> Any: ...
    @property
    def position(self) -> Any: ...
    @property
    def velocity(self) -> Any: ...


def check(scene: Parts) -> None:
    """Raises InputError with the field's path."""
    _check_translation(scene)
    _check_orbit(scene)
    _check_epoch(scene)
    _check_single(scene)
    _check_ground(scene)
    _check_momentum(scene)


def _check_translation(scene: Parts) -> None:
    for given, missing in (("position", "velocity"), ("velocity", "position")):
        if getattr(scene, given) is not None and getattr(scene, missing) is None:
            raise InputError(missing, None, f"a {missing} beside {given}")
    if scene.orbit is not None and scene.position is not None:
        raise InputError(
            "position", scene.position.value, "no position beside orbit, which says where the body is"
        )


def _check_orbit(scene: Parts) -> None:
    needing = [effect.type for effect in scene.effects if effect.needs_orbit]
    if needing and scene.orbit is None:
        raise InputError("orbit", None, f"an orbit, which {' and '.join(dict.fromkeys(needing))} needs")


def _check_epoch(scene: Parts) -> None:
    for effect in scene.effects:
        if effect.needs_epoch and scene.epoch is None:
            raise InputError("epoch", None, f"an epoch, which {effect.type} needs here")


def _check_single(scene: Parts) -> None:
    for name in ONLY_ONE:
        places = [i for i, effect in enumerate(scene.effects) if effect.type == name]
        if len(places) > 1:
            raise InputError(f"effects[{places[1]}].type", name, f"{name} once (effects[{places[0]}] is one)")


def _check_ground(scene: Parts) -> None:
    if not any(effect.type == "ground" for effect in scene.effects):
        return
    if scene.body.mass is None:
        raise InputError("body.mass", None, "the mass, which a bounce on the ground depends on")
    if scene.position is None:
        raise InputError("position", None, "a position and a velocity, since there is a ground to fall on")
    for i, effect in enumerate(scene.effects):
        if effect.ACTS_ON == "attitude":
            expected = (
                "no torque in a scene with ground: this version simulates contact with free rotation between"
            )
            raise InputError(f"effects[{i}].type", effect.type, expected)


def _check_momentum(scene: Parts) -> None:
    """An impulse moves the centre of mass too, wherever that is simulated."""
    for i, effect in enumerate(scene.effects):
        if getattr(effect, "moves", False) and scene.position is not None and scene.body.mass is None:
            raise InputError("body.mass", None, f"the mass, which effects[{i}] sets in motion")
