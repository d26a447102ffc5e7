"""Who may import whom: read off the source, and off what an import loads."""

import ast
import re
import subprocess
import sys
from collections import Counter
from functools import cache
from pathlib import Path

import attitude
import attitude.kernels

ROOT = Path(attitude.__file__).parent
MODULES = {
    ".".join(path.relative_to(ROOT.parent).with_suffix("").parts).removesuffix(".__init__"): path
    for path in sorted(ROOT.rglob("*.py"))
}
KERNELS = [name for name in MODULES if name.startswith("attitude.kernels.")]
SERVICE = sorted((ROOT.parent / "service").glob("*.py"))


def statements(tree, everywhere):
    """Import statements: all, or those that run when the module is imported."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            yield node
        elif everywhere:
            yield from statements(node, everywhere)
        elif isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)):
            continue
        elif isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            yield from (found for other in node.orelse for found in statements(other, everywhere))
        else:
            yield from statements(node, everywhere)


@cache
def syntax_tree(path):
    return ast.parse(path.read_text())


def imported(path, package, everywhere=True):
    """Absolute names of what a file imports; names imported from a module follow its own."""
    for node in statements(syntax_tree(path), everywhere):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        else:
            parts = package.split(".")
            base = parts[: len(parts) - node.level + 1] if node.level else []
            module = ".".join([*base, *([node.module] if node.module else [])])
            yield from (f"{module}.{alias.name}" for alias in node.names)


@cache
def names_imported(name, everywhere=True):
    """Absolute names of what a module of the library imports."""
    package = name if MODULES[name].name == "__init__.py" else name.rpartition(".")[0]
    return frozenset(imported(MODULES[name], package, everywhere))


@cache
def modules_imported(name, everywhere=True):
    """Which of the library's modules a module imports."""
    found = set()
    for target in names_imported(name, everywhere):
        while target and target not in MODULES:
            target = target.rpartition(".")[0]
        found.add(target)
    return found - {"", name}


def tops(names):
    return {name.split(".")[0] for name in names}


def test_source_is_read_as_python_reads_it():
    assert {"attitude.motion", "attitude.formats.tables.csv", "attitude.kernels.clock"} <= set(MODULES)
    assert "attitude.kernels.doubledouble" in modules_imported("attitude.kernels.elliptic")
    assert {"attitude.units", "attitude.errors"} <= modules_imported("attitude.rigid_body.body")
    assert "attitude.scene.scene" in modules_imported("attitude.cli.command")
    assert "attitude.scene.scene" not in modules_imported("attitude.cli.command", everywhere=False)


# -- wings --------------------------------------------------------------------------------------

# From the ground up: a module imports from its own wing and from those before it, and from no other.
# Imports inside functions and those for type checkers count too.
WINGS = (
    "errors stopping version oracle",
    "units kernels",
    "runtime",
    "times",
    "documents frames",
    "rigid_body",
    "samples problem",
    "pointing dynamics",
    "formats plot",
    "orbit windows",
    "ephemeris effects",
    "motion quality",
    "scene",
    "ensemble cost estimation",
    "cli",
)
FLOOR = {wing: floor for floor, wings in enumerate(WINGS) for wing in wings.split()}


def wing(name):
    return name.split(".")[1]


def test_every_module_has_a_wing_and_every_wing_a_module():
    assert {wing(name) for name in MODULES if name != "attitude"} == set(FLOOR)


def test_imports_run_down():
    upward = {
        (name, other)
        for name in MODULES.keys() - {"attitude"}
        for other in modules_imported(name)
        if other == "attitude" or (wing(other) != wing(name) and FLOOR[wing(other)] >= FLOOR[wing(name)])
    }
    assert not upward


def test_no_module_imports_itself_in_a_circle():
    graph = {name: modules_imported(name) for name in MODULES if name != "attitude"}
    while graph:
        free = [name for name, needed in graph.items() if not needed & graph.keys()]
        assert free, {name: needed & graph.keys() for name, needed in graph.items()}
        for name in free:
            del graph[name]


# The same role in sibling packages: a package and the module that carries it, kernels and their caller.
SHARED_ROLES = {
    *(
        "ensemble",
        "orbit",
        "plot",
        "scene",
        "contact",
        "solvers",
        "statistics",
        "dispersion",
        "parquet",
        "partials",
    ),
    *("check", "compare", "fit", "instants", "interpolation", "windows"),
}


def test_module_names_stand_once():
    names = Counter(name.rpartition(".")[2] for name in MODULES)
    assert {name for name, count in names.items() if count > 1} <= SHARED_ROLES


SHARED_CLASSES: set[str] = set()


def test_public_classes_have_names_of_their_own():
    names = Counter(
        node.name
        for path in MODULES.values()
        for node in syntax_tree(path).body
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    )
    assert {name for name, count in names.items() if count > 1} <= SHARED_CLASSES


# -- kernels ------------------------------------------------------------------------------------


def test_kernels_know_numbers_and_nothing_else():
    names = set().union(*map(names_imported, KERNELS))
    ours = {target for target in names if target.startswith("attitude")}
    assert all(target.startswith("attitude.kernels.") for target in ours)
    assert tops(names - ours) <= {"numpy", "numba", "llvmlite"} | sys.stdlib_module_names


def kernels_in_order():
    """The modules of the calculation, as the package's docstring lists them."""
    return re.findall(r"(?m)^ +([\w.]+) +\S", attitude.kernels.__doc__)


def test_every_kernel_has_its_place_in_the_calculation():
    modules = [name for name in KERNELS if MODULES[name].name != "__init__.py"]
    assert sorted(kernels_in_order()) == sorted(name.removeprefix("attitude.kernels.") for name in modules)


def test_kernels_import_from_those_before_them():
    order = [f"attitude.kernels.{module}" for module in kernels_in_order()]
    assert not {
        name: later for k, name in enumerate(order) if (later := modules_imported(name) - {*order[:k]})
    }


# -- library and service ------------------------------------------------------------------------


def test_library_knows_no_http():
    http = {"fastapi", "uvicorn", "starlette", "httpx", "service"}
    uses = {(name, target) for name in MODULES for target in names_imported(name) if tops([target]) & http}
    assert uses == {("attitude.cli.command", "service.serve")}  # the command that starts the service


def test_service_reaches_no_kernel():
    names = {name for path in SERVICE for name in imported(path, "service")}
    assert "attitude.errors.AttitudeError" in names
    assert not any(name.startswith("attitude.kernels") for name in names)


ORACLE = {name for name in MODULES if name.startswith("attitude.oracle")}


def test_oracle_judges_and_never_computes():
    users = {name for name in MODULES.keys() - ORACLE if modules_imported(name) & ORACLE}
    assert users
    assert all(name.startswith("attitude.cost") for name in users)


def test_oracle_knows_nothing_of_what_it_judges():
    names = set().union(*map(names_imported, ORACLE))
    assert set().union(*map(modules_imported, ORACLE)) <= ORACLE
    assert tops(names) <= {"attitude", "mpmath", "gmpy2"} | sys.stdlib_module_names


# -- what an import loads -----------------------------------------------------------------------


SAMPLES = """
import sys
from attitude import Ephemeris, RigidBody, TorqueFreeMotion
TorqueFreeMotion(RigidBody((1, 2, 2.5)), (1, 0, 0, 0), (1, 2, 3), order="wxyz").at(5.0)
print(*sys.modules)
"""


def test_library_and_its_samples_load_no_more_than_they_need():
    run = subprocess.run([sys.executable, "-c", SAMPLES], capture_output=True, text=True, check=True)
    modules = set(run.stdout.split())
    assert "attitude.motion" in modules
    heavy = {
        "numba",
        "pydantic",
        "scipy.spatial",
        "matplotlib",
        "mpmath",
        "attitude.cost",
        "fastapi",
        "uvicorn",
        "orjson",
        "hypothesis",
        "service",
    }
    assert not modules & heavy
