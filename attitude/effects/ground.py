"""The ground: a plane that the body bounces on."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from ..documents.fields import Number, Vector
from ..documents.quantities import Length, unit_vector
from ..dynamics import contact
from ..errors import InputError
from ..frames import rotations
from ..problem.initial_state import InitialState
from .contact_shape import Shape, Solid
from .effect import Effect

# Of the body's size: how far its lowest point may be below the plane, by rounding of what is given.
DEEPEST = 1e-12


class Ground(Effect):
    """`{"type": "ground", "normal": [0, 0, 1], "height": {"value": 0, "unit": "m"}, "shape": {...}, ...}`.

    `normal`: upwards, inertial; `height`: of the plane along it from the origin; `friction`: Coulomb's
    coefficient.  `restitution`: Poisson's, 0 to 1: the normal impulse that pushes a touching point off, over
    the one that stopped it.  A single point without friction leaves with that part of the normal speed it
    approached with; with friction, or where several touch, it may leave faster or slower.
    """

    ACTS_ON: ClassVar[Literal["translation", "instants", "attitude"]] = "instants"

    type: Literal["ground"]
    normal: Vector
    height: Length
    shape: Shape
    restitution: Annotated[Number, Field(ge=0.0, le=1.0)]
    friction: Annotated[Number, Field(ge=0.0, le=1e6)]

    @model_validator(mode="after")
    def _check(self) -> Ground:
        unit_vector(self.normal, "normal")
        return self

    @property
    def direction(self) -> np.ndarray:
        """(3,), the unit normal."""
        return unit_vector(self.normal, "normal")

    def solid(self) -> Solid:
        return self.shape.solid()

    def numbers(self) -> contact.Ground:
        """As the solver takes it."""
        solid = self.solid()
        if solid.axis.any():
            ends = solid.points[0] + np.outer((-solid.half_height, solid.half_height), solid.axis)
            shape = contact.Shape(ends, solid.radius, solid.axis)
        else:
            shape = contact.Shape(solid.points, solid.radius)
        return contact.Ground(self.direction, self.height.si, shape, self.restitution, self.friction)

    def clearance(self, initial_state: InitialState) -> float:
        """m: how high the body's lowest point is above the plane at the epoch."""
        if initial_state.position is None:
            raise InputError("position", None, "a position of the body")
        inverse = initial_state.attitude * np.array([1.0, -1.0, -1.0, -1.0])
        downwards = rotations.rotate(inverse, -self.direction)
        return float(self.direction @ initial_state.position) - self.solid().reach(downwards) - self.height.si

    def check(self, initial_state: InitialState) -> None:
        clearance = self.clearance(initial_state)
        if clearance < -DEEPEST * self.solid().size:
            above = f"a plane below the body at the epoch (its lowest point is {-clearance:.6g} m under it)"
            raise InputError("height.value", self.height.value, above)
