"""Rates in turns per second as two doubles, so that phases keep their digits over long times."""

from __future__ import annotations

from decimal import Context, Decimal

import numpy as np

_EXACT = Context(prec=60)
TWO_PI = Decimal("6.28318530717958647692528676655900576839433879875021164194989")


def turns(radians_per_second: float) -> tuple[float, float]:
    """A rate in rad/s as turns/s in two parts, good to 32 digits."""
    return split(_EXACT.divide(Decimal(radians_per_second), TWO_PI))


def mean_motion(mu: float, semi_major_axis: float) -> tuple[float, float, float]:
    """sqrt(mu / a^3): turns/s in two parts, and rad/s."""
    a = Decimal(semi_major_axis)
    cube = _EXACT.multiply(_EXACT.multiply(a, a), a)
    rate = _EXACT.sqrt(_EXACT.divide(Decimal(mu), cube))
    return *split(_EXACT.divide(rate, TWO_PI)), float(rate)


def split(value: Decimal) -> tuple[float, float]:
    """A number as two doubles: the nearest one, and the remainder."""
    high = float(value)
    return high, float(_EXACT.subtract(value, Decimal(high)))


def fraction_of_turn(t: np.ndarray, high: float, low: float) -> np.ndarray:
    """t (high + low) less its whole turns, from -0.5 to 0.5; t (n,) s, high + low turns/s.

    The product t * high is kept in two parts (Dekker 1971), so that the whole turns, of which there
    may be millions, take no digits from the rest.
    """
    product = t * high
    t_high, high_high = _upper_half(t), _upper_half(np.asarray(high))
    t_low, high_low = t - t_high, high - high_high
    error = t_low * high_low - (((product - t_high * high_high) - t_low * high_high) - t_high * high_low)
    return (product - np.round(product)) + (error + t * low)


def _upper_half(value: np.ndarray) -> np.ndarray:
    """The upper 26 bits of each double (Veltkamp)."""
    shifted = value * 134217729.0
    return shifted - (shifted - value)
