"""Attitude records of a CK, and rotation at a constant rate, which its readers interpolate with."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...errors import InputError
from ...frames import rotations

MAX_ID = 2**31 - 1
MAX_ATTITUDE_MISMATCH = 1e-9  # rad; intervals of type 2 that differ by less are continuous


class CkRecords(NamedTuple):
    """Records at n instants.

    ticks : (n,)
    quaternion : (n, 4) wxyz, of this library's convention
    velocity : (n, 3) rad/s, inertial components, or None
    """

    ticks: np.ndarray
    quaternion: np.ndarray
    velocity: np.ndarray | None

    @property
    def c_quaternion(self) -> np.ndarray:
        """(n, 4) quaternions of SPICE's C-matrices, contiguous as CSPICE takes them."""
        return np.ascontiguousarray(rotations.conjugate(self.quaternion))

    @property
    def packets(self) -> np.ndarray:
        """(n, 8): those and their derivatives, dq/dt = Omega q / 2 with inertial components of Omega."""
        assert self.velocity is not None
        q = rotations.sign_continuous(self.quaternion)
        pure = np.concatenate([np.zeros((len(q), 1)), self.velocity], axis=1)
        packets = [rotations.conjugate(part) for part in (q, 0.5 * rotations.product(pure, q))]
        return np.ascontiguousarray(np.concatenate(packets, axis=1))

    @property
    def rates_between(self) -> np.ndarray:
        """(n - 1, 3) rad a tick, inertial: constant rates from each attitude to the next, the shorter way."""
        q = self.quaternion
        step = rotations.product(q[1:], rotations.conjugate(q[:-1]))
        step = np.where(step[:, :1] < 0.0, -step, step)
        size = np.sqrt((step[:, 1:] ** 2).sum(axis=1))
        angle = 2.0 * np.arctan2(size, step[:, 0])
        scale = np.divide(angle, size, out=np.full_like(size, 2.0), where=size > 0.0)
        return step[:, 1:] * (scale / np.diff(self.ticks))[:, None]

    def part(self, key: Any) -> CkRecords:
        """Part of the records: at an index, a slice or a mask."""
        velocity = None if self.velocity is None else self.velocity[key]
        return CkRecords(self.ticks[key], self.quaternion[key], velocity)


def concatenated(several: list[CkRecords]) -> CkRecords:
    """One series of records; with velocities if all have them."""
    velocities = [records.velocity for records in several if records.velocity is not None]
    return CkRecords(
        np.concatenate([records.ticks for records in several]),
        np.concatenate([records.quaternion for records in several]),
        np.concatenate(velocities) if len(velocities) == len(several) else None,
    )


def rotate_at_constant_rate(q: np.ndarray, omega: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(n, 4): q exp(omega t / 2), at a constant body rate omega, rad/s."""
    speed = np.sqrt((omega * omega).sum(axis=-1))
    half = 0.5 * speed * t
    axis = np.divide(omega, speed[..., None], out=np.zeros_like(omega), where=speed[..., None] > 0.0)
    turn = np.concatenate([np.cos(half)[:, None], np.sin(half)[:, None] * axis], axis=1)
    return rotations.product(q, turn)


def check_id(number: int, field: str) -> None:
    """Refuse what is no number of SPICE."""
    if isinstance(number, bool) or not isinstance(number, int) or not 0 < abs(number) <= MAX_ID:
        raise InputError(field, number, f"a whole number other than 0, at most {MAX_ID} either way")
