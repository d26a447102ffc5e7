"""The uncertainty of a scene's body and initial state, as documents state it."""

from __future__ import annotations

import numpy as np
from pydantic import model_validator

from ..documents.fields import Number, Part
from ..documents.quantities import AngleVector, MomentVector, RateVector
from ..errors import InputError
from ..rigid_body.body import RigidBody

NAMES = ("attitude", "angular_velocity", "moments", "axes")
# Of a correlation: what a symmetric, positive matrix may lack by rounding.
ROUNDING = 1e-9


class UncertaintyForm(Part):
    """1 sigma of what is given, or its `covariance`; what is not named is exact.

    `attitude`: small rotation about the body axes; `angular_velocity`: components in the body frame;
    `moments`: principal moments; `axes`: small turns of the principal axes about the body axes.
    `covariance`: of these four, in this order and in SI units (rad, rad/s, kg m2, rad); the first 6, 9 or
    all 12 rows.
    """

    attitude: AngleVector | None = None
    angular_velocity: RateVector | None = None
    moments: MomentVector | None = None
    axes: AngleVector | None = None
    covariance: list[list[Number]] | None = None

    @model_validator(mode="after")
    def _check(self) -> UncertaintyForm:
        stated = [name for name in NAMES if getattr(self, name) is not None]
        if self.covariance is not None and stated:
            raise InputError(
                stated[0], "a value", f"no {stated[0]} beside covariance: it would be said twice"
            )
        if self.covariance is None and not stated:
            raise InputError("attitude", None, f"at least one of {', '.join(NAMES)}, or a covariance")
        for name in stated:
            value = getattr(self, name).value
            if min(value) < 0.0:
                raise InputError(f"{name}.value", value, "standard deviations, zero or greater")
        if self.covariance is not None:
            self._check_covariance(self.covariance)
        return self

    def _check_covariance(self, rows: list[list[float]]) -> None:
        size = len(rows)
        if size not in (6, 9, 12) or any(len(row) != size for row in rows):
            shape = f"{size} rows of {sorted({len(row) for row in rows})}"
            raise InputError("covariance", shape, "a square matrix of 6, 9 or 12 rows")
        matrix = np.array(rows, dtype=float)
        variances = np.diagonal(matrix)
        if variances.min() < 0.0:
            raise InputError(
                "covariance", float(variances.min()), "variances, zero or greater, on its diagonal"
            )
        sigma = np.sqrt(np.where(variances > 0.0, variances, 1.0))
        correlation = matrix / sigma[:, None] / sigma
        if np.abs(correlation - correlation.T).max() > ROUNDING:
            i, j = np.unravel_index(np.abs(correlation - correlation.T).argmax(), matrix.shape)
            raise InputError(f"covariance[{i}][{j}]", rows[i][j], f"its mirrored element, {rows[j][i]!r}")
        least = float(np.linalg.eigvalsh(0.5 * (correlation + correlation.T))[0])
        if least < -ROUNDING:
            expected = "a positive semidefinite matrix (its correlation has no negative eigenvalue)"
            raise InputError("covariance", f"least eigenvalue of the correlation {least:.3g}", expected)

    def build(self, body: RigidBody) -> np.ndarray:
        """(12, 12), SI.  Raises InputError for moments that are less than four times their 1 sigma."""
        covariance = np.zeros((12, 12))
        if self.covariance is not None:
            part = np.array(self.covariance, dtype=float)
            covariance[: len(part), : len(part)] = 0.5 * (part + part.T)
        else:
            for i, name in enumerate(NAMES):
                quantity = getattr(self, name)
                if quantity is not None:
                    covariance[range(3 * i, 3 * i + 3), range(3 * i, 3 * i + 3)] = quantity.si**2
        sigma = np.sqrt(np.diagonal(covariance)[6:9])
        if (4.0 * sigma > body.moments).any():
            field = "moments" if self.covariance is None else "covariance"
            expected = f"below a quarter of the principal moments, {body.moments.tolist()} kg m2"
            raise InputError(f"uncertainty.{field}", sigma.tolist(), expected)
        return covariance
