"""The project's figures, each beside what it has to reach.

    python tests/benchmarks/figures.py            everything, about a minute
    python tests/benchmarks/figures.py accuracy   one part: accuracy, speed or memory

Accuracy is that of the bodies of tests/test_against_truth.py, against the 50-digit oracle (attitude/oracle);
speeds are medians of repeats in this run, and ratios are of medians taken in turns.
"""

from __future__ import annotations

import platform
import random
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from attitude import RigidBody, TorqueFreeMotion
from attitude.cost.machine import processor
from tests.bodies import ATTITUDE, NAMED, Body, errors, random_bodies, times
from tests.test_against_truth import LADDERS, random_tensors, tensors_beside_the_separatrix

IDENTITY = (1.0, 0.0, 0.0, 0.0)
REPEATS = 15
ROW = "{:<72} {:>14} {:>12}"


def main(parts: list[str]) -> None:
    print(_machine())
    print(ROW.format("figure", "reached", "to reach"))
    for name, part in PARTS.items():
        if not parts or name in parts:
            part()


def _machine() -> str:
    from importlib.metadata import version

    names = ("numpy", "numba", "llvmlite", "astropy", "scipy")
    versions = ", ".join(f"{name} {version(name)}" for name in names)
    return f"{processor()}, Python {platform.python_version()}, {versions}"


def report(figure: str, reached: str, reach: str) -> None:
    print(ROW.format(figure, reached, reach), flush=True)


# -- accuracy -------------------------------------------------------------------------------------

HORIZONS = (0.0, 0.7, -3.0, 57.0, -1e3, 1e6, -1e9, 0.813e9)  # rad


def accuracy() -> None:
    generic = list(random_bodies(random.Random(20261121), 24))
    _report_worst("generic bodies, abs(omega t) to 1e9 rad", generic, HORIZONS)
    _report_worst("generic bodies, abs(omega t) to 1e12 rad", generic, (-1e12, 0.813e12))
    for name, bodies in {**LADDERS, "named bodies": NAMED.values()}.items():
        _report_worst(name, [(body, ATTITUDE) for body in bodies], HORIZONS)
    rng = random.Random(1)
    tensors = [Body(tensor, tuple(rng.gauss(0, 1) for _ in range(3))) for tensor in random_tensors(rng, 24)]
    tensors += [body for seed in range(2) for body in tensors_beside_the_separatrix(seed)]
    _report_worst(
        "full tensors, random and beside the separatrix", [(b, ATTITUDE) for b in tensors], HORIZONS
    )
    _conservation()


def _report_worst(name: str, states: list[tuple[Body, tuple]], radians: tuple[float, ...]) -> None:
    worst = [errors(body, times(body, radians), attitude) for body, attitude in states]
    report(f"attitude error, {name} [rad]", f"{max(each.attitude for each in worst):.2e}", "<= 4e-15")
    report(f"body rate, {name}, relative", f"{max(each.rate for each in worst):.2e}", "<= 4e-15")


def _conservation() -> None:
    count, span = 1_000_000, 1e9
    spread, slope = 0.0, 0.0
    for moments, omega in (((1.0, 2.0, 2.5), (0.3, 0.4, 0.5)), ((1.0, 2.0, 3.0), (1e-6, 1.0, 1e-6))):
        motion = TorqueFreeMotion(RigidBody(moments), IDENTITY, omega, order="wxyz")
        t = np.linspace(0.0, span, count)
        ephemeris = motion.at(t)
        momentum = np.linalg.norm(motion.angular_momentum)
        for values in (
            ephemeris.kinetic_energy / motion.kinetic_energy,
            *((ephemeris.angular_momentum - motion.angular_momentum) / momentum).T,
        ):
            spread = max(spread, float(np.ptp(values)))
            slope = max(slope, abs(float(np.polyfit(t / span, values - values.mean(), 1)[0])))
    report("energy and momentum, 1e6 samples over 1e9 s, relative spread", f"{spread:.2e}", "<= 4e-15")
    report("    trend over the whole span, relative (noise / sqrt n = 1e-18)", f"{slope:.2e}", "none")


# -- speed ----------------------------------------------------------------------------------------


def speed() -> None:
    """What tests/benchmarks/test_speed.py does not hold against something else."""
    _near_and_far()
    _import_time()


def _timed(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def _in_turns(*works: Callable[[], object], repeats: int = REPEATS) -> list[float]:
    """Median seconds of each, timed in turns after one warm-up of each."""
    for work in works:
        work()
    runs = [[_timed(work) for work in works] for _ in range(repeats)]
    return [statistics.median(run[i] for run in runs) for i in range(len(works))]


def _near_and_far() -> None:
    count = 1_000_000
    motion = TorqueFreeMotion(RigidBody((1.0, 2.0, 2.5)), IDENTITY, (0.3, 0.4, 0.5), order="wxyz")
    near, far = np.linspace(0.0, 1.0, count), np.linspace(1e12, 1e12 + 1e6, count)
    seconds = _in_turns(lambda: motion.at(near), lambda: motion.at(far))
    report("cost a sample at t = 1e12 s against t = 1 s", f"{seconds[1] / seconds[0]:.3f}", "0.95..1.05")


def _import_time() -> None:
    def run(code: str) -> Callable[[], object]:
        return lambda: subprocess.run([sys.executable, "-c", code], check=True)

    parts, whole = _in_turns(
        run("import astropy.time, numpy, numba"), run("from attitude import *"), repeats=9
    )
    report(
        "import of all public names, over astropy.time, numpy and numba together [s]",
        f"{whole - parts:+.2f}",
        "<= +0.2",
    )


# -- memory ---------------------------------------------------------------------------------------

MEASURE = """
import re, numpy as np
from pathlib import Path
from attitude import RigidBody, TorqueFreeMotion
motion = TorqueFreeMotion(RigidBody((1.0, 2.0, 3.0)), (1, 0, 0, 0), (0.3, 0.4, 0.5), order="wxyz")
motion.at(np.zeros(2))
t = np.linspace(0.0, 1e6, 10_000_000)
def resident(which):  # KiB
    return int(re.search(which + r":\\s+(\\d+)", Path("/proc/self/status").read_text())[1])
Path("/proc/self/clear_refs").write_text("5")  # the peak counts from here
before = resident("VmRSS")
ephemeris = motion.at(t)
outputs = ephemeris.quaternion("wxyz").nbytes + ephemeris.elapsed.nbytes
print((resident("VmHWM") - before) / 1024 - outputs / 2**20)
"""


def memory() -> None:
    answer = subprocess.run([sys.executable, "-c", MEASURE], check=True, capture_output=True, text=True)
    report(
        "peak memory of motion.at(1e7 samples), over the output arrays [MiB]",
        f"{float(answer.stdout):+.1f}",
        "<= 64",
    )


PARTS = {"accuracy": accuracy, "speed": speed, "memory": memory}

if __name__ == "__main__":
    main(sys.argv[1:])
