"""Cross-field validation of scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from ..errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .effect import Effect


class SceneFields(Protocol):
    """The fields of a scene that are checked against each other."""

    body: Any
    epoch: Any
    orbit: Any
    position: Any
    velocity: Any

    @property
    def effects(self) -> Sequence[Effect]:
        """Effects of the scene."""


def check(scene: SceneFields) -> None:
    """Raise InputError, with the field's path, where fields of a scene exclude or need each other."""
    for present, missing in (("position", "velocity"), ("velocity", "position")):
        if getattr(scene, present) is not None and getattr(scene, missing) is None:
            raise InputError(missing, None, f"a {missing} beside {present}")
    if scene.orbit is not None and scene.position is not None:
        expected = "no position beside orbit, which determines the position"
        raise InputError("position", scene.position.value, expected)
    in_need = dict.fromkeys(effect.type for effect in scene.effects if effect.needs_orbit)
    if in_need and scene.orbit is None:
        raise InputError("orbit", None, f"an orbit, which {' and '.join(in_need)} needs")
    for effect in scene.effects:
        if effect.needs_epoch and scene.epoch is None:
            raise InputError("epoch", None, f"an epoch, which {effect.type} needs here")
    for name in ("ground", "gravity_gradient"):  # one ground, and one central body
        indices = [i for i, effect in enumerate(scene.effects) if effect.type == name]
        if len(indices) > 1:
            expected = f"{name} once (effects[{indices[0]}] is one)"
            raise InputError(f"effects[{indices[1]}].type", name, expected)
    if any(effect.type == "ground" for effect in scene.effects):
        _check_ground(scene)
    for i, effect in enumerate(scene.effects):
        if getattr(effect, "moves", False) and scene.position is not None and scene.body.mass is None:
            expected = f"a mass, since effects[{i}] changes the velocity of the body"
            raise InputError("body.mass", None, expected)


def _check_ground(scene: SceneFields) -> None:
    if scene.body.mass is None:
        raise InputError("body.mass", None, "a mass, which a bounce on the ground depends on")
    if scene.position is None:
        raise InputError("position", None, "a position and a velocity, which a scene with ground needs")
    for i, effect in enumerate(scene.effects):
        if effect.ACTS_ON == "attitude":
            expected = "no torque in a scene with ground: between contacts only free rotation is simulated"
            raise InputError(f"effects[{i}].type", effect.type, expected)
