"""The command `attitude`."""

from .command import main as main
