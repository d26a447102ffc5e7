"""The command `attitude`."""

from .main import main

__all__ = ["main"]
