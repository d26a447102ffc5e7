"""The orbit of an ephemeris: its course, made when something is asked of it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..frames.inertial import FrameRotation
from ..problem.initial_state import OrbitPath
from ..times.instants import Instants
from .local_frames import qsw
from .path_states import position, velocity


class EphemerisOrbit:
    """The orbit of an ephemeris, evaluated on demand (`samples.ephemeris_data.OrbitStates`).

    Parameters
    ----------
    course : of a span, s since the epoch
    span : that of the scene
    frame : whose axes the course is along
    """

    def __init__(
        self,
        course: Callable[[float, float], OrbitPath],
        span: Callable[[], tuple[float, float]],
        frame: str,
    ):
        self.frame = frame
        self._course_over, self._scene_span = course, span
        self._made: tuple[float, float, OrbitPath] | None = None

    @property
    def is_about_the_earth(self) -> bool:
        central = self._course(np.zeros(0)).central
        return central is not None and central.is_earth

    def state(self, instants: Instants) -> tuple[np.ndarray, np.ndarray]:
        """Position and velocity, (n, 3), m and m/s, from the central body along the axes of `frame`."""
        t = instants.seconds.reshape(-1)
        course = self._course(t)
        return position(course, t), velocity(course, t)

    def axes(self, instants: Instants) -> FrameRotation:
        """From `frame` to QSW, at (n,) instants."""
        t = instants.seconds.reshape(-1)
        return qsw(
            self._course(t), t, None if instants.seconds_low is None else instants.seconds_low.reshape(-1)
        )

    def _course(self, t: np.ndarray) -> OrbitPath:
        """Over the scene's span; a longer one where instants are asked for beyond."""
        first, last = float(t.min(initial=0.0)), float(t.max(initial=0.0))
        made = self._made or self._over(*self._scene_span())
        start, stop, _ = made
        if not (start <= first and last <= stop):
            made = self._over(min(start, first), max(stop, last))
        self._made = made  # written once, read once: threads may ask at the same time
        return made[2]

    def _over(self, start: float, stop: float) -> tuple[float, float, OrbitPath]:
        return start, stop, self._course_over(start, stop)
