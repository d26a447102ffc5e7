"""Bodies of an ensemble with torques against a loop over `Scene.run`, which gives the same attitudes.

    python tests/benchmarks/torque_ensembles.py [BODIES]

Envisat as in docs/examples/envisat-dispersion.json, gravity gradient and eddy currents, an instant a minute,
tolerances of 1e-3 and 1e-6 rad, over an hour, an orbit and a day.  Answers are asserted equal first.
Processor time a body of the block and of the loop, the least of three turns, and their ratio; and the same by
the clock, the ensemble on two threads (as the loop has them in every run).
"""

from __future__ import annotations

import json
import sys
import warnings
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from attitude import Scene
from attitude.ensemble import Ensemble
from attitude.ensemble.block_motion import motion_of, solver_choice
from attitude.times.instants import Instants

ROOT = Path(__file__).parents[2]
DOCUMENT = json.loads((ROOT / "docs/examples/envisat-dispersion.json").read_text())["scene"]
SPANS = {"an hour": 3600.0, "an orbit": 6000.0, "a day": 86400.0}
TURNS = 3


def scene_of(tolerance: float, seconds: float, **state: Any) -> Scene:
    times = {"start": 0, "stop": seconds, "step": 60, "unit": "s"}
    more = {"times": times, "tolerance": {"value": tolerance, "unit": "rad"}}
    return Scene.model_validate(DOCUMENT | more | state)


def alone(tolerance: float, seconds: float, states: Any, i: int) -> Scene:
    return scene_of(
        tolerance,
        seconds,
        body={"tensor": np.asarray(states.body.tensor)[i].tolist(), "unit": "kg m2"},
        attitude={"quaternion": np.asarray(states.attitude)[i].tolist(), "order": "wxyz"},
        angular_velocity={"value": np.asarray(states.angular_velocity)[i].tolist(), "unit": "rad/s"},
    )


def row(name: str, seconds: float, tolerance: float, count: int) -> None:
    scene = scene_of(tolerance, seconds)
    ensemble = Ensemble.sample(scene, count, 7, moments="2 %", angular_velocity="0.1 deg/s")
    states, instants = ensemble.states(), scene.times.build(None)
    instants = Instants(instants.seconds, instants.seconds_low, None)
    choice = solver_choice(scene, ensemble.source, instants)
    scenes = [alone(tolerance, seconds, states, i) for i in range(count)]

    def block() -> np.ndarray:
        return motion_of(scene, states, instants, choice=choice).quaternion

    def loop() -> np.ndarray:
        return np.array([one.run().quaternion("wxyz") for one in scenes])

    halves = 2.0 * np.arccos(np.minimum(1.0, np.abs((block() * loop()).sum(axis=-1))))
    assert halves.max() <= 2.0 * tolerance + 1e-7  # the angle of the cosine is no better than 1e-8
    busy, clock = {}, {}
    for work in (block, loop):
        for _ in range(TURNS):
            begun, used = perf_counter(), process_time()
            work()
            busy[work] = min(busy.get(work, np.inf), process_time() - used)
            clock[work] = min(clock.get(work, np.inf), perf_counter() - begun)
    begun = perf_counter()
    ensemble.statistics(instants.seconds, workers=2)
    both = perf_counter() - begun
    each = [1e3 * t / count for t in (busy[block], busy[loop], both, clock[loop])]
    ratios = busy[loop] / busy[block], clock[loop] / both
    print(
        f"| {name}, {tolerance:.0e} | {each[0]:.2f} | {each[1]:.2f} | {ratios[0]:.1f} |"
        f" {each[2]:.2f} | {each[3]:.2f} | {ratios[1]:.1f} |",
        flush=True,
    )


def main(count: int = 200) -> None:
    warnings.simplefilter("ignore")
    print(
        "| | processor ms a body: block | loop | ratio | by the clock: two threads | loop | ratio |\n"
        + "|---" * 7
        + "|"
    )
    for tolerance in (1e-3, 1e-6):
        for name, seconds in SPANS.items():
            row(name, seconds, tolerance, count)


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:]))
