"""Long and timed measurements of motions under torques: printed, not asserted.

python tests/benchmarks/torques_long.py             all, about two minutes
python tests/benchmarks/torques_long.py jacobi      the Jacobi integral over 1e5 orbits
python tests/benchmarks/torques_long.py unasked     time of a torque-free scene with and without gravity
python tests/benchmarks/torques_long.py plan        what plans predict against what runs take and are off by
"""

from __future__ import annotations

import statistics
import sys
from pathlib import Path
from time import perf_counter

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from attitude.cost.machine import processor, versions
from attitude.dynamics.solvers import SOLVERS
from tests.dynamics.motions import angle, integrate_arc
from tests.dynamics.test_torques_effects import quantity, scene
from tests.dynamics.test_torques_estimate import random_scene, truth
from tests.dynamics.test_torques_pendulum import COURSE, TORQUES, N, jacobi, released

BODIES = {"cylinder": (12250.0, 12250.0, 500.0), "triaxial": (300.0, 410.0, 190.0)}


def jacobi_integral(orbits: int = 100_000) -> None:
    print(f"Jacobi integral over {orbits} orbits, Gauss: greatest change, change by the line fitted, time")
    t = np.linspace(0.0, orbits, 2001) * COURSE.period
    for name, moments in BODIES.items():
        body = released(moments, (0.3, 0.6, -0.4), (0.1 * N, 0.0, 0.2 * N))
        for step in (0.5, 0.35):
            begun = perf_counter()
            rows, work = integrate_arc(SOLVERS["gauss, order 16"], body, TORQUES, step / N, t)
            seconds = perf_counter() - begun
            J = jacobi(rows, t, moments)
            greatest, trend = np.abs(J - J[0]).max(), np.polyfit(t, J, 1)[0] * t[-1]
            assert work.failed == 0
            print(f"  {name:<10}{step} rad a step  {greatest:.1e}  {trend:+.1e}  {seconds:5.1f} s")


def unasked(samples: int = 1_000_000, repeats: int = 21) -> None:
    """The same scene with uniform gravity added, by turns."""
    gravity = {"type": "uniform_gravity", "acceleration": quantity([0, 0, -9.81], "m/s2")}
    t = {"times": {"start": 0, "stop": 1e6, "count": samples, "unit": "s"}}
    scenes = [scene(rate=(0.3, -0.5, 0.4), **t), scene(gravity, rate=(0.3, -0.5, 0.4), **t)]
    times: list[list[float]] = [[], []]
    for made in scenes:
        made.run()
    for _ in range(repeats):
        for made, taken in zip(scenes, times, strict=True):
            begun = perf_counter()
            made.run()
            taken.append(perf_counter() - begun)
    free, falling = (statistics.median(taken) for taken in times)
    print(
        f"{samples} samples: free {1e3 * free:.2f} ms, falling {1e3 * falling:.2f} ms, {falling / free:.3f}"
    )


def predictions(count: int = 8) -> None:
    """Predicted over measured: seconds, with one sample more than none; and error, of which the prediction
    is to be no less than the truth by much."""
    print("predicted / measured: solver, seconds, error (predicted, told, true)")
    rng = np.random.default_rng(7)
    for kind in ("gravity gradient", "eccentric orbit", "constant torque"):
        for i in range(count):
            made = random_scene(rng, kind, i % 2 == 0, 10.0 ** -rng.integers(6, 10), "automatic", 300.0)
            plan = made.plan()
            made.run()
            begun = perf_counter()
            run = made.run()
            taken = perf_counter() - begun
            true = angle(run.quaternion("wxyz").T, truth(made))
            print(
                f"  {kind:<18}{plan.solver:<28}{plan.predicted_seconds / taken:8.2f} "
                f"({1e3 * taken:.1f} ms)  {plan.predicted_error:.1e} {run.plan.error_bound:.1e} {true:.1e}"
            )


def main() -> None:
    asked = sys.argv[1:] or ["unasked", "plan", "jacobi"]
    print(processor(), versions())
    for name in asked:
        {"jacobi": jacobi_integral, "unasked": unasked, "plan": predictions}[name]()


if __name__ == "__main__":
    main()
