"""Density of a body axis on the sphere: numbers of bodies in cells of equal area."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import InputError
from ..frames import rotations
from ..scene.scene import Scene
from ..times.instants import Instants
from .block_motion import motion_of
from .redraws import Redraws, note
from .sources.states import StateSource

ROWS, COLUMNS = 60, 120  # of equal steps in z, and in longitude
BODY_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
PRINCIPAL = ("least", "middle", "greatest")
AXES = f"one of {', '.join([*BODY_AXES, *PRINCIPAL])} (moment), or three numbers that are not all zero"


class AxisDensity:
    """Numbers of bodies by the cell of the sphere that an axis of theirs points to.

    Attributes
    ----------
    axis : (3,), unit, body frame
    instants : the instants, m of them; frame : the inertial frame
    count : bodies, without those that are lost
    lost : indices of bodies that could not be integrated, and were left out
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
        """(m, ROWS, COLUMNS): divided by that of uniformly distributed axes."""
        return self.counts * (ROWS * COLUMNS / self.count)

    @property
    def covered(self) -> np.ndarray:
        """(m,): the smallest fraction of the sphere, of whole cells, that has 95 % of the bodies."""
        cells = -np.sort(-self.counts.reshape(len(self.counts), -1), axis=1)
        needed = (np.cumsum(cells, axis=1) < 0.95 * self.count).sum(axis=1) + 1
        return needed / (ROWS * COLUMNS)

    def __repr__(self) -> str:
        size = f"{self.count} bodies at {len(self.counts)} instants"
        return f"<AxisDensity: {size}, {self.frame}{note(self.redraws)}>"


def axis_of(axis: Any, scene: Scene | None) -> np.ndarray:
    """Return the unit vector (3,) of a body axis, a principal axis of the scene's body, or any vector.

    Raises InputError for an axis that is none of these.
    """
    if isinstance(axis, str):
        if axis in BODY_AXES:
            return np.array(BODY_AXES[axis])
        if axis not in PRINCIPAL or scene is None:
            raise InputError("axis", axis, AXES if scene is not None else f"one of {', '.join(BODY_AXES)}")
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
class CellCounter:
    """The work of a task: called with (first, last), it counts these bodies by cell and instant.

    It gives counts (m, cells), and the indices of bodies that were left out.
    """

    source: StateSource
    scene: Scene | None
    choice: Any
    instants: Instants
    axis: np.ndarray
    leave_out: bool = False

    def __call__(self, bodies: tuple[int, int]) -> tuple[np.ndarray, list[int]]:
        """Return counts and left-out bodies of those from first to last."""
        counts = np.zeros((self.instants.seconds.size, ROWS * COLUMNS), np.int64)
        size, lost = max(2**18 // len(counts), 1), list[int]()  # attitudes of 8 MiB at a time
        for first in range(*bodies, size):
            states = self.source.part(first, min(first + size, bodies[1]))
            motion = motion_of(self.scene, states, self.instants, first, False, self.choice, self.leave_out)
            lost += motion.lost
            cells = cell_of(rotations.rotate(motion.quaternion, self.axis))
            for cells_then, counts_then in zip(cells.T, counts, strict=True):
                np.add(counts_then, np.bincount(cells_then, minlength=ROWS * COLUMNS), out=counts_then)
        return counts, lost


def cell_of(directions: np.ndarray) -> np.ndarray:
    """(...): index of the cell, row by row, of unit vectors (..., 3), eq. (E8)."""
    x, y, z = np.moveaxis(directions, -1, 0)
    row = np.floor((0.5 * ROWS) * (z + 1.0)).astype(np.int64)
    column = np.floor(COLUMNS * (np.arctan2(y, x) / (2.0 * np.pi) + 0.5)).astype(np.int64)
    return np.clip(row, 0, ROWS - 1) * COLUMNS + np.clip(column, 0, COLUMNS - 1)
