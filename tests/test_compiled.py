"""Machine code of the kernels: kept, found again, and needing no compiler."""

import os
import subprocess
import sys

import numpy as np
import pytest

from attitude import AttitudeError, RigidBody, TorqueFreeMotion, compiled
from attitude.kernels.layout import CompiledName

# One kernel of little code, in a process that has nothing else to compile.
SEVERAL_DAYS = """
import sys
import numpy as np
from attitude import compiled

compiled.built.find = lambda *_: None
compiled.STANDARD[:] = [[("clock", "days_from_seconds", "d1.d1.d1.d1")]]
announced = []
compiled.on_compilation.append(announced.append)
seconds, days, low = np.array([86400.0, 43200.0]), np.empty(2), np.empty(2)
compiled.days_from_seconds(seconds, np.zeros(2), days, low)
assert days.tolist() == [1.0, 0.5]
assert "numba" not in sys.modules
print(*announced)
"""


def announced_compilations(place):
    run = subprocess.run(
        [sys.executable, "-c", SEVERAL_DAYS],
        env=os.environ | {"ATTITUDE_CACHE_DIR": str(place)},
        capture_output=True,
        text=True,
        check=True,
    )
    return run.stdout.split()


def test_code_is_compiled_once_and_found_again(tmp_path):
    place = tmp_path / "new" / "place"
    assert announced_compilations(place) == ["1"]
    (kept,) = place.iterdir()
    assert CompiledName.parse(kept.name)[:3] == ("clock", "days_from_seconds", ("d1",) * 4)
    assert announced_compilations(place) == []


def test_without_a_place_to_keep_it_code_is_compiled_and_runs(tmp_path):
    occupied = tmp_path / "file"
    occupied.write_text("no directory can be here")
    for _ in range(2):
        assert announced_compilations(occupied) == ["1"]


def test_a_compiler_that_fails_says_so_in_one_line():
    with pytest.raises(AttitudeError, match=r"the kernels cannot be compiled: .*nothing"):
        compiled.Kernel("clock", "nothing")(1.0)


def test_name_of_a_file_says_what_is_in_it():
    name = CompiledName("clock", "grid", ("f", "d1"), "0123456789abcdef")
    assert CompiledName.parse(str(name)) == name


def test_kernels_refuse_arrays_in_another_order():
    t = np.arange(6.0)
    with pytest.raises(TypeError, match="C order"):
        compiled.days_from_seconds(t[::2], t[::2], t[::2], t[::2])


@pytest.mark.parametrize("omega", [(0.3, 0.4, 0.5), (1e-6, 1.0, 1e-6)])
def test_plain_phases_are_those_of_doubles(omega):
    """What attitude.cost measures beside ours: equal near the epoch, worse in proportion to time."""
    motion = TorqueFreeMotion(RigidBody((1.0, 2.0, 3.0)), (1, 0, 0, 0), omega, order="wxyz")
    for span, least, most in ((1.0, 0.0, 1e-15), (1e9, 1e-9, 1e-5)):
        t, plain = np.linspace(0.0, span, 1000), np.empty((4, 1, 1000))
        compiled.sample(next(motion._batch.blocks(0, 1))[1], t, None, plain, None, 1, 0, 0, 1000)
        difference = np.abs(plain[:, 0].T - motion.at(t).quaternion("wxyz")).max()
        assert least <= difference <= most
