"""Dates of a document: ISO 8601 text in a time scale."""

from __future__ import annotations

import re
import warnings
from contextlib import suppress
from typing import Literal

from astropy.time import Time
from erfa import ErfaWarning

from ..errors import InputError

Scale = Literal["utc", "tai", "tt", "tdb", "tcb", "tcg", "ut1"]

ISO_DATE = re.compile(r"\d{4}-\d{2}-\d{2}([T ][\d:.]+)?")


def parse_time(text: str, scale: str | None, field: str) -> Time:
    """ISO 8601; a Z at the end is taken where the scale is UTC, which it states."""
    plain = text.removesuffix("Z") if scale == "utc" else text
    try:
        if ISO_DATE.fullmatch(plain):
            return _existing(plain, scale)
    except ValueError:
        pass
    raise InputError(field, text, "a date such as 2026-01-01T00:00:00 (ISO 8601)") from None


def _existing(text: str | list[str], scale: str | None) -> Time:
    """A second 60 where no leap second was, astropy lets pass with a warning; here it is a ValueError."""
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message=".*after end of day")
        try:
            return Time(text, scale=scale)
        except ErfaWarning as warning:
            raise ValueError(str(warning)) from None


def parse_times(texts: list[str], scale: str | None) -> Time:
    """All at once where all are plain ISO 8601; one by one to find the one that is not."""
    if all(ISO_DATE.fullmatch(text) for text in texts):
        with suppress(ValueError):
            return _existing(texts, scale)
    return Time([parse_time(text, scale, f"times.dates[{i}]") for i, text in enumerate(texts)])
