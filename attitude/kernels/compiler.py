"""Numba as a compiler: kernels in, machine code out, as files that need nothing of numba's to run.

    python -m attitude.kernels.compiler [--to-link] DIRECTORY FILE...

A file's name, a `layout.CompiledName`, says what is to be in it.  `attitude.compiled` runs this in
processes of their own.  With --to-link a linker can make shared libraries of the code, by which
attitude/build_kernels.py does without numba's loader too.

Numba would optimise, and translate to machine code, every routine by itself and again in each
routine that calls it; here routines are only linked into the kernel, which is optimised once.
"""

import gc
import os
import sys
import tempfile
from importlib import import_module
from pathlib import Path

from llvmlite import binding, ir
from numba import types
from numba.core import cgutils, codegen, compiler, registry
from numba.core.compiler_lock import global_compiler_lock
from numba.extending import intrinsic
from numba.np import arrayobj
from numba.np.numpy_support import from_dtype

from .intrinsics import OPTIONS, prefer_widest_vectors
from .layout import ENTRY, INVARIANTS, CompiledName

TO_LINK = "--to-link"
SCALARS = {"f": types.float64, "i": types.int64, "n": types.none}
ELEMENTS = {
    "d": types.float64,
    "b": types.boolean,
    "i": types.int64,
    "r": from_dtype(INVARIANTS),
}


def argument_type(kind):
    """The numba type of an argument's kind: "f", "i", "n", or element and dimensions, such as "d2"."""
    return SCALARS[kind] if kind in SCALARS else types.Array(ELEMENTS[kind[0]], int(kind[1:]), "C")


def arguments_from(kinds):
    """An intrinsic that reads a kernel's arguments from words: address and shape, or bits, or nothing."""
    wanted = tuple(argument_type(kind) for kind in kinds)

    @intrinsic
    def arguments(typingctx, words):
        def codegen(context, builder, signature, args):
            place = 0

            def word():
                nonlocal place
                place += 1
                index = ir.Constant(ir.IntType(64), place - 1)
                return builder.load(builder.gep(args[0], [index]))

            values = [_read(context, builder, kind, word) for kind in wanted]
            return context.make_tuple(builder, signature.return_type, values)

        return types.Tuple(wanted)(words), codegen

    return arguments


def _read(context, builder, kind, word):
    if isinstance(kind, types.Array):
        return _read_array(context, builder, kind, word)
    if kind is types.float64:
        return builder.bitcast(word(), ir.DoubleType())
    return word() if kind is types.int64 else context.get_dummy_value()


def _read_array(context, builder, kind, word):
    array = context.make_array(kind)(context, builder)
    pointer = builder.inttoptr(word(), array.data.type)
    shape = [word() for _ in range(kind.ndim)]
    size = context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(kind.dtype)))
    strides = [size]
    for extent in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], extent))
    arrayobj.populate_array(
        array,
        data=pointer,
        shape=cgutils.pack_array(builder, shape),
        strides=cgutils.pack_array(builder, strides),
        itemsize=size,
        meminfo=None,
    )
    return array._getvalue()


class LinkedOnce(codegen.JITCodeLibrary):
    """A routine's code: kept as it is written, for the kernel that calls it to link."""

    def add_linking_library(self, library):
        self._linking_libraries.append(library)

    def _optimize_functions(self, ll_module):
        ll_module.data_layout = self._codegen._data_layout

    def finalize(self):
        raise AssertionError("no routine is to become machine code by itself")

    def link(self):
        """The module with all that it calls, optimised once."""
        for library in _called(self, {}):
            module = library._final_module.clone()
            for function in module.functions:
                if not function.is_declaration and function.linkage == binding.Linkage.external:
                    function.linkage = "linkonce_odr"
            self._final_module.link_in(module, preserve=True)
        self._optimize_final_module()
        self._final_module.verify()
        return self._final_module


def _called(library, seen):
    """All libraries that one calls, and those that they call, once each."""
    for other in library._linking_libraries:
        if other not in seen:
            seen[other] = None
            _called(other, seen)
    return seen


def object_code(module, name, kinds, to_link):
    """Machine code of one kernel for arguments of these kinds; entry point `ENTRY`, of one address."""
    kernel = getattr(import_module(f"{__package__}.{module}"), name)
    arguments = arguments_from(kinds)

    def entry(words):
        prefer_widest_vectors()
        kernel(*arguments(words))

    target = registry.cpu_target
    flags = compiler.Flags()
    flags.no_compile = flags.no_cpython_wrapper = flags.no_cfunc_wrapper = flags.release_gil = True
    flags.error_model = OPTIONS["error_model"]
    words = (types.CPointer(types.int64),)
    with global_compiler_lock:
        result = compiler.compile_extra(
            target.typing_context, target.target_context, entry, words, types.none, flags, {}
        )
        _add_entry_point(target.target_context, result)
        codegen = target.target_context.codegen()
        machine = _machine_to_link(codegen) if to_link else codegen._tm
        return machine.emit_object(result.library.link())


def _machine_to_link(codegen):
    """Numba's own emits code that stays where it is loaded first: a library's is loaded anywhere."""
    target = binding.Target.from_triple(binding.get_process_triple())
    processor, features = codegen._get_host_cpu_name(), codegen._tm_features
    return target.create_target_machine(processor, features, reloc="pic", codemodel="small", opt=3)


def _add_entry_point(context, result):
    """A C function of one pointer around numba's own calling convention."""
    module = result.library.create_ir_module(ENTRY)
    words = ir.IntType(64).as_pointer()
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), [words]), ENTRY)
    builder = ir.IRBuilder(function.append_basic_block())
    native = context.declare_function(module, result.fndesc)
    context.call_conv.call_function(builder, native, types.none, result.fndesc.argtypes, function.args)
    builder.ret_void()
    result.library.add_ir_module(module)


def prepare():
    """Make this process one that only compiles: nothing that numba compiles from here on can be called."""
    gc.disable()  # little of what a compiler makes is garbage before it ends: an eighth of its time
    target = registry.cpu_target
    target.typing_context.refresh()
    target.target_context.refresh()
    target.target_context.codegen()._library_class = LinkedOnce
    # numba keys its functions by this: any callable, a new one each time
    target.target_context.get_executable = lambda library, fndesc, env: [].append


def main(arguments):
    to_link = arguments[0] == TO_LINK
    directory, *names = arguments[to_link:]
    prepare()
    for name in names:
        code = object_code(*CompiledName.parse(name)[:3], to_link)
        with tempfile.NamedTemporaryFile(dir=directory, delete=False) as file:
            file.write(code)
        os.chmod(file.name, 0o644)
        os.replace(file.name, Path(directory) / name)  # whole or absent, whoever else compiles it now


if __name__ == "__main__":
    main(sys.argv[1:])
