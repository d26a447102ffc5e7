"""CSPICE through spiceypy: one caller at a time, errors as FormatError."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ...errors import FormatError

_LOCK = threading.Lock()  # CSPICE has one state for all threads


def import_spiceypy(purpose: str = "SPICE CK") -> Any:
    """Import spiceypy; FormatError if it is not installed."""
    try:
        import spiceypy
    except ImportError:
        raise FormatError(f"{purpose} needs spiceypy: pip install 'attitude[spice]'") from None
    return spiceypy


@contextmanager
def calling(spice: Any, source: str = "") -> Iterator[None]:
    """One caller at a time; errors of CSPICE become FormatError, of this source."""
    with _LOCK:
        try:
            yield
        except spice.utils.exceptions.SpiceyError as error:
            raise FormatError(f"CSPICE: {' '.join(str(error).split())[:300]}", source) from None
