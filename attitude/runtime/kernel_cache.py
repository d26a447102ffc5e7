"""Machine code of the kernels on disk: found again, compiled where it is missing, and loaded.

It is kept beside the kernels' sources where that may be written to, else in the user's cache;
ATTITUDE_CACHE_DIR names another place.  A directory holds the code for one processor, of one compiler.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import AttitudeError
from . import prebuilt
from .signature import SOURCES, Signature

if TYPE_CHECKING:
    from llvmlite.binding import ExecutionEngine

# Called with the number of kernels before they are compiled: on a new machine a run would look hung.
on_compilation: list[Callable[[int], None]] = []

_engines: list[ExecutionEngine] = []  # they own the code: alive as long as the process


def is_kept(signature: Signature) -> bool:
    return prebuilt.address(signature) is not None or _file(signature) is not None


def address(signature: Signature) -> int:
    """Where the kernel's machine code is in memory; it has been built ahead, or compiled."""
    built = prebuilt.address(signature)
    if built is not None:
        return built
    file = _file(signature)
    if file is None:
        raise AttitudeError(f"the kernels cannot be kept: {signature.symbol} was compiled, and is gone")
    return load(file.read_bytes(), signature.symbol)


def load(code: bytes, symbol: str) -> int:
    """The address of a function of an object file that is loaded."""
    import llvmlite.binding as llvm

    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _target_machine())
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    _engines.append(engine)
    return engine.get_function_address(symbol)


@cache
def _target_machine() -> Any:
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine(codemodel="jitdefault")


def compile_missing(groups: list[list[Signature]]) -> int:
    """Compile what is not kept, each group in a process of its own; returns how many kernels that was."""
    missing = [[signature for signature in group if not is_kept(signature)] for group in groups]
    count = sum(map(len, missing))
    if count:
        for listener in on_compilation:
            listener(count)
        run_compilers(_writeable_directory(), missing)
    return count


def run_compilers(directory: Path, groups: list[list[Signature]], *options: str) -> None:
    """A process for each group that is not empty, side by side; they write to the directory."""
    settings = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    packages = os.pathsep.join([str(SOURCES.parents[1]), settings.get("PYTHONPATH", "")]).rstrip(os.pathsep)
    running = [
        subprocess.Popen(
            [
                *(sys.executable, "-m", "attitude.runtime.compiler", *options),
                *(str(directory / f"{signature.symbol}.o") for signature in group),
            ],
            env=settings | {"PYTHONPATH": packages, "NUMBA_OPT": "0"},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        for group in groups
        if group
    ]
    messages = [process.communicate()[1] for process in running]
    for process, message in zip(running, messages, strict=True):
        if process.returncode != 0:
            lines = message.strip().splitlines() or [f"exit code {process.returncode}"]
            reason = next((line for line in lines if re.match(r"[\w.]*Error:", line)), lines[-1])
            raise AttitudeError(f"the kernels cannot be compiled: {reason}")


# -- where ------------------------------------------------------------------------------------------


def _file(signature: Signature) -> Path | None:
    files = (directory / f"{signature.symbol}.o" for directory in _directories())
    return next((file for file in files if file.exists()), None)


def _directories() -> Iterator[Path]:
    """Where machine code may be kept; the first that can be written to is written to."""
    chosen = os.environ.get("ATTITUDE_CACHE_DIR")
    cache_home = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))
    for place in [Path(chosen)] if chosen else [SOURCES / "__pycache__", cache_home / "attitude"]:
        yield place / _compiler_digest()
    yield from (Path(directory.name) for directory in _temporary)


_temporary: list[tempfile.TemporaryDirectory[str]] = []  # one of this process, where no other can be had


def _writeable_directory() -> Path:
    for directory in _directories():
        with suppress(OSError):
            directory.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=directory):
                return directory
    _temporary.append(tempfile.TemporaryDirectory())
    return Path(_temporary[-1].name)


@cache
def _compiler_digest() -> str:
    """Of what machine code depends on beside its sources: compiler and processor."""
    try:
        import llvmlite.binding as llvm

        versions = version("numba"), version("llvmlite")
    except ImportError as error:
        raise AttitudeError(f"the kernels cannot be compiled: {error}") from None
    processor = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten(), llvm.get_process_triple()
    return sha256(repr((*versions, processor)).encode()).hexdigest()[:16]
