"""Where a body axis points: bodies counted in cells of the sphere, all of the same area."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import InputError
from ..frames import rotations
from ..scene.document import Scene
from ..times.instants import Instants
from .motion import motion_of
from .redraws import Redraws, note
from .sources.states import Source

ROWS, COLUMNS = 60, 120  # of equal steps in z, and in longitude
HELD = 2**18  # attitudes at a time: 8 MiB
NAMED = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
PRINCIPAL = ("least", "middle", "greatest")
AXES = f"one of {', '.join([*NAMED, *PRINCIPAL])} (moment), or three numbers that are not all zero"


class Density:
    """How many bodies have the axis in which cell.

    Attributes
    ----------
    axis : (3,), unit, body frame
    instants : the instants, m of them; frame : the inertial frame
    count : bodies, without those that are lost
    lost : places of bodies that could not be followed, and were left out
    counts : (m, ROWS, COLUMNS), int64: rows from the south pole up, equal steps of z; columns by longitude
        from -180 degrees on
    redraws : of all bodies, whose moments were drawn again; None where moments are not spread
    """

    def __init__(
        self,
        axis: np.ndarray,
        instants: Instants,
        frame: str,
        counts: np.ndarray,
        lost: Sequence[int] = (),
        redraws: Redraws | None = None,
    ):
        self.axis, self.instants, self.frame = axis, instants, frame
        self.counts, self.count = counts, int(counts[0].sum())
        self.lost, self.redraws = np.array(sorted(lost), np.int64), redraws

    @property
    def relative(self) -> np.ndarray:
        """(m, ROWS, COLUMNS): over the density of axes that point anywhere."""
        return self.counts * (ROWS * COLUMNS / self.count)

    @property
    def covered(self) -> np.ndarray:
        """(m,): the smallest part of the sphere, of whole cells, that has 95 % of the bodies."""
        cells = -np.sort(-self.counts.reshape(len(self.counts), -1), axis=1)
        needed = (np.cumsum(cells, axis=1) < 0.95 * self.count).sum(axis=1) + 1
        return needed / (ROWS * COLUMNS)

    def __repr__(self) -> str:
        said = f"{self.count} bodies at {len(self.counts)} instants, {self.frame}{note(self.redraws)}"
        return f"<Density: {said}>"


def axis_of(axis: Any, scene: Scene | None) -> np.ndarray:
    """(3,), unit: a body axis by name, a principal axis of the scene's body, or a vector along it.

    Raises InputError for what is none of these.
    """
    if isinstance(axis, str):
        if axis in NAMED:
            return np.array(NAMED[axis])
        if axis not in PRINCIPAL or scene is None:
            raise InputError("axis", axis, AXES if scene is not None else f"one of {', '.join(NAMED)}")
        body = scene.body.build()
        order = np.argsort(body.moments, kind="stable")
        return np.array(body.axes[order[PRINCIPAL.index(axis)]])
    try:
        vector = np.asarray(axis, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError("axis", axis, AXES) from None
    size = np.abs(vector).max() if vector.shape == (3,) else 0.0
    if not 0.0 < size < np.inf:
        raise InputError("axis", axis, AXES)
    vector = vector / size
    return np.asarray(vector / np.linalg.norm(vector))


@dataclass(frozen=True)
class Counting:
    """The work of a task: called with (first, last), it counts these bodies in each cell at each instant.

    It gives (m, cells), and the places of bodies that were left out.
    """

    source: Source
    scene: Scene | None
    choice: Any
    instants: Instants
    axis: np.ndarray
    leave_out: bool = False

    def __call__(self, part: tuple[int, int]) -> tuple[np.ndarray, list[int]]:
        counts = np.zeros((self.instants.seconds.size, ROWS * COLUMNS), np.int64)
        size, lost = max(HELD // len(counts), 1), list[int]()
        for first in range(*part, size):
            states = self.source.part(first, min(first + size, part[1]))
            block = motion_of(self.scene, states, self.instants, first, False, self.choice, self.leave_out)
            lost += block.lost
            cells = cell_of(rotations.rotate(block.quaternion, self.axis))
            for found, row in zip(cells.T, counts, strict=True):
                row += np.bincount(found, minlength=ROWS * COLUMNS)
        return counts, lost


def cell_of(directions: np.ndarray) -> np.ndarray:
    """(...): index of the cell, row after row, of unit vectors (..., 3)."""
    x, y, z = np.moveaxis(directions, -1, 0)
    row = np.floor((0.5 * ROWS) * (z + 1.0)).astype(np.int64)
    column = np.floor(COLUMNS * (np.arctan2(y, x) / (2.0 * np.pi) + 0.5)).astype(np.int64)
    return np.clip(row, 0, ROWS - 1) * COLUMNS + np.clip(column, 0, COLUMNS - 1)
