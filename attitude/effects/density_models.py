"""The density of the air: a constant, a table over the altitude, or a model of the Earth's thermosphere."""

from __future__ import annotations

from typing import Any

from ..documents.fields import Part
from ..documents.files import document_path
from ..documents.quantities import MassDensity, above_zero
from ..errors import InputError, unknown_name
from .atmosphere import Atmosphere
from .density_table import DensityTable
from .harris_priester import HarrisPriester
from .nrlmsise00 import Nrlmsise00

MODELS: dict[str, type[Atmosphere]] = {"harris_priester": HarrisPriester, "nrlmsise00": Nrlmsise00}


def parse_density(value: Any) -> MassDensity | Atmosphere:
    """Choose the form of a density by the keys of the document; those made in Python pass through."""
    if isinstance(value, Atmosphere):
        return value
    if isinstance(value, MassDensity):
        return above_zero(value)
    if not isinstance(value, dict):
        expected = (
            f"a value and its unit, a table of altitudes and densities, or a model ({', '.join(MODELS)})"
        )
        raise InputError("", value, f'{expected}, as {{"model": "harris_priester"}}')
    if "model" in value:
        name = value["model"]
        if not isinstance(name, str) or name not in MODELS:
            raise unknown_name("model", "model of the density", name, MODELS)
        return MODELS[name].model_validate(value)
    if {"altitudes", "densities", "file"} & value.keys():
        if isinstance(value.get("file"), str) and value["file"]:
            value = value | {"file": document_path(value["file"], "altitudes and densities")}
        return DensityTable.model_validate(value)
    return above_zero(MassDensity.model_validate(value))


def density_classes() -> list[type[Part]]:
    """The classes of a density."""
    return [MassDensity, DensityTable, *MODELS.values()]
