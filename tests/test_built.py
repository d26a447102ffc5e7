"""Kernels built ahead: loaded without a compiler, for the processor at hand, with the bits of any other."""

from __future__ import annotations

import ctypes
import os
import platform
import shutil
import subprocess
import sys

import numpy as np
import pytest

from attitude import AttitudeError, Scene
from attitude.cost import InitialValueProblem
from attitude.cost.methods import ours
from attitude.rigid_body.constants_of_motion import Batch
from attitude.runtime import build, compiled, kernel_cache, prebuilt, signature
from attitude.runtime.signature import Signature

DAYS = Signature("clock", "days_from_seconds", "d1.d1.d1.d1")
V3 = prebuilt.PROCESSORS["x86_64"]["x86-64-v3"]
V4 = prebuilt.PROCESSORS["x86_64"]["x86-64-v4"]
LEAST = list(prebuilt.PROCESSORS.get(platform.machine(), ["none"]))[-1]

# In a process where nothing of numba can be imported; argument: the library that was built.
WITHOUT_NUMBA = """
import sys
import ctypes
sys.modules |= dict.fromkeys(["numba", "llvmlite", "llvmlite.binding"])

import numpy as np
from attitude.runtime import compiled, prebuilt

prebuilt._library = lambda: ctypes.CDLL(sys.argv[1])
seconds, days, low = np.array([86400.0, 43200.0, 0.1, 1e10 / 3]), np.empty(4), np.empty(4)
compiled.days_from_seconds(seconds, np.zeros(4), days, low)
print(days.tolist(), low.tolist())
"""

ABSENT = """
import sys
sys.modules["numba"] = None

import numpy as np
from attitude import Scene
from attitude.cost import AbsentError, InitialValueProblem
from attitude.cost.methods import fixed_step

try:
    problem = InitialValueProblem.of_scene(Scene.builtin("toutatis"))
    fixed_step.methods()[0].prepare(problem)(np.linspace(0.0, 1.0, 3))
except AbsentError as error:
    print(error)
"""


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """One small kernel, for the least of this architecture: what differs most from code for the processor."""
    if shutil.which("ld") is None or platform.machine() not in prebuilt.PROCESSORS:
        pytest.skip("kernels are linked by ld, on Linux")
    library = tmp_path_factory.mktemp("built") / f"{LEAST}.so"
    build.build(library, LEAST, [[DAYS]])
    return library


def days_without_numba(library):
    return subprocess.run([sys.executable, "-c", WITHOUT_NUMBA, library], capture_output=True, text=True)


def test_built_kernels_need_no_compiler_and_give_the_bits_of_any_other(library):
    days, low = compiled_days()
    assert days_without_numba(library).stdout == f"{days} {low}\n"


def compiled_days():
    seconds, days, low = np.array([86400.0, 43200.0, 0.1, 1e10 / 3]), np.empty(4), np.empty(4)
    compiled.days_from_seconds(seconds, np.zeros(4), days, low)
    return days.tolist(), low.tolist()


def test_kernel_neither_built_nor_compilable_says_what_is_missing():
    run = days_without_numba("")  # the process itself, which has no kernels
    assert "AttitudeError: the kernels cannot be compiled" in run.stderr
    assert "llvmlite" in run.stderr


def test_kernels_built_of_other_sources_are_not_loaded(library, monkeypatch):
    monkeypatch.setattr(prebuilt, "_library", lambda: ctypes.CDLL(str(library)))
    assert prebuilt.address(DAYS)
    monkeypatch.setattr(signature, "source_digest", lambda module: "0123456789abcdef")
    assert prebuilt.address(DAYS) is None


def test_where_all_is_built_the_compiler_is_not_used(monkeypatch):
    monkeypatch.setattr(prebuilt, "address", lambda signature: 1)
    monkeypatch.setattr(
        kernel_cache, "_compiler_digest", lambda: pytest.fail("the compiler's version was asked for")
    )
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
    assert prebuilt.processor(abilities, machine) == processor


class AskedError(Exception):
    """For a kernel, before it is loaded."""


def test_everything_the_library_calls_and_measures_is_built(monkeypatch):
    def is_kept(signature):
        if signature.kernel == "sample":
            raise AskedError(signature)
        return True

    monkeypatch.setattr(kernel_cache, "is_kept", is_kept)
    monkeypatch.setattr(Batch, "sample_kernel", compiled.Kernel("cayley_klein.sample"))
    with pytest.raises(AskedError) as asked:
        ours.methods()[0].prepare(InitialValueProblem.of_scene(Scene.builtin("toutatis")))(
            np.linspace(0.0, 1.0, 3)
        )
    assert asked.value.args[0] in [signature for group in build.signatures() for signature in group]


def test_methods_of_others_say_that_numba_is_absent_where_it_is():
    run = subprocess.run([sys.executable, "-c", ABSENT], capture_output=True, text=True)
    assert run.stdout.startswith("numba, which compiles the equations of motion, is not installed")


def test_missing_linker_is_one_line(tmp_path, monkeypatch):
    monkeypatch.setitem(os.environ, "PATH", str(tmp_path))
    with pytest.raises(AttitudeError, match="ld is not installed"):
        build.link([tmp_path / "code.o"], tmp_path / "library.so")
