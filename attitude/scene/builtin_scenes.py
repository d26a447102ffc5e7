"""The scenes that come with the package."""

from __future__ import annotations

from importlib import resources

from ..errors import unknown_name


def builtin_names() -> list[str]:
    """Names of the scenes that come with the package, sorted."""
    entries = resources.files("attitude.scene").joinpath("scenes").iterdir()
    return sorted([entry.name.removesuffix(".json") for entry in entries if entry.name.endswith(".json")])


def builtin_text(name: str) -> bytes:
    """The document of a scene that comes with the package; InputError for any other name."""
    if name not in builtin_names():
        raise unknown_name("scene", "scene", name, builtin_names())
    return resources.files("attitude.scene").joinpath("scenes", f"{name}.json").read_bytes()
