"""The project's figures, each beside what it has to reach.

    python tests/benchmarks/figures.py            everything, about a minute
    python tests/benchmarks/figures.py accuracy   one part: accuracy, speed or memory

Accuracy is against the 50-digit oracle (attitude/oracle), speeds are medians of repeats in this run,
ratios are of medians taken in turns, and equal answers are asserted before anything is timed.
"""

from __future__ import annotations

import platform
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
from attitude.oracle import truth

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


def accuracy() -> None:
    generic = _generic_states(24)
    report_worst("generic bodies, abs(omega t) to 1e9 rad", generic, 1e9)
    report_worst("generic bodies, abs(omega t) to 1e12 rad", generic, 1e12)
    for name, states in _ladders().items():
        report_worst(name, states, 1e9)
    report_worst("full tensors, 1e-1..1e-15 from the separatrix", _tensor_states(), 1e9)
    _conservation()


def report_worst(name: str, states: list, farthest: float) -> None:
    errors, rates = zip(*(_errors(*state, farthest) for state in states), strict=True)
    report(f"attitude error, {name} [rad]", f"{max(errors):.2e}", "<= 4e-15")
    report(f"body rate, {name}, relative", f"{max(rates):.2e}", "<= 4e-15")


def _errors(moments: tuple, omega: tuple, attitude: tuple, farthest: float) -> tuple[float, float]:
    """Worst attitude error and relative rate error of one body over horizons up to `farthest` radians."""
    rate = float(np.linalg.norm(omega)) or 1.0
    horizons = np.array([0.0, 0.7, -3.0, 57.0, -1e3, 1e6, -farthest, 0.813 * farthest]) / rate
    ephemeris = TorqueFreeMotion(RigidBody(moments), attitude, omega, order="wxyz").at(horizons)
    quaternions, rates = ephemeris.quaternion("wxyz"), ephemeris.angular_velocity
    if not (np.isfinite(quaternions).all() and np.isfinite(rates).all()):
        return np.nan, np.nan
    reference = truth.attitude_and_rate if np.ndim(moments) == 1 else truth.attitude_and_rate_of_tensor
    worst, worst_rate = 0.0, 0.0
    for t, q, w in zip(horizons, quaternions, rates, strict=True):
        true_q, true_w = reference(moments, omega, attitude, float(t))
        worst = max(worst, truth.attitude_error(tuple(map(float, q)), true_q))
        if any(omega):
            worst_rate = max(worst_rate, truth.rate_error(tuple(map(float, w)), true_w))
    return worst, worst_rate


def _generic_states(count: int) -> list:
    random = np.random.default_rng(20261121)
    states = []
    for _ in range(count):
        moments = random.permutation(1.0 + random.random(3))
        attitude = random.normal(size=4)
        attitude /= np.linalg.norm(attitude)
        states.append(tuple(tuple(map(float, x)) for x in (moments, random.normal(size=3), attitude)))
    return states


def _ladders() -> dict[str, list]:
    steps = [10.0**-k for k in range(1, 16)]
    far = [*steps, 1e-30, 1e-80, 1e-150]
    edge = 3.0**-0.5  # with moments 1, 2, 3 and omega_x = 1, omega_z = edge gives D = 0
    return {
        "1e-1..1e-15 from the separatrix, outside": [
            ((1.0, 2.0, 3.0), (1.0, 0.7, edge * (1 + d)), IDENTITY) for d in steps
        ],
        "1e-1..1e-15 from the separatrix, inside": [
            ((1.0, 2.0, 3.0), (1.0, 0.7, edge * (1 - d)), IDENTITY) for d in steps
        ],
        "exactly on the separatrix": [
            ((3.0, 4.0, 6.0), (2.0, w, z), IDENTITY) for w in (0.7, -0.2, 0.0) for z in (1.0, -1.0)
        ],
        "1e-1..1e-150 from the least axis": [((1.0, 2.0, 3.0), (1.0, d, -d), IDENTITY) for d in far],
        "1e-1..1e-150 from the intermediate axis": [((1.0, 2.0, 3.0), (d, 1.0, d), IDENTITY) for d in far]
        + [((1.0, 2.0, 3.0), (d, 1.0, -0.3 * d), IDENTITY) for d in far],
        "1e-1..1e-150 from the greatest axis": [((1.0, 2.0, 3.0), (-d, d, 1.0), IDENTITY) for d in far],
        "1e-1..1e-15 from symmetry, oblate": [
            ((1.0, 1.0 + d, 1.7), (0.3, 0.4, 0.5), IDENTITY) for d in steps
        ],
        "1e-1..1e-15 from symmetry, prolate": [
            ((1.7 + d, 1.0, 1.7), (0.3, 0.4, 0.5), IDENTITY) for d in steps
        ],
        "1e-1..1e-15 from the sphere": [((1.0 + d, 1.0 - d, 1.0), (0.3, 0.4, 0.5), IDENTITY) for d in steps],
        "symmetric, sphere, pure spin, equatorial spin, rest": _special_states(),
        "scale 1e-150..1e150, needle, disc": _extreme_states(),
    }


def _special_states() -> list:
    oblate, prolate, sphere, generic = (1.0, 1.0, 1.8), (1.0, 2.0, 2.0), (2.0, 2.0, 2.0), (1.0, 2.0, 2.5)
    turned = [(0.3, 0.4, 0.5), (0.0, 0.0, 1.1), (0.0, -0.8, 0.0), (0.9, 0.0, 0.0), (0.3, -0.7, 0.0)]
    bodies = [oblate, (1.0, 1.8, 1.0), (1.8, 1.0, 1.0), prolate, (2.0, 1.0, 2.0), (2.0, 2.0, 1.0), sphere]
    states = [(body, omega, IDENTITY) for body in bodies for omega in turned]
    states += [(generic, omega, IDENTITY) for omega in turned[1:4]]
    return [*states, (generic, (0.0, 0.0, 0.0), IDENTITY)]


def _extreme_states() -> list:
    states = []
    for size in (1e-150, 1e-60, 1e60, 1e150):
        states.append(((size, 2 * size, 2.5 * size), (0.3, 0.4, 0.5), IDENTITY))
        states.append(((1.0, 2.0, 2.5), (0.3 * size, 0.4 * size, 0.5 * size), IDENTITY))
    needle, disc = (1e-12, 1.0, 1.0), (1.0, 1.0, 2.0)
    states += [(needle, (5.0, 0.4, 0.5), IDENTITY), (disc, (0.3, 0.4, 0.5), IDENTITY)]
    return [*states, ((1e-9, 1.0, 1.0 + 9e-10), (0.3, 0.4, 0.5), IDENTITY)]


def _tensor_states() -> list:
    random = np.random.default_rng(7)
    states = []
    for power in range(1, 16):
        turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
        tensor = turn @ np.diag([1.0, 2.0, 2.7]) @ turn.T
        tensor = 0.5 * (tensor + tensor.T)
        body = RigidBody(tensor)
        least, middle, greatest = np.argsort(body.moments)
        edge = np.sqrt(1.0 / (2.7 * 0.7))  # the rate about the greatest axis that makes D = 0
        for side in (1.0, -1.0):
            rate = np.empty(3)
            rate[[least, middle, greatest]] = 1.0, 0.7, edge * (1.0 + side * 10.0**-power)
            omega = tuple(map(float, body.axes.T @ rate))
            states.append((tuple(map(tuple, tensor.tolist())), omega, IDENTITY))
    return states


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
