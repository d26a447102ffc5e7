"""Machine code of the kernels: kept, found again, of the sources at hand, and needing no compiler."""

import os
import re
import shutil
import subprocess
import sys
import threading
import tomllib
from pathlib import Path

import numba
import numpy as np
import pytest

from attitude import AttitudeError, RigidBody, TorqueFreeMotion
from attitude.runtime import compiled, kernel_cache, numba_internals, signature
from attitude.runtime.signature import Signature, modules_of, source_digest

# One kernel of little code, in a process that has nothing else to compile.
SEVERAL_DAYS = """
import sys
import numpy as np
from attitude.runtime import compiled, kernel_cache, prebuilt

prebuilt.address = lambda _: None
compiled.WINGS[:] = []
announced = []
kernel_cache.on_compilation.append(announced.append)
seconds, days, low = np.array([86400.0, 43200.0]), np.empty(2), np.empty(2)
compiled.days_from_seconds(seconds, np.zeros(2), days, low)
assert days.tolist() == [1.0, 0.5]
assert "numba" not in sys.modules
print(*announced)
"""
DAYS = Signature("clock", "days_from_seconds", "d1.d1.d1.d1")


def announced_compilations(cache):
    run = subprocess.run(
        [sys.executable, "-c", SEVERAL_DAYS],
        env=os.environ | {"ATTITUDE_CACHE_DIR": str(cache)},
        capture_output=True,
        text=True,
        check=True,
    )
    return run.stdout.split()


def test_code_is_compiled_once_and_found_again(tmp_path):
    cache = tmp_path / "new" / "place"
    assert announced_compilations(cache) == ["1"]
    (object_file,) = cache.rglob("*.o")
    assert object_file.stem == DAYS.symbol
    assert announced_compilations(cache) == []


def test_without_a_place_to_keep_it_code_is_compiled_and_runs(tmp_path):
    occupied = tmp_path / "file"
    occupied.write_text("no directory can be here")
    for _ in range(2):
        assert announced_compilations(occupied) == ["1"]


def test_a_compiler_that_fails_says_so_in_one_line():
    with pytest.raises(AttitudeError, match=r"the kernels cannot be compiled: .*nothing"):
        compiled.Kernel("clock.nothing")(1.0)


def test_symbol_says_whose_code_it_is():
    assert re.fullmatch(r"clock\.days_from_seconds-d1\.d1\.d1\.d1-[0-9a-f]{16}", DAYS.symbol)
    assert Signature.of_symbol(DAYS.symbol) == DAYS


def test_kernels_refuse_arrays_in_another_order():
    t = np.arange(6.0)
    with pytest.raises(TypeError, match="C order"):
        compiled.days_from_seconds(t[::2], t[::2], t[::2], t[::2])


# -- without numba's private classes ----------------------------------------------------------------

# One kernel of much code, in a process that has nothing else to compile.
SAMPLES = """
import sys
import numpy as np
from attitude.runtime import compiled, prebuilt

prebuilt.address = lambda _: None
compiled.WINGS[:] = []
bodies, t = np.load(sys.argv[1]), np.linspace(-1e3, 1e6, 1001)
quaternions = np.empty((4, len(bodies), len(t)))
compiled.sample(bodies, t, None, quaternions, None, 0, 0, len(t))
sys.stdout.buffer.write(quaternions.tobytes())
"""


def test_bits_are_the_same_without_numbas_private_classes(tmp_path):
    motions = [
        TorqueFreeMotion(RigidBody((1.0, 2.0, 3.0)), (1, 0, 0, 0), omega, order="wxyz")
        for omega in ((0.3, 0.4, 0.5), (1e-6, 1.0, 1e-6))
    ]
    np.save(tmp_path / "bodies", np.concatenate([next(motion._batch.blocks(0, 1))[1] for motion in motions]))

    def samples(**variables):
        cache = tmp_path / "-".join(["cache", *variables])
        run = [sys.executable, "-c", SAMPLES, tmp_path / "bodies.npy"]
        environment = os.environ | {"ATTITUDE_CACHE_DIR": str(cache)} | variables
        return subprocess.run(run, env=environment, capture_output=True, check=True).stdout

    plain = samples(ATTITUDE_PLAIN_NUMBA="1")
    assert len(plain) == 4 * 2 * 1001 * 8
    assert plain == samples()


def test_private_classes_are_used_of_the_numba_at_hand_and_of_no_untested_one(monkeypatch):
    version = tuple(map(int, numba.__version__.split(".")[:2]))
    first, beyond = numba_internals.TESTED
    assert first <= version < beyond
    monkeypatch.setattr(numba, "__version__", ".".join(map(str, beyond)) + ".0")
    assert not numba_internals.link_routines_once()


def test_numba_is_bounded_by_what_was_tested():
    project = Path(__file__).parents[1] / "pyproject.toml"
    dependencies = tomllib.loads(project.read_text())["project"]["dependencies"]
    (bounds,) = [each for each in dependencies if each.startswith("numba")]
    first, beyond = (".".join(map(str, version)) for version in numba_internals.TESTED)
    assert bounds == f"numba>={first},<{beyond}"


# -- what is compiled anew --------------------------------------------------------------------------


@pytest.fixture
def sources(tmp_path, monkeypatch):
    """The kernels' sources in a place where they can be changed."""
    shutil.copytree(signature.SOURCES, tmp_path / "kernels", ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(signature, "SOURCES", tmp_path / "kernels")
    modules_of.cache_clear()
    source_digest.cache_clear()
    yield tmp_path / "kernels"
    modules_of.cache_clear()
    source_digest.cache_clear()


EVERY_MODULE = {each.module for wing in compiled.WINGS for group in wing for each in group}
TORQUES = {"solvers.collocation"}


@pytest.mark.parametrize(
    ("changed", "recompiled"),
    [
        ("interpolation", {"interpolation"}),
        ("solvers.torque", TORQUES | {"solvers.plate_march"}),
        ("contact.friction", {"contact.flight"}),
        ("statistics.normal", {"statistics.dispersion"}),
        ("clock", {"clock"}),
        ("cayley_klein", {"cayley_klein", "contact.flight", "gyrostat.attitudes", "partials.assembly"}),
        ("intrinsics", EVERY_MODULE),
    ],
)
def test_changed_kernel_recompiles_what_imports_it_and_nothing_else(sources, changed, recompiled):
    before = {module: source_digest(module) for module in EVERY_MODULE}
    source_digest.cache_clear()
    with open(sources.joinpath(*changed.split(".")).with_suffix(".py"), "a") as file:
        file.write("# changed\n")
    assert {module for module in EVERY_MODULE if source_digest(module) != before[module]} == recompiled


IMPORTED = """
import importlib, sys
for name in sys.argv[1:]:
    for loaded in [each for each in sys.modules if each.startswith("attitude.kernels.")]:
        del sys.modules[loaded]
    sys.modules.pop("attitude.kernels", None)
    importlib.import_module(f"attitude.kernels.{name}")
    print(*(each[17:] for each, module in sys.modules.items() if each.startswith("attitude.kernels.")
            and not hasattr(module, "__path__")))
"""


def test_digest_is_of_every_module_that_python_imports_for_a_kernel():
    names = sorted(EVERY_MODULE)
    run = subprocess.run([sys.executable, "-c", IMPORTED, *names], capture_output=True, text=True, check=True)
    for name, line in zip(names, run.stdout.splitlines(), strict=True):
        assert set(line.split()) == modules_of(name)


def test_kernel_is_called_while_all_are_compiled(monkeypatch):
    arrays = [np.ones(1) for _ in range(4)]
    compiled.days_from_seconds(*arrays)  # compiled, or kept
    begun, release = threading.Event(), threading.Event()

    def compile_missing(groups):
        begun.set()
        release.wait(5.0)
        return 0

    monkeypatch.setattr(kernel_cache, "compile_missing", compile_missing)
    monkeypatch.setattr(compiled.days_from_seconds, "_functions", {})  # as in a process that has just started
    thread = threading.Thread(target=compiled.compile_all)
    thread.start()
    begun.wait()
    compiled.days_from_seconds(*arrays)
    assert thread.is_alive()
    release.set()
    thread.join()
