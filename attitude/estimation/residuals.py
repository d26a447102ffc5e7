"""Residuals of a set of observations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from typing_extensions import TypedDict


class ResidualsAnswer(TypedDict):
    """`Residuals` as plain data."""

    name: str
    unit: str
    rms: float
    elapsed_s: list[float]
    vectors: list[list[float]]
    sizes: list[float]
    sigmas: list[float]


@dataclass(frozen=True, eq=False)
class Residuals:
    """Residuals of one set of observations.

    name : of the set; seconds : (n,) since the epoch
    vectors : (n, k) observed less computed: rotation vectors along body axes (rad), rates (rad/s), chords of
        directions along body axes, offsets (m)
    sizes : (n,) rad, rad/s or m
    sigmas : (n,) sizes over standard deviations; where these are only relative, over the typical scatter
    is_outlier : (n,) bool
    """

    name: str
    unit: str
    seconds: np.ndarray
    vectors: np.ndarray
    sizes: np.ndarray
    sigmas: np.ndarray
    is_outlier: np.ndarray

    def to_dict(self) -> ResidualsAnswer:
        """Return plain data."""
        return {
            "name": self.name,
            "unit": self.unit,
            "rms": self.rms,
            "elapsed_s": self.seconds.tolist(),
            "vectors": self.vectors.tolist(),
            "sizes": self.sizes.tolist(),
            "sigmas": self.sigmas.tolist(),
        }

    @property
    def outlier_indices(self) -> np.ndarray:
        """Indices of the outliers."""
        return np.flatnonzero(self.is_outlier)

    @property
    def sum_of_squares(self) -> float:
        """Of the components of `vectors`."""
        return float((self.vectors**2).sum())

    @property
    def rms(self) -> float:
        """Root of the mean square of `sizes`."""
        return float(np.sqrt((self.sizes**2).mean()))
