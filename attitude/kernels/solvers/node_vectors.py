"""Rows of a step's workspace as vectors of the processor, where the compiler finds none by itself."""

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from ..layout import HALF, KNOWN_ROWS, MATRIX, NODES, WEIGHTS

VECTOR = ir.VectorType(ir.DoubleType(), HALF)
ROWS = 4  # that are integrated together: sums of several do not wait for one another


@intrinsic
def integrate(typingctx, work, slopes, integrals):
    """Integrals of ROWS rows of slopes up to the nodes; both begin at these numbers of the workspace.

    That from the middle of the step to a node is the integral of the even part of a function, odd in the
    node, and that of its odd part, even in the node: sums and differences of mirrored nodes, half of all
    products each.
    """

    def codegen(context, builder, signature, args):
        rows = _Rows(context, builder, signature.args[0], args[0])
        of_sums = [rows.load(rows.at(NODES * (MATRIX + j))) for j in range(HALF)]
        of_differences = [rows.load(rows.at(NODES * (MATRIX + j) + HALF)) for j in range(HALF)]
        weights = rows.load(rows.at(NODES * WEIGHTS))
        weight = [rows.spread(weights, j) for j in range(HALF)]
        for row in range(ROWS):
            one, other = (rows.load(rows.at(NODES * row + half, args[1])) for half in (0, HALF))
            sums, differences = builder.fadd(one, other), builder.fsub(one, other)
            odd = even = whole = ir.Constant(VECTOR, [0.0] * HALF)
            for j in range(HALF):
                total, difference = rows.spread(sums, j), rows.spread(differences, j)
                odd = rows.fma(of_sums[j], total, odd)
                even = rows.fma(of_differences[j], difference, even)
                whole = rows.fma(weight[j], total, whole)
            rows.store(builder.fadd(odd, even), rows.at(NODES * row, args[2]))
            mirrored = builder.fadd(builder.fsub(whole, odd), even)
            rows.store(mirrored, rows.at(NODES * row + HALF, args[2]))
        return context.get_dummy_value()

    return types.void(work, types.int64, types.int64), codegen


@intrinsic
def copied_known(typingctx, work, origin, target):
    """Copy what is known of an effect, KNOWN_ROWS rows, from one number of the workspace to another."""

    def codegen(context, builder, signature, args):
        rows = _Rows(context, builder, signature.args[0], args[0])
        for first in range(0, KNOWN_ROWS * NODES, HALF):
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
        module, name = self._builder.module, f"llvm.fma.v{HALF}f64"
        function_type = ir.FunctionType(VECTOR, [VECTOR] * 3)
        instruction = module.globals.get(name) or ir.Function(module, function_type, name)
        return self._builder.call(instruction, [a, b, c])
