"""Flat plates that represent a body's surface, for sunlight and for drag."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from .. import stopping
from ..documents.fields import Number, Part
from ..documents.quantities import ABOVE_ZERO, Area, Direction, LengthVector, unit_vector
from ..errors import InputError

DIRECTION_COUNT = 5_000
# No direction is farther than this from one of directions(), rad (a test measures it).
COVERING = 2.6 / math.sqrt(DIRECTION_COUNT)
Fraction = Annotated[Number, Field(ge=0.0, le=1.0)]


class Plate(Part):
    """`area`; outward `normal`; `centre` of pressure from the centre of mass; both along the body's axes.

    One side of it: light and flow on its back have no effect, and no plate shades another.
    """

    area: Annotated[Area, ABOVE_ZERO]
    normal: Direction
    centre: LengthVector

    def along(self, axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(unit normal, centre in m) in components along the rows of axes."""
        return axes @ unit_vector(self.normal, "normal"), axes @ self.centre.si

    def surface(self) -> tuple[float, float, float]:
        """(area in m2, specular, diffuse): the force on it, for a pressure of 1, is that of sunlight."""
        raise NotImplementedError


class OpticalPlate(Plate):
    """`specular` and `diffuse`: the fractions of the light that it reflects so; the rest it absorbs."""

    specular: Fraction = 0.0
    diffuse: Fraction = 0.0

    @model_validator(mode="after")
    def _check_light(self) -> OpticalPlate:
        if self.specular + self.diffuse > 1.0:
            expected = f"at most {1.0 - self.specular!r}, since specular + diffuse is at most 1"
            raise InputError("diffuse", self.diffuse, expected)
        return self

    def surface(self) -> tuple[float, float, float]:
        """Its own numbers."""
        return self.area.si, self.specular, self.diffuse


class DragPlate(Plate):
    """`coefficient`: of drag; 2 where the molecules stick to the plate."""

    coefficient: Annotated[Number, Field(gt=0.0, le=1e6)] = 2.0

    def surface(self) -> tuple[float, float, float]:
        """Area times drag coefficient, absorbing: the force on it is that of drag."""
        return self.area.si * self.coefficient, 0.0, 0.0


class Surfaces(NamedTuple):
    """Plates as arrays: normals, centres (n, 3); areas, specular, diffuse (n,).

    The force on a lit plate, for a pressure of 1, the source in direction s (unit), c = n . s > 0:
    -area c ((1 - specular) s + 2 (specular c + diffuse / 3) n)   (Wertz 1978, eq. 17-66)
    """

    normals: np.ndarray
    centres: np.ndarray
    areas: np.ndarray
    specular: np.ndarray
    diffuse: np.ndarray

    @classmethod
    def of(cls, plates: Sequence[Plate]) -> Surfaces:
        """Return the surfaces of plates."""
        normals, centres = (
            np.array(part) for part in zip(*(p.along(np.eye(3)) for p in plates), strict=True)
        )
        return cls(normals, centres, *np.array([plate.surface() for plate in plates]).T)

    def torque(self, towards: np.ndarray) -> np.ndarray:
        """(m, 3) m3, for a pressure of 1 from the directions (m, 3)."""
        cosine = np.maximum(towards @ self.normals.T, 0.0)
        along = self.areas * cosine * (1.0 - self.specular)
        inwards = 2.0 * self.areas * cosine * (self.specular * cosine + self.diffuse / 3.0)
        # c x (along s + inwards n), summed over plates
        return -np.cross(along @ self.centres, towards) - inwards @ np.cross(self.centres, self.normals)

    def greatest_torque(self) -> float:
        """Upper bound over all directions, m3, for a pressure of 1.

        The greatest of DIRECTION_COUNT directions, and what it may grow by between them: the force changes
        by at most area (1 + specular + 2/3 diffuse) for each radian.  A few percent above the maximum.
        """
        steepest = self.areas * (1.0 + self.specular + 2.0 / 3.0 * self.diffuse)
        reach = float(steepest @ np.linalg.norm(self.centres, axis=1))
        if reach == 0.0:
            return 0.0
        greatest = 0.0
        step = max(1, (1 << 18) // len(self.areas))  # directions in an array
        for first in range(0, DIRECTION_COUNT, step):
            stopping.check()
            torques = self.torque(directions()[first : first + step])
            greatest = max(greatest, float(np.sqrt((torques**2).sum(axis=1).max())))
        return float(min(reach, greatest + reach * COVERING))


@cache
def directions() -> np.ndarray:
    """(DIRECTION_COUNT, 3) unit vectors, evenly over the sphere: a spiral by the golden angle."""
    k = np.arange(DIRECTION_COUNT) + 0.5
    z, longitude = 1.0 - 2.0 * k / DIRECTION_COUNT, math.pi * (3.0 - math.sqrt(5.0)) * k
    across = np.sqrt(1.0 - z * z)
    spiral = np.stack([across * np.cos(longitude), across * np.sin(longitude), z], axis=1)
    spiral.flags.writeable = False
    return spiral
