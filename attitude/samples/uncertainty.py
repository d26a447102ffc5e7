"""Uncertainty of an initial state and inertia, and the ellipses that it makes of directions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """What is not known of a body and its state at the epoch.

    Attributes
    ----------
    covariance : (12, 12), SI: of the small rotation of the attitude (3, body axes, rad), the body rate (3,
        body axes, rad/s), the principal moments (3, kg m2) and the angles of their axes (3, body axes, rad)
    linear_until : s from the epoch, up to which exact bodies at 3 sigma are within 10 % of what the first
        order gives for them; infinite where they are over the whole span, None where it was not checked
    """

    covariance: np.ndarray
    linear_until: float | None = None

    @property
    def root(self) -> np.ndarray:
        """(12, k): independent changes of 1 sigma, whose sum of squares is the covariance.

        By the correlations: inputs in kg m2 may have variances 1e30 times those in rad.
        """
        sigma = np.sqrt(np.diagonal(self.covariance))
        per_sigma = 1.0 / np.where(sigma > 0.0, sigma, 1.0)
        values, vectors = np.linalg.eigh(self.covariance * per_sigma * per_sigma[:, None])
        is_part = values > 1e-14 * max(float(values.max()), 1e-300)
        return sigma[:, None] * vectors[:, is_part] * np.sqrt(values[is_part])

    @property
    def note(self) -> str | None:
        """What to say of an answer that goes beyond `linear_until`."""
        if self.linear_until is None or np.isinf(self.linear_until):
            return None
        return (
            f"uncertainty: from {self.linear_until:.6g} s on, the covariance's first order is off by more "
            "than 10 % of itself at 3 sigma; attitude.ensemble.Ensemble has no such limit"
        )


def ellipse(attitude_covariance: np.ndarray, body_axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The 1 sigma ellipse of a body axis's direction (3,): semi-axes and where they lie.

    The major and the minor, (..., 2) rad; unit vectors along both, (..., 2, 3), body axes.
    The small rotation theta moves the unit vector b by theta x b, which lies across it.
    """
    b = np.asarray(body_axis, dtype=float)
    b = b / np.linalg.norm(b)
    turn = np.cross(np.eye(3), b)  # theta x b = theta @ turn
    moved = np.swapaxes(turn, -1, -2) @ attitude_covariance @ turn
    squares, vectors = np.linalg.eigh(moved)
    return np.sqrt(np.maximum(squares[..., :0:-1], 0.0)), np.swapaxes(vectors, -1, -2)[..., :0:-1, :]
