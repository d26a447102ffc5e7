"""Damaged files of all formats, a hundred thousand or more: each is refused, or read and written again.

    python -m tests.benchmarks.fuzz_formats [--inputs 100000] [--format NAME] [--seed N] [--keep FOLDER]

What is refused, is so by a FormatError that names the file; what is read, the format's own writer writes, and
it comes back the same.  Orbits (oem, stk-ephemeris, orbit-csv) and parameter messages (apm) are read as parts
of scenes, which are stopped after SECONDS_OF_SCENE (a damaged torque may spin a body up to 1e8 rad/s), and
refused by errors of this library alone.  Anything else (another exception, a warning) is
printed, its input is kept under `keep`, and the exit code is 1.  Inputs are shared among the formats by their
speed.
"""

import argparse
import random
import sys
import threading
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path

import numpy as np

from attitude import AttitudeError, AttitudeWarning, Scene, stopping
from attitude.formats.registry import FORMATS
from tests.formats import apm_texts, orbit_texts
from tests.formats.damage import edited, originals, outcome, random_edits

# Parts of all inputs: ECSV, FITS and what is written through SPICE or turned with the Earth is slow.
SHARES = dict.fromkeys(FORMATS, 10) | {"ecsv": 1, "fits": 3, "parquet": 5, "ck": 4, "czml": 6}
ROWS = [30.0 * i for i in range(12)]
BASE = {
    "body": {"moments": [1.0, 2.0, 2.5], "unit": "kg m2"},
    "epoch": {"time": "2026-01-01T00:00:00", "scale": "utc"},
    "frame": "EME2000",
    "attitude": {"quaternion": [1.0, 0.0, 0.0, 0.0], "order": "wxyz"},
    "angular_velocity": {"value": [0.0, 0.01, 0.0], "unit": "rad/s"},
    "times": {"start": 0, "stop": 300, "step": 100, "unit": "s"},
}
# Parts of scenes by their names here: the member of the document, its key, and texts.
PARTS = {
    "oem": ("orbit", "oem", [orbit_texts.oem(orbit_texts.oem_segment(ROWS)), orbit_texts.oem_xml(ROWS)]),
    "stk-ephemeris": (
        "orbit",
        "stk",
        [orbit_texts.stk(ROWS), orbit_texts.stk(ROWS, "EphemerisTimePos", "Lagrange")],
    ),
    "orbit-csv": ("orbit", "csv", [orbit_texts.csv(ROWS)]),
    "apm": ("apm", None, [apm_texts.SPINNER, apm_texts.FIRST_VERSION]),
}
SHARES |= dict.fromkeys(PARTS, 10)
SECONDS_OF_SCENE = 1.0
MAX_PRINTED_FAILURES = 5  # of one kind


def fuzzed(format, count, seed, keep, progress=None):
    """How many were refused and kept, and the failures by what they say."""
    chance, counts, failures = random.Random(f"{format} {seed}"), Counter(), Counter()
    files = [text.encode() for text in PARTS[format][2]] if format in PARTS else originals(format)
    judge = outcome_of_part if format in PARTS else outcome
    for i in range(count):
        content = edited(chance.choice(files), random_edits(chance))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                warnings.filterwarnings("ignore", "ERFA function")  # dubious years
                counts[judge(format, content)] += 1
        except Exception as error:
            message = described(error)
            failures[message] += 1
            if failures[message] <= MAX_PRINTED_FAILURES:
                keep.mkdir(parents=True, exist_ok=True)
                path = keep / f"{format}.{seed}.{i}"
                path.write_bytes(content)
                print(f"{path}: {message}", flush=True)
    return counts, failures


def outcome_of_part(name, content):
    """Refused by an error of this library, or kept: a scene that runs, and whose message is written."""
    member, key, _ = PARTS[name]
    text = content.decode("utf-8", "replace")
    try:
        warnings.simplefilter("ignore", AttitudeWarning)
        document = {"apm": text, "times": BASE["times"]} if key is None else BASE | {member: {key: text}}
        scene = Scene.model_validate(document)
        if key is None:
            scene.to_apm()
        positions = positions_of(scene)
        assert positions is None or np.isfinite(positions).all()
    except AttitudeError:
        return "refused"
    except stopping.Stopped:
        return "stopped"
    return "kept"


def positions_of(scene):
    """Positions along the orbit of a scene that is run, where it has one; Stopped where that takes long."""
    stop = stopping.Stop()
    timer = threading.Timer(SECONDS_OF_SCENE, stop.set)
    timer.start()
    try:
        with stopping.stoppable(stop):
            ephemeris = scene.run()
            return None if ephemeris.orbit is None else ephemeris.position
    finally:
        timer.cancel()


def described(error):
    """The exception and where it was raised last, in one line."""
    frame = traceback.extract_tb(error.__traceback__)[-1]
    ours = [f for f in traceback.extract_tb(error.__traceback__) if "/attitude/" in f.filename]
    inside = f" of {Path(ours[-1].filename).name}:{ours[-1].lineno}" if ours else ""
    text = " ".join(str(error).split())[:120]
    return f"{type(error).__name__}: {text} ({Path(frame.filename).name}:{frame.lineno}{inside})"


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--format", choices=[*FORMATS, *PARTS])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, default=Path("damaged"))
    options = parser.parse_args()
    formats = [options.format] if options.format else [*FORMATS, *PARTS]
    total, failed = Counter(), 0
    print(f"{'format':14}{'inputs':>8}{'refused':>9}{'kept':>7}{'stopped':>8}{'failed':>8}{'time, s':>9}")
    for format in formats:
        count = -(-options.inputs * SHARES[format] // sum(SHARES[name] for name in formats))
        begun = time.perf_counter()
        counts, failures = fuzzed(format, count, options.seed, options.keep)
        seconds, wrong = time.perf_counter() - begun, sum(failures.values())
        print(
            f"{format:14}{count:8}{counts['refused']:9}{counts['kept']:7}{counts['stopped']:8}{wrong:8}"
            f"{seconds:9.1f}",
            flush=True,
        )
        total += counts
        failed += wrong
    counted = f"{total['refused']:9}{total['kept']:7}{total['stopped']:8}{failed:8}"
    print(f"{'all':14}{sum(total.values()) + failed:8}{counted}")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
