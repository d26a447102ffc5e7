"""Random scenes under torques: the error against many digits, and the bound that is told.

    python tests/benchmarks/torque_campaign.py [COUNT [SEED]]

Bodies of every shape, states near an axis and near the separatrix, torques of every kind and size, tolerances
from 1e-2 to 1e-12 rad.  The truth is the Taylor oracle's (eighteen digits), or, for what that does not know
(sunlight and drag), extrapolation in doubles of equations of its own, with its own error.  A line for every
scene whose error is above its bound; then a table by shape.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from attitude import Scene, ToleranceError
from attitude.cost import InitialValueProblem, torque_truth

COUNT, SEED = 3000, 20
SAMPLES = 5
TRUTH_SECONDS = 3.0  # budget of `reach`: about a hundred radians
# Angles below this are rounding of the truth's last conversion to doubles.
FLOOR = 3e-16
SHAPES = {
    "needle": (1.0, 1.0 - 1e-3, 1e-3),
    "disc": (1.0, 1.0, 1.99),
    "sphere": (1.0, 1.0, 1.0),
    "symmetric": (1.0, 1.0, 0.6),
    "nearly symmetric": (1.0, 1.0 + 1e-7, 0.6),
    "triaxial": (1.0, 1.5, 2.0),
    "flat": (1.0, 1.3, 2.299),
}
NEAR_AXIS, NEAR_SEPARATRIX = 1e-5, 1e-6


class Outcome(NamedTuple):
    """Of one scene: shape, bound and error in rad; both None where it was refused."""

    shape: str
    bound: float | None
    error: float | None


def quantity(value: Any, unit: str) -> dict[str, Any]:
    return {"value": value, "unit": unit}


def direction(rng: np.random.Generator, size: float = 1.0) -> list[float]:
    vector = rng.normal(size=3)
    return (size * vector / np.linalg.norm(vector)).tolist()


def rate_of(rng: np.random.Generator, moments: np.ndarray) -> np.ndarray:
    """A unit rate: in general position, near an axis, or near the separatrix."""
    kind = rng.integers(4)
    rate = np.array(direction(rng))
    if kind == 1:
        rate = np.eye(3)[rng.integers(3)] + NEAR_AXIS * rate
    if kind == 2:
        low, middle, high = np.argsort(moments, kind="stable")
        a, b, c = moments[[low, middle, high]]
        rate[low] = np.sqrt(max(c * (c - b), 0.0) / max(a * (b - a), 1e-12)) * rate[high] + NEAR_SEPARATRIX
    return rate / np.linalg.norm(rate)


def plates(rng: np.random.Generator, extra: dict[str, Any]) -> list[dict[str, Any]]:
    return [
        {
            "area": quantity(float(rng.uniform(0.1, 1.0)), "m2"),
            "normal": direction(rng),
            "centre": quantity(direction(rng, 0.3), "m"),
            **extra,
        }
        for _ in range(2)
    ]


def effects_of(rng: np.random.Generator, size: float, momentum: float, pace: float) -> list[dict[str, Any]]:
    """One to three effects; size : N m, of those that are not gravity's."""
    available = [
        {"type": "constant_torque", "torque": quantity(direction(rng, size), "N m"), "frame": "body"},
        {"type": "constant_torque", "torque": quantity(direction(rng, size), "N m"), "frame": "inertial"},
        {"type": "gravity_gradient"},
        {"type": "eddy_damping", "coefficient": size / pace, "unit": "N m s"},
        {
            "type": "dissipation",
            "coefficient": quantity(0.1 * size / (momentum * momentum * pace), "1/(N m s)"),
        },
        {
            "type": "wheels",
            "momentum": quantity(direction(rng, momentum * rng.uniform(0.01, 1.0)), "N m s"),
        },
        {
            "type": "magnetic_dipole",
            "dipole": quantity(direction(rng, size / 3e-5), "A m2"),
            "field": {"strength": quantity(3e-5, "T"), "radius": quantity(6371.2, "km")},
        },
        {"type": "drag", "plates": plates(rng, {}), "density": quantity(size / 1e7, "kg/m3")},
    ]
    chosen = rng.choice(len(available), rng.integers(1, 4), replace=False)
    return [available[i] for i in sorted(chosen)]


def scene_of(rng: np.random.Generator) -> tuple[str, Scene]:
    shape = str(rng.choice(list(SHAPES)))
    moments = rng.permutation(np.array(SHAPES[shape])) * 10.0 ** rng.uniform(0, 3)
    pace, turned = 10.0 ** rng.uniform(-3, -0.5), rng.uniform(5.0, 40.0)
    rate = pace * rate_of(rng, moments)
    momentum = float(np.linalg.norm(moments * rate))
    size = momentum**2 / moments.max() * moments.min() / moments.max() * 10.0 ** rng.uniform(-8, -1)
    q = rng.normal(size=4)
    orbit = {
        "altitude": quantity(float(rng.uniform(400, 2000)), "km"),
        "inclination": quantity(float(rng.uniform(0, 180)), "deg"),
        "mean_anomaly": quantity(float(rng.uniform(-3, 3)), "rad"),
    }
    document = {
        "body": {"moments": moments.tolist(), "unit": "kg m2"},
        "frame": "INERTIAL",
        "attitude": {"quaternion": (q / np.linalg.norm(q)).tolist(), "order": "wxyz"},
        "angular_velocity": quantity(rate.tolist(), "rad/s"),
        "times": {"start": 0, "stop": turned / pace, "count": SAMPLES, "unit": "s"},
        "effects": effects_of(rng, size, momentum, pace),
        "orbit": orbit,
        "tolerance": quantity(10.0 ** rng.uniform(-12, -2), "rad"),
    }
    return shape, Scene.model_validate(document)


def outcome_of(shape: str, scene: Scene) -> Outcome:
    try:
        run = scene.run()
    except ToleranceError:
        return Outcome(shape, None, None)
    assert run.plan is not None
    problem = InitialValueProblem.of_scene(scene)
    grid = scene.times.build(None).seconds
    (found,) = torque_truth.truths(problem, [grid], 0)
    error = float(found.error(run.quaternion("wxyz"))) - found.off
    return Outcome(shape, run.plan.error_bound, max(error, 0.0))


def is_within_reach(problem: InitialValueProblem) -> bool:
    """Whether torques act, and do not make the body turn too far for its truth."""
    return problem.environment is not None and torque_truth.reach(problem, TRUTH_SECONDS) == 1.0


def main(count: int, seed: int) -> None:
    outcomes = []
    for i in range(count):
        rng = np.random.default_rng([seed, i])
        shape, scene = scene_of(rng)
        while not is_within_reach(InitialValueProblem.of_scene(scene)):
            shape, scene = scene_of(rng)
        outcome = outcome_of(shape, scene)
        outcomes.append(outcome)
        if outcome.error is not None and outcome.bound is not None and outcome.error > outcome.bound + FLOOR:
            kinds = ", ".join(effect.type for effect in scene.effects)
            print(f"scene {i}: {shape}, {kinds}: {outcome.error:.1e} > {outcome.bound:.1e}", flush=True)
    print(f"| body | scenes | refused | above the bound | bound / error: median, 95 % |\n{'|---' * 5}|")
    for shape in (*SHAPES, "all"):
        own = [one for one in outcomes if shape in (one.shape, "all")]
        done = [(o.bound, o.error) for o in own if o.bound is not None and o.error is not None]
        ratios = [bound / max(error, FLOOR) for bound, error in done] or [np.nan]
        above = sum(error > bound + FLOOR for bound, error in done)
        median, most = np.median(ratios), np.quantile(ratios, 0.95)
        print(f"| {shape} | {len(own)} | {len(own) - len(done)} | {above} | {median:.1f}, {most:.0f} |")


if __name__ == "__main__":
    numbers = [int(argument) for argument in sys.argv[1:]]
    main(*numbers, *(COUNT, SEED)[len(numbers) :])
