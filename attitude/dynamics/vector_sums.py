"""Vectors of three components, bodies along the first axis.

Sums are written out: the order in which a library adds may depend on how many bodies there are, and the bits
of a body's result would depend on the batch it is in.
"""

from __future__ import annotations

import numpy as np


def dot(a: np.ndarray, b: np.ndarray, axis: int = -1) -> np.ndarray:
    """Scalar products of vectors whose components are along an axis."""
    x, y, z = np.moveaxis(a * b, axis, 0)
    product: np.ndarray = (x + y) + z
    return product


def lengths(vectors: np.ndarray, axis: int = -1) -> np.ndarray:
    """Lengths of vectors whose components are along an axis."""
    return np.asarray(np.sqrt(dot(vectors, vectors, axis)))


def unit(vectors: np.ndarray) -> np.ndarray:
    """Unit vectors (n, 3); zeros stay."""
    size = lengths(vectors)[:, None]
    return np.asarray(vectors / np.where(size > 0.0, size, 1.0))
