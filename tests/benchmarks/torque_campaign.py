"""Random scenes under torques: the error against Taylor's series in 80-bit numbers, and the bound given.

    python tests/benchmarks/torque_campaign.py [COUNT [SEED [FILE]]]          (the extra `peers`)

Bodies of every shape, states near an axis, near the separatrix and at rest, all effects, torques of every
size, eccentric orbits, spans forwards, backwards and both, tolerances from 1e-2 to 1e-12 rad.  The truth is
`campaign_truth`; what it found is added to FILE, and taken from there the next time: a campaign goes on where
it was interrupted, and another version of the library is judged in minutes.  A line for every scene whose
error is above its bound, and for every refusal; then tables by shape and by effect.
"""

from __future__ import annotations

import itertools
import json
import math
import sys
import warnings
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from attitude import AttitudeError, Scene
from attitude.effects import UserTorque
from tests.benchmarks.campaign_truth import CampaignTruth, TooManyStepsError, most_plates

COUNT, SEED = 3000, 20
TOLERANCES = 1e-19, 1e-17  # of the truth, and of another by which its own error is estimated
DISTURBANCE = 2.0**-61  # of the momentum, of the truth's own rounding
MU, RADIUS, ROTATION = 3.986004418e14, 6378137.0, 7.292115e-5
# Angles below this are rounding of the attitude itself.
FLOOR = 3e-16
SHAPES = {
    "needle": (1.0, 1.0 - 1e-3, 1e-3),
    "disc": (1.0, 1.0, 1.99),
    "sphere": (1.0, 1.0, 1.0),
    "symmetric": (1.0, 1.0, 0.6),
    "nearly symmetric": (1.0, 1.0, 0.6),
    "triaxial": (1.0, 1.5, 2.0),
    "flat": (1.0, 1.3, 2.299),
}
STATES = ("any", "near an axis", "near the separatrix", "at rest")


class Outcome(NamedTuple):
    """Of one scene: groups that it belongs to, bound and error in rad; both None where it was refused."""

    groups: tuple[str, ...]
    bound: float | None
    error: float | None
    outgrown: bool = False


def quantity(value: Any, unit: str) -> dict[str, Any]:
    return {"value": value, "unit": unit}


def direction(rng: np.random.Generator, size: float = 1.0) -> list[float]:
    vector = rng.normal(size=3)
    return (size * vector / np.linalg.norm(vector)).tolist()


def rate_of(rng: np.random.Generator, moments: np.ndarray, state: str) -> np.ndarray:
    """A unit rate, or zeros."""
    rate, small = np.array(direction(rng)), 10.0 ** rng.uniform(-10, -2)
    if state == "at rest":
        return np.zeros(3)
    if state == "near an axis":
        rate = np.eye(3)[rng.integers(3)] + small * rate
    if state == "near the separatrix":
        low, middle, high = np.argsort(moments, kind="stable")
        a, b, c = moments[[low, middle, high]]
        rate[low] = np.sqrt(max(c * (c - b), 0.0) / max(a * (b - a), 1e-12)) * rate[high] + small
    return rate / np.linalg.norm(rate)


def plates(rng: np.random.Generator, **properties: Any) -> list[dict[str, Any]]:
    return [
        {
            "area": quantity(float(rng.uniform(0.1, 1.0)), "m2"),
            "normal": direction(rng),
            "centre": quantity(direction(rng, 0.3), "m"),
            **properties,
        }
        for _ in range(int(rng.integers(1, 3)))
    ]


def instant(rng: np.random.Generator, span: tuple[float, float]) -> float:
    return float(rng.uniform(*span))


def effects_of(
    rng: np.random.Generator, size: float, momentum: float, pace: float, span: tuple[float, float]
) -> list[dict[str, Any]]:
    """One to three effects; size : N m, of those that are not gravity's."""
    start, stop = sorted((instant(rng, span), instant(rng, span)))
    damping = rng.normal(size=(3, 3))
    damping = damping @ damping.T * size / pace / 3.0
    density = {"density": quantity(size / 1e7, "kg/m3")}
    if rng.integers(2):
        density |= {
            "reference_altitude": quantity(float(rng.uniform(3e5, 8e5)), "m"),
            "scale_height": quantity(float(rng.uniform(5e4, 2e5)), "m"),
        }
    available = [
        {"type": "constant_torque", "torque": quantity(direction(rng, size), "N m"), "frame": "body"},
        {"type": "constant_torque", "torque": quantity(direction(rng, size), "N m"), "frame": "inertial"},
        {
            "type": "constant_torque",
            "torque": quantity(direction(rng, size), "N m"),
            "frame": "body",
            "start": quantity(start, "s"),
            "stop": quantity(stop, "s"),
        },
        {
            "type": "impulse",
            "time": quantity(instant(rng, span), "s"),
            "frame": str(rng.choice(["body", "inertial"])),
            "angular_impulse": quantity(direction(rng, min(0.3 * momentum, size / pace)), "N m s"),
        },
        {"type": "gravity_gradient"},
        {"type": "eddy_damping", "tensor": (0.5 * (damping + damping.T)).tolist(), "unit": "N m s"},
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
            "field": {
                "strength": quantity(3e-5, "T"),
                "radius": quantity(6371200.0, "m"),
                "tilt": quantity(float(rng.uniform(0.0, 0.3)), "rad"),
                "longitude": quantity(float(rng.uniform(-3.0, 3.0)), "rad"),
                "rotation": quantity(ROTATION, "rad/s"),
            },
        },
        {
            "type": "drag",
            "plates": plates(rng, coefficient=2.2),
            "rotation": quantity(ROTATION, "rad/s"),
            **density,
        },
        {
            "type": "solar_pressure",
            "plates": [
                plate | {"area": quantity(plate["area"]["value"] * size / 1e-6, "m2")}
                for plate in plates(rng, specular=float(rng.uniform(0, 0.6)), diffuse=0.3)
            ],
            "sun": {"direction": direction(rng)},
            "shadow": [False, "cylindrical"][rng.integers(2)],
        },
        {
            "type": "user",
            "damping": float(size / pace),
            "swing": direction(rng, size),
            "beat": pace * float(rng.uniform(0.1, 3.0)),
            "size": size,
        },
    ]
    chosen = rng.choice(len(available), rng.integers(1, 4), replace=False)
    return [available[i] for i in sorted(chosen)]


def orbit_of(rng: np.random.Generator) -> dict[str, Any]:
    eccentricity = float(rng.choice([0.0, rng.uniform(0.0, 0.1), rng.uniform(0.1, 0.9)]))
    angles = ("raan", "argument_of_pericentre", "mean_anomaly")
    pericentre = RADIUS + float(rng.uniform(3e5, 2e6))
    return {
        "semi_major_axis": quantity(pericentre / (1.0 - eccentricity), "m"),
        "eccentricity": eccentricity,
        "inclination": quantity(float(rng.uniform(0, math.pi)), "rad"),
        **{name: quantity(float(rng.uniform(-3, 3)), "rad") for name in angles},
        "mu": quantity(MU, "m3/s2"),
        "radius": quantity(RADIUS, "m"),
    }


def document_of(rng: np.random.Generator) -> tuple[dict[str, Any], tuple[str, ...]]:
    """A document, and the groups that it belongs to."""
    shape, state = str(rng.choice(list(SHAPES))), str(rng.choice(STATES, p=[0.4, 0.25, 0.25, 0.1]))
    moments = np.array(SHAPES[shape])
    if shape == "nearly symmetric":
        moments[1] += 10.0 ** rng.uniform(-12, -2)
    moments = rng.permutation(moments) * 10.0 ** rng.uniform(0, 3)
    pace, turned = 10.0 ** rng.uniform(-3, -0.5), rng.uniform(5.0, 40.0)
    rate = pace * rate_of(rng, moments, state)
    momentum = float(np.linalg.norm(moments * rate)) or pace * float(moments.max())
    size = momentum**2 / moments.max() * moments.min() / moments.max() * 10.0 ** rng.uniform(-8, -1)
    if state == "at rest":  # as far as torques turn it
        pace = max(math.sqrt(size / float(moments.min())), 1e-3)
    share = float(rng.choice([0.0, 0.0, 1.0, 0.5]))  # of the span, before the epoch
    start, stop = -share * turned / pace, (1.0 - share) * turned / pace
    q = rng.normal(size=4)
    document = {
        "body": {"moments": moments.tolist(), "unit": "kg m2"},
        "frame": "INERTIAL",
        "attitude": {"quaternion": (q / np.linalg.norm(q)).tolist(), "order": "wxyz"},
        "angular_velocity": quantity(rate.tolist(), "rad/s"),
        "times": {"start": start, "stop": stop, "count": int(rng.choice([5, 41])), "unit": "s"},
        "effects": effects_of(rng, size, momentum, pace, (start, stop)),
        "orbit": orbit_of(rng),
        "tolerance": quantity(10.0 ** rng.uniform(-12, -2), "rad"),
    }
    kinds = tuple(sorted({effect["type"] for effect in document["effects"]}))
    return document, (shape, state, *kinds, "backwards" if share else "forwards")


def user_torque(damping: float, swing: list[float], beat: float, size: float) -> UserTorque:
    """-k w, and a torque that swings."""
    amplitude = np.array(swing)
    return UserTorque(
        "user", lambda t, _, rate: math.sin(beat * t) * amplitude - damping * rate, size=2.0 * size
    )


def scene_of(document: dict[str, Any]) -> Scene:
    effects = [
        user_torque(**{k: v for k, v in effect.items() if k != "type"})
        if effect["type"] == "user"
        else effect
        for effect in document["effects"]
    ]
    return Scene(**(document | {"effects": effects}))


def seconds_of(scene: Scene) -> np.ndarray:
    """(n,) s, 80 bits: scenes have instants of two parts, and a needle turns far in what rounding changes."""
    instants = scene.times.build(None)
    low = 0.0 if instants.seconds_low is None else instants.seconds_low
    return instants.seconds.astype(np.longdouble) + low


def angle(p: np.ndarray, q: np.ndarray) -> float:
    """rad, the greatest between attitudes (n, 4)."""
    (a, b), (c, d) = (p[:, 0], p[:, 1:]), (q[:, 0], q[:, 1:])
    across = a[:, None] * d - c[:, None] * b - np.cross(b, d)
    return float(2.0 * np.arcsin(np.minimum(1.0, np.sqrt((across**2).sum(axis=1)))).max())


class Campaign:
    """Scenes of a seed, with the truths in a file, a line each."""

    def __init__(self, seed: int, path: Path):
        self._seed, self._path = seed, path
        lines = path.read_text().splitlines() if path.exists() else []
        self._truths = {tuple(one["scene"]): one["truth"] for one in map(json.loads, lines)}
        self._engines: dict[tuple[int, float], CampaignTruth] = {}

    def outcome(self, i: int) -> Outcome:
        """Of scene i, drawn again where the body turns too far for a truth; prints what is wrong."""
        for draw in itertools.count():
            document, groups = document_of(np.random.default_rng([self._seed, i, draw]))
            scene = scene_of(document)
            seconds = seconds_of(scene)
            truth, off = self._truth((i, draw), document, seconds)
            if truth.size:
                break
        try:
            run = scene.run()
        except AttitudeError as error:
            print(f"scene {i}: refused: {', '.join(groups)}: {error}", flush=True)
            return Outcome(groups, None, None)
        assert run.plan is not None
        assert run.plan.error_bound is not None
        bound, error = run.plan.error_bound, max(0.0, angle(run.quaternion("wxyz"), truth) - 3.0 * off)
        if error > bound + FLOOR:  # is the truth itself as good as that?
            other = CampaignTruth(most_plates(document), TOLERANCES[0], DISTURBANCE)
            at = other.attitudes(document, seconds).astype(float)
            error = max(0.0, error - 3.0 * angle(truth, at))
        if error > bound + FLOOR:
            print(f"scene {i}: {', '.join(groups)}: {error:.1e} > {bound:.1e}", flush=True)
        return Outcome(groups, bound, error, run.plan.tolerance_span is not None)

    def _truth(
        self, scene: tuple[int, int], document: dict[str, Any], seconds: np.ndarray
    ) -> tuple[np.ndarray, float]:
        """Attitudes, none where the body turns too far; and by how much those in other steps differ, rad."""
        key, plates = (self._seed, *scene), most_plates(document)
        if key not in self._truths:
            try:
                found, other = (
                    self._engine(plates, tolerance).attitudes(document, seconds).astype(float)
                    for tolerance in TOLERANCES
                )
            except TooManyStepsError:
                found, other = np.empty((2, 0, 4))
            self._truths[key] = found.tolist(), angle(found, other) if found.size else 0.0
            with self._path.open("a") as file:
                file.write(json.dumps({"scene": key, "truth": self._truths[key]}) + "\n")
        attitudes, off = self._truths[key]
        return np.array(attitudes), off

    def _engine(self, plates: int, tolerance: float) -> CampaignTruth:
        if (plates, tolerance) not in self._engines:
            self._engines[plates, tolerance] = CampaignTruth(plates, tolerance)
        return self._engines[plates, tolerance]


def table(outcomes: list[Outcome]) -> None:
    print("| | scenes | refused | outgrown | above the bound | bound / error: median, 95 % |")
    print("|---" * 6 + "|")
    names = Counter(name for outcome in outcomes for name in outcome.groups)
    for name in (*SHAPES, *STATES, *sorted(set(names) - {*SHAPES, *STATES}), "all"):
        own = [one for one in outcomes if name in (*one.groups, "all")]
        done = [(o.bound, o.error) for o in own if o.bound is not None and o.error is not None]
        ratios = [bound / max(error, FLOOR) for bound, error in done] or [np.nan]
        above = sum(error > bound + FLOOR for bound, error in done)
        outgrown = sum(one.outgrown for one in own)
        median, most = np.median(ratios), np.quantile(ratios, 0.95)
        counts = f"{len(own)} | {len(own) - len(done)} | {outgrown} | {above}"
        print(f"| {name} | {counts} | {median:.1f}, {most:.0f} |")


def main(count: int = COUNT, seed: int = SEED, path: str = "torque_campaign.jsonl") -> None:
    warnings.simplefilter("ignore")
    campaign = Campaign(seed, Path(path))
    table([campaign.outcome(i) for i in range(count)])


if __name__ == "__main__":
    numbers = [int(argument) for argument in sys.argv[1:3]]
    main(*numbers, *sys.argv[3:4])
