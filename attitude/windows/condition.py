"""Conditions on a motion, as documents and as Python expressions.

(angle("z", to="sun") < 10 * u.deg) & ~in_shadow()
{"and": [{"axis": "z", "to": "sun", "below": {"value": 10, "unit": "deg"}}, {"not": {"shadow": "umbra"}}]}
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field, PlainValidator, ValidationError, WithJsonSchema, model_validator

from .. import units
from ..documents.fields import Part, exactly_one, input_error
from ..documents.quantities import Angle, LengthVector
from ..errors import InputError, suggestion
from ..pointing import targets

MAX_CONDITIONS, MAX_LEVELS = 100, 20  # within one


class AngleBelow(NamedTuple):
    """That the angle between a body axis and a target is below a threshold.

    axis : (3,) along the body axes; target : `to` of `targets.target_vector`, as JSON; threshold : rad
    """

    axis: tuple[float, ...]
    target: str
    threshold: float


class InShadow(NamedTuple):
    """That the body is in the central body's shadow: "umbra", "penumbra" (umbra included) or "cylinder"."""

    kind: str


Elementary = AngleBelow | InShadow
Holding = Callable[[Elementary], np.ndarray]


VECTOR = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}
AXIS_SCHEMA = {"oneOf": [{"enum": ["x", "y", "z", "-x", "-y", "-z"]}, VECTOR]}


def _parse_axis(value: Any) -> Any:
    """A body axis as a document states it: its name, or three numbers."""
    targets.body_axis(value, "")
    return value


Axis = Annotated[Any, PlainValidator(_parse_axis), WithJsonSchema(AXIS_SCHEMA)]


class PositionTarget(Part):
    """A place, from the central body along the axes of the frame."""

    position: LengthVector

    @property
    def evaluable(self) -> dict[str, Any]:
        """The target as `targets.target_vector` takes it."""
        return {"position": self.position.si.tolist()}


class BodyAxisTarget(Part):
    """Another axis of the body."""

    body_axis: Axis

    @property
    def evaluable(self) -> dict[str, Any]:
        """The target as `targets.target_vector` takes it."""
        return {"body_axis": self.body_axis}


def _parse_target(value: Any) -> Any:
    """A target as a document states it: a name, three numbers, a body axis or a position."""
    if isinstance(value, (PositionTarget, BodyAxisTarget)):
        return value
    if isinstance(value, dict):
        return (BodyAxisTarget if "body_axis" in value else PositionTarget).model_validate(value)
    expected = f"one of {', '.join(targets.NAMES)}, three numbers, a body_axis or a position"
    expected += suggestion(value, targets.NAMES)
    if isinstance(value, list):
        targets.unit_vector(value, "", expected)
        return value
    if value not in targets.NAMES:
        raise InputError("", value, expected)
    return targets.SYNONYMS.get(value, value)


TARGET_SCHEMA = {
    "oneOf": [
        {"enum": list(targets.NAMES)},
        VECTOR,
        {"type": "object", "required": ["body_axis"], "properties": {"body_axis": AXIS_SCHEMA}},
        {"type": "object", "required": ["position"], "properties": {"position": {"type": "object"}}},
    ]
}
Target = Annotated[Any, PlainValidator(_parse_target), WithJsonSchema(TARGET_SCHEMA)]


class Condition(Part):
    """A condition on a motion, one of:

    the angle from a body `axis` (a name, or three numbers) to a target is `below` an angle, `above` one, or
    both; the axis is `above_plane`, on that side of a plane to which its normal points, which is a target;
    the body is in the `shadow` of the central body, its umbra, its penumbra (umbra included) or a cylinder;
    others combined by `and`, `or`, `not`; in Python by `&`, `|`, `~`.
    """

    axis: Axis | None = Field(None, examples=["z"])
    to: Target | None = Field(None, examples=["sun"])
    below: Angle | None = None
    above: Angle | None = None
    above_plane: Target | None = Field(None, examples=["orbit_normal"])
    shadow: Literal["umbra", "penumbra", "cylinder"] | None = None
    all_of: Annotated[list[Condition], Field(min_length=1)] | None = Field(None, alias="and")
    any_of: Annotated[list[Condition], Field(min_length=1)] | None = Field(None, alias="or")
    negated: Condition | None = Field(None, alias="not")

    @model_validator(mode="after")
    def _check(self) -> Condition:
        forms = {"axis": "axis", "shadow": "shadow", "all_of": "and", "any_of": "or", "negated": "not"}
        present = [key for name, key in forms.items() if getattr(self, name) is not None]
        if len(present) != 1:
            raise InputError("", " and ".join(present) or None, f"one of {', '.join(forms.values())}")
        if self.axis is None:
            for name in ("to", "below", "above", "above_plane"):
                if getattr(self, name) is not None:
                    raise InputError(name, getattr(self, name), f"an axis beside it, not {present[0]}")
            return self
        if exactly_one(self, ("to", "above_plane")) == "to" and self.below is None and self.above is None:
            raise InputError("below", None, "an angle, below or above or both, beside to")
        for name, limit in (("below", self.below), ("above", self.above)):
            if limit is not None and self.to is None:
                raise InputError(name, limit.value, "no angle beside above_plane")
            if limit is not None and not 0.0 <= limit.si <= np.pi:
                raise InputError(f"{name}.value", f"{limit.value} {limit.unit}", "an angle from 0 to 180 deg")
        return self

    def document(self) -> dict[str, Any]:
        """Return plain data; `parse_condition` of it is this condition."""
        return self.model_dump(exclude_unset=True, by_alias=True)

    def __and__(self, other: Condition) -> Condition:
        return parse_condition({"and": [self, other]})

    def __or__(self, other: Condition) -> Condition:
        return parse_condition({"or": [self, other]})

    def __invert__(self) -> Condition:
        return parse_condition({"not": self})

    @property
    def _parts(self) -> list[Condition]:
        return self.all_of or self.any_of or ([] if self.negated is None else [self.negated])

    def elementary(self) -> Iterator[Elementary]:
        """The elementary conditions that it depends on, of which some may come several times."""
        for part in self._parts:
            yield from part.elementary()
        if self.shadow is not None:
            yield InShadow(self.shadow)
        if self.above_plane is not None:
            yield self._angle_below(self.above_plane, 0.5 * np.pi)
        for limit in (self.below, self.above):
            if limit is not None:
                yield self._angle_below(self.to, limit.si)

    def holds(self, holding: Holding) -> np.ndarray:
        """(n,), whether it holds where each elementary condition does or does not."""
        of_parts = [part.holds(holding) for part in self._parts]
        if self.any_of is not None:
            return np.logical_or.reduce(of_parts)
        if self.all_of is not None:
            return np.logical_and.reduce(of_parts)
        if self.negated is not None:
            return ~of_parts[0]
        one, *others = self.elementary()
        if self.above is None:
            return holding(one)
        return ~holding(one) if not others else holding(one) & ~holding(others[0])

    def _angle_below(self, to: Any, threshold: float) -> AngleBelow:
        axis = tuple(targets.body_axis(self.axis, "axis").tolist())
        return AngleBelow(axis, json.dumps(getattr(to, "evaluable", to)), threshold)


def parse_condition(document: Any, field: str = "condition") -> Condition:
    """A condition of plain data, or one made in Python.

    Raises InputError with the path of what is wrong, beginning with `field`.
    """
    if isinstance(document, Condition):
        return document
    if not isinstance(document, dict):
        raise InputError(field, document, "a JSON object: an axis, a shadow, and, or, not")
    _check_size(document, field)
    try:
        return Condition.model_validate(document)
    except ValidationError as error:
        refusal = input_error(error, Condition, document)
        inner = refusal.field if refusal.steps else ""
        separator = "." if inner else ""
        raise InputError(f"{field}{separator}{inner}", refusal.value, refusal.expected) from None


def _check_size(document: Any, field: str) -> None:
    """Refuse what is nested too deeply, or has too many members, before it is read."""
    members, levels, count = [document], 0, 0
    while members:
        levels, count = levels + 1, count + len(members)
        if levels > MAX_LEVELS or count > MAX_CONDITIONS:
            expected = f"at most {MAX_CONDITIONS} conditions, in {MAX_LEVELS} levels"
            raise InputError(field, f"{count} conditions in {levels} levels", expected)
        inner: list[Any] = []
        for member in members:
            plain = member.document() if isinstance(member, Condition) else member
            for key in ("and", "or", "not") if isinstance(plain, dict) else ():
                value = plain.get(key)
                inner += value if isinstance(value, list) else [] if value is None else [value]
        members = inner


# -- in Python --------------------------------------------------------------------------------------------


class AngleTo:
    """The angle from a body axis to a target; compared with an angle it is a Condition."""

    def __init__(self, axis: Any, to: Any):
        self._members = {"axis": _plain(axis), "to": _plain_target(to)}

    def _compared(self, name: str, limit: Any) -> Condition:
        radians = float(units.si_array(limit, units.ANGLE, name))
        return parse_condition({**self._members, name: {"value": radians, "unit": "rad"}}, "angle")

    def __lt__(self, limit: Any) -> Condition:
        return self._compared("below", limit)

    def __gt__(self, limit: Any) -> Condition:
        return self._compared("above", limit)

    __le__, __ge__ = __lt__, __gt__


def angle(axis: Any, to: Any) -> AngleTo:
    """The angle from a body axis to a target, to be compared: `angle("z", to="sun") < 10 * u.deg`.

    axis, to : as of `Ephemeris.angle`; limits are Quantities, or bare floats in rad, from 0 to 180 deg
    """
    return AngleTo(axis, to)


def above_plane(axis: Any, normal: Any) -> Condition:
    """That a body axis is on that side of a plane to which its normal points: `normal` as `to` of `angle`."""
    return parse_condition({"axis": _plain(axis), "above_plane": _plain_target(normal)}, "above_plane")


def in_shadow(kind: str = "umbra") -> Condition:
    """That the body is in the central body's shadow.

    kind : "umbra", where no light comes; "penumbra", where less does, the umbra included; "cylinder"
    """
    return parse_condition({"shadow": kind}, "in_shadow")


def _plain(value: Any) -> Any:
    """Numbers of a vector as JSON has them; anything else as it is."""
    return np.asarray(value).tolist() if isinstance(value, (tuple, np.ndarray)) else value


def _plain_target(to: Any) -> Any:
    if not isinstance(to, dict):
        return _plain(to)
    plain = {key: _plain(value) for key, value in to.items()}
    if set(to) == {"position"} and not isinstance(to["position"], dict):
        place = units.si_array(to["position"], units.LENGTH, "to.position")
        plain = {"position": {"value": place.tolist(), "unit": "m"}}
    return plain
