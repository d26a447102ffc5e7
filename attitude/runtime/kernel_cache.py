"""Cache of the kernels' machine code on disk: looked up, compiled where it is missing, loaded.

It is stored beside the kernels' sources where these are writeable, else in the user's cache directory, or
in ATTITUDE_CACHE_DIR.  Each directory holds the code for one processor and one compiler.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import AttitudeError
from . import prebuilt
from .signature import SOURCES, Signature
from .threads import processors

if TYPE_CHECKING:
    from llvmlite.binding import ExecutionEngine

# Called with the number of kernels before they are compiled, which takes seconds.
on_compilation: list[Callable[[int], None]] = []

_engines: list[ExecutionEngine] = []  # own the code, for the life of the process


def is_kept(signature: Signature) -> bool:
    """Whether the kernel was built ahead or is in the cache."""
    return prebuilt.address(signature) is not None or _file(signature) is not None


def address(signature: Signature) -> int:
    """The address of the kernel's machine code, which was built ahead or is in the cache."""
    built = prebuilt.address(signature)
    if built is not None:
        return built
    file = _file(signature)
    if file is None:
        raise AttitudeError(f"the kernels cannot be cached: {signature.symbol} was compiled, and is gone")
    return load(file.read_bytes(), signature.symbol)


def load(code: bytes, symbol: str) -> int:
    """Loads an object file; returns the address of a function of it."""
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
    """Compiles missing kernels, each group in a process of its own; returns their number."""
    missing = [[signature for signature in group if not is_kept(signature)] for group in groups]
    count = sum(map(len, missing))
    if count:
        for listener in on_compilation:
            listener(count)
        run_compilers(_writeable_directory(), missing)
    return count


def run_compilers(directory: Path, groups: list[list[Signature]], *options: str) -> None:
    """Compiles each group that is not empty into the directory, in a process of its own.

    As many processes run at once as there are processors.
    """
    compiler = [sys.executable, "-m", "attitude.runtime.compiler", *options]
    files = [[str(directory / f"{signature.symbol}.o") for signature in group] for group in groups if group]
    with ThreadPoolExecutor(processors()) as pool:
        for failure in pool.map(run_compiler, [compiler + each for each in files]):
            if failure:
                raise AttitudeError(f"the kernels cannot be compiled: {failure}")


def run_compiler(command: list[str]) -> str:
    """Runs a compiler process; returns why it failed, or an empty text."""
    settings = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    packages = os.pathsep.join([str(SOURCES.parents[1]), settings.get("PYTHONPATH", "")]).rstrip(os.pathsep)
    process = subprocess.run(
        command,
        env=settings | {"PYTHONPATH": packages, "NUMBA_OPT": "0"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    if process.returncode == 0:
        return ""
    lines = process.stderr.strip().splitlines() or [f"exit code {process.returncode}"]
    return next((line for line in lines if re.match(r"[\w.]*Error:", line)), lines[-1])


# -- directories ------------------------------------------------------------------------------------------


def _file(signature: Signature) -> Path | None:
    files = (directory / f"{signature.symbol}.o" for directory in _directories())
    return next((file for file in files if file.exists()), None)


def _directories() -> Iterator[Path]:
    """Directories of machine code; the first writeable one is written to."""
    chosen = os.environ.get("ATTITUDE_CACHE_DIR")
    cache_home = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))
    for parent in [Path(chosen)] if chosen else [SOURCES / "__pycache__", cache_home / "attitude"]:
        yield parent / _compiler_digest()
    yield from (Path(directory.name) for directory in _temporary)


_temporary: list[tempfile.TemporaryDirectory[str]] = []  # of this process, where no other is writeable


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
    """Digest of what machine code depends on besides its sources: compiler and processor."""
    try:
        import llvmlite.binding as llvm

        versions = version("numba"), version("llvmlite")
    except ImportError as error:
        raise AttitudeError(f"the kernels cannot be compiled: {error}") from None
    processor = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten(), llvm.get_process_triple()
    return sha256(repr((*versions, processor)).encode()).hexdigest()[:16]
