"""A torque that is constant in the body or in inertial space, always or for a while."""

from __future__ import annotations

from typing import Literal

import numpy as np

from ..documents.quantities import Instant, TorqueVector
from ..errors import InputError
from ..kernels import layout
from ..problem.initial_state import Situation
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

    def check(self, situation: Situation) -> None:
        start, stop = self._start(situation), self._stop(situation)
        if not start < stop:
            raise InputError("stop", stop, f"an instant after start ({start!r} s)")
        if self.start is not None and start >= situation.stop > situation.start:
            raise InputError("start", start, f"an instant before the end of {span_text(situation)}")
        if self.stop is not None and stop <= situation.start < situation.stop:
            raise InputError("stop", stop, f"an instant after the beginning of {span_text(situation)}")

    def _start(self, situation: Situation) -> float:
        return -np.inf if self.start is None else seconds(self.start, situation, "start")

    def _stop(self, situation: Situation) -> float:
        return np.inf if self.stop is None else seconds(self.stop, situation, "stop")

    def rows(self, situation: Situation) -> np.ndarray:
        if self.frame == "inertial":
            return row(layout.CONSTANT_INERTIAL, self.torque.si)[None]
        return row(layout.CONSTANT_BODY, situation.axes @ self.torque.si)[None]

    def intervals(self, situation: Situation) -> list[tuple[float, float]] | None:
        """The one from start to stop, cut to the span."""
        if self.start is None and self.stop is None:
            return None
        start, stop = max(self._start(situation), situation.start), min(self._stop(situation), situation.stop)
        return [(float(start), float(stop))] if start < stop else []

    def size(self, situation: Situation) -> float:
        return float(np.linalg.norm(self.torque.si))
