"""How much memory a writer takes for ten million instants, each format in a process of its own.

    python -m tests.benchmarks.formats_memory [COUNT]

The ephemeris is computed piece by piece and written to the null device, so that what the process grows by,
from the first piece of it to the end of the file, is the writer's.  Fails where that is above 150 MiB.
Of scenes with effects, whose instants are all computed before the first is written, it is only printed.
"""

import json
import subprocess
import sys
import time

import numpy as np

from tests.benchmarks.serving import resident

FORMATS = ("arrow", "arrows", "parquet", "fits", "npz", "ecsv", "csv", "ndjson", "json")
SCENES = ("thruster-plan", "gyrostat", "drop")
COUNT = 10_000_000
MOST = 150.0  # MiB


def lazy(count):
    """Attitudes and rates at so many dated instants, one second apart, computed when they are asked for."""
    from astropy.time import Time

    from attitude import Grid, RigidBody, TorqueFreeMotion
    from attitude.samples.chunks import Samples

    epoch = Time("2020-01-01T00:00:00", scale="utc")
    body, identity = RigidBody((1.0, 2.0, 3.0)), (1.0, 0.0, 0.0, 0.0)
    motion = TorqueFreeMotion(body, identity, (0.3, 0.4, 0.5), epoch, order="wxyz")
    grid = Grid(0.0, float(count - 1), count)
    return Samples(count, lambda a, b: motion.ephemeris(grid.part(a, b, epoch), rate=True))


def measure(format, count):
    """(MiB that the process grew by, seconds) of writing so many instants."""
    from attitude import formats
    from attitude.samples.chunks import CHUNK_INSTANTS

    formats.write(lazy(10), "/dev/null", format)  # what the format rests on is imported
    samples = lazy(count)
    samples.chunk(0, min(CHUNK_INSTANTS, count))
    before, begun = resident("self"), time.perf_counter()
    formats.write(samples, "/dev/null", format)
    return resident("self", "VmHWM") - before, time.perf_counter() - begun


def with_effects(name, count):
    """(MiB that the process grew by, seconds) of a built-in scene with effects, as CSV."""
    from attitude import Scene

    document = json.loads(Scene.builtin(name).to_json())
    times = {name: document["times"][name] for name in ("start", "stop", "unit")}
    few, many = (Scene.from_json(json.dumps(document | {"times": times | {"count": n}})) for n in (10, count))
    few.write("/dev/null", "csv")
    before, begun = resident("self"), time.perf_counter()
    many.write("/dev/null", "csv")
    return resident("self", "VmHWM") - before, time.perf_counter() - begun


def main(count):
    print(f"{count} instants\n{'format':10}{'growth, MiB':>12}{'time, s':>10}{'ns an instant':>15}")
    grown = []
    for name in FORMATS + SCENES:
        command = [sys.executable, "-m", "tests.benchmarks.formats_memory", "--one", name, str(count)]
        run = subprocess.run(command, capture_output=True, text=True, check=True)
        growth, seconds = map(float, run.stdout.split())
        if name in FORMATS:
            grown.append(growth)
        print(f"{name:14}{growth:8.1f}{seconds:10.1f}{1e9 * seconds / count:15.0f}", flush=True)
    return int(np.max(grown) > MOST)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        print(*(measure if sys.argv[2] in FORMATS else with_effects)(sys.argv[2], int(sys.argv[3])))
    else:
        sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else COUNT))
