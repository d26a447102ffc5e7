"""Figures of accuracy, each beside what it has to reach.

    python tests/benchmarks/figures.py

The bodies are those of tests/test_against_truth.py, the truth is the 50-digit oracle (attitude/oracle).
"""

from __future__ import annotations

import platform
import random
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from attitude import RigidBody, TorqueFreeMotion
from attitude.cost.machine import processor
from tests.bodies import ATTITUDE, NAMED, Body, errors, random_bodies, times
from tests.test_against_truth import LADDERS, random_tensors, tensors_beside_the_separatrix

IDENTITY = (1.0, 0.0, 0.0, 0.0)
ROW = "{:<72} {:>14} {:>12}"


def _machine() -> str:
    from importlib.metadata import version

    names = ("numpy", "numba", "llvmlite", "astropy", "scipy")
    versions = ", ".join(f"{name} {version(name)}" for name in names)
    return f"{processor()}, Python {platform.python_version()}, {versions}"


def report(figure: str, reached: str, reach: str) -> None:
    print(ROW.format(figure, reached, reach), flush=True)


HORIZONS = (0.0, 0.7, -3.0, 57.0, -1e3, 1e6, -1e9, 0.813e9)  # rad


def main() -> None:
    print(_machine())
    print(ROW.format("figure", "reached", "to reach"))
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


if __name__ == "__main__":
    main()
