"""Densities of drag by tables and models: time to interpolate a day along the orbit, error, and whole runs.

    python -m tests.benchmarks.density_models

The CubeSat of six plates, a circle at 400 km and an ellipse from 200 to 800 km; the exponential beside them.
Times are of the thread that computes the answer; the second solution has a processor of its own.
"""

import warnings
from time import thread_time

import numpy as np

from attitude import Scene
from attitude.effects import density_profile
from tests.dynamics.test_drag_models import BULGE, CIRCLE, ELLIPSE, NRL, TABLE, elements
from tests.dynamics.test_plates import CUBESAT, box
from tests.effects.scenes import quantity

EXPONENTIAL = {
    "density": quantity(2.8e-12, "kg/m3"),
    "reference_altitude": quantity(400, "km"),
    "scale_height": quantity(58.5, "km"),
}
MODELS = {"exponential": EXPONENTIAL} | {
    name: {"density": density}
    for name, density in (("table", TABLE), ("harris_priester", BULGE), ("nrlmsise00", NRL))
}


def scene(air, orbit):
    drag = {"type": "drag", "plates": box(coefficient=2.2), **air}
    return Scene.model_validate(
        CUBESAT
        | {
            "frame": "GCRF",
            "epoch": {"time": "2026-03-20T12:00:00", "scale": "utc"},
            "orbit": elements(orbit),
            "effects": [{"type": "gravity_gradient"}, drag],
            "times": {"start": 0, "stop": 86400, "count": 1441, "unit": "s"},
            "tolerance": "best",
        }
    )


def row(name, orbit):
    made = scene(MODELS[name], orbit)
    state, text = made.initial_state(), f"{'':33}"
    model = made.effects[0 if len(made.effects) == 1 else 1].density
    if name != "exponential":
        density_profile.along.cache_clear()
        begun = thread_time()
        profile = density_profile.along(model, state)
        seconds = thread_time() - begun
        t = np.random.default_rng(1).uniform(0.0, 86400.0, 5000)
        off = np.log(density_profile.evaluate(profile, t)) - model.log_densities(state, t)
        counts = f"{len(profile.pieces):6d} {len(profile.cuts):6d}"
        text = f"{1e3 * seconds:8.1f} ms {counts} {np.abs(off).max():8.1e}"
    times = []
    for _ in range(5):
        begun = thread_time()
        run = scene(MODELS[name], orbit).run()
        times.append(thread_time() - begun)
    foretold = scene(MODELS[name], orbit).plan().predicted_seconds
    return f"{text} {1e3 * min(times):8.1f} ms {1e3 * foretold:8.1f} ms {run.plan.error_bound:10.1e}"


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    columns = f"{'pieces':>6} {'cuts':>6} {'error':>8} {'run':>11} {'foretold':>11} {'bound, rad':>10}"
    print(f"{'':34}{'profile':>11} {columns}")
    for where, orbit in (("circle", CIRCLE), ("ellipse", ELLIPSE)):
        for name in MODELS:
            print(f"{where:10}{name:24}{row(name, orbit)}")
