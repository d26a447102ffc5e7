"""Observations of a body: attitudes, body rates, directions, range offsets.

A set of each kind has instants, values and standard deviations, and tells the weighted residuals of a motion
and their derivatives by its attitude (small rotation theta about body axes, q exp(theta/2)) and body rate.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from astropy import units as u
from astropy.time import Time

from .. import units
from ..errors import InputError
from ..frames import rotations
from ..samples.ephemeris_data import EphemerisData
from ..samples.transform import rotation_to
from ..times.instants import Instants, as_instants

SMALL_ANGLE = 1e-4  # rad, below which series replace quotients of sines
MIN_SIGMA = 1e-50  # SI; squares of what it divides, and of the inverse, are doubles


@dataclass(frozen=True, eq=False)
class ObservationSet:
    """Observations of one kind.

    times : (n,) Time; or seconds (a bare array or Quantity) since the epoch of the fit; or Instants
    sigma : standard deviation, 1 sigma, of every observation: a number, (n,) of each, or what the kind adds;
        None where it is not known: the scatter of residuals then is
    label : name in reports
    frame : the inertial frame of the values
    """

    times: Any
    sigma: Any = None
    label: str = ""
    frame: str = "ICRF"

    KIND: ClassVar[str]
    SIGMA_UNIT: ClassVar[u.UnitBase] = units.ANGLE
    UNIT: ClassVar[str] = "rad"
    DEGREES: ClassVar[int]  # of freedom of one observation
    COMPONENTS: ClassVar[int] = 3
    VALUES: ClassVar[tuple[str, ...]]  # the fields that have a value for each observation
    INERTIAL: ClassVar[tuple[str, ...]] = ()  # the fields that are vectors along the axes of the frame
    SIGMA_PER_AXIS: ClassVar[bool] = False  # whether standard deviations may differ by body axes

    def __post_init__(self) -> None:
        rotations.check_frame(self.frame, f"{self.name}.frame")
        shape = np.shape(self.times)
        if len(shape) != 1 or shape[0] == 0:
            raise InputError(f"{self.name}.times", f"shape {shape}", "a list of at least one instant")
        if self.sigma is not None:
            sigma = units.si_array(self.sigma, self.SIGMA_UNIT, f"{self.name}.sigma")
            by_axis = ((*shape, 3), (1, 3)) if self.SIGMA_PER_AXIS else ()
            if sigma.shape not in ((), shape, (*shape, 1), *by_axis):
                raise InputError(
                    f"{self.name}.sigma", f"shape {sigma.shape}", f"one number, or {shape[0]} of them"
                )
            wrong = (sigma < MIN_SIGMA) | (sigma > 1.0 / MIN_SIGMA)
            expected = f"numbers greater than 0, from {MIN_SIGMA} to {1.0 / MIN_SIGMA}"
            units.refuse_where(wrong, sigma, f"{self.name}.sigma", expected)
            object.__setattr__(self, "sigma", sigma)

    @property
    def name(self) -> str:
        """The label, else the kind."""
        return self.label or self.KIND

    def __len__(self) -> int:
        return int(np.shape(self.times)[0])

    def instants(self, epoch: Time | None) -> Instants:
        """The instants since the epoch; InputError for dates without one, or seconds that are not finite."""
        if isinstance(self.times, Instants):
            return self.times
        return as_instants(self.times, epoch, f"{self.name}.times")

    def __getitem__(self, key: Any) -> Self:
        """The observations of these indices."""
        sigma = self.sigma if self.sigma is None or self.sigma.shape[:1] != (len(self),) else self.sigma[key]
        values = {name: getattr(self, name)[key] for name in self.VALUES}
        return replace(self, times=self.times[key], sigma=sigma, **values)

    @property
    def biases(self) -> int:
        """Parameters that it adds."""
        return self.COMPONENTS if getattr(self, "has_bias", False) else 0

    @property
    def unknown_sigma(self) -> float:
        """Provisional standard deviation where none is known, SI: 0.01 rad."""
        return 0.01

    def bias_unit(self, rate: float) -> float:
        """The size of a bias, in SI units, for a body that turns at a rate (rad/s)."""
        return rate

    def in_frame(self, frame: str) -> Self:
        """The same observations along the axes of another inertial frame."""
        if frame == self.frame:
            return self
        turn = turn_of_frame(self.frame, frame)
        vectors: dict[str, Any] = {
            name: rotations.rotate(turn, getattr(self, name)) for name in self.INERTIAL
        }
        return replace(self, frame=frame, **vectors)

    @cached_property
    def weights(self) -> np.ndarray:
        """(n or 1, 1 or components): inverse standard deviations; 1 where they are not known."""
        if self.sigma is None:
            return np.ones((1, 1))
        sigma = np.asarray(self.sigma)
        return 1.0 / (sigma if sigma.ndim == 2 else sigma.reshape(-1, 1))

    def residuals(self, attitude: np.ndarray, rate: np.ndarray | None, bias: np.ndarray) -> np.ndarray:
        """(n, components), observed less computed, not weighted, at attitudes (n, 4) and rates (n, 3)."""
        raise NotImplementedError

    def derivatives(self, attitude: np.ndarray, residuals: np.ndarray) -> np.ndarray:
        """(n, components, 3) of the residuals by theta; of `BodyRates`, by the rate."""
        raise NotImplementedError

    def sizes(self, residuals: np.ndarray) -> np.ndarray:
        """(n,), rad, rad/s or m: how far each observation is off."""
        return np.asarray(np.linalg.norm(residuals, axis=1))


def _vectors(value: Any, count: int, field_name: str, unit: u.UnitBase | None = None) -> np.ndarray:
    """(n, 3) of (n, 3) or (3,), finite."""
    array = (
        units.si_array(value, unit, field_name) if unit is not None else units.finite_array(value, field_name)
    )
    if array.shape not in ((3,), (count, 3)):
        raise InputError(field_name, f"shape {array.shape}", f"shape ({count}, 3) or (3,)")
    return np.broadcast_to(array, (count, 3))


def _directions(value: Any, count: int, field_name: str) -> np.ndarray:
    vectors = _vectors(value, count, field_name)
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    units.refuse_where(length[:, 0] == 0.0, vectors, field_name, "a direction, not zero")
    return vectors / length


@dataclass(frozen=True, eq=False)
class Attitudes(ObservationSet):
    """Attitudes, body to an inertial frame.

    Parameters
    ----------
    attitude : scipy Rotation, or (n, 4) with `order`
    sigma : rad, about every axis; (n, 3) or (1, 3) about each body axis
    order : "wxyz" or "xyzw" of a bare array
    """

    attitude: Any = None
    order: str | None = None

    KIND = "attitudes"
    DEGREES = 3
    VALUES = ("attitude",)
    SIGMA_PER_AXIS = True

    def __post_init__(self) -> None:
        super().__post_init__()
        q = rotations.attitude_quaternion(self.attitude, self.order, f"{self.name}.attitude")
        if q.shape != (len(self), 4):
            raise InputError(f"{self.name}.attitude", f"shape {q.shape}", f"{len(self)} attitudes")
        object.__setattr__(self, "attitude", q)
        object.__setattr__(self, "order", "wxyz")

    @classmethod
    def of(cls, data: EphemerisData, sigma: Any = None, label: str = "") -> Attitudes:
        """The attitudes of an ephemeris, of any file that is read."""
        if len(data.shape) != 1:
            raise InputError(
                "observations", f"shape {data.shape}", "an ephemeris of one body at a list of instants"
            )
        if data.frame in rotations.TURNING_FRAMES:
            expected = 'attitudes in an inertial frame, as `in_frame("GCRF")` of the ephemeris makes them'
            raise InputError("observations", data.frame, expected)
        times = data.elapsed if data.epoch is None else data.time
        return cls(times, sigma, label, data.frame, data.quaternion("wxyz"), "wxyz")

    def in_frame(self, frame: str) -> Self:
        """The same attitudes, relative to another inertial frame."""
        if frame == self.frame:
            return self
        attitude = rotations.product(turn_of_frame(self.frame, frame), self.attitude)
        return replace(self, attitude=attitude, frame=frame)

    def residuals(self, attitude: np.ndarray, rate: np.ndarray | None, bias: np.ndarray) -> np.ndarray:
        """Rotation vectors from the computed attitudes to the observed ones, along body axes."""
        del rate, bias
        return rotations.rotation_vectors(attitude, self.attitude)

    def derivatives(self, attitude: np.ndarray, residuals: np.ndarray) -> np.ndarray:
        """log(exp(-theta) exp(r)) = r - J theta, J the inverse of the left Jacobian of r."""
        del attitude
        angle = np.linalg.norm(residuals, axis=1)
        safe = np.where(angle > SMALL_ANGLE, angle, 1.0)
        quadratic = (1.0 - 0.5 * safe / np.tan(0.5 * safe)) / safe**2
        quadratic = np.where(angle > SMALL_ANGLE, quadratic, 1.0 / 12.0)
        cross = cross_matrix(residuals)
        return 0.5 * cross - np.eye(3) - quadratic[:, None, None] * (cross @ cross)


@dataclass(frozen=True, eq=False)
class BodyRates(ObservationSet):
    """Angular velocities of the body, along body axes, as of a gyroscope.

    Parameters
    ----------
    rate : (n, 3), rad/s or a Quantity
    sigma : rad/s
    has_bias : whether a constant bias (observed less true) is estimated
    """

    rate: Any = None
    has_bias: bool = False

    KIND = "rates"
    SIGMA_UNIT = units.RATE
    UNIT = "rad/s"
    DEGREES = 3
    VALUES = ("rate",)
    SIGMA_PER_AXIS = True

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "rate", _vectors(self.rate, len(self), f"{self.name}.rate", units.RATE))

    @property
    def unknown_sigma(self) -> float:
        """A hundredth of the largest rate."""
        return 0.01 * float(np.abs(self.rate).max()) or 1.0

    def residuals(self, attitude: np.ndarray, rate: np.ndarray | None, bias: np.ndarray) -> np.ndarray:
        """Observed rate less bias less the computed one."""
        del attitude
        return self.rate - (bias if self.has_bias else 0.0) - rate

    def derivatives(self, attitude: np.ndarray, residuals: np.ndarray) -> np.ndarray:
        """Derivatives by the rate."""
        del attitude
        return np.broadcast_to(-np.eye(3), (len(residuals), 3, 3))


@dataclass(frozen=True, eq=False)
class Directions(ObservationSet):
    """Directions known along body axes and along inertial axes.

    A star, the Sun or a field seen by a sensor of the body; or a body axis seen from outside.

    Parameters
    ----------
    body : (n, 3) or (3,) along body axes, of any length
    inertial : (n, 3) or (3,) along the axes of `frame`, of any length
    sigma : rad, across the direction
    """

    body: Any = None
    inertial: Any = None

    KIND = "directions"
    DEGREES = 2
    VALUES = ("body", "inertial")
    INERTIAL = ("inertial",)

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in self.VALUES:
            object.__setattr__(self, name, _directions(getattr(self, name), len(self), f"{self.name}.{name}"))

    def residuals(self, attitude: np.ndarray, rate: np.ndarray | None, bias: np.ndarray) -> np.ndarray:
        """The chord from the computed direction to the observed one, along body axes."""
        del rate, bias
        return self.body - rotations.rotate(rotations.conjugate(attitude), self.inertial)

    def derivatives(self, attitude: np.ndarray, residuals: np.ndarray) -> np.ndarray:
        """-[u]x, u the computed direction along body axes, which a small rotation moves by u x theta."""
        del attitude
        return -cross_matrix(self.body - residuals)

    def sizes(self, residuals: np.ndarray) -> np.ndarray:
        """Angles of these chords."""
        return 2.0 * np.arcsin(np.minimum(0.5 * super().sizes(residuals), 1.0))


@dataclass(frozen=True, eq=False)
class RangeOffsets(ObservationSet):
    """How much farther a point of the body is than its centre of mass, as of a reflector in laser ranging.

    Parameters
    ----------
    offset : (n,), m: range of the point less range of the centre of mass
    point : (n, 3) or (3,), m, along body axes, from the centre of mass
    line_of_sight : (n, 3) or (3,), from the station to the body, along the axes of `frame`, of any length
    sigma : m
    has_bias : whether a constant bias of the offsets is estimated
    """

    offset: Any = None
    point: Any = None
    line_of_sight: Any = None
    has_bias: bool = False

    KIND = "ranges"
    SIGMA_UNIT = units.LENGTH
    UNIT = "m"
    DEGREES = 1
    COMPONENTS = 1
    VALUES = ("offset", "point", "line_of_sight")
    INERTIAL = ("line_of_sight",)

    def __post_init__(self) -> None:
        super().__post_init__()
        offset = units.si_array(self.offset, units.LENGTH, f"{self.name}.offset")
        if offset.shape != (len(self),):
            raise InputError(f"{self.name}.offset", f"shape {offset.shape}", f"shape ({len(self)},)")
        point = _vectors(self.point, len(self), f"{self.name}.point", units.LENGTH)
        sight = _directions(self.line_of_sight, len(self), f"{self.name}.line_of_sight")
        for name, value in zip(self.VALUES, (offset, point, sight), strict=True):
            object.__setattr__(self, name, value)

    @property
    def unknown_sigma(self) -> float:
        """A hundredth of the largest offset."""
        return 0.01 * float(np.abs(self.offset).max()) or 1.0

    def bias_unit(self, rate: float) -> float:
        """The greatest distance of the points."""
        del rate
        return float(np.linalg.norm(self.point, axis=1).max()) or 1.0

    def residuals(self, attitude: np.ndarray, rate: np.ndarray | None, bias: np.ndarray) -> np.ndarray:
        """Observed offset less bias less s . R p."""
        del rate
        sight = rotations.rotate(rotations.conjugate(attitude), self.line_of_sight)
        computed = (sight * self.point).sum(axis=1)
        return (self.offset - (bias[0] if self.has_bias else 0.0) - computed)[:, None]

    def derivatives(self, attitude: np.ndarray, residuals: np.ndarray) -> np.ndarray:
        """-(p x s), s the line of sight along body axes."""
        del residuals
        sight = rotations.rotate(rotations.conjugate(attitude), self.line_of_sight)
        return -np.cross(self.point, sight)[:, None, :]


def turn_of_frame(frame: str, other: str) -> np.ndarray:
    """(4,) wxyz that takes components along the axes of an inertial frame to those along another's."""
    turn = rotation_to(other, frame, None, Instants(np.zeros(1), None, None), "tables")
    return np.array([1.0, 0.0, 0.0, 0.0]) if turn is None else turn.quaternion.reshape(4)


def observation_sets(observations: Any) -> list[ObservationSet]:
    """One set or ephemeris, or a list of these, as sets; InputError for what is none, and for none."""
    is_one = isinstance(observations, (ObservationSet, EphemerisData)) or not isinstance(
        observations, Iterable
    )
    sets = [
        Attitudes.of(each) if isinstance(each, EphemerisData) else each
        for each in ([observations] if is_one else observations)
    ]
    for i, each in enumerate(sets):
        if not isinstance(each, ObservationSet):
            expected = "Attitudes, BodyRates, Directions, RangeOffsets, or an Ephemeris"
            raise InputError(f"observations[{i}]", each, expected)
    if not sets:
        raise InputError("observations", observations, "at least one set")
    return sets


def cross_matrix(vectors: np.ndarray) -> np.ndarray:
    """(..., 3, 3) [v]x of (..., 3): [v]x a = v x a."""
    matrix = np.zeros((*vectors.shape, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        matrix[..., j, i] = vectors[..., k]
        matrix[..., i, j] = -vectors[..., k]
    return matrix
