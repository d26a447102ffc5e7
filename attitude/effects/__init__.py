"""Effects of a scene, one module each, imported when a scene names them."""

from __future__ import annotations

from importlib import import_module
from typing import Annotated, Any

from ..documents.fields import Chosen
from ..errors import InputError, suggestion
from .effect import Effect

# Class of each effect, in the module of the effect's name.
_CLASS_NAMES = {
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
KNOWN_EFFECTS: tuple[str, ...] = tuple(_CLASS_NAMES)


def effect_class(name: str) -> type[Effect]:
    """Return the class of a known effect."""
    return getattr(import_module(f".{name}", __name__), _CLASS_NAMES[name])


def _parse(value: Any) -> Effect:
    """Choose the class of an effect by its `type`; effects made in Python pass through."""
    if isinstance(value, Effect):
        return value
    known = ", ".join(KNOWN_EFFECTS)
    if not isinstance(value, dict):
        expected = f"an object with the type of an effect that this version simulates ({known})"
        raise InputError("", value, expected)
    name = value.get("type")
    if not isinstance(name, str) or name not in _CLASS_NAMES:
        expected = f"an effect that this version simulates ({known}){suggestion(name, KNOWN_EFFECTS)}"
        raise InputError("type", name, expected)
    return effect_class(name).model_validate(value)


AnyEffect = Annotated[Effect, Chosen(_parse, lambda: [effect_class(name) for name in KNOWN_EFFECTS])]


def __getattr__(name: str) -> Any:
    """Import `UserTorque` on first access."""
    if name == "UserTorque":
        from .user import UserTorque

        return UserTorque
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
