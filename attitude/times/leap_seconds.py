"""TAI - UTC in whole seconds, from 1972 on, by modified Julian day."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import date
from functools import cache

import erfa
import numpy as np

MJD_ORDINAL = 678576  # date.toordinal() of 1858-11-17


@contextmanager
def dubious_years() -> Iterator[None]:
    """Take years whose leap seconds are unknown, or before UTC, without the warning of erfa in this block."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", erfa.ErfaWarning)
        yield


@cache
def steps() -> tuple[np.ndarray, np.ndarray]:
    """The days from 1972 on at whose beginning TAI - UTC changed, and its value from then on, s."""
    table = erfa.leap_seconds.get()
    table = table[table["year"] >= 1972]
    begins = [
        date(int(y), int(m), 1).toordinal() - MJD_ORDINAL
        for y, m in zip(table["year"], table["month"], strict=True)
    ]
    return np.array(begins, dtype=np.int64), np.rint(table["tai_utc"]).astype(np.int64)


def tai_minus_utc(day: np.ndarray) -> np.ndarray:
    """s, whole, from 1972 on; 10 for all earlier days."""
    begins, offsets = steps()
    return offsets[np.maximum(np.searchsorted(begins, day, side="right") - 1, 0)]
