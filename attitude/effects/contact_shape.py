"""The shape of a body that falls on the ground."""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from .. import units
from ..documents.fields import Number, Part, Vector, exactly_one
from ..documents.quantities import GREATEST
from ..errors import InputError

Positive = Annotated[Number, Field(gt=0.0)]
# Vertices whose third extent is smaller than this part of the first lie in one plane.
FLATTEST = 1e-9


class Solid(NamedTuple):
    """A convex shape in numbers, m, body frame, from the centre of mass.

    Attributes
    ----------
    points : (n, 3); vertices, or for round shapes the one at the centre
    radius : of the cylinder or sphere about points[0]; 0 for vertices
    half_height : of the cylinder; 0 for others
    axis : (3,) unit vector of the cylinder; zeros for others
    """

    points: np.ndarray
    radius: float
    half_height: float
    axis: np.ndarray

    def reach(self, direction: np.ndarray) -> float:
        """m: how far it reaches in a direction (3,), unit, body frame: its support function."""
        corner = float((self.points @ direction).max())
        if not self.axis.any():
            return corner + self.radius
        along = float(self.axis @ direction)
        across = float(np.linalg.norm(np.cross(self.axis, direction)))
        return corner + self.half_height * abs(along) + self.radius * across

    @property
    def size(self) -> float:
        """m: how far its farthest point is from the centre of mass, or little more."""
        farthest = float(np.sqrt((self.points**2).sum(axis=1).max()))
        return farthest + float(np.hypot(self.radius, self.half_height))


class Cylinder(Part):
    """Its `radius`, `height` and the body axis ("x", "y" or "z") that it stands along."""

    radius: Positive
    height: Positive
    axis: Literal["x", "y", "z"]


class Shape(Part):
    """`box` (edges along the body axes), `cylinder`, `sphere` (radius) or `vertices`, in a `unit` of length.

    `centre`: from the centre of mass to the middle of the shape, or to where vertices are counted from.
    """

    box: Annotated[list[Positive], Field(min_length=3, max_length=3)] | None = None
    cylinder: Cylinder | None = None
    sphere: Positive | None = None
    vertices: list[Vector] | None = None
    centre: Vector | None = None
    unit: str = Field(examples=["m"])

    @model_validator(mode="after")
    def _check(self) -> Shape:
        form = exactly_one(self, ("box", "cylinder", "sphere", "vertices"))
        units.parse_unit(self.unit, units.LENGTH, "unit")
        with np.errstate(over="ignore"):
            numbers = np.concatenate([np.ravel(_numbers(getattr(self, form))), self.centre or [0.0]])
            size = float(np.abs(numbers * self._factor).max())
        if not size <= GREATEST:
            raise InputError(form, getattr(self, form), f"magnitudes up to {GREATEST:g} m")
        solid = self.solid()
        if form == "vertices":
            _check_vertices(solid.points, self.vertices)
        elif not self._holds_centre(solid):
            raise InputError("centre", self.centre, f"the centre of mass inside the {form}")
        return self

    @property
    def _factor(self) -> float:
        return units.parse_unit(self.unit, units.LENGTH, "unit")

    def solid(self) -> Solid:
        centre = np.array(self.centre or [0.0, 0.0, 0.0]) * self._factor
        none = np.zeros(3)
        if self.cylinder is not None:
            axis = np.eye(3)["xyz".index(self.cylinder.axis)]
            half = 0.5 * self.cylinder.height * self._factor
            return Solid(centre[None], self.cylinder.radius * self._factor, half, axis)
        if self.sphere is not None:
            return Solid(centre[None], self.sphere * self._factor, 0.0, none)
        if self.box is not None:
            signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
            return Solid(centre + 0.5 * signs * np.array(self.box) * self._factor, 0.0, 0.0, none)
        return Solid(centre + np.array(self.vertices).reshape(-1, 3) * self._factor, 0.0, 0.0, none)

    def _holds_centre(self, solid: Solid) -> bool:
        """Whether the centre of mass is inside a box, cylinder or sphere."""
        if self.box is not None:
            return bool(
                (np.abs(solid.points.sum(axis=0) / 8.0) < 0.5 * np.array(self.box) * self._factor).all()
            )
        along = float(solid.points[0] @ solid.axis)
        across = float(np.linalg.norm(solid.points[0] - along * solid.axis))
        return across < solid.radius and (abs(along) < solid.half_height or not solid.axis.any())


def _numbers(value: Any) -> Any:
    return [value.radius, value.height] if isinstance(value, Cylinder) else value


def _check_vertices(points: np.ndarray, given: Any) -> None:
    """At least four, not in one plane, and the centre of mass inside their convex hull."""
    if len(points) < 4:
        raise InputError("vertices", given, "at least 4 vertices")
    extents = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if extents[2] <= FLATTEST * extents[0]:
        raise InputError("vertices", given, "vertices that do not all lie in one plane")
    from scipy.spatial import ConvexHull

    scale = np.abs(points).max()
    offsets = ConvexHull(points / scale).equations[:, 3]  # of the origin over each face, positive outside
    if not offsets.max() < 0.0:
        raise InputError("vertices", given, "the centre of mass (the origin) inside the hull of the vertices")
