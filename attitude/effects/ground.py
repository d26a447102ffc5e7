"""The ground: a plane that the body bounces on."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from ..documents.fields import Number
from ..documents.quantities import Direction, Length, unit_vector
from ..dynamics.contact import MAX_RELATIVE_DEPTH, GroundPlane
from ..errors import InputError
from ..problem.initial_state import InitialState
from .contact_shape import Shape
from .effect import Effect


class Ground(Effect):
    """`{"type": "ground", "normal": [0, 0, 1], "height": {"value": 0, "unit": "m"}, "shape": {...}, ...}`.

    `normal`: upwards, inertial; `height`: of the plane along it from the origin; `friction`: Coulomb's
    coefficient.  `restitution`: Poisson's, 0 to 1: the normal impulse of restitution over that of
    compression.  A single point without friction leaves with that part of the normal speed it
    approached with; with friction, or where several touch, it may leave faster or slower.
    """

    ACTS_ON: ClassVar[Literal["translation", "instants", "attitude"]] = "instants"
    REASON: ClassVar[str] = "contacts change the momentum at an instant; between them the closed form holds"

    type: Literal["ground"]
    normal: Direction
    height: Length
    shape: Shape
    restitution: Annotated[Number, Field(ge=0.0, le=1.0)]
    friction: Annotated[Number, Field(ge=0.0, le=1e6)]

    def plane(self) -> GroundPlane:
        """Return the plane and the body's shape as the solver takes them."""
        normal = unit_vector(self.normal, "normal")
        return GroundPlane(normal, self.height.si, self.shape.hull(), self.restitution, self.friction)

    def clearance(self, initial_state: InitialState) -> float:
        """Height of the body's lowest point above the plane at the epoch, m."""
        if initial_state.position is None:
            raise InputError("position", None, "a position of the body")
        return float(self.plane().clearance(initial_state.attitude, initial_state.position))

    def check(self, initial_state: InitialState) -> None:
        """Refuse a body that is in the ground at the epoch."""
        clearance = self.clearance(initial_state)
        if clearance < -MAX_RELATIVE_DEPTH * self.shape.hull().size:
            above = f"a plane below the body at the epoch (its lowest point is {-clearance:.6g} m under it)"
            raise InputError("height.value", self.height.value, above)
