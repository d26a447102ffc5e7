"""Kernels built ahead: shared libraries beside the kernels' sources, for machines without a compiler.

attitude/runtime/build.py builds one for each level of processors; that of the highest level which this
processor supports is loaded.  Where there are none (all machines but container images), kernels are
compiled for this processor (attitude/runtime/kernel_cache.py).
"""

from __future__ import annotations

import ctypes
import platform
from functools import cache
from pathlib import Path

from .signature import SOURCES, Signature

DIRECTORY = SOURCES / "built"

# LLVM's names of processors, and the flags of /proc/cpuinfo that their code requires: the levels of the
# x86-64 psABI.  The last of each architecture requires none.
_V2 = frozenset(["cx16", "lahf_lm", "popcnt", "pni", "ssse3", "sse4_1", "sse4_2"])
_V3 = _V2 | {"avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe", "xsave"}
_V4 = _V3 | {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}
PROCESSORS = {
    "x86_64": {"x86-64-v4": _V4, "x86-64-v3": _V3, "x86-64": frozenset[str]()},
    "aarch64": {"generic": frozenset[str]()},
}


def address(signature: Signature) -> int | None:
    """The address of the kernel's code; None where the present sources were not built ahead."""
    library = _library()
    if library is None:
        return None
    try:
        return ctypes.cast(library[signature.symbol], ctypes.c_void_p).value
    except AttributeError:
        return None


def processor(flags: frozenset[str], machine: str) -> str | None:
    """The highest of PROCESSORS that a processor with these flags supports."""
    for name, needed in PROCESSORS.get(machine, {}).items():
        if needed <= flags:
            return name
    return None


@cache
def _library() -> ctypes.CDLL | None:
    if not DIRECTORY.is_dir():
        return None
    path = DIRECTORY / f"{processor(_flags(), platform.machine())}.so"
    return ctypes.CDLL(str(path)) if path.exists() else None


def _flags() -> frozenset[str]:
    """The flags of all cores by /proc/cpuinfo; none where there is no such file."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return frozenset()
    lists = [frozenset(line.partition(":")[2].split()) for line in lines if line.startswith("flags")]
    return frozenset.intersection(*lists) if lists else frozenset()
