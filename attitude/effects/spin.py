"""How fast bodies can turn, for estimates of torques that depend on it.

Moments and rates, (..., 3), are those along the principal axes, kg m2 and rad/s.
"""

from __future__ import annotations

import numpy as np


def momentum(moments: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """(...), N m s, at the epoch."""
    size: np.ndarray = np.sqrt(((moments * rates) ** 2).sum(axis=-1))
    return size


def fastest_by_energy(moments: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """(...), rad/s: sqrt(2E/I), I the least moment."""
    rate: np.ndarray = np.sqrt((rates * (moments * rates)).sum(axis=-1) / moments.min(axis=-1))
    return rate


def greatest_rate(moments: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """(...), rad/s that free rotation from the epoch never exceeds: L/I or sqrt(2E/I), I the least moment."""
    by_momentum = momentum(moments, rates) / moments.min(axis=-1)
    least: np.ndarray = np.minimum(fastest_by_energy(moments, rates), by_momentum)
    return least
