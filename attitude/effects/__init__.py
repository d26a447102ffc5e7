"""The effects a scene may name, one module each; a scene imports those that it names."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module
from typing import Annotated, Any

from ..documents.fields import Chosen, Part
from ..errors import InputError
from .effect import Effect

# The class of each effect, in the module of the effect's name.
_CLASSES = {
    "uniform_gravity": "UniformGravity",
    "ground": "Ground",
    "impulse": "Impulse",
    "constant_torque": "ConstantTorque",
    "gravity_gradient": "GravityGradient",
    "dissipation": "Dissipation",
    "eddy_damping": "EddyDamping",
    "magnetic_dipole": "MagneticDipole",
    "solar_pressure": "SolarPressure",
    "drag": "Drag",
    "wheels": "Wheels",
}
KNOWN_EFFECTS: tuple[str, ...] = tuple(_CLASSES)


def effect_class(name: str) -> type[Effect]:
    """The class of a known effect."""
    return getattr(import_module(f".{name}", __name__), _CLASSES[name])


def _pick(value: Any) -> Effect:
    """The effect that a document names by its `type`; effects made in Python pass through."""
    if isinstance(value, Effect):
        return value
    known = ", ".join(KNOWN_EFFECTS)
    if not isinstance(value, dict):
        raise InputError(
            "", value, f"an object with the type of an effect that this version simulates ({known})"
        )
    name = value.get("type")
    if not isinstance(name, str) or name not in _CLASSES:
        raise InputError("type", name, f"an effect that this version simulates ({known})")
    return effect_class(name).model_validate(value)


def _classes() -> Iterable[type[Part]]:
    return [effect_class(name) for name in KNOWN_EFFECTS]


AnyEffect = Annotated[Effect, Chosen(_pick, _classes)]


def __getattr__(name: str) -> Any:
    """`UserTorque`, imported when it is asked for."""
    if name == "UserTorque":
        from .user import UserTorque

        return UserTorque
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
