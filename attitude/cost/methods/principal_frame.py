"""Principal axes of a problem, and powers of two as its units."""

from __future__ import annotations

import numpy as np

from ..initial_value_problem import InitialValueProblem


def principal_axes(problem: InitialValueProblem) -> tuple[np.ndarray, np.ndarray]:
    """Moments (3,), and axes (3, 3) as columns in the body frame, a proper rotation."""
    if problem.moments is not None:
        return problem.moments, np.eye(3)
    moments, axes = np.linalg.eigh(problem.tensor)
    return moments, axes * np.sign(np.linalg.det(axes))


def exponent(vector: np.ndarray) -> int:
    """e with 2^(e-1) <= largest component < 2^e; 0 for a vector of zeros.

    Powers of two as units change no digit.
    """
    return int(np.frexp(np.abs(vector).max())[1])
