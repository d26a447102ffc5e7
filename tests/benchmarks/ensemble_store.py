"""What it costs to store an ensemble, beside what Zarr takes for that many random bytes.

    python tests/benchmarks/ensemble_store.py [DIRECTORY] [--bodies 1000000] [--instants 100] [--turns 3]

In turns, on two threads, in the same chunks: Zarr alone as its defaults are (which compress), Zarr alone as
an ensemble is stored (chunks by component, not compressed), and the run of the ensemble.  Each in a
directory of its own that is removed afterwards, with what is in it brought to the disk (`sync`) or left to
the system.  DIRECTORY has to have room for one of them (5.6 GB for the default).
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import zarr
from zarr.codecs import TransposeCodec

from attitude import Scene
from attitude.ensemble import Ensemble
from attitude.ensemble.storage.chunk_grid import chunk_grid

THREADS = 2
OURS = {"filters": [TransposeCodec(order=(2, 0, 1))], "compressors": None}
DEFAULTS: dict[str, Any] = {}
WHERE = {False: "left to the system", True: "brought to the disk"}


def zarr_alone(place: Path, bodies: int, instants: int, options: dict[str, Any]) -> None:
    """Random doubles, made before, one block for all chunks: only the writing is done here."""
    group, cut = zarr.create_group(place), chunk_grid(bodies, instants)
    arrays = [
        group.create_array(
            name,
            shape=(bodies, instants, width),
            chunks=(*cut.shape, width),
            dtype="f8",
            config={"write_empty_chunks": True},
            **options,
        )
        for name, width in (("quaternion", 4), ("rate", 3))
    ]

    def write(part: Any) -> None:
        for array, block in zip(arrays, RANDOM[cut.shape[0], instants], strict=True):
            array[part.first : part.last, part.start : part.stop] = block[: part.last - part.first]

    with ThreadPoolExecutor(THREADS) as pool:
        list(pool.map(write, cut))


RANDOM: dict[tuple[int, int], list[np.ndarray]] = {}


def make_random(bodies: int, instants: int) -> None:
    """By component, as an ensemble's blocks are."""
    at_once, generator = chunk_grid(bodies, instants).shape[0], np.random.default_rng(1)
    RANDOM[at_once, instants] = [
        np.moveaxis(generator.random((width, at_once, instants)), 0, -1) for width in (4, 3)
    ]


def ensemble_run(place: Path, bodies: int, instants: int) -> None:
    scene = Scene.builtin("toutatis")
    spreads = {"moments": "2 %", "angular_velocity": "0.1 deg/d", "attitude": "1 deg"}
    ensemble = Ensemble.sample(scene, bodies, 7, **spreads)
    ensemble.run(np.linspace(0.0, 40 * 86400.0, instants), place, workers=THREADS)


def timed(work: Callable[[Path], None], directory: str, sync: bool) -> float:
    with tempfile.TemporaryDirectory(dir=directory) as folder:
        os.sync()
        begun = perf_counter()
        work(Path(folder) / "out.zarr")
        if sync:
            os.sync()
        return perf_counter() - begun


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("directory", nargs="?", default=tempfile.gettempdir())
    parser.add_argument("--bodies", type=int, default=1_000_000)
    parser.add_argument("--instants", type=int, default=100)
    parser.add_argument("--turns", type=int, default=3)
    options = parser.parse_args()
    size = options.bodies, options.instants
    needed = 56 * size[0] * size[1]
    if shutil.disk_usage(options.directory).free < 1.2 * needed:
        sys.exit(f"{options.directory} has no room for {needed / 1e9:.3g} GB")
    make_random(*size)
    ways: dict[str, Callable[[Path], None]] = {
        "zarr, defaults": lambda place: zarr_alone(place, *size, DEFAULTS),
        "zarr, as here": lambda place: zarr_alone(place, *size, OURS),
        "ensemble": lambda place: ensemble_run(place, *size),
    }
    with tempfile.TemporaryDirectory(dir=options.directory) as folder:  # kernels are loaded
        ensemble_run(Path(folder) / "out.zarr", 100, 10)
    for sync in (False, True):
        taken: dict[str, list[float]] = {name: [] for name in ways}
        for _ in range(options.turns):
            for name, work in ways.items():
                taken[name].append(timed(work, options.directory, sync))
        ours = statistics.median(taken["ensemble"])
        print(f"{size[0]} bodies x {size[1]} instants, {needed / 1e9:.3g} GB, {WHERE[sync]}")
        for name, seconds in taken.items():
            median = statistics.median(seconds)
            spread = f"{min(seconds):.2f} to {max(seconds):.2f}"
            print(f"  {name:<15} {median:7.2f} s ({spread})   the ensemble takes {ours / median:.2f} of it")


if __name__ == "__main__":
    main()
