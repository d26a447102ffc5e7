"""Compilation of kernels, and instructions that numba does not offer."""

from llvmlite import ir
from numba import njit, types
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, intrinsic

# error_model="numpy": division without a test for zero, which would prevent vectorisation.
# No fastmath: reassociation and contraction would break the two-part arithmetic.
# No allocation: compiled kernels run without numba's runtime.
# `kernel` marks functions that attitude/runtime/compiled.py calls, `routine` those that kernels call.
OPTIONS = {"error_model": "numpy", "nogil": True, "_nrt": False}
routine = kernel = njit(**OPTIONS, no_cpython_wrapper=True, no_cfunc_wrapper=True)
# For functions in inner loops: a call that is not inlined prevents vectorisation.
inlined = njit(**OPTIONS, no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline=True)


@infer_getattr
class IntegerMembers(AttributeTemplate):
    """Members of an IntEnum are plain integers: as types of their own they would multiply routines."""

    key = types.IntEnumClass

    def generic_resolve(self, ty, attr):
        """The type of a member."""
        if attr in ty.instance_class.__members__:
            return ty.dtype
        return None


@intrinsic
def fma(typingctx, a, b, c):
    """a*b + c rounded once (float64)."""
    signature = types.float64(types.float64, types.float64, types.float64)

    def codegen(context, builder, signature, args):
        double = ir.DoubleType()
        function_type = ir.FunctionType(double, [double, double, double])
        instruction = builder.module.declare_intrinsic("llvm.fma", [double], function_type)
        return builder.call(instruction, args)

    return signature, codegen


@intrinsic
def bits_of(typingctx, x):
    """The 64 bits of a double, as an integer."""

    def codegen(context, builder, signature, args):
        return builder.bitcast(args[0], ir.IntType(64))

    return types.int64(types.float64), codegen


@intrinsic
def double_of(typingctx, bits):
    """The double that has these 64 bits."""

    def codegen(context, builder, signature, args):
        return builder.bitcast(args[0], ir.DoubleType())

    return types.float64(types.int64), codegen


@intrinsic
def high_product(typingctx, a, b):
    """The upper 64 bits of the product of two 64-bit integers without signs."""

    def codegen(context, builder, signature, args):
        wide = ir.IntType(128)
        product = builder.mul(builder.zext(args[0], wide), builder.zext(args[1], wide))
        return builder.trunc(builder.lshr(product, ir.Constant(wide, 64)), ir.IntType(64))

    return types.uint64(types.uint64, types.uint64), codegen
