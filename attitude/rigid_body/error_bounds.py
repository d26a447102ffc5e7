"""Proven bounds on the attitude error of each closed form (docs/theory.md, section 8)."""

from __future__ import annotations

import numpy as np

from ..kernels import layout

BOUND_SOURCE = (
    "docs/theory.md, section 8, equation (34): a running error analysis of every operation of a sample, "
    "for the inputs as the binary numbers they are"
)
# Forms of the solution, and the greatest angle in rad that an attitude can be off: docs/theory.md (34).
FORMS = (
    ("rotation at a constant rate", 1.6e-15),
    ("closed form, theta series", 3.7e-15),
    ("closed form, transformed theta series (beside the separatrix)", 3.9e-15),
)


def form_of(regimes: np.ndarray, routes: np.ndarray) -> np.ndarray:
    """Index into FORMS for each of these fields of records."""
    return np.where(regimes == layout.CONSTANT_RATE, 0, np.where(routes == layout.TRANSFORMED, 2, 1))


def solution(forms: np.ndarray) -> tuple[str, float]:
    """(name of the closed form, bound on its error in rad) for a batch's bodies together."""
    counts = np.bincount(forms, minlength=len(FORMS)).tolist()
    used = [(name, bound, count) for (name, bound), count in zip(FORMS, counts, strict=True) if count]
    bound = max((bound for _, bound, _ in used), default=0.0)
    if len(used) == 1:
        return used[0][0], bound
    return "; ".join(f"{name}: {count} bodies" for name, _, count in used), bound
