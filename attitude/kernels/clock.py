"""Days and seconds in two parts, exact to 1e-32 of the span: what stands between a Time and a phase."""

from .doubledouble import add, div, mul, two_product, two_sum
from .intrinsics import kernel

DAY = 86400.0


@kernel
def seconds_from_days(day, fraction, day0, fraction0, seconds, seconds_low):
    """(day + fraction - day0 - fraction0) * 86400 for arrays of days against one epoch.

    day, fraction, seconds, seconds_low : (n,); day0, fraction0 : float; the last two are written.
    """
    for i in range(day.shape[0]):
        days = add(two_sum(day[i], -day0), two_sum(fraction[i], -fraction0))
        seconds[i], seconds_low[i] = mul(days, (DAY, 0.0))


@kernel
def days_from_seconds(seconds, seconds_low, days, days_low):
    """Two-part seconds to two-part days; all (n,), the last two are written."""
    for i in range(seconds.shape[0]):
        days[i], days_low[i] = div((seconds[i], seconds_low[i]), (DAY, 0.0))


@kernel
def grid(start, stop, intervals, step, unit, seconds, seconds_low):
    """start + k*step in `unit` seconds, or `intervals` equal steps to stop where step is 0."""
    first = two_product(start, unit)
    if step == 0.0:
        span = mul(two_sum(stop, -start), (unit, 0.0))
        pace = div(span, (max(intervals, 1.0), 0.0))
    else:
        pace = two_product(step, unit)
    for i in range(seconds.shape[0]):
        seconds[i], seconds_low[i] = add(first, mul(pace, (float(i), 0.0)))


@kernel
def scaled(values, unit, seconds, seconds_low):
    """values * unit, exactly, as two parts."""
    for i in range(values.shape[0]):
        seconds[i], seconds_low[i] = two_product(values[i], unit)
