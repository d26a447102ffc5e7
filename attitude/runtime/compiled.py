"""The kernels as Python calls them: `compiled.sample(bodies, t, ...)` and the others.

attitude/runtime/__init__.py describes the way from a kernel's source to a call.
"""

from __future__ import annotations

import ctypes
from itertools import repeat
from threading import RLock
from typing import Any

import numpy as np

from . import kernel_cache
from .signature import ELEMENTS, Signature

LETTERS = {dtype: letter for letter, dtype in ELEMENTS.items()}
DOUBLES = ELEMENTS["d"]
SCALARS = {"f": ctypes.c_double, "i": ctypes.c_int64, "n": ctypes.c_void_p}

_loading, _compiling = RLock(), RLock()  # one thread at a time loads; one compiles what a call needs
_unread = ctypes.create_string_buffer(8)  # for the result and the exception of a kernel, which has neither
_UNREAD = ctypes.addressof(_unread)


class Kernel:
    """One compiled function; called with C-ordered arrays, floats, ints and Nones.

    Each combination of kinds of arguments has machine code of its own; that for `kinds`
    (signature.Signature) is compiled together with others.  Calls release the interpreter's lock.
    """

    def __init__(self, name: str, *kinds: str):
        self.module, _, self.name = name.rpartition(".")
        self.signatures = [Signature(self.module, self.name, each) for each in kinds]
        self._functions: dict[tuple[str, ...], Any] = {}

    def __call__(self, *arguments: Any) -> None:
        """Call the machine code for arguments of these kinds, compiled or loaded at its first call."""
        values: list[Any] = [_UNREAD, _UNREAD]
        kinds = tuple(map(flatten, arguments, repeat(values)))
        function = self._functions.get(kinds)
        if function is None:
            function = self._functions[kinds] = self._function(kinds)
        if function(*values):
            raise RuntimeError(f"{self.module}.{self.name} raised an exception")

    def signature(self, kinds: tuple[str, ...]) -> Signature:
        """The signature for arguments of these kinds."""
        return Signature(self.module, self.name, ".".join(kinds))

    def _function(self, kinds: tuple[str, ...]) -> Any:
        signature = self.signature(kinds)
        if not kernel_cache.is_kept(signature):
            with _compiling:
                kernel_cache.compile_missing(compiled_with(signature))
        with _loading:
            return prototype(kinds)(kernel_cache.address(signature))


def flatten(argument: Any, values: list[Any]) -> str:
    """The argument's kind; appends the values that it is in numba's calling convention.

    An array is: its owner (two numbers, none here), size, bytes of an element, address, shape, strides.
    """
    if isinstance(argument, np.ndarray):
        if not argument.flags.c_contiguous:
            raise TypeError("kernels take arrays in C order")
        if argument.dtype is DOUBLES and argument.size and argument.flags.writeable:
            address = ctypes.addressof(ctypes.c_char.from_buffer(argument))  # type: ignore[arg-type]
        else:
            address = argument.ctypes.data  # for any array, in five times the time
        values += (None, None, argument.size, argument.itemsize, address)
        values += argument.shape
        values += argument.strides
        return f"{LETTERS[argument.dtype]}{argument.ndim}"
    values.append(argument)
    if argument is None:
        return "n"
    return "f" if isinstance(argument, float) else "i"


def prototype(kinds: tuple[str, ...]) -> Any:
    """The C type of a kernel for arguments of these kinds: result, exception, and the values of `flatten`."""
    types: list[Any] = [ctypes.c_void_p] * 2
    for kind in kinds:
        if kind in SCALARS:
            types.append(SCALARS[kind])
        else:
            types += [ctypes.c_void_p] * 2 + [ctypes.c_int64] * 2 + [ctypes.c_void_p]
            types += [ctypes.c_int64] * (2 * int(kind[1:]))
    return ctypes.CFUNCTYPE(ctypes.c_int, *types)


# -- the kernels, and the signatures that the library calls ----------------------------------------------

SAMPLES = ("d1.d3.n", "n.d3.n", "d1.n.d3", "n.n.d3", "d1.d3.d3", "n.d3.d3")  # t_low, quaternions, rates

invariants = Kernel("invariants.invariants", "d3.d3.d4.d2.d2.r1.d1.d2.d2.d2")
theta_invariants = Kernel("lanes.theta_invariants", *(f"d3.{axes}.d2.d2.d2.i1.d1" for axes in ("n", "d4")))
sample = Kernel("cayley_klein.sample", *(f"r1.d1.{outputs}.i.i.i" for outputs in SAMPLES))
partials = Kernel(
    "partials.assembly.partials",
    *(f"r1.d1.{low}.d4.i1.d3.d4.d2.p1.d2.d2.d2.d2.d1" for low in ("d1", "n")),
)
azimuth = Kernel("cayley_klein.azimuth", "r1.d1.d1.d2")
gyrostats = Kernel("gyrostat.record.gyrostats", "d3.d3.d4.d2.d2.d2.g1.d2.d1.d2.d2.d2")
sample_gyrostats = Kernel("gyrostat.attitudes.sample", *(f"g1.d1.{outputs}.i.i.i" for outputs in SAMPLES))
principal_axes = Kernel("principal.principal_axes", "d3.d3.d4.d3")
max_abs_seconds = Kernel("clock.max_abs_seconds", "d1.i.i.d1")
seconds_from_days = Kernel("clock.seconds_from_days", "d1.d1.f.f.d1.d1")
days_from_seconds = Kernel("clock.days_from_seconds", "d1.d1.d1.d1")
nanoseconds = Kernel("clock.nanoseconds", "d1.d1.i.f.d1")
grid = Kernel("clock.grid", "d1.f.d1.d1")
scaled = Kernel("clock.scaled", "d1.f.f.d1.d1")
momentum_integral = Kernel("clock.momentum_integral", "d1.d1.d1.d1.d1.d1")
collocate = Kernel("solvers.collocation.collocate", "s1.d1.d2.d3.d1.d1.d3.d1.d3")
march = Kernel("solvers.plate_march.march", "m1.d1.d2.d3.d1.d1.d3.d3.d3.d3.d2.d2.d1.d2.d1.d3.d1.d3.d2")
bounce = Kernel("contact.flight.bounce", "d3.d3.d4.d2.d1.d1.d1.r1.d2.d2.d1.d2.d2.d2.d2.d2.d1.d3.d3.d2")
interpolate = Kernel("interpolation.interpolate", "d1.d2.i1.i.d1.d2.d2.d1")
draw = Kernel("statistics.dispersion.draw", "i1.i.d1.d1.d2.d2.d2.i1")
accumulate = Kernel("statistics.moment_sums.accumulate", "d3.d1.d1")
add_exactly = Kernel("statistics.moment_sums.add_exactly", "d1.i3")


def signatures(*kernels: Kernel) -> list[Signature]:
    """All signatures of these kernels."""
    return [signature for kernel in kernels for signature in kernel.signatures]


OF_MOMENTS, OF_TENSORS = theta_invariants.signatures
# Kernels that are compiled together when a missing one is called, each group in a process of its own.
WINGS = [
    [
        [OF_MOMENTS],
        [
            *signatures(sample, azimuth, principal_axes),
            *signatures(max_abs_seconds, seconds_from_days, days_from_seconds, nanoseconds, grid, scaled),
        ],
    ],
    [[OF_TENSORS]],
    [signatures(invariants)],
    [[signature] for signature in signatures(partials)],
    [signatures(momentum_integral)],
    [signatures(collocate)],
    [signatures(march)],
    [signatures(gyrostats), signatures(sample_gyrostats)],
    [signatures(bounce)],
    [signatures(interpolate)],
    [signatures(draw), signatures(accumulate, add_exactly)],
]


def compiled_with(signature: Signature) -> list[list[Signature]]:
    """The groups that are compiled together with a signature."""
    return next((wing for wing in WINGS if any(signature in group for group in wing)), [[signature]])


def compile_all() -> int:
    """Compiles all missing kernels; returns their number.

    A thread that calls one of them during this compiles that one itself instead of waiting for all.
    """
    return kernel_cache.compile_missing([group for wing in WINGS for group in wing])


def loaded() -> set[Signature]:
    """The signatures that this process has called."""
    kernels = [value for value in globals().values() if isinstance(value, Kernel)]
    return {kernel.signature(kinds) for kernel in kernels for kinds in kernel._functions}
