"""Covariances of ten scenes against ensembles of exact bodies.

python -m tests.benchmarks.uncertainty [--count 100000]
"""

import argparse

import numpy as np

from attitude import Scene
from attitude.scene import simulation
from attitude.scene.perturbed_bodies import responses
from attitude.times.instants import Instants

BODY = {"moments": [1.0, 1.6, 2.1], "unit": "kg m2"}
CUBESAT = {"moments": [0.03, 0.035, 0.008], "unit": "kg m2"}
ROTORS = {"type": "wheels", "momentum": {"value": [0.1, 0.0, -0.2], "unit": "N m s"}}
IMPULSE = {
    "type": "impulse",
    "time": {"value": 20, "unit": "s"},
    "angular_impulse": {"value": [0.02, 0.0, 0.01], "unit": "N m s"},
    "frame": "body",
}
# Name, body, body rate in deg/s, span in s, effects.
SCENES = (
    ("short axis", BODY, (3, -5, 20), 400, []),
    ("long axis", BODY, (20, 4, -3), 400, []),
    ("beside the middle axis", BODY, (0.5, 15, 0.3), 200, []),
    ("beside the separatrix", {"moments": [3, 4, 6], "unit": "kg m2"}, (20, 7, 10.1), 200, []),
    ("spin about the greatest", BODY, (0, 0, 12), 400, []),
    ("oblate", {"moments": [2, 2, 3], "unit": "kg m2"}, (3, -4, 12), 400, []),
    ("sphere", {"moments": [2, 2, 2], "unit": "kg m2"}, (3, -4, 12), 400, []),
    ("needle", {"moments": [0.05, 2, 2.04], "unit": "kg m2"}, (60, 0.5, 0.3), 400, []),
    ("rotors", BODY, (3, -5, 20), 400, [ROTORS]),
    ("impulse", CUBESAT, (2, 1, 4), 400, [IMPULSE]),
)
INSTANTS = 41
BODIES_AT_ONCE = 5000


def scene_of(body, rate, span, effects):
    """1 sigma of 0.3 deg, 0.002 of the rate, 0.001 of the moments and 0.1 deg of their axes."""
    size = float(np.linalg.norm(rate))
    moments = [0.001 * moment for moment in body["moments"]]
    return Scene.model_validate(
        {
            "body": body,
            "attitude": {"quaternion": [0.1, -0.7, 0.5, 0.5], "order": "wxyz"},
            "angular_velocity": {"value": list(map(float, rate)), "unit": "deg/s"},
            "times": {"start": 0, "stop": span, "count": INSTANTS, "unit": "s"},
            "effects": effects,
            "uncertainty": {
                "attitude": {"value": [0.3] * 3, "unit": "deg"},
                "angular_velocity": {"value": [0.002 * size] * 3, "unit": "deg/s"},
                "moments": {"value": moments, "unit": "kg m2"},
                "axes": {"value": [0.1] * 3, "unit": "deg"},
            },
        }
    )


def compare(name, scene, count, rng):
    """A row: the greatest relative error of 1 sigma, all axes together, before the first order ends."""
    ephemeris, inputs = scene.run(), simulation.resolve(scene)
    uncertainty = ephemeris.uncertainty
    seconds = ephemeris.elapsed
    seconds = seconds[seconds < uncertainty.linear_until]
    squares, left = np.zeros((seconds.size, 2)), count
    while left:
        part = min(left, BODIES_AT_ONCE)
        changes = rng.multivariate_normal(np.zeros(12), uncertainty.covariance, part, method="eigh")
        moved = responses(inputs, Instants(seconds, None, None), changes, "moments")[:2]
        squares += np.stack([(one**2).sum(axis=(0, 2)) for one in moved], axis=-1)
        left -= part
    exact = np.sqrt(squares / count)
    linear = [
        np.trace(block, axis1=1, axis2=2)
        for block in (ephemeris.attitude_covariance, ephemeris.rate_covariance)
    ]
    off = np.abs(np.sqrt(np.stack(linear, axis=-1))[: seconds.size] / exact - 1.0).max(axis=0)
    last = np.rad2deg(exact[-1, 0])
    until = "all" if np.isinf(uncertainty.linear_until) else f"{uncertainty.linear_until:.0f} s"
    print(f"| {name} | {until} | {last:.2g} deg | {100 * off[0]:.2f} % | {100 * off[1]:.2f} % |", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=100_000)
    count = parser.parse_args().count
    print("| scene | linear until | 1 sigma there | attitude off by | rate off by |\n|---|---|---|---|---|")
    for name, body, rate, span, effects in SCENES:
        compare(name, scene_of(body, rate, span, effects), count, np.random.default_rng(1))
