"""Memory and time of a stored ensemble, by the number of bodies.

    python tests/benchmarks/ensemble_memory.py [DIRECTORY] [--sizes 100000 1000000 10000000] [--instants 10]

Each size in a process of its own, to Zarr in DIRECTORY (5.6 GB for the largest), removed afterwards.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile

RUN = """
import resource, sys
import numpy as np
from attitude import Scene
from attitude.ensemble import Ensemble
bodies, instants, place = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
spreads = {"moments": "2 %", "angular_velocity": "0.1 deg/d", "attitude": "1 deg"}
ensemble = Ensemble.sample(Scene.builtin("toutatis"), bodies, 7, **spreads)
ensemble.states(0, 10)
result = ensemble.run(np.linspace(0.0, 40 * 86400.0, instants), place, workers=2)
memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
print(f"{bodies:>9} bodies x {instants} instants: at most {memory:5.0f} MiB, {result.seconds:6.2f} s, "
      f"{result.seconds / bodies * 1e6:.2f} us a body")
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("directory", nargs="?", default=tempfile.gettempdir())
    parser.add_argument("--sizes", type=int, nargs="+", default=[100_000, 1_000_000, 10_000_000])
    parser.add_argument("--instants", type=int, default=10)
    options = parser.parse_args()
    for size in options.sizes:
        with tempfile.TemporaryDirectory(dir=options.directory) as folder:
            place = [str(size), str(options.instants), f"{folder}/out.zarr"]
            subprocess.run([sys.executable, "-c", RUN, *place], check=True)


if __name__ == "__main__":
    main()
