"""Time in two parts, exact to 1e-32 of the span: days, seconds, grids of instants.

Also the integral over time of a momentum that a constant torque and a damping change (`momentum_integral`).
"""

import numpy as np

from .doubledouble import INVERSE_FACTORIAL, ONE, add, div, exp, mul, neg, pair, sub, two_product, two_sum
from .intrinsics import bits_of, double_of, kernel, routine
from .phase import ROUND

DAY = 86400.0  # s


@kernel
def seconds_from_days(day, fraction, day0, fraction0, seconds, seconds_low):
    """(day + fraction - day0 - fraction0) * 86400 for arrays of days against one epoch.

    day, fraction, seconds, seconds_low : (n,); day0, fraction0 : float; the last two are written.
    """
    for i in range(day.shape[0]):
        days = add(two_sum(day[i], -day0), two_sum(fraction[i], -fraction0))
        seconds[i], seconds_low[i] = mul(days, (DAY, 0.0))


@kernel
def max_abs_seconds(seconds, first, last, greatest):
    """Write the greatest of abs(seconds[first:last]) to greatest[0]; not finite where one of them is not."""
    most = 0
    for i in range(np.uint64(first), np.uint64(last)):
        # as bits, magnitudes are ordered too, and NaN comes last
        most = max(most, bits_of(seconds[i]) & 0x7FFFFFFFFFFFFFFF)
    greatest[0] = double_of(most)


@kernel
def days_from_seconds(seconds, seconds_low, days, days_low):
    """Two-part seconds to two-part days; all (n,), the last two are written."""
    for i in range(seconds.shape[0]):
        days[i], days_low[i] = div((seconds[i], seconds_low[i]), (DAY, 0.0))


@kernel
def nanoseconds(seconds, seconds_low, start, below, counts):
    """start + below + 1e9*(seconds + seconds_low), to the nearest whole number.

    seconds, seconds_low : (n,); start : int; below : float, less than 1e15
    counts : (n,), written: the bits of 64-bit integers, which must be able to hold them
    """
    for i in range(seconds.shape[0]):
        whole = np.int64(seconds[i])
        part = (seconds[i] - float(whole)) * 1e9 + (seconds_low[i] * 1e9 + below)
        counts[i] = double_of(start + whole * 1_000_000_000 + np.int64((part + ROUND) - ROUND))


@kernel
def grid(spacing, first, seconds, seconds_low):
    """start + k*step, or `intervals` equal steps to stop where step is 0; in units of times/over seconds.

    spacing : (6,), start, stop, intervals, step, times, over
    first : float, the first k; seconds, seconds_low : (n,), written
    """
    start, stop, intervals, step = spacing[0], spacing[1], spacing[2], spacing[3]
    times, over = spacing[4], spacing[5]
    unit = div((times, 0.0), (over, 0.0))
    begin = mul((start, 0.0), unit)
    if step == 0.0:
        interval = div(mul(two_sum(stop, -start), unit), (max(intervals, 1.0), 0.0))
    else:
        interval = mul((step, 0.0), unit)
    for i in range(seconds.shape[0]):
        seconds[i], seconds_low[i] = add(begin, mul(interval, (first + float(i), 0.0)))


@kernel
def scaled(values, times, over, seconds, seconds_low):
    """values * times / over as two parts."""
    for i in range(values.shape[0]):
        seconds[i], seconds_low[i] = div(two_product(values[i], times), (over, 0.0))


@kernel
def momentum_integral(seconds, seconds_low, law, own, own_low, size):
    """The integral of p over time, p' = torque - damping p, and p.

    seconds, seconds_low : (n,); law : (5,), p at zero, torque and damping in two parts each
    own, own_low, size : (n,), written: the integral in two parts, and p
    """
    start, torque, damping = (law[0], 0.0), pair(law[1:3]), pair(law[3:5])
    for i in range(seconds.shape[0]):
        t = seconds[i], seconds_low[i]
        x = mul(damping, t)
        first, second = exponential_means(x)
        first = mul(t, first)  # integral of exp(-damping t)
        own[i], own_low[i] = add(mul(start, first), mul(torque, mul(mul(t, t), second)))
        size[i] = add(mul(start, exp(neg(x))), mul(torque, first))[0]


@routine
def exponential_means(x):
    """(1 - e^-x)/x and (e^-x - 1 + x)/x^2, for x > -700."""
    if abs(x[0]) >= 0.35:
        first = div(sub(ONE, exp(neg(x))), x)
        return first, div(sub(ONE, first), x)
    second = pair(INVERSE_FACTORIAL[21])
    for n in range(20, 1, -1):
        second = sub(pair(INVERSE_FACTORIAL[n]), mul(x, second))
    return sub(ONE, mul(x, second)), second
