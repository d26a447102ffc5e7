"""From a kernel's source to an object file, by the public interfaces of numba and llvmlite.

    python -m attitude.runtime.compiler [--processor NAME] FILE...

A file's name is a `Signature.symbol` with the ending .o.  `kernel_cache.run_compilers` runs this in
processes of their own, with NUMBA_OPT=0: numba only translates, and a kernel is optimised once, with
all that it calls.  The function in the file is numba's own, with its calling convention:

    int symbol(void **result, void **exception, arguments...)

An array is seven arguments for one dimension, and two more for each further one (`compiled.flatten`).
With --processor the code is for LLVM's processor of this name, and can be linked to a shared library.
"""

from __future__ import annotations

import argparse
import gc
import os
import tempfile
from importlib import import_module
from pathlib import Path
from typing import Any

import numba
import numpy as np
from llvmlite import binding as llvm

from . import numba_internals
from .signature import ELEMENTS, Signature

EXAMPLES = {"f": 0.0, "i": 0, "n": None}


def object_code(symbol: str, machine: Any) -> bytes:
    """The object file of a kernel for a machine."""
    signature = Signature.of_symbol(symbol)
    kernel = getattr(import_module(f"attitude.kernels.{signature.module}"), signature.kernel)
    types = argument_types(kernel, signature.kinds.split("."))
    kernel.compile(types)
    code = llvm.parse_assembly(kernel.inspect_llvm(types))
    export_as(symbol, code)
    optimise(code, machine)
    return machine.emit_object(code)


def argument_types(kernel: Any, kinds: list[str]) -> tuple[Any, ...]:
    """Numba's types of a kernel's arguments; those of its *argument are one tuple."""
    types = tuple(numba.typeof(example(kind)) for kind in kinds)
    count = kernel.py_func.__code__.co_argcount
    return types if count == len(types) else (*types[:count], numba.types.StarArgTuple(types[count:]))


def example(kind: str) -> Any:
    """A value of this kind, for numba to infer its type."""
    return EXAMPLES[kind] if kind in EXAMPLES else np.empty((1,) * int(kind[1:]), ELEMENTS[kind[0]])


def export_as(symbol: str, code: Any) -> None:
    """Names the kernel's function by its symbol; makes the routines that it calls internal."""
    for function in code.functions:
        if not function.is_declaration:
            if function.linkage == llvm.Linkage.external:
                function.name = symbol
            else:
                function.linkage = "internal"


def optimise(code: Any, machine: Any) -> None:
    """Run LLVM's passes of level 3."""
    options = llvm.create_pipeline_tuning_options(speed_level=3)
    options.loop_vectorization = True
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(code, builder)


def target_machine(processor: str | None) -> Any:
    """The target of code that is linked, for a named processor, or that is loaded by this processor.

    LLVM uses half of AVX-512 by default, for the sake of code that is mostly scalar; loops over samples
    are a third faster in whole vectors (measured by tests/benchmarks/test_speed.py).
    """
    target = llvm.Target.from_triple(llvm.get_process_triple())
    widest = "-prefer-256-bit" if target.triple.startswith("x86_64") else ""
    if processor:
        return target.create_target_machine(processor, widest, opt=3, reloc="pic", codemodel="small")
    features = ",".join(filter(None, [llvm.get_host_cpu_features().flatten(), widest]))
    return target.create_target_machine(llvm.get_host_cpu_name(), features, opt=3, codemodel="jitdefault")


def write_whole(path: Path, content: bytes) -> None:
    """Writes a file atomically, also while other processes write the same one."""
    with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
        file.write(content)
    os.chmod(file.name, 0o644)
    os.replace(file.name, path)


def main() -> None:
    """Compile the kernels that the command line names."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--processor")
    parser.add_argument("files", nargs="+", type=Path)
    options = parser.parse_args()
    gc.disable()  # a compiler makes little garbage before it ends: saves an eighth of its time
    numba_internals.link_routines_once()
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = target_machine(options.processor)
    for file in options.files:
        write_whole(file, object_code(file.stem, machine))


if __name__ == "__main__":
    main()
