"""Eddy-current damping: an external torque against the rotation of the body."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from .. import units
from ..documents.fields import Matrix, Number, exactly_one
from ..documents.quantities import GREATEST
from ..errors import InputError
from ..kernels.layout import EffectCode
from ..problem.initial_state import InitialState, Spin
from .effect import BodyDependentTorque, row

# Asymmetry by rounding that is accepted, relative to the greatest element, as in a body's tensor.
SYMMETRY_TOLERANCE = 1e-12


class EddyDamping(BodyDependentTorque):
    """`{"type": "eddy_damping", "coefficient": 1e-3, "unit": "N m s"}`: torque -C omega.

    C is `coefficient` in all directions, or a `tensor` in the body frame, symmetric and with no negative
    eigenvalue.  The torque is that of a steady field on the body; energy and momentum both fall.
    """

    REASON: ClassVar[str] = (
        "takes energy and momentum; exact in a sphere, and about an axis that stands still"
    )

    type: Literal["eddy_damping"]
    coefficient: Annotated[Number, Field(ge=0.0)] | None = None
    tensor: Matrix | None = None
    unit: str = Field(examples=["N m s"])

    @model_validator(mode="after")
    def _check(self) -> EddyDamping:
        form = exactly_one(self, ("coefficient", "tensor"))
        units.parse_unit(self.unit, units.ANGULAR_IMPULSE, "unit")
        with np.errstate(over="ignore"):
            C = self.C
        if not np.abs(C).max() <= GREATEST:
            raise InputError(form, getattr(self, form), f"a magnitude up to {GREATEST:g} N m s")
        off = np.abs(C - C.T)
        if self.tensor is not None and (off > SYMMETRY_TOLERANCE * np.abs(C).max()).any():
            i, j = (int(k) for k in np.unravel_index(int(np.argmax(off)), (3, 3)))
            mirror = f"a symmetric tensor (the mirrored element is {self.tensor[j][i]!r})"
            raise InputError(f"tensor[{i}][{j}]", self.tensor[i][j], mirror)
        least = float(np.linalg.eigvalsh(C)[0])
        if least < -SYMMETRY_TOLERANCE * float(np.abs(C).max()):
            expected = f"a tensor without negative eigenvalues (one is {least:.6g} N m s)"
            raise InputError("tensor", self.tensor, expected)
        return self

    @property
    def C(self) -> np.ndarray:
        """(3, 3), N m s, body frame."""
        values = np.eye(3) * (self.coefficient or 0.0) if self.tensor is None else np.array(self.tensor)
        return values * units.parse_unit(self.unit, units.ANGULAR_IMPULSE, "unit")

    def rows(self, initial_state: InitialState) -> np.ndarray:
        """One row: C along the principal axes."""
        C = initial_state.axes @ self.C @ initial_state.axes.T
        return row(EffectCode.EDDY, 0.5 * (C + C.T))[None]

    def sizes(self, initial_state: InitialState, moments: np.ndarray, spin: Spin) -> np.ndarray:
        """Greatest eigenvalue of C times the greatest rate."""
        return float(np.linalg.eigvalsh(self.C)[-1]) * spin.rate
