"""Damaged files of all formats, a hundred thousand or more: each is refused, or read and written again.

    python -m tests.benchmarks.fuzz_formats [--inputs 100000] [--format NAME] [--seed N] [--keep FOLDER]

What is refused, is so by a FormatError that names the file; what is read, the format's own writer writes, and
it comes back the same.  Anything else (another exception, a warning) is printed, its input is kept
under `keep`, and the exit code is 1.  Inputs are shared among the formats by their speed.
"""

import argparse
import random
import sys
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path

from attitude.formats.registry import FORMATS
from tests.formats.damage import edited, originals, outcome, random_edits

# Parts of all inputs: ECSV, FITS and what is written through SPICE or turned with the Earth is slow.
SHARES = dict.fromkeys(FORMATS, 10) | {"ecsv": 1, "fits": 3, "parquet": 5, "ck": 4, "czml": 6}
MAX_PRINTED_FAILURES = 5  # of one kind


def fuzzed(format, count, seed, keep, progress=None):
    """How many were refused and kept, and the failures by what they say."""
    chance, counts, failures = random.Random(f"{format} {seed}"), Counter(), Counter()
    files = originals(format)
    for i in range(count):
        content = edited(chance.choice(files), random_edits(chance))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                warnings.filterwarnings("ignore", "ERFA function")  # dubious years
                counts[outcome(format, content)] += 1
        except Exception as error:
            message = described(error)
            failures[message] += 1
            if failures[message] <= MAX_PRINTED_FAILURES:
                keep.mkdir(parents=True, exist_ok=True)
                path = keep / f"{format}.{seed}.{i}"
                path.write_bytes(content)
                print(f"{path}: {message}", flush=True)
    return counts, failures


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
    parser.add_argument("--format", choices=FORMATS)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, default=Path("damaged"))
    options = parser.parse_args()
    formats = [options.format] if options.format else list(FORMATS)
    total, failed = Counter(), 0
    print(f"{'format':10}{'inputs':>8}{'refused':>9}{'kept':>7}{'failed':>8}{'time, s':>9}")
    for format in formats:
        count = -(-options.inputs * SHARES[format] // sum(SHARES[name] for name in formats))
        begun = time.perf_counter()
        counts, failures = fuzzed(format, count, options.seed, options.keep)
        seconds, wrong = time.perf_counter() - begun, sum(failures.values())
        print(
            f"{format:10}{count:8}{counts['refused']:9}{counts['kept']:7}{wrong:8}{seconds:9.1f}", flush=True
        )
        total += counts
        failed += wrong
    print(f"{'all':10}{sum(total.values()) + failed:8}{total['refused']:9}{total['kept']:7}{failed:8}")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
