"""Which directions of the estimated parameters the data see, and how well."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# Standard deviation, in natural units (rad, the whole rate, logarithms of moments), beyond which a direction
# counts as unseen, since the linear theory fails.
UNSEEN = 0.3
ALWAYS_UNSEEN = (
    "scale of the inertia: never seen in free rotation; kept as it was",
    "energy sinks and torques: the fit assumes that there are none",
)


@dataclass(frozen=True, eq=False)
class Observability:
    """Singular directions of the least-squares problem, the best seen first.

    names : (p,) of the parameters; directions : (p, p), of unit length, in its rows, in natural units
    sigma : (p,) standard deviations along them; infinite where the data see nothing
    is_seen : (p,) bool; what is not seen was kept at its value of the start
    """

    names: tuple[str, ...]
    directions: np.ndarray
    sigma: np.ndarray
    is_seen: np.ndarray

    @classmethod
    def of(cls, triangle: np.ndarray, names: tuple[str, ...], scale: float) -> Observability:
        """Decompose the (p, p) triangle of weighted derivatives; `scale` of standard deviations."""
        _, values, directions = np.linalg.svd(triangle)
        is_zero = values <= 1e-13 * values.max(initial=0.0)  # of rounding
        sigma = np.where(is_zero, np.inf, scale / np.where(is_zero, 1.0, values))
        return cls(names, directions, sigma, sigma <= UNSEEN)

    @property
    def unseen(self) -> tuple[str, ...]:
        """Words for what free rotation never shows, then for the directions that these data do not see."""
        return (*ALWAYS_UNSEEN, *(self.words(int(i)) for i in np.flatnonzero(~self.is_seen)))

    def words(self, index: int) -> str:
        """A direction by the parameters that have the most part in it."""
        parts = self.directions[index]
        parts = parts * np.sign(parts[np.argmax(np.abs(parts))])
        order = [i for i in np.argsort(-np.abs(parts), kind="stable") if abs(parts[i]) > 0.1][:6]
        terms = " ".join(f"{parts[i]:+.2f} {self.names[i]}" for i in order)
        return f"{terms} (1 sigma {self.sigma[index]:.2g})"

    @property
    def seen_basis(self) -> np.ndarray:
        """(p, m): the directions that are seen, in columns."""
        return self.directions[self.is_seen].T
