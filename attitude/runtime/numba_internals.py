"""The one module that uses numba's private classes: it makes compiling faster, and changes no result.

Numba makes machine code of every routine by itself, and links each into all that call it, directly or
not.  Here a routine stays LLVM's language until the kernel that calls it is asked for its own: then
all are linked once.  Without this (another numba than those tested, or ATTITUDE_PLAIN_NUMBA set)
plain `njit` gives the same functions to the same optimiser; it takes 1.4 times as long.
"""

from __future__ import annotations

import os

import numba
from llvmlite.binding import Linkage

TESTED = (0, 61), (0, 69)  # from, and the first that is not: as pyproject.toml has it


def link_routines_once() -> bool:
    """Have this process only translate what numba compiles, none of which can be called here."""
    version = tuple(map(int, numba.__version__.split(".")[:2]))
    if os.environ.get("ATTITUDE_PLAIN_NUMBA") or not TESTED[0] <= version < TESTED[1]:
        return False
    from numba.core import codegen, registry

    class UnlinkedLibrary(codegen.JITCodeLibrary):
        """The code of one routine, and the libraries of the routines that it calls."""

        def add_linking_library(self, library):
            self._linking_libraries.append(library)

        def _optimize_functions(self, ll_module):
            ll_module.data_layout = self._codegen._data_layout

        def finalize(self):
            raise AssertionError("no routine is to become machine code by itself")

        def get_llvm_str(self):
            for library in called_by(self, {}):
                module = library._final_module.clone()
                for function in module.functions:
                    if not function.is_declaration and function.linkage == Linkage.external:
                        function.linkage = "linkonce_odr"
                self._final_module.link_in(module)
            return str(self._final_module)

    target = registry.cpu_target.target_context
    target.refresh()  # numba's own runtime is machine code
    target.codegen()._library_class = UnlinkedLibrary
    # numba keys its functions by what this returns
    target.get_executable = lambda library, fndesc, env: [].append
    return True


def called_by(library, found):
    """All libraries that one links to, directly or not, once each."""
    for other in library._linking_libraries:
        if other not in found:
            found[other] = None
            called_by(other, found)
    return found
