"""What plans predict beside what runs take and say: `python -m tests.benchmarks.plan_figures`.

To be reached: time within a factor of 3 for runs above 10 ms, error within a factor of 10 of the run's bound.
"""

import time

import numpy as np

from attitude import Scene
from tests.effects.scenes import document, effect, quantity

DAY = 86400.0
REPEATS = 3


def turning(rate, tolerance, *effects, moments=(2, 3, 4), span=DAY, count=1441):
    """A scene of the tests' orbit, at a rate in deg/s."""
    direction = np.array([1.0, 0.5, -0.3]) / np.linalg.norm([1.0, 0.5, -0.3])
    made = document(
        *map(effect, effects or ("gravity_gradient",)),
        angular_velocity=quantity((np.deg2rad(rate) * direction).tolist(), "rad/s"),
        times={"start": 0, "stop": span, "count": count, "unit": "s"},
        tolerance=quantity(tolerance, "rad"),
    )
    return made | {"body": {"moments": list(moments), "unit": "kg m2"}}


SCENES = {
    "Envisat": Scene.builtin("envisat").document(),
    "gravity-gradient capture": Scene.builtin("gravity-gradient-capture").document(),
    "gravity gradient, 0.1 deg/s": turning(0.1, 1e-9),
    "gravity gradient, 1 deg/s": turning(1, 1e-9),
    "gravity gradient, 10 deg/s": turning(10, 1e-8),
    "gravity gradient, 60 deg/s": turning(60, 1e-6),
    "the same, symmetric": turning(60, 1e-6, moments=(3, 3, 4)),
    "30 days at 1 deg/s": turning(1, 1e-7, span=30 * DAY),
    "100,001 instants": turning(10, 1e-8, count=100_001),
    "with dipole and eddies": turning(5, 1e-8, "gravity_gradient", "magnetic_dipole", "eddy_damping"),
    "drag and sunlight on plates": turning(3, 1e-7, "drag", "solar_pressure"),
}


def seconds(act):
    start = time.perf_counter()
    result = act()
    return time.perf_counter() - start, result


if __name__ == "__main__":
    print(f"{'scene':30s} {'predicted':>12s} {'taken':>12s}       {'predicted':>12s} {'bound':>12s}")
    for name, made in SCENES.items():
        scene = Scene.model_validate(made)
        plan = scene.plan()
        scene.run()
        taken, ephemeris = min((seconds(scene.run) for _ in range(REPEATS)), key=lambda pair: pair[0])
        times = f"{1e3 * plan.predicted_seconds:9.1f} ms {1e3 * taken:9.1f} ms"
        shares = plan.predicted_seconds / taken, plan.predicted_error / ephemeris.plan.error_bound
        errors = f"{plan.predicted_error:12.1e} {ephemeris.plan.error_bound:12.1e}"
        print(f"{name:30s} {times} {shares[0]:5.2f} {errors} {shares[1]:5.2f}")
