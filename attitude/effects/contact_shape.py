"""The shape of a body that falls on the ground."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from .. import units
from ..documents.fields import Number, Part, Vector, exactly_one
from ..documents.quantities import GREATEST
from ..dynamics import contact
from ..errors import InputError

Positive = Annotated[Number, Field(gt=0.0)]


class Cylinder(Part):
    """`radius`, `height` and the body axis ("x", "y" or "z") of a cylinder."""

    radius: Positive
    height: Positive
    axis: Literal["x", "y", "z"]


class Shape(Part):
    """`box` (edges along the body axes), `cylinder`, `sphere` (radius) or `vertices`, in a `unit` of length.

    `centre`: from the centre of mass to the middle of the shape, or to the origin of the vertices.
    """

    box: Annotated[list[Positive], Field(min_length=3, max_length=3)] | None = None
    cylinder: Cylinder | None = None
    sphere: Positive | None = None
    vertices: list[Vector] | None = Field(None, fail_fast=True)
    centre: Vector | None = None
    unit: str = Field(examples=["m"])

    @model_validator(mode="after")
    def _check(self) -> Shape:
        form = exactly_one(self, ("box", "cylinder", "sphere", "vertices"))
        factor = units.parse_unit(self.unit, units.LENGTH, "unit")
        value = getattr(self, form)
        lengths = [value.radius, value.height] if isinstance(value, Cylinder) else value
        with np.errstate(over="ignore"):
            size = float(np.abs(np.concatenate([np.ravel(lengths), self.centre or [0.0]]) * factor).max())
        if not size <= GREATEST:
            raise InputError(form, value, f"magnitudes up to {GREATEST:g} m")
        if form == "vertices":
            _check_vertices(self.hull().corners, value)
        elif not self._holds_centre_of_mass():
            raise InputError("centre", self.centre, f"the centre of mass inside the {form}")
        return self

    def hull(self) -> contact.RoundedHull:
        """Return the shape in m, from the centre of mass, as the solver takes it."""
        factor = units.parse_unit(self.unit, units.LENGTH, "unit")
        centre = np.array(self.centre or [0.0, 0.0, 0.0]) * factor
        if self.cylinder is not None:
            radius, height = self.cylinder.radius * factor, self.cylinder.height * factor
            return contact.cylinder(radius, height, np.eye(3)["xyz".index(self.cylinder.axis)], centre)
        if self.sphere is not None:
            return contact.sphere(self.sphere * factor, centre)
        if self.box is not None:
            return contact.box(np.array(self.box) * factor, centre)
        return contact.RoundedHull(centre + np.array(self.vertices).reshape(-1, 3) * factor)

    def _holds_centre_of_mass(self) -> bool:
        """Whether the centre of mass is inside a box, cylinder or sphere."""
        centre = np.array(self.centre or [0.0, 0.0, 0.0])
        if self.box is not None:
            return bool((np.abs(centre) < 0.5 * np.array(self.box)).all())
        if self.cylinder is not None:
            axial = "xyz".index(self.cylinder.axis)
            radial = float(np.linalg.norm(np.delete(centre, axial)))
            return radial < self.cylinder.radius and bool(abs(centre[axial]) < 0.5 * self.cylinder.height)
        return self.sphere is not None and float(np.linalg.norm(centre)) < self.sphere


def _check_vertices(points: np.ndarray, vertices: list[list[float]]) -> None:
    """Refuse fewer than four, all in one plane, or the centre of mass outside their convex hull."""
    if len(points) < 4:
        raise InputError("vertices", vertices, "at least 4 vertices")
    extents = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if extents[2] <= 1e-9 * extents[0]:
        raise InputError("vertices", vertices, "vertices that do not all lie in one plane")
    from scipy.spatial import ConvexHull

    scale = np.abs(points).max()
    offsets = ConvexHull(points / scale).equations[:, 3]  # of the origin over each face, positive outside
    if not offsets.max() < 0.0:
        expected = "the centre of mass (the origin) inside the hull of the vertices"
        raise InputError("vertices", vertices, expected)
