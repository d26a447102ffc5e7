"""What is estimated, as numbers: the motion of given numbers, and its derivatives by them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from astropy.time import Time

from ..errors import InputError, unknown_name
from ..frames import rotations
from ..motion import TorqueFreeMotion
from ..rigid_body.body import RigidBody
from ..rigid_body.partials import ELEMENTS
from .observations import SMALL_ANGLE, ObservationSet, cross_matrix

# What may be estimated, in the order of the columns of `motion.partials`; "inertia" stands for "moments", and
# for "principal_axes" too where the body is a tensor.
GROUPS = ("attitude", "angular_velocity", "moments", "principal_axes")
AXES = "xyz"


@dataclass(frozen=True, eq=False)
class BodyState:
    """A body and its state at the epoch.

    attitude : (4,) wxyz, body to `frame`; rate : (3,) rad/s, body axes
    moments : (3,) kg m2, principal; axes : (3, 3), the principal axes in its rows, body components
    """

    attitude: np.ndarray
    rate: np.ndarray
    moments: np.ndarray
    axes: np.ndarray
    epoch: Time | None
    frame: str

    @classmethod
    def of(cls, motion: TorqueFreeMotion) -> BodyState:
        """The state of the motion of one body."""
        if motion.shape:
            raise InputError("start", f"{motion.shape} bodies", "the motion of one body")
        at_epoch, body = motion.at(0.0), motion.body
        return cls(
            at_epoch.quaternion("wxyz"),
            at_epoch.angular_velocity,
            body.moments,
            body.axes,
            motion.epoch,
            motion.frame,
        )

    @property
    def inertia_form(self) -> str:
        """How `body` has the inertia: "moments" where the principal axes are the body axes, else "tensor"."""
        return "moments" if (self.axes == np.eye(3)).all() else "tensor"

    @property
    def body(self) -> RigidBody:
        """The body, by its moments or by its tensor."""
        if self.inertia_form == "moments":
            return RigidBody.from_moments(self.moments, physical=False)
        return RigidBody(self.tensor, physical=False)

    @property
    def tensor(self) -> np.ndarray:
        """(3, 3), kg m2."""
        return (self.axes.T * self.moments) @ self.axes

    @property
    def tensor_columns(self) -> np.ndarray:
        """(6, 6): elements xx, yy, zz, xy, xz, yz of the tensor by moments and turns about body axes."""
        turned = cross_matrix(np.eye(3)) @ self.tensor
        changes = [*(axis[:, None] * axis for axis in self.axes), *(turned + np.swapaxes(turned, -1, -2))]
        return np.array([[change[i, j] for change in changes] for i, j in ELEMENTS])

    def with_inertia(self, body: RigidBody | None) -> BodyState:
        """The state with the inertia of a body, if there is one."""
        return self if body is None else replace(self, moments=body.moments, axes=body.axes)

    def is_near(self, other: BodyState, tolerance: float = 1e-4) -> bool:
        """Whether both are one state, whatever the scale of inertia; tolerance in rad, and relative."""
        size = np.sqrt(self.rate @ self.rate)
        shapes = [each.tensor / each.moments.sum() for each in (self, other)]
        return bool(
            rotations.angle_between(self.attitude, other.attitude) < tolerance
            and np.abs(self.rate - other.rate).max() <= tolerance * size
            and np.abs(shapes[0] - shapes[1]).max() < tolerance
        )

    def after(self, seconds: float) -> BodyState:
        """The state so much later, of the same motion, with this epoch."""
        motion = replace(self, epoch=None).motion().at(seconds)
        return replace(self, attitude=motion.quaternion("wxyz"), rate=motion.angular_velocity)

    def rescaled(self, least_moment: float) -> BodyState:
        """The same motion by another scale of inertia; its principal axes in the order of `RigidBody`."""
        body = self.body
        return replace(self, moments=body.moments * (least_moment / body.moments.min()), axes=body.axes)

    def motion(self) -> TorqueFreeMotion:
        """Free rotation from this state."""
        return TorqueFreeMotion(self.body, self.attitude, self.rate, self.epoch, "wxyz", self.frame)


class Quantities(NamedTuple):
    """Names (n,), values (n,) in SI, and derivatives (n, p) by the parameters, of what is estimated."""

    names: tuple[str, ...]
    values: np.ndarray
    derivatives: np.ndarray


def check_groups(estimate: Sequence[str], body: RigidBody) -> tuple[str, ...]:
    """The groups of parameters, in the order of GROUPS; "inertia" is spelled out by the form of the body."""
    names = (estimate,) if isinstance(estimate, str) else tuple(estimate)
    for name in names:
        if name not in (*GROUPS, "inertia"):
            raise unknown_name("estimate", "parameter", name, (*GROUPS, "inertia"))
    of_inertia = ("moments",) if (body.axes == np.eye(3)).all() else ("principal_axes", "moments")
    expanded = {each for name in names for each in (of_inertia if name == "inertia" else (name,))}
    if not expanded:
        raise InputError("estimate", estimate, f"at least one of {', '.join(GROUPS)}")
    return tuple(name for name in GROUPS if name in expanded)


class Parameters:
    """Numbers x, zero at a reference state, each in its own natural unit, and the states that they stand for.

    attitude : rotation vector from the reference, body axes; rad
    angular_velocity : difference from the reference; the size of the reference rate
    principal_axes : rotation vector that turns them about body axes; rad
    moments : logarithms of two moments' ratios to the third, the least, whose value is kept: free rotation
        does not depend on the scale of inertia
    biases : of the sets that have one; their unit is the size of what they are added to
    """

    def __init__(
        self, reference: BodyState, groups: tuple[str, ...], sets: Sequence[ObservationSet], span: float
    ):
        self.reference, self.groups = reference, groups
        rate = float(np.sqrt((reference.rate**2).sum())) or 1.0 / span
        self.kept = int(np.argmin(reference.moments))
        self.free = [i for i in range(3) if i != self.kept]
        columns = {"moments": [AXES[i] for i in self.free]}
        names = [(group, axis) for group in groups for axis in columns.get(group, AXES)]
        self.units = [rate if group == "angular_velocity" else 1.0 for group, _ in names]
        self.columns = {group: [i for i, name in enumerate(names) if name[0] == group] for group in groups}
        self.bias_columns: list[list[int]] = []
        for each in sets:
            self.bias_columns.append(list(range(len(names), len(names) + each.biases)))
            names += [(f"{each.name} bias", axis) for axis in AXES[: each.biases]]
            self.units += [each.bias_unit(rate)] * each.biases
        self.names = [f"{group}.{axis}" for group, axis in names]
        self.unit_array = np.array(self.units)

    def state(self, x: np.ndarray) -> BodyState:
        """The state that x stands for."""
        reference, values = self.reference, self._values(x)
        attitude = rotations.product(reference.attitude, exponential(values["attitude"]))
        turn = exponential(values["principal_axes"])
        axes = reference.axes
        if values["principal_axes"].any():
            axes = rotations.rotate(turn, axes)
        moments = reference.moments * np.exp(values["moments"])
        rate = reference.rate + values["angular_velocity"]
        return replace(reference, attitude=attitude, rate=rate, moments=moments, axes=axes)

    def _values(self, x: np.ndarray) -> dict[str, np.ndarray]:
        """(3,) of every group, in SI units; zeros of those that are not estimated."""
        values = {group: np.zeros(3) for group in GROUPS}
        scaled = x * self.unit_array
        for group, columns in self.columns.items():
            values[group][self.free if group == "moments" else slice(None)] = scaled[columns]
        return values

    def coordinates(self, state: BodyState) -> np.ndarray:
        """The x of a state, but for what is not estimated, and biases (zero)."""
        reference = self.reference
        cosines = reference.axes @ state.axes.T
        order = np.argmax(np.abs(cosines), axis=1)  # axes have neither an order nor a sense
        axes = state.axes[order] * np.sign(cosines[range(3), order])[:, None]
        turn = rotations.from_matrix(axes.T @ reference.axes)
        ratios = state.moments[order] / reference.moments
        values = {
            "attitude": rotations.rotation_vectors(reference.attitude, state.attitude),
            "angular_velocity": state.rate - reference.rate,
            "principal_axes": rotations.rotation_vectors(np.array([1.0, 0.0, 0.0, 0.0]), turn),
            "moments": np.log(ratios[self.free] / ratios[self.kept]),
        }
        x = np.zeros(len(self.names))
        for group, columns in self.columns.items():
            x[columns] = values[group]
        return x / self.unit_array

    def physical(self, x: np.ndarray) -> Quantities:
        """What is estimated, three numbers of each group, at x.

        Attitude and principal axes are relative to the state of x, as small rotations about body axes.
        """
        state = self.state(x)
        values = np.concatenate([np.zeros(3), state.rate, state.moments, np.zeros(3)])
        rows = [3 * GROUPS.index(group) + i for group in self.groups for i in range(3)]
        biases = [column for columns in self.bias_columns for column in columns]
        return Quantities(
            tuple([f"{GROUPS[row // 3]}.{AXES[row % 3]}" for row in rows] + [self.names[i] for i in biases]),
            np.append(values[rows], (x * self.unit_array)[biases]),
            np.concatenate([self._chart(x)[rows], np.diag(self.unit_array)[biases]]),
        )

    def biases(self, x: np.ndarray) -> list[np.ndarray]:
        """The biases of every set, in SI units; empty of a set that has none."""
        return [(x * self.unit_array)[columns] for columns in self.bias_columns]

    def input_matrix(self, x: np.ndarray) -> np.ndarray:
        """(12, p): the columns of `motion.partials` by x, inertia as in `inertia_form`."""
        matrix, state = self._chart(x), self.state(x)
        if state.inertia_form == "tensor":
            matrix[6:] = state.tensor_columns @ matrix[6:]
        return matrix

    def _chart(self, x: np.ndarray) -> np.ndarray:
        """(12, p): small rotation, rate, moments, and turn of the axes about body axes, by x."""
        values, matrix = self._values(x), np.zeros((12, len(x)))
        blocks = {
            "attitude": _right_jacobian(values["attitude"]),
            "angular_velocity": np.eye(3),
            "moments": np.diag(self.state(x).moments)[:, self.free],
            "principal_axes": _right_jacobian(values["principal_axes"]).T,
        }
        for group, columns in self.columns.items():
            first = 3 * GROUPS.index(group)
            matrix[first : first + 3, columns] = blocks[group]
        return matrix * self.unit_array


def exponential(vectors: np.ndarray) -> np.ndarray:
    """(..., 4) wxyz of rotation vectors (..., 3)."""
    half = 0.5 * np.sqrt((vectors**2).sum(axis=-1, keepdims=True))
    return np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * vectors], axis=-1)


def _right_jacobian(vector: np.ndarray) -> np.ndarray:
    """(3, 3) J of exp(v + dv) = exp(v) exp(J dv), to first order."""
    angle, cross = np.sqrt(vector @ vector), cross_matrix(vector)
    if angle < SMALL_ANGLE:
        return np.eye(3) - 0.5 * cross + cross @ cross / 6.0
    linear = (1.0 - np.cos(angle)) / angle**2
    return np.eye(3) - linear * cross + (angle - np.sin(angle)) / angle**3 * (cross @ cross)
