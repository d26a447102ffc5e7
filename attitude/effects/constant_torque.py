"""A torque that is constant in the body or in inertial space, always or for a while."""

from __future__ import annotations

from typing import Literal

import numpy as np

from ..documents.quantities import Instant, TorqueVector
from ..errors import InputError
from ..kernels import layout
from ..problem.initial_state import InitialState
from .effect import Torque, row
from .time_span import seconds, span_text


class ConstantTorque(Torque):
    """`{"type": "constant_torque", "torque": {"value": [..3], "unit": "N m"}, "frame": "body"}`.

    `frame`: "body" or "inertial", what the components are along.  `start` and `stop`: elapsed
    (`{"value", "unit"}`) or dates (`{"date", "scale"}`); left out, it has always acted and always will.
    """

    type: Literal["constant_torque"]
    torque: TorqueVector
    frame: Literal["body", "inertial"]
    start: Instant | None = None
    stop: Instant | None = None

    def check(self, initial_state: InitialState) -> None:
        start, stop = self._start(initial_state), self._stop(initial_state)
        if not start < stop:
            raise InputError("stop", stop, f"an instant after start ({start!r} s)")
        if self.start is not None and start >= initial_state.stop > initial_state.start:
            raise InputError("start", start, f"an instant before the end of {span_text(initial_state)}")
        if self.stop is not None and stop <= initial_state.start < initial_state.stop:
            raise InputError("stop", stop, f"an instant after the beginning of {span_text(initial_state)}")

    def _start(self, initial_state: InitialState) -> float:
        return -np.inf if self.start is None else seconds(self.start, initial_state, "start")

    def _stop(self, initial_state: InitialState) -> float:
        return np.inf if self.stop is None else seconds(self.stop, initial_state, "stop")

    def rows(self, initial_state: InitialState) -> np.ndarray:
        if self.frame == "inertial":
            return row(layout.CONSTANT_INERTIAL, self.torque.si)[None]
        return row(layout.CONSTANT_BODY, initial_state.axes @ self.torque.si)[None]

    def intervals(self, initial_state: InitialState) -> list[tuple[float, float]] | None:
        """The one from start to stop, cut to the span."""
        if self.start is None and self.stop is None:
            return None
        start, stop = (
            max(self._start(initial_state), initial_state.start),
            min(self._stop(initial_state), initial_state.stop),
        )
        return [(float(start), float(stop))] if start < stop else []

    def size(self, initial_state: InitialState) -> float:
        return float(np.linalg.norm(self.torque.si))
