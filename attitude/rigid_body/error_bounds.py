"""Bounds on the attitude error of each closed form (docs/theory.md, section 8), and how far they hold."""

from __future__ import annotations

import numpy as np

from ..errors import ToleranceError
from ..kernels.layout import MAX_TURNS, GyrostatRegime, GyrostatRoute, Regime, Route

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
THETA_FORM = 1  # index of the form that most bodies have
# Of gyrostats: three times the greatest error measured; for any rotor times the frame's condition number.
GYROSTAT_BOUND_SOURCE = (
    "docs/gyrostats.md: three times the greatest error measured against Taylor series, times the "
    "condition number of the transformation for a rotor along no principal axis; not proven"
)
GYROSTAT_FORMS = (
    ("rotation at a constant rate", 4e-15),
    ("gyrostat, closed form: two turns (symmetric about the rotor)", 4e-15),
    ("gyrostat, closed form, theta series (rotor along a principal axis)", 4e-15),
    ("gyrostat, closed form, transformed theta series (rotor along a principal axis)", 4e-15),
    ("gyrostat, closed form, theta series (any rotor)", 4e-15),
    ("gyrostat, closed form, transformed theta series (any rotor)", 4e-15),
)


def gyrostat_form_of(regimes: np.ndarray, routes: np.ndarray, any_rotor: np.ndarray) -> np.ndarray:
    """Index into GYROSTAT_FORMS for each of these fields of records."""
    series = 2 + (routes == GyrostatRoute.TRANSFORMED) + 2 * any_rotor
    return np.where(regimes <= GyrostatRegime.TWO_TURNS, regimes, series)


def form_of(regimes: np.ndarray, routes: np.ndarray) -> np.ndarray:
    """Index into FORMS for each of these fields of records."""
    return np.where(regimes == Regime.CONSTANT_RATE, 0, np.where(routes == Route.TRANSFORMED, 2, THETA_FORM))


def solution(forms: np.ndarray, table: tuple[tuple[str, float], ...] = FORMS) -> tuple[str, float]:
    """(name of the closed form, bound on its error in rad) for a batch's bodies together."""
    counts = np.bincount(forms, minlength=len(table)).tolist()
    used = [(name, bound, count) for (name, bound), count in zip(table, counts, strict=True) if count]
    bound = max((bound for _, bound, _ in used), default=0.0)
    if len(used) == 1:
        return used[0][0], bound
    return "; ".join(f"{name}: {count} bodies" for name, _, count in used), bound


def max_phase_rate(bodies: np.ndarray) -> float:
    """Turns/s of the fastest phase of these records; zero for no records."""
    phases = (bodies[name][..., 0] for name in ("precession", "argument"))
    return max(float(np.abs(rates).max(initial=0.0)) for rates in phases)


def refuse_too_far(turns_per_second: float, farthest: float) -> None:
    """Raise ToleranceError where the fastest phase makes more than MAX_TURNS turns up to an instant.

    turns_per_second : `max_phase_rate` of the bodies; farthest : s, greatest of the instants' absolute values
    """
    if farthest * turns_per_second > MAX_TURNS:
        limit = MAX_TURNS / turns_per_second
        raise ToleranceError(
            f"t: {farthest:.6g} s is beyond {limit:.6g} s, where this body has made "
            f"{MAX_TURNS:.3g} turns and phases would lose digits; ask for nearer instants"
        )
