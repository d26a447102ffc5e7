"""Rows of a step's workspace as vectors of the processor, where the compiler finds none by itself."""

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from ..layout import HALF, NODES, ROWS_PER_EFFECT, StepRow

VECTOR, MAGNITUDES = (ir.VectorType(kind, HALF) for kind in (ir.DoubleType(), ir.IntType(64)))
ROWS = 4  # that are integrated together: sums of several do not wait for one another


@intrinsic
def integrate(typingctx, work, slopes, integrals):
    """Integrals of ROWS rows of slopes up to the nodes; both begin at these numbers of the workspace.

    Returns by how much one of them differs from the number that it replaces, at the most; NaN if any is.

    That from the middle of the step to a node is the integral of the even part of a function, odd in the
    node, and that of its odd part, even in the node: sums and differences of mirrored nodes, half of all
    products each.
    """

    def codegen(context, builder, signature, args):
        rows = _Rows(context, builder, signature.args[0], args[0])
        of_sums = [rows.load(rows.at(NODES * (StepRow.MATRIX + j))) for j in range(HALF)]
        of_differences = [rows.load(rows.at(NODES * (StepRow.MATRIX + j) + HALF)) for j in range(HALF)]
        weights = rows.load(rows.at(NODES * StepRow.WEIGHT))
        weight = [rows.spread(weights, j) for j in range(HALF)]
        greatest = ir.Constant(MAGNITUDES, [0] * HALF)
        for row in range(ROWS):
            one, other = (rows.load(rows.at(NODES * row + half, args[1])) for half in (0, HALF))
            sums, differences = builder.fadd(one, other), builder.fsub(one, other)
            odd = even = whole = ir.Constant(VECTOR, [0.0] * HALF)
            for j in range(HALF):
                total, difference = rows.spread(sums, j), rows.spread(differences, j)
                odd = rows.fma(of_sums[j], total, odd)
                even = rows.fma(of_differences[j], difference, even)
                whole = rows.fma(weight[j], total, whole)
            mirrored = builder.fadd(builder.fsub(whole, odd), even)
            for half, integral in ((0, builder.fadd(odd, even)), (HALF, mirrored)):
                address = rows.at(NODES * row + half, args[2])
                change = rows.magnitudes(builder.fsub(integral, rows.load(address)))
                greatest = rows.call("llvm.smax", MAGNITUDES, greatest, change)
                rows.store(integral, address)
        reduced = rows.call("llvm.vector.reduce.smax", ir.IntType(64), greatest)
        return builder.bitcast(reduced, ir.DoubleType())

    return types.float64(work, types.int64, types.int64), codegen


@intrinsic
def copy_effect(typingctx, work, origin, target):
    """Copy what is known of an effect, ROWS_PER_EFFECT rows, from one number of the workspace to another."""

    def codegen(context, builder, signature, args):
        rows = _Rows(context, builder, signature.args[0], args[0])
        for first in range(0, ROWS_PER_EFFECT * NODES, HALF):
            rows.store(rows.load(rows.at(first, args[1])), rows.at(first, args[2]))
        return context.get_dummy_value()

    return types.void(work, types.int64, types.int64), codegen


class _Rows:
    """Instructions on half rows of a workspace."""

    def __init__(self, context: Any, builder: ir.IRBuilder, kind: Any, work: ir.Value):
        self._builder, self._data = builder, context.make_array(kind)(context, builder, work).data

    def at(self, number: int, first: ir.Value | None = None) -> ir.Value:
        """The address of a number of the workspace, counted from `first`."""
        index = ir.Constant(ir.IntType(64), number)
        index = index if first is None else self._builder.add(first, index)
        return self._builder.bitcast(self._builder.gep(self._data, [index]), VECTOR.as_pointer())

    def load(self, address: ir.Value) -> ir.Value:
        return self._builder.load(address, align=8)

    def store(self, vector: ir.Value, address: ir.Value) -> None:
        self._builder.store(vector, address, align=8)

    def spread(self, vector: ir.Value, j: int) -> ir.Value:
        """Component j, in all places."""
        places = ir.Constant(ir.VectorType(ir.IntType(32), HALF), [j] * HALF)
        return self._builder.shuffle_vector(vector, vector, places)

    def fma(self, a: ir.Value, b: ir.Value, c: ir.Value) -> ir.Value:
        return self.call("llvm.fma", VECTOR, a, b, c)

    def magnitudes(self, vector: ir.Value) -> ir.Value:
        """The bits of absolute values, which are ordered as integers, NaN last."""
        bits = self._builder.bitcast(vector, MAGNITUDES)
        return self._builder.and_(bits, ir.Constant(MAGNITUDES, [(1 << 63) - 1] * HALF))

    def call(self, name: str, kind: ir.Type, *vectors: ir.Value) -> ir.Value:
        """An instruction of LLVM's on half rows, which returns a value of this type."""
        of_integers = vectors[0].type == MAGNITUDES
        name = f"{name}.v{HALF}{'i' if of_integers else 'f'}64"
        module, function_type = self._builder.module, ir.FunctionType(kind, [each.type for each in vectors])
        instruction = module.globals.get(name) or ir.Function(module, function_type, name)
        return self._builder.call(instruction, vectors)
