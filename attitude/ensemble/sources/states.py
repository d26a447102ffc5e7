"""States of bodies at the epoch, and the protocol of their sources."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from astropy import units as u
from astropy.table import QTable

from ...errors import InputError
from ...frames import rotations
from ...rigid_body.body import RigidBody

MAX_BODIES = 2**33  # the sums of statistics hold no more in 64 bits (kernels.layout.BODIES_PER_BLOCK)


@dataclass(frozen=True)
class States:
    """Bodies, and their attitudes and rates at the epoch.

    Attributes
    ----------
    body : RigidBody, of shape (n,)
    attitude : (n, 4), wxyz, body to inertial; of unit length within 1e-6
    angular_velocity : (n, 3), rad/s, body frame
    """

    body: RigidBody
    attitude: np.ndarray
    angular_velocity: np.ndarray

    def __len__(self) -> int:
        return len(self.attitude)

    def __getitem__(self, part: slice) -> States:
        return States(self.body[part], self.attitude[part], self.angular_velocity[part])

    def to_table(self) -> QTable:
        """Columns moments or tensor [kg m2], quaternion (w, x, y, z), angular_velocity [rad/s]."""
        table = QTable(meta={"quaternion_order": "wxyz"})
        if self.body._tensor is None:
            table["moments"] = self.body.moments * (u.kg * u.m**2)
        else:
            table["tensor"] = self.body.tensor * (u.kg * u.m**2)
        table["quaternion"] = rotations.in_order(self.attitude, "wxyz")
        table["angular_velocity"] = self.angular_velocity * (u.rad / u.s)
        return table


class StateSource(Protocol):
    """A source of states; picklable, and small, for it is sent to the workers."""

    @property
    def size(self) -> int:
        """Number of bodies."""

    def part(self, first: int, last: int) -> States:
        """States of the bodies from first to last, the last one excluded: the same bits in any part."""


def check_range(first: int, last: int, size: int) -> tuple[int, int]:
    """Return (first, last).  Raises InputError unless 0 <= first < last <= size."""
    if not 0 <= first < last <= size:
        raise InputError("bodies", f"{first} to {last}", f"first and last of {size} bodies, first below last")
    return first, last
