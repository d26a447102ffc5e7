"""Exact attitude ephemerides of freely rotating bodies.  The public names, nothing else."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .version import __version__ as __version__

if TYPE_CHECKING:
    from .ephemeris import Ephemeris
    from .errors import AttitudeError, AttitudeWarning, FormatError, InputError, RegimeError, ToleranceError
    from .estimation.fit import fit
    from .motion import TorqueFreeMotion
    from .rigid_body.body import RigidBody
    from .scene.scene import Scene
    from .times.instants import Grid


# Each is imported when first asked for: the command answers `--version` or a mistyped argument at
# once, and only those who use documents pay for pydantic.
_WHERE = {
    "AttitudeError": "errors",
    "AttitudeWarning": "errors",
    "Ephemeris": "ephemeris",
    "FormatError": "errors",
    "Grid": "times.instants",
    "InputError": "errors",
    "RegimeError": "errors",
    "RigidBody": "rigid_body.body",
    "Scene": "scene.scene",
    "ToleranceError": "errors",
    "TorqueFreeMotion": "motion",
    "fit": "estimation.fit",
}

__all__ = [
    "AttitudeError",
    "AttitudeWarning",
    "Ephemeris",
    "FormatError",
    "Grid",
    "InputError",
    "RegimeError",
    "RigidBody",
    "Scene",
    "ToleranceError",
    "TorqueFreeMotion",
    "fit",
]


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


def __getattr__(name: str) -> Any:
    if name in _WHERE:
        return getattr(import_module(f".{_WHERE[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
