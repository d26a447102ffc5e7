"""Orbits in SPICE's SPK files, evaluated by CSPICE: any type of segment that it has."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np

from ...errors import FormatError
from ..orbits import OrbitCurve
from .cspice import calling, import_spiceypy


def read_orbit(path: str, object_name: str | None = None) -> OrbitCurve:
    """The orbit of an SPK's only object, or of one by its name or number, from the centre of its segments."""
    spice = import_spiceypy("an SPK")
    with calling(spice, path):
        bodies = [int(body) for body in spice.spkobj(path)]
        body = _body(bodies, object_name, path, spice)
        cover = spice.spkcov(path, body)
        intervals = np.array([spice.wnfetd(cover, i) for i in range(spice.wncard(cover))])
        with _loaded(path, spice):
            handle, descriptor, _ = spice.spksfs(body, 0.5 * (intervals[0][0] + intervals[0][1]), 41)[:3]
            center = int(spice.spkuds(descriptor)[1])
        del handle
        try:
            name = spice.bodc2n(center)
        except spice.SpiceyError:  # it has none
            name = str(center)
    return OrbitCurve(partial(_positions, path, body, center), intervals, name.upper(), path)


@contextmanager
def _loaded(path: str, spice: Any) -> Iterator[None]:
    handle = spice.spklef(path)
    try:
        yield
    finally:
        spice.spkuef(handle)


def _body(bodies: list[int], name: str | None, path: str, spice: Any) -> int:
    listed = ", ".join(map(str, bodies[:20]))
    if name is None:
        if len(bodies) != 1:
            raise FormatError(f"{len(bodies)} objects ({listed}): object names one", path)
        return bodies[0]
    try:
        number = int(name)
    except ValueError:
        try:
            number = int(spice.bodn2c(name))
        except spice.SpiceyError:
            number = 0
    if number not in bodies:
        raise FormatError(f"no object {name!r}, but {listed}", path)
    return number


def _positions(path: str, body: int, center: int, seconds: np.ndarray) -> np.ndarray:
    """(n, 3) m along the axes of the ICRF, SPICE's J2000, at seconds of TDB since J2000."""
    spice = import_spiceypy("an SPK")
    with calling(spice, path), _loaded(path, spice):
        km = [spice.spkgps(body, float(t), "J2000", center)[0] for t in seconds]
    return 1e3 * np.array(km).reshape(-1, 3)
