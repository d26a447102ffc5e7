"""Orbits in files: OEM, STK ephemerides, tables in CSV and SPK, read as rows or as a function of time."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np

from ..errors import FormatError, file_errors, suggestion
from ..samples.interpolation import InterpolationMethod
from ..times.instants import Instants


class OrbitSegment(NamedTuple):
    """Rows among which a file may be interpolated.

    Attributes
    ----------
    instants : (n,), dated unless the file has elapsed times alone
    positions : (n, 3) m, from the centre
    velocities : (n, 3) m/s relative to the file's axes, or None
    method : what the file states; None where it states nothing
    useable : first and last second of the span in which it may be interpolated, of the instants' seconds
    """

    instants: Instants
    positions: np.ndarray
    velocities: np.ndarray | None
    method: InterpolationMethod | None
    useable: tuple[float, float]


class OrbitRows(NamedTuple):
    """The orbit in a file.

    segments : in the order of time
    frame : of its axes, by this library's name where it has one; "" where the file does not say
    center : name of the body that positions are from, in capitals
    source : name of the file
    """

    segments: tuple[OrbitSegment, ...]
    frame: str
    center: str
    source: str


class OrbitCurve(NamedTuple):
    """The orbit in a file that holds a function of time: SPK.

    position : (n,) s of TDB since J2000 -> (n, 3) m along the axes of the ICRF
    intervals : (m, 2) s of TDB since J2000, ascending: where it is defined
    """

    position: Callable[[np.ndarray], np.ndarray]
    intervals: np.ndarray
    center: str
    source: str


ORBIT_ENDINGS = {".oem": "oem", ".xml": "oem", ".e": "stk", ".csv": "csv", ".bsp": "spk"}
ORBIT_MODULES = {"oem": "ccsds.oem", "stk": "stk_ephemeris", "csv": "tables.orbit_csv", "spk": "spice.spk"}


def read_orbit(
    path: str,
    format: str | None = None,  # noqa: A002 (as in formats.read)
    object_name: str | None = None,
) -> OrbitRows | OrbitCurve:
    """The orbit in a file, in the format of its ending or the one that is named.

    object_name : which, where the file has several (OBJECT_NAME of an OEM, a name or number of an SPK)

    Raises FormatError, with file and line, for what cannot be read.
    """
    name = ORBIT_ENDINGS.get(Path(path).suffix.lower()) if format is None else format
    if name not in ORBIT_MODULES:
        known = f"{', '.join(ORBIT_MODULES)}{suggestion(format, ORBIT_MODULES)}"
        endings = ", ".join(ORBIT_ENDINGS)
        raise FormatError(f"no format of orbits; format is one of {known}, or the ending of {endings}", path)
    with file_errors(path):
        if name == "spk":
            module = import_module(f".{ORBIT_MODULES[name]}", __package__)
            curve: OrbitCurve = module.read_orbit(path, object_name)
            return curve
        with open(path, "rb") as stream:
            return parse_orbit(stream, path, name, object_name)


def parse_orbit(
    stream: BinaryIO,
    source: str,
    format: str,  # noqa: A002
    object_name: str | None = None,
) -> OrbitRows:
    """The orbit in an open file of a format of rows; `source` is its name in errors."""
    with np.errstate(over="ignore"):
        orbit: OrbitRows = import_module(f".{ORBIT_MODULES[format]}", __package__).parse_orbit(
            stream, source, object_name
        )
    for segment in orbit.segments:
        for values, unit in zip(segment[:3], ("s", "m", "m/s"), strict=True):
            numbers = values.seconds if isinstance(values, Instants) else values
            if numbers is not None and not np.abs(numbers).max() <= 1e18:  # squares of more may overflow
                raise FormatError(f"a number of more than 1e+18 {unit}", source)
    return orbit
