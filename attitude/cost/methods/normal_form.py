"""A problem as integrators and formulas like it: in principal axes, and in units near one.

Both are bookkeeping that any user of the methods here would do first.  Units change by powers of two, so that
no digit of the problem changes with them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..problem import Problem


@dataclass(frozen=True)
class PrincipalState:
    """A problem in principal axes.

    Attributes
    ----------
    moments, angular_velocity : (3,); attitude : (4,), wxyz, principal axes to inertial
    axes : (3, 3), the principal axes as columns in the body frame, a proper rotation; None for body axes
    """

    moments: np.ndarray
    angular_velocity: np.ndarray
    attitude: np.ndarray
    axes: np.ndarray | None

    @classmethod
    def of_problem(cls, problem: Problem) -> PrincipalState:
        attitude = problem.attitude / np.linalg.norm(problem.attitude)
        if problem.moments is not None:
            return cls(problem.moments, problem.angular_velocity, attitude, None)
        moments, axes = principal_axes(problem.tensor)
        turned = multiply(attitude, quaternion_of(axes))
        return cls(moments, axes.T @ problem.angular_velocity, turned, axes)

    def to_body(self, attitudes: np.ndarray, rates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Quaternions (n, 4) and rates (n, 3) in principal axes, as those of the body frame."""
        if self.axes is None:
            return attitudes, rates
        back = quaternion_of(self.axes) * (1.0, -1.0, -1.0, -1.0)
        return multiply(attitudes, back), rates @ self.axes.T


def principal_axes(tensor: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Moments (3,), ascending, and axes (3, 3) as columns, a proper rotation."""
    moments, axes = np.linalg.eigh(tensor)
    return moments, axes * np.sign(np.linalg.det(axes))


def quaternion_of(matrices: np.ndarray) -> np.ndarray:
    """(..., 4), wxyz, of proper rotation matrices (..., 3, 3)."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(matrices).as_quat(scalar_first=True))


def multiply(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Hamilton product (..., 4), wxyz."""
    p0, p1, p2, p3 = np.moveaxis(p, -1, 0)
    q0, q1, q2, q3 = np.moveaxis(q, -1, 0)
    parts = (
        p0 * q0 - p1 * q1 - p2 * q2 - p3 * q3,
        p0 * q1 + p1 * q0 + p2 * q3 - p3 * q2,
        p0 * q2 - p1 * q3 + p2 * q0 + p3 * q1,
        p0 * q3 + p1 * q2 - p2 * q1 + p3 * q0,
    )
    return np.stack(parts, axis=-1)


def exponent_of(vector: np.ndarray) -> int:
    """e with 2^(e-1) <= largest component < 2^e; 0 for a vector of zeros."""
    return int(np.frexp(np.abs(vector).max())[1])
