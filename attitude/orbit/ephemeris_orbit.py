"""The orbit of an ephemeris: its path, computed when it is first needed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..frames.inertial import FrameRotation
from ..problem.initial_state import OrbitPath
from ..samples.ephemeris_data import OrbitLimits
from ..times.instants import Instants
from .local_frames import qsw
from .path_states import limits, position, velocity


class EphemerisOrbit:
    """The orbit of an ephemeris, evaluated on demand (`samples.ephemeris_data.OrbitStates`).

    Parameters
    ----------
    path : (start, stop) -> OrbitPath over that span, s since the epoch
    span : () -> (start, stop) of the scene, s since the epoch
    frame : inertial frame of the path
    """

    def __init__(
        self,
        path: Callable[[float, float], OrbitPath],
        span: Callable[[], tuple[float, float]],
        frame: str,
    ):
        self.frame = frame
        self._compute_path, self._scene_span = path, span
        self._cached: tuple[float, float, OrbitPath] | None = None

    @property
    def is_about_the_earth(self) -> bool:
        """Whether the central body is the Earth."""
        central = self._path(np.zeros(0)).central
        return central is not None and central.is_earth

    @property
    def central_radius(self) -> float | None:
        """Radius of the central body, m; None where it is not known."""
        central = self._path(np.zeros(0)).central
        return None if central is None else central.radius

    def limits(self, start: float, stop: float) -> OrbitLimits:
        """Bounds over a span, s since the epoch."""
        return limits(self._path(np.array([start, stop])))

    def state(self, instants: Instants) -> tuple[np.ndarray, np.ndarray]:
        """Position and velocity, (n, 3), m and m/s, from the central body along the axes of `frame`."""
        t = instants.seconds.reshape(-1)
        path = self._path(t)
        return position(path, t), velocity(path, t)

    def axes(self, instants: Instants) -> FrameRotation:
        """Rotation from `frame` to QSW at (n,) instants."""
        flat = instants.flattened()
        return qsw(self._path(flat.seconds), flat.seconds, flat.seconds_low)

    def _path(self, t: np.ndarray) -> OrbitPath:
        """Path over the scene's span, or over a longer one that includes the instants."""
        first, last = float(t.min(initial=0.0)), float(t.max(initial=0.0))
        cached = self._cached  # read once, written once: threads may ask at the same time
        start, stop = self._scene_span() if cached is None else cached[:2]
        if cached is None or not (start <= first and last <= stop):
            start, stop = min(start, first), max(stop, last)
            self._cached = cached = start, stop, self._compute_path(start, stop)
        return cached[2]
