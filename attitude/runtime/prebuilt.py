"""Kernels built ahead: a shared library beside the kernels' sources, for machines that have no compiler.

attitude/runtime/build.py makes one for each of several kinds of processor; the one for the most that
this processor can do is taken.  Where none were built, which is everywhere but in container images,
kernels are compiled for the very processor (attitude/runtime/kernel_cache.py).
"""

from __future__ import annotations

import ctypes
import platform
from functools import cache
from pathlib import Path

from .signature import SOURCES, Signature

PLACE = SOURCES / "built"

# LLVM's names of processors, and what /proc/cpuinfo has to list for their code to run: the levels of the
# x86-64 psABI.  The last of each architecture runs on all of it.
_V2 = frozenset(["cx16", "lahf_lm", "popcnt", "pni", "ssse3", "sse4_1", "sse4_2"])
_V3 = _V2 | {"avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe", "xsave"}
_V4 = _V3 | {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}
PROCESSORS = {
    "x86_64": {"x86-64-v4": _V4, "x86-64-v3": _V3, "x86-64": frozenset[str]()},
    "aarch64": {"generic": frozenset[str]()},
}


def address(signature: Signature) -> int | None:
    """Where the kernel's code is; None where none was built of the sources as they are."""
    library = _library()
    if library is None:
        return None
    try:
        return ctypes.cast(library[signature.symbol], ctypes.c_void_p).value
    except AttributeError:
        return None


def processor(abilities: frozenset[str], machine: str) -> str | None:
    """Which of PROCESSORS is the most that a processor with these abilities can run."""
    for name, needed in PROCESSORS.get(machine, {}).items():
        if needed <= abilities:
            return name
    return None


@cache
def _library() -> ctypes.CDLL | None:
    if not PLACE.is_dir():
        return None
    path = PLACE / f"{processor(_abilities(), platform.machine())}.so"
    return ctypes.CDLL(str(path)) if path.exists() else None


def _abilities() -> frozenset[str]:
    """What the system says that every core can do and programs may use; nothing where it does not say."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return frozenset()
    lists = [frozenset(line.partition(":")[2].split()) for line in lines if line.startswith("flags")]
    return frozenset.intersection(*lists) if lists else frozenset()
