"""Every compiled loop ends soon after its computation is stopped (attitude/stopping.py).

A loop reads the stop, as `halted[0]`; or constants of its module limit it to SHORT turns; or BOUNDED says why
it is short.
"""

from __future__ import annotations

import ast
from importlib import import_module
from pathlib import Path

import pytest

import attitude

ROOT = Path(attitude.__file__).parent
COMPILING = {"kernel", "routine", "inlined", "njit"}  # decorators
SHORT = 5000  # turns of a few microseconds at the most

# Of a module, its loops over ranges; of a function, those with `while` too.
CHUNKS = "one pass over an array, which service requests limit to a million numbers: some 10 ms"
POINTS = "one pass over the points of a body, some ns each, within a step or sweep that reads the stop"
ROWS = "one pass over the rows of a scene's effects, within a step that reads the stop"
FIXED = "a number of turns that the lengths of fixed arrays give"
BOUNDED = {
    "kernels.cayley_klein": CHUNKS,
    "kernels.clock": CHUNKS,
    "kernels.invariants": "one pass over bodies, of which a request has one",
    "kernels.lanes": "one pass over bodies, of which a request has one",
    "kernels.principal": "one pass over bodies, of which a request has one",
    "kernels.expansion": "at most 4**4 terms: the products of four numbers of two parts",
    "kernels.elliptic.mean_with_one": "the mean of doubles converges in 12 turns",
    "kernels.gyrostat.attitudes": CHUNKS,
    "kernels.gyrostat.base": FIXED,
    "kernels.gyrostat.record": "one pass over bodies, of which a request has one",
    "kernels.interpolation": "one pass over at most 2**18 intervals, 16 nodes and 128 fractions: 0.2 s",
    "kernels.partials": "one pass over instants, 0.2 us each, and over at most twelve columns",
    "kernels.contact": POINTS,
    "kernels.solvers.collocation": FIXED,
    "kernels.solvers.collocation._march": "halvings of a step, of which there are no more than MAX_HALVINGS",
    "kernels.solvers.orbit_path": "the degree of a polynomial",
    "kernels.solvers.torque": ROWS,
    "kernels.solvers.plate_sources": ROWS,
    "kernels.solvers.plate_sources.log_density": "halvings of the pieces, and the degree of a polynomial",
    "kernels.solvers.edge_search": ROWS,
    "kernels.solvers.edge_search._edge_of": "at most 40,000 steps of 5e-5 between -1 and 1: 0.4 ms",
    "kernels.solvers.plate_march._interval": "one pass over the cuts of a span, some ns each",
    "kernels.solvers.plate_march._instants_before": CHUNKS,
    "kernels.solvers.plate_march": "one pass over cuts, instants or user functions, within arcs that read it",
    "kernels.statistics": "one pass over a block of bodies, in ensembles only",
    "cost.methods.euler.normalise": CHUNKS,
    "cost.methods.torques": ROWS,
    "cost.methods.torques.log_density": "one pass over the pieces of a density, 1 ns each, and a degree",
}


def compiled_loops(path):
    """(function, loop) of each loop in the compiled functions of a source file."""
    for function in ast.walk(ast.parse(path.read_text())):
        if isinstance(function, ast.FunctionDef):
            decorators = {getattr(each, "id", "") for each in function.decorator_list}
            if decorators & COMPILING:
                loops = (each for each in ast.walk(function) if isinstance(each, ast.For | ast.While))
                yield from ((function.name, loop) for loop in loops)


@pytest.fixture(scope="module")
def loops_of():
    """The loops of each module that has any, by its name."""
    each = {path: [*compiled_loops(path)] for path in sorted(ROOT.rglob("*.py"))}
    return {
        ".".join(path.relative_to(ROOT).with_suffix("").parts): loops for path, loops in each.items() if loops
    }


def reads_stop(loop):
    subscripts = (node.value for node in ast.walk(loop) if isinstance(node, ast.Subscript))
    return any(getattr(value, "id", "") == "halted" for value in subscripts)


def is_short(loop, name):
    """Whether it runs over a tuple, or over a short range or tuple of constants of the module."""
    if isinstance(loop, ast.While) or isinstance(loop.iter, ast.Tuple):
        return isinstance(loop, ast.For)
    module, expression = import_module(f"attitude.{name}"), compile(ast.Expression(loop.iter), name, "eval")
    try:
        return len(eval(expression, dict(vars(module)))) <= SHORT
    except NameError:  # of a local variable
        return False


def is_bounded(function, loop, name):
    entries = {f"{name}.{function}"}
    if isinstance(loop, ast.For):
        entries |= {name, name.rpartition(".")[0]}
    return bool(entries & set(BOUNDED))


def test_compiled_loops_read_the_stop_or_are_short(loops_of):
    endless = [
        f"attitude.{name}:{loop.lineno} ({function})"
        for name, loops in loops_of.items()
        for function, loop in loops
        if not (reads_stop(loop) or is_short(loop, name) or is_bounded(function, loop, name))
    ]
    assert not endless, "neither halted[0] is read nor an entry of BOUNDED stands for:\n" + "\n".join(endless)


def test_sources_with_compiled_loops_are_found(loops_of):
    found = {name.rpartition(".")[2] for name in loops_of}
    assert {"collocation", "flight", "impact", "interpolation", "euler"} <= found
    assert "kernels.contact.flight" in loops_of


def test_entries_stand_for_loops_that_neither_read_the_stop_nor_are_short(loops_of):
    needed = {
        entry
        for name, loops in loops_of.items()
        for function, loop in loops
        if not reads_stop(loop) and not is_short(loop, name)
        for entry in (f"{name}.{function}", name, name.rpartition(".")[0])
    }
    assert set(BOUNDED) <= needed


def test_loop_without_either_is_found():
    loops = ast.parse("while x[0] > 0.0: pass\nfor i in range(n): pass").body
    for loop in loops:
        checks = reads_stop(loop), is_short(loop, "kernels.phase"), is_bounded("f", loop, "kernels.phase")
        assert checks == (False, False, False)
