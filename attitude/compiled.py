"""The kernels as Python calls them: machine code, kept on disk and loaded without the compiler.

Numba compiles attitude/kernels for this processor when code is first wanted, in processes of their
own (attitude/kernels/compiler.py); from then on a process needs no numba, which would take it
longer to start than all of a short run.  Code is kept beside the kernels' sources where that may
be written to, else in the user's cache; ATTITUDE_CACHE_DIR names another place.  Kernels that were
built ahead (attitude/built.py) are taken as they are: then nothing of numba's need be installed.
"""

from __future__ import annotations

import ctypes
import os
import re
import subprocess
import sys
import tempfile
from array import array
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path
from struct import Struct
from threading import RLock
from typing import TYPE_CHECKING, Any

import numpy as np

from . import built
from .built import SOURCES
from .errors import AttitudeError
from .kernels.layout import ENTRY, INVARIANTS, CompiledName

if TYPE_CHECKING:
    from llvmlite.binding import ExecutionEngine

ELEMENTS = {
    np.dtype(np.float64): "d",
    np.dtype(np.bool_): "b",
    np.dtype(np.int64): "i",
    INVARIANTS: "r",
}

# Called with the number of kernels before they are compiled: on a new machine a run would look hung.
on_compilation: list[Callable[[int], None]] = []


class Kernel:
    """One compiled function; called with C-ordered arrays, floats, ints and Nones.

    For each combination of kinds of arguments there is machine code of its own.  Releases the
    interpreter's lock.
    """

    def __init__(self, module: str, name: str):
        self.module = module
        self.name = name
        self._functions: dict[tuple[str, ...], Any] = {}

    def __call__(self, *arguments: Any) -> None:
        words: list[int] = []
        kinds = tuple([_described(argument, words) for argument in arguments])
        function = self._functions.get(kinds)
        if function is None:
            function = self._functions[kinds] = _function(self.module, self.name, kinds)
        handed = array("q", words)
        function(handed.buffer_info()[0])


sample = Kernel("cayley_klein", "sample")
azimuth = Kernel("cayley_klein", "azimuth")
invariants = Kernel("invariants", "invariants")
principal_axes = Kernel("principal", "principal_axes")
rate_is_constant = Kernel("principal", "rate_is_constant")
farthest = Kernel("clock", "farthest")
seconds_from_days = Kernel("clock", "seconds_from_days")
days_from_seconds = Kernel("clock", "days_from_seconds")
nanoseconds = Kernel("clock", "nanoseconds")
grid = Kernel("clock", "grid")
scaled = Kernel("clock", "scaled")
split = Kernel("splitting", "split")
collocate = Kernel("collocation", "collocate")
runge_kutta = Kernel("runge_kutta", "runge_kutta")
split_each = Kernel("many", "split_each")
collocate_each = Kernel("many", "collocate_each")
runge_kutta_each = Kernel("many", "runge_kutta_each")
bounce = Kernel("contact", "bounce")
interpolate = Kernel("interpolation", "interpolate")
draw = Kernel("dispersion", "draw")
gather = Kernel("gathering", "gather")
settle = Kernel("gathering", "settle")

# What the library calls: compiled together when any of it is missing, the longest first.
SAMPLES = ("d1.d3.n", "n.d3.n", "d1.n.d3", "n.n.d3", "d1.d3.d3", "n.d3.d3")  # t_low, quaternions, rates
WORLD = "d2.d1.d3.d1.d3"  # effects, orbit, its pieces, sun, its pieces
STANDARD = [
    [("invariants", "invariants", "d3.d3.d4.d2.d2.b1.r1.d1.d2.d2.d2")],
    [
        *(("cayley_klein", "sample", f"r1.d1.{outputs}.n.i.i.i") for outputs in SAMPLES),
        ("cayley_klein", "azimuth", "r1.d1.d1.d2"),
        ("principal", "principal_axes", "d3.d3.d4.d3"),
        ("principal", "rate_is_constant", "d3.d2.b1.d1.d2.d2.d2"),
        ("clock", "farthest", "d1.i.i.d1"),
        ("clock", "seconds_from_days", "d1.d1.f.f.d1.d1"),
        ("clock", "days_from_seconds", "d1.d1.d1.d1"),
        ("clock", "nanoseconds", "d1.d1.i.f.d1"),
        ("clock", "grid", "f.f.f.f.f.f.f.d1.d1"),
        ("clock", "scaled", "d1.f.f.d1.d1"),
    ],
]
# What only scenes with torques, or with a ground, need: compiled together when one of a set is first called.
TORQUES = [
    [("collocation", "collocate", f"d1.d1.f.i.d1.i.{WORLD}.d1.d1.d2.d1.d1.d1.d1")],
    [
        ("splitting", "split", f"d1.d1.f.i.d1.d1.d1.i.{WORLD}.d1.d1.d2.d1.d2.d1"),
        ("runge_kutta", "runge_kutta", f"d1.d1.d1.f.f.d2.d1.{WORLD}.d1.d1.d2.d1.d1.d1.f.d1"),
    ],
]
# What only ensembles of scenes with torques need: the same loops, for body after body.
WORLDS = "d3.d1.d3.d1.d3"  # effects of each body, and the world of all
MANY = [
    [("many", "collocate_each", f"i1.d2.d1.f.i1.d2.i1.{WORLDS}.d1.d1.d3.d1.d1.d2.d1")],
    [
        ("many", "split_each", f"i1.d2.d1.f.i1.d1.d1.d2.i1.{WORLDS}.d1.d1.d3.d1.d2.d1"),
        ("many", "runge_kutta_each", f"i1.d2.d1.d1.d1.d1.d2.d2.{WORLDS}.d1.d1.d3.d1.d1.d2.f.d1"),
    ],
]
CONTACT = [[("contact", "bounce", "d3.d3.d4.d2.d1.d1.r1.d2.d2.d2.d1.d1.d2.d2.d2.d2.d2.b1.d1.d3.d3")]]
# What only formats whose readers interpolate need.
INTERPOLATION = [[("interpolation", "interpolate", "d1.d2.i.i.i.i.d2.d1")]]
# What only ensembles need.
ENSEMBLES = [
    [("dispersion", "draw", "i.i.i.d1.d1.d2.d2.d2.i1")],
    [("gathering", "gather", "d3.d1.d1"), ("gathering", "settle", "d1.i3")],
]
SETS = [STANDARD, TORQUES, MANY, CONTACT, INTERPOLATION, ENSEMBLES]


def compile_all() -> int:
    """Compile what the library calls and is not kept yet; returns how many kernels that was."""
    count = 0
    with _lock:
        for groups in map(_named, SETS):
            missing = [name for names in groups for name in names if not _kept(name)]
            if missing:
                _compile(missing[0])
            count += len(missing)
    return count


def is_standard(kernel: Kernel, kinds: tuple[str, ...]) -> bool:
    """Whether code for these kinds of arguments is compiled with others."""
    named = kernel.module, kernel.name, ".".join(kinds)
    return any(named in group for groups in SETS for group in groups)


def loaded() -> dict[Kernel, set[tuple[str, ...]]]:
    """What this process has called: kernels, and the kinds of arguments they were called with."""
    kernels = [value for value in globals().values() if isinstance(value, Kernel)]
    return {kernel: set(kernel._functions) for kernel in kernels}


# -- arguments --------------------------------------------------------------------------------------


def _described(argument: Any, words: list[int]) -> str:
    """The argument's kind; what the machine code reads of it is appended to the words."""
    if isinstance(argument, np.ndarray):
        if not argument.flags.c_contiguous:
            raise TypeError("kernels take arrays in C order")
        words.append(_address(argument))
        words.extend(argument.shape)
        return f"{ELEMENTS[argument.dtype]}{argument.ndim}"
    if argument is None:
        return "n"
    if isinstance(argument, float):
        words.extend(_WORD.unpack(_DOUBLE.pack(argument)))
        return "f"
    words.append(int(argument))
    return "i"


_DOUBLE, _WORD = Struct("d"), Struct("q")
_PLAIN = np.dtype(np.float64)


def _address(numbers: np.ndarray) -> int:
    """Where they begin: `numbers.ctypes` knows for any array, but takes five times as long to say so."""
    if numbers.dtype is _PLAIN and numbers.size and numbers.flags.writeable:
        return ctypes.addressof(ctypes.c_char.from_buffer(numbers))  # type: ignore[arg-type]
    return numbers.ctypes.data


# -- machine code, from disk ------------------------------------------------------------------------

_lock = RLock()
_engines: list[ExecutionEngine] = []  # they own the code: alive as long as the process
_unkept: dict[str, bytes] = {}  # code for which no place on disk can be written to


def _function(module: str, kernel: str, kinds: tuple[str, ...]) -> Any:
    """The machine code as a function of one address, compiled first where it is not kept."""
    with _lock:
        library = built.find(module, kernel, kinds)
        if library is not None:
            return built.load(library)
        name = CompiledName(module, kernel, kinds, _digest())
        return _loaded(_kept(name) or _compile(name))


def _loaded(code: bytes) -> Any:
    import llvmlite.binding as llvm

    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _target_machine())
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    _engines.append(engine)
    return ctypes.CFUNCTYPE(None, ctypes.c_void_p)(engine.get_function_address(ENTRY))


@cache
def _target_machine() -> Any:
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_triple(llvm.get_process_triple())
    return target.create_target_machine(codemodel="jitdefault")


@cache
def _digest() -> str:
    """Of what machine code depends on: kernels as written, compiler, processor."""
    try:
        import llvmlite.binding as llvm

        compiler = version("numba"), version("llvmlite")
    except ImportError as error:
        raise AttitudeError(f"the kernels cannot be compiled: {error}") from None
    digest = built.sources()
    processor = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten(), llvm.get_process_triple()
    digest.update(repr((*compiler, processor)).encode())
    return digest.hexdigest()[:16]


def _kept(name: CompiledName) -> bytes | None:
    if str(name) in _unkept:
        return _unkept[str(name)]
    for place in _places():
        with suppress(OSError):
            return (place / str(name)).read_bytes()
    return None


def _places() -> list[Path]:
    """Where machine code may be kept, the first of them that can be written to is written to."""
    chosen = os.environ.get("ATTITUDE_CACHE_DIR")
    if chosen:
        return [Path(chosen)]
    cache_home = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return [SOURCES / "__pycache__", Path(cache_home) / "attitude"]


# -- compiling --------------------------------------------------------------------------------------


def _named(groups: list[list[tuple[str, str, str]]]) -> list[list[CompiledName]]:
    """All but those built ahead: where every one was, nothing asks for a compiler."""
    return [list(_not_built(group)) for group in groups]


def _not_built(group: list[tuple[str, str, str]]) -> Iterator[CompiledName]:
    for module, kernel, text in group:
        kinds = tuple(text.split("."))
        if not built.find(module, kernel, kinds):
            yield CompiledName(module, kernel, kinds, _digest())


def _together(wanted: CompiledName) -> list[list[CompiledName]]:
    """What is compiled when this is wanted: with each group in a process of its own."""
    sets = map(_named, SETS)
    return next((groups for groups in sets if any(wanted in group for group in groups)), [[wanted]])


def _compile(wanted: CompiledName) -> bytes:
    """Machine code of what is wanted; and what belongs with it and is missing is kept too."""
    groups = [[name for name in group if not _kept(name)] for group in _together(wanted)]
    for listener in on_compilation:
        listener(sum(map(len, groups)))
    with tempfile.TemporaryDirectory() as elsewhere:
        place = _writeable_place() or Path(elsewhere)
        run_compilers(place, [group for group in groups if group])
        if place == Path(elsewhere):
            _unkept.update((path.name, path.read_bytes()) for path in place.iterdir())
        code = _kept(wanted)
    if code is None:
        raise AttitudeError(f"the kernels cannot be kept: {wanted} was compiled, and is gone")
    return code


def _writeable_place() -> Path | None:
    for place in _places():
        with suppress(OSError):
            place.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=place):
                return place
    return None


def run_compilers(place: Path, groups: Iterable[list[CompiledName]], *options: str, **variables: str) -> None:
    """One process for each group, side by side, with these options and environment variables."""
    packages = os.pathsep.join([str(SOURCES.parents[1]), os.environ.get("PYTHONPATH", "")]).rstrip(os.pathsep)
    environment = os.environ | {"PYTHONPATH": packages} | variables
    running = [
        subprocess.Popen(
            [sys.executable, "-m", "attitude.kernels.compiler", *options, str(place), *map(str, group)],
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        for group in groups
    ]
    messages = [process.communicate()[1] for process in running]
    for process, message in zip(running, messages, strict=True):
        if process.returncode != 0:
            lines = message.strip().splitlines() or [f"exit code {process.returncode}"]
            reason = next((line for line in lines if re.match(r"[\w.]*Error:", line)), lines[-1])
            raise AttitudeError(f"the kernels cannot be compiled: {reason}")
