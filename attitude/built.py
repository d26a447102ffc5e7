"""Kernels built ahead: shared libraries beside the kernels' sources, for machines that have no compiler.

attitude/build_kernels.py makes them, for several kinds of processor; the one for the most that this
processor can do is taken.  Where none were built, which is everywhere but in container images,
attitude/compiled.py compiles for the very processor it runs on.
"""

from __future__ import annotations

import ctypes
import hashlib
import platform
from collections.abc import Callable
from functools import cache
from pathlib import Path

from . import kernels
from .kernels.layout import ENTRY, CompiledName

SOURCES = Path(kernels.__file__).parent
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

Function = Callable[[object], None]


def find(module: str, kernel: str, kinds: tuple[str, ...]) -> Path | None:
    """The library of a kernel, for this processor; None where none was built of the sources as they are."""
    place = _place()
    if place is None:
        return None
    library = place / library_name(CompiledName(module, kernel, kinds, digest()))
    return library if library.exists() else None


def load(library: Path) -> Function:
    """Its entry point, which releases the interpreter's lock."""
    function: Function = ctypes.CFUNCTYPE(None, ctypes.c_void_p)((ENTRY, ctypes.CDLL(str(library))))
    return function


def library_name(name: CompiledName) -> str:
    return str(Path(str(name)).with_suffix(".so"))


@cache
def digest() -> str:
    """Of the kernels as written."""
    return sources().hexdigest()[:16]


def sources() -> hashlib._Hash:
    found = hashlib.sha256()
    for path in sorted(SOURCES.glob("*.py")):
        found.update(path.read_bytes())
    return found


def processor(abilities: frozenset[str], machine: str) -> str | None:
    """Which of PROCESSORS is the most that a processor with these abilities can run."""
    for name, needed in PROCESSORS.get(machine, {}).items():
        if needed <= abilities:
            return name
    return None


@cache
def _place() -> Path | None:
    if not PLACE.is_dir():
        return None
    name = processor(_abilities(), platform.machine())
    return PLACE / name if name else None


def _abilities() -> frozenset[str]:
    """What the system says that every core can do and programs may use; nothing where it does not say."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return frozenset()
    lists = [frozenset(line.partition(":")[2].split()) for line in lines if line.startswith("flags")]
    return frozenset.intersection(*lists) if lists else frozenset()
