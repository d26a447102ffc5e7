"""Signatures of kernels: name, kinds of arguments, digest of the sources."""

from __future__ import annotations

import re
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .. import kernels
from ..kernels.layout import GYROSTAT, INVARIANTS, PARTIALS, STEPPED
from ..kernels.solvers.plate_layout import MARCHED

SOURCES = Path(kernels.__file__).parent
COMPILER = Path(__file__).with_name("compiler.py")
# Dots, module or nothing, and names of a relative import; two threads cannot call `ast.parse` (CPython 3.11)
IMPORT = re.compile(r"^from (\.+)([\w.]*) import (.+)$", re.MULTILINE)
ELEMENTS = {
    "d": np.dtype(np.float64),
    "b": np.dtype(np.bool_),
    "c": np.dtype(np.uint8),
    "i": np.dtype(np.int64),
    "g": GYROSTAT,
    "r": INVARIANTS,
    "p": PARTIALS,
    "s": STEPPED,
    "m": MARCHED,
}


class Signature(NamedTuple):
    """A kernel, and the kinds of its arguments with points between them.

    A kind is "f" (float), "i" (int), "n" (None), or element and dimensions of a C-ordered array:
    "d2" doubles, "b1" booleans, "c1" bytes, "i1" 64-bit integers, "r1" records of INVARIANTS, "g1" of
    GYROSTAT, "p1" of PARTIALS, "s1" of STEPPED, "m1" of MARCHED.
    """

    module: str
    kernel: str
    kinds: str

    @property
    def symbol(self) -> str:
        """Name of the machine code's function and file: "clock.grid-f.d1-0123456789abcdef"."""
        return f"{self.module}.{self.kernel}-{self.kinds}-{source_digest(self.module)}"

    @classmethod
    def of_symbol(cls, symbol: str) -> Signature:
        """The signature of a symbol."""
        function, kinds, _ = symbol.split("-")
        module, _, kernel = function.rpartition(".")
        return cls(module, kernel, kinds)


@cache
def source_digest(module: str) -> str:
    """Digest of the sources of a module's machine code: its own, those it imports, and compiler.py."""
    digest = sha256(COMPILER.read_bytes())
    for name in sorted(modules_of(module)):
        digest.update(source_of(name).read_bytes())
    return digest.hexdigest()[:16]


def source_of(module: str) -> Path:
    """The source file of a module of kernels."""
    return SOURCES.joinpath(*module.split(".")).with_suffix(".py")


@cache
def modules_of(module: str) -> frozenset[str]:
    """The module, and all modules of kernels that it imports, directly or not."""
    package, imported = module.split(".")[:-1], []
    for dots, source, names in IMPORT.findall(source_of(module).read_text()):
        base = package[: len(package) + 1 - len(dots)]
        imported += [".".join([*base, name]) for name in ([source] if source else names.split(", "))]
    return frozenset([module]).union(*map(modules_of, imported))
