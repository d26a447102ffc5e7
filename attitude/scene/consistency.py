"""Cross-field validation of scenes: which fields of a document need or exclude each other."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ..documents.fields import field_within
from ..documents.quantities import GREATEST
from ..errors import InputError
from ..frames import rotations

if TYPE_CHECKING:
    from collections.abc import Sequence

    from astropy.time import Time

    from ..effects.effect import Effect


class SceneFields(Protocol):
    """The fields of a scene that are checked against each other."""

    body: Any
    epoch: Any
    frame: str
    attitude: Any
    angular_velocity: Any
    spin: Any
    relative_to: str | None
    times: Any
    orbit: Any
    position: Any
    velocity: Any

    @property
    def effects(self) -> Sequence[Effect]:
        """Effects of the scene."""

    @property
    def epoch_time(self) -> Time | None:
        """The epoch."""


def check(scene: SceneFields) -> None:
    """Raise InputError, with the field's path, where fields of a scene exclude or need each other."""
    rotations.check_frame(scene.frame, also=("TEME",))
    if scene.frame == "TEME" and scene.epoch is None:
        raise InputError("epoch", None, "an epoch; the axes of TEME are those of a date")
    for name in ("attitude", "angular_velocity"):
        if getattr(scene, name) is None and scene.spin is None:
            raise InputError(name, None, "a value (the field is required)")
        if getattr(scene, name) is not None and scene.spin is not None:
            raise InputError(name, "a value", f"no {name} beside spin: it would be said twice")
    if scene.relative_to is not None:
        _check_reference(scene, scene.relative_to)
    if scene.orbit is not None:
        with field_within("orbit"):
            scene.orbit.check_span(*scene.times.span(scene.epoch_time), scene.epoch_time)
    for present, missing in (("position", "velocity"), ("velocity", "position")):
        if getattr(scene, present) is not None and getattr(scene, missing) is None:
            raise InputError(missing, None, f"a {missing} beside {present}")
    if scene.orbit is not None and scene.position is not None:
        expected = "no position beside orbit, which determines the position"
        raise InputError("position", scene.position.value, expected)
    _check_effects(scene)


def check_magnitudes(moments: np.ndarray, rate: np.ndarray) -> None:
    """Refuse moments and rates whose products with those of effects would not be finite."""
    if not (moments.min() >= 1.0 / GREATEST and moments.max() <= GREATEST):
        expected = f"moments from {1.0 / GREATEST:g} to {GREATEST:g} kg m2 in a scene with effects"
        raise InputError("body", moments.tolist(), expected)
    if not np.abs(rate).max() <= GREATEST:
        expected = f"a rate of at most {GREATEST:g} rad/s in a scene with effects"
        raise InputError("angular_velocity", rate.tolist(), expected)


def _check_reference(scene: SceneFields, reference: str) -> None:
    """Refuse a frame of the state without the orbit, the date or the axes that it needs."""
    rotations.check_any_frame(reference, "relative_to")
    if reference in rotations.ORBITAL_FRAMES:
        if scene.orbit is None:
            raise InputError("orbit", None, f"an orbit, which {reference} lies along")
    elif reference != scene.frame:
        if "INERTIAL" in (reference, scene.frame):
            expected = f"a frame whose axes relative to {scene.frame} are defined; INERTIAL is the user's own"
            raise InputError("relative_to", reference, expected)
        if reference in rotations.TURNING_FRAMES and scene.epoch is None:
            raise InputError("epoch", None, f"an epoch; the axes of {reference} are those of a date")


def _check_effects(scene: SceneFields) -> None:
    """Refuse effects without the orbit, epoch or mass that they need, and a second ground or gravity."""
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
    lit = [i for i, effect in enumerate(scene.effects) if effect.type == "solar_pressure"]
    suns = [getattr(scene.effects[i], "source", None) for i in lit]
    for i, sun in zip(lit[1:], suns[1:], strict=True):
        if sun != suns[0]:
            expected = f"the sun of effects[{lit[0]}]: a scene has one"
            raise InputError(f"effects[{i}].sun", getattr(sun, "direction", sun), expected)
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
