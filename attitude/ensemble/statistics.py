"""Statistics of attitudes from sums over bodies: mean, covariance, directions of the body axes.

Equation numbers are those of docs/ensemble-statistics.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from astropy import units as u
from astropy.table import QTable

from ..frames import rotations
from ..times.instants import Instants
from .redraws import Redraws, note

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

ROUNDING = 1e-15  # a mean of unit vectors that is shorter has no direction


@dataclass(frozen=True)
class Population:
    """The bodies that statistics are of.

    count : bodies, without those that are lost
    regimes : fraction of all bodies by regime of the free motion from their states at the epoch
    lost : indices of bodies that could not be integrated to the scene's tolerance, and were left out
    redraws : of all bodies, lost ones too, whose moments were drawn again; None where moments are not spread
    """

    count: int
    regimes: dict[str, float]
    lost: tuple[int, ...] = ()
    redraws: Redraws | None = None


class Statistics:
    """Statistics of the attitudes of many bodies at m instants.

    Attributes
    ----------
    count, regimes, lost, redraws : of the bodies, as in `Population`; lost is an array
    instants : the instants; seconds : (m,), s since the epoch
    frame : the inertial frame
    mean : (m, 4), wxyz: the chordal mean, eq. (E3), on the side of the first body's quaternion
    covariance : (m, 3, 3), rad2: of the small rotation from the mean to each body, components along the
        mean's body axes, eq. (E4)
    directions : (m, 3, 3): unit vectors, inertial; row k is the mean direction of body axis k, eq. (E6);
        zeros where an axis has none
    resultants : (m, 3): length of the mean of each body axis, 1 where all bodies agree, 0 where none do
    spreads : (m, 3), rad: root mean square of each body axis's distance from its mean direction, as a chord
        of the unit sphere (of small spreads the angle), eq. (E7)
    """

    def __init__(
        self,
        products: np.ndarray,
        reference: np.ndarray,
        instants: Instants,
        frame: str,
        population: Population,
    ):
        self.count, self.regimes, self.redraws = population.count, population.regimes, population.redraws
        self.lost = np.array(sorted(population.lost), np.int64)
        self.instants, self.frame = instants, frame
        offset = mean_departure(products)
        self.mean = rotations.product(reference, offset)
        self.covariance = covariance(products, offset)
        self.directions, self.resultants, self.spreads = axes(products, reference)

    @property
    def seconds(self) -> np.ndarray:
        """(m,), s since the epoch."""
        return self.instants.seconds

    @property
    def rotation(self) -> Rotation:
        """The mean attitudes."""
        from scipy.spatial.transform import Rotation

        return Rotation.from_quat(self.mean, scalar_first=True)

    @property
    def deviation(self) -> np.ndarray:
        """(m, 3), rad: standard deviations about the mean's body axes."""
        variance = np.diagonal(self.covariance, axis1=1, axis2=2)
        return np.sqrt(np.maximum(variance, 0.0))  # bodies that are alike may have -1e-33

    def __len__(self) -> int:
        return len(self.mean)

    def to_table(self) -> QTable:
        """One row an instant; count, regimes, frame, lost bodies and redraws are in meta.

        Columns time (with an epoch), elapsed [s], quaternion (w, x, y, z; the mean), covariance [rad2]
        (3, 3), directions (3, 3), resultants (3) and spreads [rad] (3).
        """
        convention = (
            "q rotates body to inertial; covariance along the mean's body axes; rows of directions are axes"
        )
        meta = {"count": self.count, "regimes": dict(self.regimes), "frame": self.frame}
        meta |= {"lost": self.lost.tolist()} if len(self.lost) else {}
        meta |= {"redraws": self.redraws.document()} if self.redraws is not None else {}
        table = QTable(meta=meta | {"quaternion_order": "wxyz", "convention": convention})
        if self.instants.time is not None:
            table["time"] = self.instants.time
        table["elapsed"] = self.seconds * u.s
        table["quaternion"] = self.mean
        table["covariance"] = self.covariance * u.rad**2
        table["directions"] = self.directions
        table["resultants"] = self.resultants
        table["spreads"] = self.spreads * u.rad
        return table

    def __repr__(self) -> str:
        return f"<Statistics: {self.count} bodies at {len(self)} instants, {self.frame}{note(self.redraws)}>"

    def __str__(self) -> str:
        lines = [f"{self.count} bodies at {len(self)} instants, {self.frame}"]
        lines += [f"  {self.redraws}"] if note(self.redraws) else []
        lines += [f"  {name}: {fraction:.4%}" for name, fraction in self.regimes.items() if fraction]
        lines.append("      elapsed, s   deviation about x, y, z, deg   resultants of x, y, z")
        for i in sorted({0, len(self) // 2, len(self) - 1}):
            angles = " ".join(f"{angle:9.4g}" for angle in np.degrees(self.deviation[i]))
            lengths = " ".join(f"{length:7.5f}" for length in self.resultants[i])
            lines.append(f"  {self.seconds[i]:14.9g}   {angles}  {lengths}")
        return "\n".join(lines)


def mean_departure(products: np.ndarray) -> np.ndarray:
    """(m, 4): eigenvector of the greatest eigenvalue of (m, 4, 4), eq. (E3), with a first component >= 0."""
    vector = np.linalg.eigh(products)[1][..., -1]
    vector /= np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.where(vector[:, :1] < 0.0, -vector, vector)


def covariance(products: np.ndarray, mean: np.ndarray) -> np.ndarray:
    """(m, 3, 3), rad2, of products (m, 4, 4) about a mean (m, 4), eq. (E4)."""
    w, x, y, z = mean.T
    # rows 1 to 3 of the matrix that multiplies by conj(mean) from the left
    left = np.stack(
        [np.stack([-x, w, z, -y], -1), np.stack([-y, -z, w, x], -1), np.stack([-z, y, -x, w], -1)], axis=1
    )
    matrix = 4.0 * np.einsum("mai,mij,mbj->mab", left, products, left)
    return 0.5 * (matrix + np.swapaxes(matrix, 1, 2))


def axes(products: np.ndarray, reference: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(directions, resultants, spreads) of the three body axes, eqs. (E5) to (E7)."""
    # columns of 1 - R are short where spreads are small, and have the digits that R would lose
    defect = _mean_rotation_defect(products)
    squares = (defect * defect).sum(axis=1)
    one_minus_square = 2.0 * np.diagonal(defect, axis1=1, axis2=2) - squares  # 1 - length^2, uncancelled
    means = np.swapaxes(np.eye(3) - defect, 1, 2)  # rows are the axes
    lengths = np.linalg.norm(means, axis=-1)
    spreads = np.sqrt(np.maximum(2.0 * one_minus_square / (1.0 + lengths), 0.0))
    inertial = rotations.rotate(reference[:, None], means)
    inertial /= np.maximum(np.linalg.norm(inertial, axis=-1, keepdims=True), ROUNDING)
    return np.where(lengths[..., None] > ROUNDING, inertial, 0.0), lengths, spreads


def _mean_rotation_defect(products: np.ndarray) -> np.ndarray:
    """(m, 3, 3): 1 - mean of R(p), eq. (E5), from the mean of p p^T of trace one."""
    out = np.empty((len(products), 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[:, i, i] = 2.0 * (products[:, 1 + j, 1 + j] + products[:, 1 + k, 1 + k])
        out[:, i, j] = -2.0 * (products[:, 1 + i, 1 + j] - products[:, 0, 1 + k])
        out[:, j, i] = -2.0 * (products[:, 1 + i, 1 + j] + products[:, 0, 1 + k])
    return out
