"""How fast a body can turn, for estimates of torques that depend on it."""

from __future__ import annotations

import math

import numpy as np

from ..dynamics.situation import Situation


def momentum(situation: Situation) -> float:
    """N m s, of the body at the epoch."""
    return float(np.linalg.norm(situation.moments * _rate(situation)))


def greatest_rate(situation: Situation) -> float:
    """rad/s that free rotation from the epoch never exceeds: L/I or sqrt(2E/I), I the least moment."""
    moments, rate = situation.moments, _rate(situation)
    least = float(moments.min())
    by_energy = math.sqrt(float(rate @ (moments * rate)) / least)
    return min(by_energy, momentum(situation) / least)


def _rate(situation: Situation) -> np.ndarray:
    """Along the principal axes."""
    return situation.axes @ situation.rate
