"""The cost of a column of angles beside that of the quaternions: computed, and written as CSV.

python -m tests.benchmarks.angle_column
"""

from __future__ import annotations

import time

import numpy as np

from attitude import Scene
from attitude.formats import encoding, registry
from attitude.samples.chunks import Samples

SAMPLES, REPEATS = 100_000, 9
COLUMNS = ("quaternion", "angle:z:sun", "angle:z:earth", "angle:z:momentum", "angle:-y:velocity")


def main() -> None:
    """Print medians, s, and ratios to the quaternions."""
    document = Scene.builtin("envisat").document()
    times = {"start": 0, "stop": 1, "count": SAMPLES, "unit": "d"}
    scene = Scene.model_validate(document | {"times": times})
    for label, work in (("computed", computed), ("computed and written as CSV", written)):
        seconds: dict[str, list[float]] = {name: [] for name in COLUMNS}
        for _ in range(REPEATS):  # interleaved: the machine's load is the same for all
            for name in COLUMNS:
                begun = time.process_time()
                work(scene, name)
                seconds[name].append(time.process_time() - begun)
        medians = {name: float(np.median(each)) for name, each in seconds.items()}
        print(label)
        for name, median in medians.items():
            print(f"  {name:18} {median:.4f} s, {median / medians['quaternion']:.2f} x the quaternions")


def computed(scene: Scene, name: str) -> None:
    ephemeris = scene.run()
    if name == "quaternion":
        ephemeris.quaternion("wxyz")
    else:
        ephemeris.angle(*name.split(":")[1:])


def written(scene: Scene, name: str) -> None:
    samples = Samples.of(scene.run().with_columns(f"elapsed,{name}"))
    for _ in encoding.encoded_file(samples, registry.FORMATS["csv"]).blocks:
        pass


if __name__ == "__main__":
    main()
