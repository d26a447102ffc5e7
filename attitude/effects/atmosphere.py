"""The density of the air: a constant, a table over the altitude, or a model of the Earth's thermosphere."""

from __future__ import annotations

from importlib import import_module
from typing import Any, ClassVar

import numpy as np

from ..documents.fields import Part
from ..documents.files import document_path
from ..documents.quantities import MassDensity
from ..errors import InputError, unknown_name
from ..problem.initial_state import InitialState

# Class of each model, in the module of the model's name.
_MODELS = {"harris_priester": "HarrisPriester", "nrlmsise00": "Nrlmsise00"}


class Atmosphere(Part):
    """A density that depends on the place and the date.

    TOLERANCE : of the density's logarithm, to which it is interpolated along an orbit
    ROUNDING : of the density's logarithm, with which the second solution is made
    PIECES_PER_REVOLUTION : polynomials, at the least and at the most
    """

    TOLERANCE: ClassVar[float] = 3e-12
    ROUNDING: ClassVar[float] = 1e-12
    PIECES_PER_REVOLUTION: ClassVar[tuple[int, int]] = (12, 200)

    def __hash__(self) -> int:
        return id(self)  # profiles are kept for the very object

    def check(self, initial_state: InitialState) -> None:
        """Refuse a scene in which the density is not defined; fields are relative to `density`."""

    def range(self) -> tuple[float, float]:
        """Altitudes, m, between which the density is known."""
        raise NotImplementedError

    def levels(self) -> np.ndarray:
        """(k,) m, ascending: altitudes at which a derivative of the density has a jump."""
        return np.zeros(0)

    def jumps(self, initial_state: InitialState) -> np.ndarray:
        """(j,) s since the epoch: instants of the span at which the density has a jump."""
        return np.zeros(0)

    def altitude_along(self, initial_state: InitialState, t: np.ndarray) -> np.ndarray:
        """(n,) m on the orbit at instants (n,), s since the epoch."""
        raise NotImplementedError

    def log_densities(self, initial_state: InitialState, t: np.ndarray) -> np.ndarray:
        """(n,): logarithms of the densities, kg/m3, on the orbit at instants (n,), s since the epoch."""
        raise NotImplementedError

    def name(self) -> str:
        """The model and its parameters, for plans."""
        raise NotImplementedError


def parse(value: Any) -> MassDensity | Atmosphere:
    """Choose the form of a density by the keys of the document; those made in Python pass through."""
    if isinstance(value, (MassDensity, Atmosphere)):
        return value
    if not isinstance(value, dict):
        expected = (
            f"a value and its unit, a table of altitudes and densities, or a model ({', '.join(_MODELS)})"
        )
        raise InputError("", value, f'{expected}, as {{"model": "harris_priester"}}')
    if "model" in value:
        name = value["model"]
        if not isinstance(name, str) or name not in _MODELS:
            raise unknown_name("model", "model of the density", name, _MODELS)
        return model_class(name).model_validate(value)
    if {"altitudes", "densities", "file"} & value.keys():
        if isinstance(value.get("file"), str) and value["file"]:
            value = value | {"file": document_path(value["file"], "altitudes and densities")}
        return _table_class().model_validate(value)
    return MassDensity.model_validate(value)


def model_class(name: str) -> type[Atmosphere]:
    """The class of a known model."""
    return getattr(import_module(f".{name}", __package__), _MODELS[name])


def _table_class() -> type[Atmosphere]:
    return import_module(".density_table", __package__).DensityTable


def classes() -> list[type[Part]]:
    """The classes of a density."""
    return [MassDensity, _table_class(), *(model_class(name) for name in _MODELS)]
