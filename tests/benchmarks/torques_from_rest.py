"""Bodies at rest at the epoch, under all pairs of effects, against those that turn at 1e-12 rad/s there.

    python tests/benchmarks/torques_from_rest.py [scenes] [seed]

The motions must be the same, to 1e-10 rad/s and the error bounds of both.
"""

import sys
from itertools import combinations
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from attitude import Scene, ToleranceError
from tests.dynamics.at_rest import EFFECTS, differences, random_scene


def main(count: int, seed: int) -> int:
    rng, worst, wrong, refused = np.random.default_rng(seed), 0.0, 0, 0
    pairs = list(combinations(EFFECTS, 2))
    for i in range(count):
        document = random_scene(rng, pairs[i % len(pairs)])
        try:
            rates, attitudes = differences(document)
        except ToleranceError as error:
            refused += 1
            print(i, pairs[i % len(pairs)], "refused:", error)
            continue
        worst = max(worst, rates, attitudes)
        if rates > 1.0 or attitudes > 1.0:
            wrong += 1
            print(
                i,
                pairs[i % len(pairs)],
                f"{rates:.1e} in rates, {attitudes:.1e} in attitudes, of what may be",
            )
            print(Scene.model_validate(document).to_json())
    print(
        f"{count} scenes, seed {seed}: {wrong} wrong, {refused} refused, at most {worst:.2f} of what may be"
    )
    return 1 if wrong or refused else 0


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:]]
    sys.exit(main(*(numbers + [500, 1][len(numbers) :])))
