"""Exact attitude ephemerides of freely rotating bodies.  The public names, nothing else."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .body import RigidBody
from .ephemeris import Ephemeris
from .errors import AttitudeError, FormatError, InputError, RegimeError, ToleranceError
from .motion import TorqueFreeMotion

if TYPE_CHECKING:
    from .scene import Scene

__version__ = "0.1.0"

__all__ = [
    "AttitudeError",
    "Ephemeris",
    "FormatError",
    "InputError",
    "RegimeError",
    "RigidBody",
    "Scene",
    "ToleranceError",
    "TorqueFreeMotion",
]


def __dir__() -> list[str]:
    return sorted({*globals(), "Scene"})


def __getattr__(name: str) -> Any:
    # pydantic costs as much to import as the rest: only those who use documents pay
    if name == "Scene":
        return import_module(".scene", __name__).Scene
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
