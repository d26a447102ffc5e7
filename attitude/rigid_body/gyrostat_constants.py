"""Bodies with rotors of constant momentum: records of their motion in closed form, and samples."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar

import numpy as np

from ..errors import RegimeError
from ..kernels.layout import EXACT_SUM_LENGTH, GYROSTAT, Sum, workspace
from ..runtime import compiled
from .body import RigidBody
from .constants_of_motion import Batch, with_tensors
from .error_bounds import GYROSTAT_FORMS, gyrostat_form_of, solution


class GyrostatBatch(Batch):
    """Gyrostats with their states at the epoch, and the records of their motion (docs/gyrostats.md).

    Parameters
    ----------
    body, attitudes, rates, shape : as of `Batch`; moments are those with the rotors locked
    rotors : (..., 3), N m s, body components: momentum of the rotors relative to the body

    Raises
    ------
    RegimeError : a motion that no series here holds for: on the path to where equilibria merge, or nearer to
        an unstable one than the squares of doubles hold (1e-100).
    """

    arrays: ClassVar[tuple[str, ...]] = (*Batch.arrays, "rotors")
    sample_kernel: ClassVar = compiled.sample_gyrostats

    def __init__(
        self,
        body: RigidBody,
        attitudes: np.ndarray,
        rates: np.ndarray,
        rotors: np.ndarray,
        shape: tuple[int, ...],
    ):
        self.rotors = np.broadcast_to(rotors, (*shape, 3))
        self._condition = 1.0
        super().__init__(body, attitudes, rates, shape)

    @cached_property
    def solution(self) -> tuple[str, float]:
        """Closed forms of these bodies, and the error that was measured of them, rad."""
        name, bound = solution(self._forms, GYROSTAT_FORMS)
        return name, bound * self._condition

    def _records(self, first: int, last: int) -> np.ndarray:
        rotors = np.ascontiguousarray(self.rotors.reshape(-1, 3)[first:last])
        out = np.zeros(last - first, GYROSTAT)
        sums = np.empty((Sum.ROWS, EXACT_SUM_LENGTH))
        states = with_tensors(self._states(first, last))
        compiled.gyrostats(*states, rotors, out, sums, *workspace())
        self._forms[first:last] = gyrostat_form_of(out["regime"], out["route"], out["any_rotor"])
        self._condition = max(self._condition, float(np.max(out["boost"], initial=1.0)))
        self._refuse_lost(out, first)
        return out

    def _refuse_lost(self, records: np.ndarray, first: int) -> None:
        lost = np.zeros(len(records), bool)
        for name in ("precession", "argument", "argument0", "frame", "to_rate", "alpha_re", "beta_im"):
            lost |= ~np.isfinite(records[name]).reshape(len(records), -1).all(axis=1)
        if lost.any():
            rotors = self.rotors.reshape(-1, 3)[first + int(np.argmax(lost))].tolist()
            raise RegimeError(
                f"effects: rotors of {rotors} N m s lead this body to where equilibria merge, or too near an "
                'unstable one, and the closed form ends there; ask for "solver": "gauss"'
            )
