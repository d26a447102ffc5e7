"""Imports of optional packages."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from ..errors import FormatError


def needed(module: str, by: str, extra: str) -> Any:
    """The module; FormatError with the pip command where its package is not installed."""
    try:
        return import_module(module)
    except ImportError:
        package = module.partition(".")[0]
        raise FormatError(f"{by} needs {package}: pip install 'attitude[{extra}]'") from None
