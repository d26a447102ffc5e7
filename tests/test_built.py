"""Kernels built ahead: loaded without a compiler, for the processor at hand, with the bits of any other."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys

import numpy as np
import pytest

from attitude import AttitudeError, Scene, build_kernels, built, compiled
from attitude.cost import Problem
from attitude.cost.methods import ours
from attitude.kernels.layout import CompiledName

V3 = built.PROCESSORS["x86_64"]["x86-64-v3"]
V4 = built.PROCESSORS["x86_64"]["x86-64-v4"]
LEAST = list(built.PROCESSORS.get(platform.machine(), ["none"]))[-1]

# In a process where nothing of numba can be imported; argument: where kernels were built.
WITHOUT_NUMBA = """
import sys
from pathlib import Path
sys.modules |= dict.fromkeys(["numba", "llvmlite", "llvmlite.binding"])

import numpy as np
from attitude import built, compiled

built._place = lambda: Path(sys.argv[1])
seconds, days, low = np.array([86400.0, 43200.0, 0.1, 1e10 / 3]), np.empty(4), np.empty(4)
compiled.days_from_seconds(seconds, np.zeros(4), days, low)
print(days.tolist(), low.tolist())
"""

ABSENT = """
import sys
sys.modules["numba"] = None

import numpy as np
from attitude import Scene
from attitude.cost import AbsentError, Problem
from attitude.cost.methods import runge_kutta

try:
    runge_kutta.ladder()[0].prepare(Problem.of_scene(Scene.builtin("toutatis")))(np.linspace(0.0, 1.0, 3))
except AbsentError as error:
    print(error)
"""


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """One small kernel, for the least of this architecture: what differs most from code for the processor."""
    if shutil.which("ld") is None or platform.machine() not in built.PROCESSORS:
        pytest.skip("kernels are linked by ld, on Linux")
    place = tmp_path_factory.mktemp("built")
    name = CompiledName("clock", "days_from_seconds", ("d1",) * 4, built.digest())
    assert build_kernels.build(place, (LEAST,), [[name]]) == 1
    return place


def days_without_numba(place):
    return subprocess.run([sys.executable, "-c", WITHOUT_NUMBA, place], capture_output=True, text=True)


def test_built_kernels_need_no_compiler_and_give_the_bits_of_any_other(place):
    days, low = compiled_days()
    assert days_without_numba(place / LEAST).stdout == f"{days} {low}\n"


def compiled_days():
    seconds, days, low = np.array([86400.0, 43200.0, 0.1, 1e10 / 3]), np.empty(4), np.empty(4)
    compiled.days_from_seconds(seconds, np.zeros(4), days, low)
    return days.tolist(), low.tolist()


def test_kernel_neither_built_nor_compilable_says_what_is_missing(tmp_path):
    run = days_without_numba(tmp_path)
    assert "AttitudeError: the kernels cannot be compiled" in run.stderr
    assert "llvmlite" in run.stderr


def test_kernels_built_of_other_sources_are_not_taken(place, monkeypatch):
    monkeypatch.setattr(built, "_place", lambda: place / LEAST)
    kernel = "clock", "days_from_seconds", ("d1",) * 4
    assert built.find(*kernel)
    monkeypatch.setattr(built, "digest", lambda: "0123456789abcdef")
    assert built.find(*kernel) is None


def test_where_all_is_built_no_compiler_is_asked_for(monkeypatch, tmp_path):
    monkeypatch.setattr(built, "find", lambda *_: tmp_path)
    monkeypatch.setattr(compiled, "_digest", lambda: pytest.fail("the compiler's version was asked for"))
    assert compiled.compile_all() == 0


@pytest.mark.parametrize(
    ("abilities", "machine", "processor"),
    [
        (V4 | {"amx_tile"}, "x86_64", "x86-64-v4"),
        (V4 - {"avx512vl"}, "x86_64", "x86-64-v3"),
        (V3, "x86_64", "x86-64-v3"),
        (V3 - {"fma"}, "x86_64", "x86-64"),
        (frozenset(), "x86_64", "x86-64"),
        (frozenset(), "aarch64", "generic"),
        (V4, "riscv64", None),
    ],
)
def test_kernels_are_those_for_the_most_that_the_processor_can_do(abilities, machine, processor):
    assert built.processor(abilities, machine) == processor


class AskedError(Exception):
    """For a kernel, before it is loaded."""


def test_everything_the_library_calls_and_measures_is_built(monkeypatch):
    built_ahead = [name[:3] for group in build_kernels.names() for name in group]
    called = [each for groups in compiled.SETS for group in groups for each in group]
    assert [(module, kernel, ".".join(kinds)) for module, kernel, kinds in built_ahead[:-1]] == called

    def find(*kernel):
        if kernel[1] == "sample":
            raise AskedError(kernel)

    monkeypatch.setattr(built, "find", find)
    monkeypatch.setattr(compiled, "sample", compiled.Kernel("cayley_klein", "sample"))
    with pytest.raises(AskedError) as asked:
        ours.plain()[0].prepare(Problem.of_scene(Scene.builtin("toutatis")))(np.linspace(0.0, 1.0, 3))
    assert asked.value.args[0] == built_ahead[-1]


def test_methods_of_others_say_that_numba_is_absent_where_it_is():
    run = subprocess.run([sys.executable, "-c", ABSENT], capture_output=True, text=True)
    assert run.stdout.startswith("numba, which compiles the equations of motion, is not installed")


def test_missing_linker_is_one_line(tmp_path, monkeypatch):
    monkeypatch.setitem(os.environ, "PATH", str(tmp_path))
    with pytest.raises(AttitudeError, match="ld is not installed"):
        build_kernels._link(tmp_path / "code.o", tmp_path / "library.so")
