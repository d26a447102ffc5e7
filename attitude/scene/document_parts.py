"""Parts of the scene document: body, epoch, attitude, angular velocity, instants and tolerance."""

from __future__ import annotations

from functools import cached_property, lru_cache
from typing import Annotated, Any

import numpy as np
from astropy import units as u
from astropy.time import Time
from pydantic import Field, StrictBool, model_validator

from .. import units
from ..documents.fields import (
    Chosen,
    Four,
    Matrix,
    Number,
    Part,
    Text,
    Vector,
    check_beside,
    exactly_one,
    field_named,
)
from ..documents.quantities import ABOVE_ZERO, Angle, Mass
from ..errors import InputError, warn
from ..frames import rotations
from ..rigid_body.body import RigidBody
from ..times import instants
from ..times.instants import Grid, Instants, as_instants
from ..times.iso8601 import Scale, parse_time, parse_times

# Between these; below the least, the rounding of the motion itself is larger (docs/theory.md, section 8).
MIN_TOLERANCE, MAX_TOLERANCE = 1e-13, 1e-2


class Body(Part):
    """Inertia about the centre of mass: principal `moments`, or a full `tensor`; and the `mass`.

    Off-diagonal elements of the tensor are -integral of x y dm.  `physical: false` takes positive moments
    that break the triangle inequality, which no body has.
    """

    moments: Vector | None = None
    tensor: Matrix | None = None
    unit: str = Field(examples=["kg m2"])
    mass: Annotated[Mass, ABOVE_ZERO] | None = None
    physical: StrictBool = True

    @model_validator(mode="after")
    def _one_of(self) -> Body:
        exactly_one(self, ("moments", "tensor"))
        return self

    def build(self) -> RigidBody:
        """Return the part in SI units, checked."""
        field = "moments" if self.moments is not None else "tensor"
        values = _si(getattr(self, field), self.unit, units.MOMENT, "body.unit")
        with field_named(f"body.{field}"):
            make = RigidBody.from_moments if field == "moments" else RigidBody
            return make(values, self.physical)


class Epoch(Part):
    """An instant: ISO 8601 text and the time scale it is in."""

    time: str = Field(examples=["1992-11-09T17:49:47"])
    scale: Scale

    def build(self) -> Time:
        """The instant, the caller's own copy."""
        return _parsed_epoch(self.time, self.scale).copy()


@lru_cache(maxsize=256)
def _parsed_epoch(time: str, scale: str) -> Time:
    """Cached, since scenes share epochs; callers get copies."""
    return instants.check_epoch(parse_time(time, scale, "epoch.time"), "epoch.time")


class Attitude(Part):
    """Attitude at the epoch, active from body to inertial, in one of four forms.

    `euler`: intrinsic rotations that carry the inertial axes onto the body's, in the order of
    `sequence`; `quaternion` with its `order`; `matrix` R with v_inertial = R v_body; `mrp`, the
    modified Rodrigues parameters e tan(angle/4) of the same rotation.
    """

    euler: Vector | None = None
    sequence: str | None = Field(None, pattern=r"^[XYZ]{3}$", examples=["ZXZ"])
    unit: str | None = Field(None, examples=["deg"])
    quaternion: Four | None = None
    order: str | None = Field(None, examples=["wxyz"])
    matrix: Matrix | None = None
    mrp: Vector | None = None

    @model_validator(mode="after")
    def _one_of(self) -> Attitude:
        form = exactly_one(self, ("euler", "quaternion", "matrix", "mrp"))
        needed = {"euler": {"sequence", "unit"}, "quaternion": {"order"}}.get(form, set())
        meanings = {
            "sequence": 'the axes in turn, such as "ZXZ",',
            "unit": 'the unit of the angles, "deg" or "rad",',
            "order": '"wxyz" or "xyzw"',
        }
        check_beside(self, form, needed, meanings)
        if self.sequence:
            rotations.check_sequence(self.sequence, "sequence")
        return self

    def build(self) -> np.ndarray:
        """(4,) wxyz."""
        if self.quaternion is not None:
            rotations.check_order(self.order, "attitude.order")
            return rotations.attitude_quaternion(self.quaternion, self.order, "attitude.quaternion")
        if self.matrix is not None:
            return _from_matrix(np.array(self.matrix))
        if self.mrp is not None:
            return rotations.from_mrp(np.array(self.mrp))
        angles = _si(self.euler, self.unit or "", u.rad, "attitude.unit")
        return rotations.from_euler(self.sequence or "", angles)


class AngularVelocity(Part):
    """The rate of the body relative to the inertial frame, components in the body frame, at the epoch."""

    value: Vector
    unit: str = Field(examples=["deg/d"])

    def build(self) -> np.ndarray:
        """(3,), rad/s."""
        values = _si(self.value, self.unit, units.RATE, "angular_velocity.unit")
        return units.finite_array(values, "angular_velocity.value")


class Times(Part):
    """Instants: from `start` to `stop` by `step` or `count`; or `elapsed` values; or `dates` in a `scale`.

    `start` and `stop` are numbers in `unit`, or both dates in `scale`; without `start` it is the epoch.
    The last instant of a stepped grid is the last one not beyond `stop`.
    """

    start: Number | Text | None = None
    stop: Number | Text | None = None
    step: Annotated[Number, Field(gt=0)] | None = None
    count: Annotated[int, Field(ge=1, le=2**53, strict=True)] | None = None  # that doubles can count
    elapsed: list[Number] | None = Field(None, min_length=1, fail_fast=True)
    unit: str | None = Field(None, examples=["s"])
    dates: list[str] | None = Field(None, min_length=1, fail_fast=True)
    scale: Scale | None = None

    @model_validator(mode="after")
    def _one_form(self) -> Times:
        first = "stop" if self.start is None else "start"
        form = exactly_one(self, (first, "elapsed", "dates"))
        needed, optional = {
            first: ({"stop"}, {"start", "step", "count"}),
            "elapsed": ({"elapsed", "unit"}, set()),
            "dates": ({"dates", "scale"}, set()),
        }[form]
        if form == first:
            is_dated = isinstance(self.stop, str)
            needed |= {"start", "scale"} if is_dated else set()
            needed |= {"unit"} if self.step is not None or not is_dated else set()
            exactly_one(self, ("step", "count"))
        members = dict.fromkeys(sorted(type(self).model_fields.keys() - (optional - needed)), "a value")
        check_beside(self, form, needed, members)
        if form == first:
            start, stop = self._limits
            if stop < start:
                raise InputError("stop", self.stop, f"an instant not before start ({self.start or 0.0})")
            if self.count == 1 and stop != start:
                raise InputError("count", 1, "at least 2 where stop is after start")
        return self

    @property
    def is_grid(self) -> bool:
        """Whether the instants are evenly spaced from `start` to `stop`."""
        return self.stop is not None

    @property
    def samples(self) -> int:
        """Number of instants, without building them."""
        given = self.elapsed if self.dates is None else self.dates
        return self.grid.count if given is None else len(given)

    def build(self, epoch: Time | None) -> Instants:
        """All instants, since the epoch."""
        instants = self.lazily(epoch)
        return instants.part(0, instants.count, epoch) if isinstance(instants, Grid) else instants

    def span(self, epoch: Time | None) -> tuple[float, float]:
        """First and last instant together with the epoch, s since it."""
        first, last = self.limits(epoch)
        return min(0.0, first), max(0.0, last)

    def limits(self, epoch: Time | None) -> tuple[float, float]:
        """First and last instant, s since the epoch."""
        instants = self.lazily(epoch)
        if isinstance(instants, Grid):
            first, last = instants.part(0, 1, epoch), instants.part(instants.count - 1, instants.count, epoch)
            return float(first.seconds[0]), float(last.seconds[0])
        return float(instants.seconds.min()), float(instants.seconds.max())

    def lazily(self, epoch: Time | None) -> Grid | Instants:
        """The instants for `TorqueFreeMotion.chunks`; those of a grid are made chunk by chunk."""
        if self.scale is not None and epoch is None:
            field, date = ("times.dates", self.dates[0]) if self.dates else ("times.start", self.start)
            raise InputError(field, date, "an epoch in the scene, for dates to be counted from")
        if self.is_grid:
            return self.grid
        if self.dates is not None:
            return as_instants(self._dated, epoch, "times.dates")
        unit = self.unit or ""
        units.parse_unit(unit, units.SECOND, "times.unit")
        return instants.in_unit(np.array(self.elapsed), unit, "times.elapsed", epoch)

    @cached_property
    def _dated(self) -> Time:
        """`dates`, parsed once for all that ask for instants and their span."""
        return parse_times(self.dates or [], self.scale)

    @cached_property
    def _limits(self) -> tuple[Any, Any]:
        """`start` and `stop`: numbers, or Times."""
        start = 0.0 if self.start is None else self.start
        if isinstance(start, str) != isinstance(self.stop, str):
            form = "a date" if isinstance(self.stop, str) else "a number"
            raise InputError("start", start, f"{form}, as stop is one")
        if not isinstance(start, str):
            return start, self.stop
        return parse_time(start, self.scale, "start"), parse_time(str(self.stop), self.scale, "stop")

    @cached_property
    def grid(self) -> Grid:
        """The instants from `start` to `stop`."""
        return Grid(*self._limits, self.count, self.step, self.unit or "s")


class Tolerance(Angle):
    """How far an attitude may be off at the end of the span."""

    @model_validator(mode="after")
    def _check_reach(self) -> Tolerance:
        if not MIN_TOLERANCE <= self.si <= MAX_TOLERANCE:
            reach = f"from {MIN_TOLERANCE:g} rad (double precision gives no less) to {MAX_TOLERANCE:g} rad"
            raise InputError("value", self.value, reach)
        return self


BEST = "best"  # the most exact answer that there is, with its estimate, instead of a tolerance
AnyTolerance = Annotated[
    Tolerance | str,
    Chosen(
        lambda value: value if value == BEST else Tolerance.model_validate(value),
        lambda: [Tolerance],
        (BEST,),
    ),
]


def _si(values: Any, unit: str, like: u.UnitBase, field: str) -> np.ndarray:
    """Numbers of a document in SI; infinite where they overflow, which the classes they go to refuse."""
    with np.errstate(over="ignore"):
        return np.array(values) * units.parse_unit(unit, like, field)


def _from_matrix(matrix: np.ndarray) -> np.ndarray:
    off = float(rotations.off_orthonormal(matrix))
    if not off <= rotations.MAX_OFF_UNIT:
        expected = f"a proper rotation matrix, orthonormal within {rotations.MAX_OFF_UNIT:g}"
        raise InputError("attitude.matrix", matrix.tolist(), expected)
    if off > rotations.UNIT_TOLERANCE:
        text = f"attitude.matrix: orthonormal within {off:.2g}; the nearest rotation is taken"
        warn(text)
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(matrix).as_quat(scalar_first=True)
