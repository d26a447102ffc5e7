"""A torque that is constant in the body or in inertial space, always or for a span of time."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from ..documents.quantities import Instant, TorqueVector
from ..errors import InputError
from ..kernels.layout import EffectCode
from ..problem.initial_state import InitialState
from .effect import Torque, row
from .time_span import seconds, span_text


class ConstantTorque(Torque):
    """`{"type": "constant_torque", "torque": {"value": [..3], "unit": "N m"}, "frame": "body"}`.

    `frame`: "body" or "inertial", the axes of the components.  `start` and `stop`: elapsed
    (`{"value", "unit"}`) or dates (`{"date", "scale"}`); if left out, it acts at all times before or after.
    """

    REASON: ClassVar[str] = "a torque while it is switched on; exact along an axis that stands still"

    type: Literal["constant_torque"]
    torque: TorqueVector
    frame: Literal["body", "inertial"]
    start: Instant | None = None
    stop: Instant | None = None

    def check(self, initial_state: InitialState) -> None:
        """Refuse a stop before the start, and a torque that acts at no time of the span."""
        start, stop = self._limits(initial_state)
        if not start < stop:
            raise InputError("stop", stop, f"an instant after start ({start!r} s)")
        if self.start is not None and start >= initial_state.stop > initial_state.start:
            raise InputError("start", start, f"an instant before the end of {span_text(initial_state)}")
        if self.stop is not None and stop <= initial_state.start < initial_state.stop:
            raise InputError("stop", stop, f"an instant after the beginning of {span_text(initial_state)}")

    def _limits(self, initial_state: InitialState) -> tuple[float, float]:
        """Start and stop, s since the epoch; infinite where left out."""
        start = -np.inf if self.start is None else seconds(self.start, initial_state, "start")
        stop = np.inf if self.stop is None else seconds(self.stop, initial_state, "stop")
        return start, stop

    def rows(self, initial_state: InitialState) -> np.ndarray:
        """One row: the torque, along the principal axes or inertial."""
        if self.frame == "inertial":
            return row(EffectCode.CONSTANT_INERTIAL, self.torque.si)[None]
        return row(EffectCode.CONSTANT_BODY, initial_state.axes @ self.torque.si)[None]

    def intervals(self, initial_state: InitialState) -> list[tuple[float, float]] | None:
        """The interval from start to stop, cut to the span of the scene; None for always."""
        if self.start is None and self.stop is None:
            return None
        start, stop = self._limits(initial_state)
        start, stop = max(start, initial_state.start), min(stop, initial_state.stop)
        return [(float(start), float(stop))] if start < stop else []

    def size(self, initial_state: InitialState) -> float:
        """Magnitude of the torque, N m."""
        return float(np.linalg.norm(self.torque.si))
