"""Processor, system and package versions of a measurement."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path


def processor() -> str:
    """Model name of the processor."""
    information = Path("/proc/cpuinfo")
    for line in information.read_text().splitlines() if information.exists() else ():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def machine() -> dict[str, str | int]:
    """Processor, number of cores, operating system."""
    return {"processor": processor(), "cores": os.cpu_count() or 1, "system": platform.system()}


def versions(
    packages: tuple[str, ...] = ("attitude", "numpy", "numba", "scipy", "mpmath", "heyoka", "orekit-jpype"),
) -> dict[str, str]:
    """Versions of Python and of the installed ones of these packages."""
    installed = {"python": platform.python_version()}
    for package in packages:
        try:
            installed[package] = version(package)
        except PackageNotFoundError:
            continue
    return installed
