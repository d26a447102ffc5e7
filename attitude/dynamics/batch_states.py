"""A block of bodies with their states at the epoch, and the problem that all of them pose to the solvers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property, wraps
from typing import Any, TypeVar

import numpy as np

from ..errors import InputError, RegimeError, ToleranceError
from ..problem.initial_state import InitialState
from ..problem.torque_model import AppliedImpulse, CachedTorque
from ..rigid_body.body import RigidBody
from .arcs import Arc, arcs_by_direction

Result = TypeVar("Result")


@dataclass(frozen=True)
class Bodies:
    """Bodies with their states at the epoch; the body of a scene is a block of one.

    Attributes
    ----------
    body : RigidBody, (n,)
    attitude : (n, 4) wxyz, body to inertial; rate : (n, 3) rad/s, body components; both at t = 0
    index : (n,), by which errors name them, or None for the body of a scene
    results : what `once_for_bodies` keeps
    """

    body: RigidBody
    attitude: np.ndarray
    rate: np.ndarray
    index: np.ndarray | None = None
    results: dict[Any, Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    @classmethod
    def of(cls, initial_state: InitialState) -> Bodies:
        """The body of a scene, as a block of one."""
        body = initial_state.body.broadcast_to((1,))
        return cls(body, np.asarray(initial_state.attitude)[None], np.asarray(initial_state.rate)[None])

    def __len__(self) -> int:
        return len(self.rate)

    def __getitem__(self, which: np.ndarray | slice) -> Bodies:
        index = None if self.index is None else self.index[which]
        return Bodies(self.body[which], self.attitude[which], self.rate[which], index)

    def initial_state(self, template: InitialState, i: int) -> InitialState:
        """The state of one of the bodies, in the surroundings and span of the template."""
        return replace(template, body=self.body[i], attitude=self.attitude[i], rate=self.rate[i])

    @cached_property
    def axes(self) -> np.ndarray:
        """(n, 3, 3): rows are the principal axes, right-handed, in the order of the moments."""
        return right_handed(np.array(self.body.axes))


def once_for_bodies(function: Callable[..., Result]) -> Callable[..., Result]:
    """A function of (template, bodies, torques, ...) that is computed once for the same objects.

    The trial, the solution and the coarser one beside it start from the same numbers.
    """

    @wraps(function)
    def kept(template: InitialState, bodies: Bodies, torques: Sequence[Any], *more: Sequence[Any]) -> Result:
        objects = (template, *torques, *(each for sequence in more for each in sequence))
        key = (function, *map(id, objects))
        if key not in bodies.results:  # the objects are kept too: their ids are then nobody else's
            bodies.results[key] = objects, function(template, bodies, torques, *more)
        result: Result = bodies.results[key][1]
        return result

    return kept


def right_handed(axes: np.ndarray) -> np.ndarray:
    """(n, 3, 3): the same axes, the third one along the product of the others; changed in place."""
    first, second = axes[:, 0], axes[:, 1]
    axes[:, 2] = first[:, [1, 2, 0]] * second[:, [2, 0, 1]] - first[:, [2, 0, 1]] * second[:, [1, 2, 0]]
    return axes


@contextmanager
def named(bodies: Bodies, i: int, lost: list[int] | None = None) -> Iterator[None]:
    """Errors raised within name the body by its index; the body of a scene needs no name.

    lost : takes the index of a body that cannot be computed to the tolerance, in place of an error
    """
    if bodies.index is None:
        yield
        return
    index = int(bodies.index[i])
    try:
        yield
    except InputError as error:
        raise InputError(f"bodies[{index}].{error.field}", error.value, error.expected) from None
    except (ToleranceError, RegimeError) as error:
        if lost is None:
            raise type(error)(f"bodies[{index}]: {error}") from None
        lost.append(index)


@dataclass(frozen=True)
class TorqueProblem:
    """Motion under torques: what all bodies have in common.

    Attributes
    ----------
    template : surroundings and span of all bodies; its own body and state are the scene's
    torques, impulses : what acts on the bodies
    tolerance : rad
    best : whether an answer that does not reach it is wanted too
    """

    template: InitialState
    torques: tuple[CachedTorque, ...]
    impulses: tuple[AppliedImpulse, ...] = ()
    tolerance: float = 0.0
    best: bool = False

    @cached_property
    def body(self) -> Bodies:
        """The scene's own body."""
        return Bodies.of(self.template)

    @cached_property
    def refined(self) -> TorqueProblem:
        """The same problem with orbit and density off by their errors; itself where both are exact."""
        path, template = self.template.orbit_path, self.template
        if path is None or (
            path.refined is None and not any(torque.air(template) for torque in self.torques)
        ):
            return self
        template = replace(template, orbit_path=path.refined or path, refined=True)
        torques = tuple(CachedTorque(torque.effect, template) for torque in self.torques)
        return replace(self, template=template, torques=torques)

    @cached_property
    def arcs(self) -> list[list[Arc]]:
        """The span cut where torques or the momentum change: backwards and forwards, as far as it goes."""
        return arcs_by_direction(self.template, self.torques, self.impulses)

    def over(self, start: float, stop: float) -> TorqueProblem:
        """The same problem over another span, s."""
        return replace(self, template=replace(self.template, start=start, stop=stop))

    @property
    def max_abs_seconds(self) -> float:
        """The longest time from the epoch to an end of the span, s."""
        return max(abs(self.template.start), abs(self.template.stop))
