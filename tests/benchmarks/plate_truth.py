"""Bodies of plates beside an independent truth, with times (docs/torques.md, section 5).

    python -m tests.benchmarks.plate_truth [ROW ...]      (the extra `peers`; without a ROW all of them)

The truth is `campaign_truth`, which has no penumbra: there the rows are without one, or have a cylindrical
shadow.
"""

import math
import sys
import warnings
from functools import cache
from statistics import median
from time import perf_counter, process_time

import numpy as np

from attitude import Scene
from tests.benchmarks.campaign_truth import CampaignTruth, most_plates
from tests.dynamics.motions import angle
from tests.dynamics.scenes import quantity
from tests.dynamics.test_plates import DRAG, LIGHT, cubesat

DAY = 86400
TOLERANCE = 1e-19  # of the truth
CUBESAT_LIGHT = LIGHT | {
    "plates": [p | {"area": quantity(0.1 * p["area"]["value"], "m2")} for p in LIGHT["plates"]],
    "shadow": "cylindrical",
}


def times(stop, step):
    return {"start": 0, "stop": stop, "step": step, "unit": "s"}


def many_plates(count):
    """Effects of a round body of so many plates."""
    rng, drag, light = np.random.default_rng(1), [], []
    for _ in range(count):
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        centre = 0.1 * normal + 0.02 * rng.normal(size=3)
        plate = {
            "normal": normal.tolist(),
            "centre": quantity(centre.tolist(), "m"),
            "area": quantity(0.14 / count, "m2"),
        }
        drag.append(plate | {"coefficient": 2.2})
        light.append(plate | {"specular": 0.1, "diffuse": 0.2})
    return DRAG | {"plates": drag}, CUBESAT_LIGHT | {"plates": light}


GRADIENT = {"type": "gravity_gradient"}
PLAIN = cubesat(GRADIENT, DRAG, CUBESAT_LIGHT, times=times(DAY, 60), tolerance=quantity(1e-9, "rad"))
FAST = {"angular_velocity": quantity([20, 15, -16], "deg/s"), "tolerance": quantity(1e-7, "rad")}
AT_REST = {"angular_velocity": quantity([0, 0, 0], "deg/s")}
ROUND = cubesat(GRADIENT, *many_plates(100), times=times(DAY, 60), tolerance=quantity(1e-8, "rad"))
# name: the document, and up to which instant the truth goes (0: none)
ROWS = {
    "CubeSat, one orbit": (PLAIN | {"times": times(5520, 60)}, 5520),
    "CubeSat, one day": (PLAIN, DAY),
    "the same with a penumbra": (
        PLAIN | {"effects": [GRADIENT, DRAG, CUBESAT_LIGHT | {"shadow": "conical"}]},
        0,
    ),
    "at 30 deg/s, one day": (PLAIN | FAST, DAY),
    "at rest, one day, 3e-11": (PLAIN | AT_REST | {"tolerance": quantity(3e-11, "rad")}, DAY),
    "100 plates, one day": (ROUND, 600),
}


def in_si(document):
    """The document as its truth is written: elements of an orbit, and the rate, in SI."""
    orbit, rate, zero = document["orbit"], document["angular_velocity"]["value"], quantity(0.0, "rad")
    elements = {
        "semi_major_axis": quantity(orbit["radius"]["value"] + 1e3 * orbit["altitude"]["value"], "m"),
        "inclination": quantity(math.radians(orbit["inclination"]["value"]), "rad"),
        **dict.fromkeys(("raan", "argument_of_pericentre", "mean_anomaly"), zero),
        **{name: orbit[name] for name in ("mu", "radius")},
    }
    return document | {"orbit": elements, "angular_velocity": quantity(np.radians(rate).tolist(), "rad/s")}


def groups_of(document):
    """Plates that turn their edges together, as `CampaignTruth` takes them."""
    groups = {}
    for kind in ("drag", "solar_pressure"):
        (effect,) = (each for each in document["effects"] if each["type"] == kind)
        for plate in effect["plates"]:
            facing = 1 if plate["normal"] > [0.0, 0.0, 0.0] else -1
            axis = kind, *(facing * np.array(plate["normal"]))
            groups.setdefault(axis, []).append((sum(map(len, groups.values())), facing))
    return tuple(map(tuple, groups.values()))


@cache
def engine(plates, groups):
    return CampaignTruth(plates, TOLERANCE, max_steps=0, groups=groups)


def error_at(document, run, end):
    """rad, of the last instant until then."""
    at = np.flatnonzero(run.elapsed <= end)[-1:]
    truth = engine(most_plates(document), groups_of(document)).attitudes(in_si(document), run.elapsed[at])
    return angle(run.quaternion("wxyz")[at].T, truth.astype(float).T)


def print_row(name, document, end):
    Scene.model_validate(document).run()
    wall, processor = [], []
    for _ in range(5):
        scene = Scene.model_validate(document)
        begun, used = perf_counter(), process_time()
        run = scene.run()
        wall.append(perf_counter() - begun)
        processor.append(process_time() - used)
    plan = scene.plan()
    arcs, both = run.plan.solver.split(": ")[1], "of both processors"
    text = f"{name:26} {arcs:27} {1e3 * median(wall):6.1f} ms, {1e3 * median(processor):5.0f} {both}"
    text += f"  plan {1e3 * plan.predicted_seconds:4.0f} ms  bound {run.plan.error_bound:.1e} rad"
    if end:
        text += f"  error {error_at(document, run, end):.1e} rad at {end} s"
    print(text, flush=True)


def print_random(count=24):
    """Random attitudes, and rates of 0.01 to 30 deg/s, for an orbit."""
    rng, worst, missed = np.random.default_rng(5), [], 0
    for _ in range(count):
        q, w = rng.normal(size=4), rng.normal(size=3)
        document = PLAIN | {
            "attitude": {"quaternion": (q / np.linalg.norm(q)).tolist(), "order": "wxyz"},
            "angular_velocity": quantity(
                (w * 10 ** rng.uniform(-2, 1.5) / np.linalg.norm(w)).tolist(), "deg/s"
            ),
            "times": times(5520, 5520),
        }
        run = Scene.model_validate(document).run()
        error = error_at(document, run, 5520)
        worst.append(error)
        missed += error > run.plan.error_bound
    print(
        f"{count} random bodies, an orbit: worst error {max(worst):.1e} rad, above the bound {missed} times"
    )


def main(rows):
    warnings.simplefilter("ignore")
    for name, (document, end) in ROWS.items():
        if not rows or name in rows:
            print_row(name, document, end)
    if not rows or "random" in rows:
        print_random()


if __name__ == "__main__":
    main(sys.argv[1:])
