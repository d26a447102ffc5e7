"""Impulses: thruster firings of no duration."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from ..documents.fields import Part, exactly_one
from ..documents.quantities import AngularImpulseVector, ImpulseVector, Instant, LengthVector
from ..errors import InputError
from ..problem.initial_state import InitialState
from ..problem.torque_model import AppliedImpulse
from .effect import Effect
from .time_span import check_in_span, seconds


class Firing(Part):
    """One impulse: an `angular_impulse`; or an `impulse` at an `arm` from the centre of mass.

    All its vectors have components along the axes of `frame`, "body" or "inertial".
    """

    time: Instant
    angular_impulse: AngularImpulseVector | None = None
    impulse: ImpulseVector | None = None
    arm: LengthVector | None = None
    frame: Literal["body", "inertial"]

    @model_validator(mode="after")
    def _check(self) -> Firing:
        _check_form(self)
        return self

    def applied(self, initial_state: InitialState, field: str) -> AppliedImpulse:
        """Return the impulse in SI units; `field` is that of its time, for errors."""
        elapsed, inertial = seconds(self.time, initial_state, field), self.frame == "inertial"
        if self.angular_impulse is not None:
            return AppliedImpulse(elapsed, self.angular_impulse.si, np.zeros(3), inertial)
        linear = np.zeros(3) if self.impulse is None else self.impulse.si
        arm = np.zeros(3) if self.arm is None else self.arm.si
        return AppliedImpulse(elapsed, np.cross(arm, linear), linear, inertial)


class Impulse(Effect):
    """One firing, its fields beside `type`; or a plan of several, a list of them as `firings`.

    `{"type": "impulse", "time": {"value": 10, "unit": "s"}, "frame": "body",
    "angular_impulse": {"value": [0, 0, 0.1], "unit": "N m s"}}`
    """

    ACTS_ON: ClassVar[Literal["translation", "instants", "attitude"]] = "instants"
    REASON: ClassVar[str] = (
        "the momentum changes at an instant; the closed form or the solver goes on from there"
    )

    type: Literal["impulse"]
    time: Instant | None = None
    angular_impulse: AngularImpulseVector | None = None
    impulse: ImpulseVector | None = None
    arm: LengthVector | None = None
    frame: Literal["body", "inertial"] | None = None
    firings: list[Firing] | None = Field(None, min_length=1, fail_fast=True)

    @model_validator(mode="after")
    def _one_form(self) -> Impulse:
        exactly_one(self, ("time", "firings"))
        for name in ("angular_impulse", "impulse", "arm", "frame"):
            if self.firings is not None and getattr(self, name) is not None:
                raise InputError(name, getattr(self, name), f"no {name} beside firings")
        if self.time is not None:
            if self.frame is None:
                raise InputError("frame", None, 'the axes of the components, "body" or "inertial"')
            _check_form(self)
        return self

    def _fields(self) -> list[tuple[str, Firing]]:
        """Each firing, and the field of its time."""
        if self.firings is None:
            fields = {name: getattr(self, name) for name in Firing.model_fields}
            return [("time", Firing.model_construct(**fields))]
        return [(f"firings[{i}].time", firing) for i, firing in enumerate(self.firings)]

    @property
    def moves(self) -> bool:
        """Whether it changes the velocity of the centre of mass."""
        return any(firing.impulse is not None for _, firing in self._fields())

    def check(self, initial_state: InitialState) -> None:
        """Refuse firings outside the span of the scene."""
        for field, firing in self._fields():
            check_in_span(firing.time, initial_state, field)

    def applied(self, initial_state: InitialState) -> list[AppliedImpulse]:
        """Impulses in the order of their instants; of one instant in that of the document."""
        impulses = [firing.applied(initial_state, field) for field, firing in self._fields()]
        return sorted(impulses, key=lambda impulse: impulse.seconds)


def _check_form(part: Firing | Impulse) -> None:
    form = exactly_one(part, ("angular_impulse", "impulse"))
    if form == "impulse" and part.arm is None:
        raise InputError("arm", None, "the point of application, from the centre of mass, beside impulse")
    if form == "angular_impulse" and part.arm is not None:
        raise InputError("arm", part.arm.value, "no arm beside angular_impulse")
