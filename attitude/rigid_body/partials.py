"""Partial derivatives of attitude and body rate by the initial state and the inertia."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InputError

INERTIA = ("moments", "tensor")
# Rows and columns of the elements Ixx, Iyy, Izz, Ixy, Ixz, Iyz.
ELEMENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def check_inertia(inertia: str) -> str:
    """Return the name; InputError for one that is not of `INERTIA`."""
    if inertia not in INERTIA:
        raise InputError("inertia", inertia, f"one of {', '.join(INERTIA)}")
    return inertia


@dataclass(frozen=True, eq=False)
class Partials:
    """Partial derivatives of a motion's attitude and body rate at instants.

    The attitude's are of the small rotation theta, rad, about the *body* axes: q_true = q exp(theta/2); the
    initial attitude's too.

    Attributes
    ----------
    matrix : (..., 6, 12), batch + instants first, SI
        Rows: theta (3, body axes, rad), body rate (3, body axes, rad/s).  Columns: theta0 (3, body axes,
        rad), initial body rate (3, body axes, rad/s), then either three principal moments (kg m2, in the
        order of `RigidBody.moments`) and three angles by which the principal axes are turned about the body
        axes while attitude and rate stay (rad); or the elements Ixx, Iyy, Izz, Ixy, Ixz, Iyz of the tensor
        (kg m2; of the matrix: Iyx is changed together with Ixy).
    inertia : "moments" or "tensor": what the last six columns are of

    Notes
    -----
    Only ratios of moments matter: the derivative along the moments themselves is zero.  Near the separatrix
    entries reach the inverse of the distance to it, and the derivatives hold for changes far below it.
    """

    matrix: np.ndarray
    inertia: str = "moments"

    def __repr__(self) -> str:
        return f"<Partials: {self.matrix.shape}, inertia by its {self.inertia}>"

    @property
    def attitude(self) -> np.ndarray:
        """(..., 3, 12): of the small rotation, rad."""
        return self.matrix[..., :3, :]

    @property
    def rate(self) -> np.ndarray:
        """(..., 3, 12): of the body rate, rad/s."""
        return self.matrix[..., 3:, :]

    @property
    def by_attitude(self) -> np.ndarray:
        """(..., 6, 3): by the initial attitude, rad."""
        return self.matrix[..., :3]

    @property
    def by_rate(self) -> np.ndarray:
        """(..., 6, 3): by the initial body rate, rad/s."""
        return self.matrix[..., 3:6]

    @property
    def by_moments(self) -> np.ndarray:
        """(..., 6, 3): by the principal moments, kg m2."""
        self._of("moments")
        return self.matrix[..., 6:9]

    @property
    def by_axes(self) -> np.ndarray:
        """(..., 6, 3): by turns of the principal axes about the body axes, rad."""
        self._of("moments")
        return self.matrix[..., 9:]

    @property
    def by_tensor(self) -> np.ndarray:
        """(..., 6, 6): by Ixx, Iyy, Izz, Ixy, Ixz, Iyz, kg m2."""
        self._of("tensor")
        return self.matrix[..., 6:]

    def covariance(self, initial: np.ndarray) -> np.ndarray:
        """(..., 6, 6): covariance of small rotation and rate, from that of the twelve columns, (..., 12, 12).

        Raises InputError for another shape.
        """
        initial = np.asarray(initial, dtype=float)
        if initial.shape[-2:] != (12, 12):
            raise InputError("initial", f"shape {initial.shape}", "the covariance of all columns, (12, 12)")
        return self.matrix @ initial @ np.swapaxes(self.matrix, -1, -2)

    def _of(self, inertia: str) -> None:
        if self.inertia != inertia:
            raise AttributeError(f'these are partial derivatives with inertia="{self.inertia}"')
