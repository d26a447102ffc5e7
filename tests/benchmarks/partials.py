"""Partial derivatives against differences of the oracle: worst errors over many bodies, and their cost.

python -m tests.benchmarks.partials             random bodies and ladders, errors
python -m tests.benchmarks.partials --cost      cost of an instant and of the set-up
"""

import argparse
import math
import random
import time

import numpy as np
from mpmath import mp, mpf
from scipy.spatial.transform import Rotation

from attitude import RigidBody
from attitude.rigid_body.constants_of_motion import Batch
from attitude.times.instants import Instants

from ..bodies import ATTITUDE, Body, motion, speed
from ..oracles.partials import partials


def random_body(rng):
    """Gaps from 1e-12, needles to 1e-3, rates nine decades apart, some beside the separatrix."""
    kind = rng.randrange(4)
    if kind == 0:
        first = 1.0
        moments = [first, first + 10 ** rng.uniform(-12, 0), first + 10 ** rng.uniform(-12, 0)]
    elif kind == 1:
        least = 10 ** rng.uniform(-3, 0)
        moments = [least, 1.0, 1.0 + least * rng.uniform(-0.99, 0.99)]
    else:
        masses = [10 ** rng.uniform(-2, 0) for _ in range(3)]
        moments = [sum(masses) - mass for mass in masses]
    omega = [rng.choice((-1, 1)) * 10 ** rng.uniform(-9, 0) for _ in range(3)]
    if kind == 3:
        lo, mid, hi = sorted(range(3), key=lambda k: moments[k])
        a, c = moments[lo] * (moments[mid] - moments[lo]), moments[hi] * (moments[hi] - moments[mid])
        off = rng.choice((-1, 1)) * 10 ** rng.uniform(-14, -1)
        omega[hi] = omega[lo] * math.sqrt(a / c) * (1 + off)
    order = rng.sample(range(3), 3)
    return Body(tuple(moments[k] for k in order), tuple(omega[k] for k in order))


def ladders():
    """(name, bodies): beside axes, symmetric bodies, the sphere, the separatrix; discs and needles."""
    powers = (3, 6, 10, 14)
    far = (3, 10, 30, 100)
    middle = math.sqrt(0.5)
    yield "beside the greatest axis", [Body((1.0, 2.0, 2.5), (10.0**-k, 10.0**-k, 1.0)) for k in far]
    yield "beside the least axis", [Body((1.0, 2.0, 2.5), (1.0, 10.0**-k, 10.0**-k)) for k in far]
    yield "nearly symmetric", [Body((1.0, 1.0 + 10.0**-k, 1.6), (0.3, -0.4, 0.8)) for k in powers]
    yield "nearly symmetric, long", [Body((1.0, 1.6, 1.6 + 10.0**-k), (0.9, -0.4, 0.2)) for k in powers]
    yield (
        "nearly a sphere",
        [Body((1.0, 1.0 + 10.0**-k, 1.0 + 3 * 10.0**-k), (0.3, -0.4, 0.8)) for k in powers],
    )
    yield "disc", [Body((1.0, 1.0, 2.0), (0.3, -0.4, 0.8)), Body((1.0, 1.3, 2.3), (0.3, -0.4, 0.8))]
    yield (
        "needle",
        [
            Body((10.0**-k, 1.0, 1.0 + 10.0 ** -(k + 1)), (1.0, y, 0.3 * y))
            for k in (3, 6)
            for y in (1.0, 1e-3, 1e-7)
        ],
    )
    off = [(s, 10.0**-k) for k in (1, 4, 8, 12, 15) for s in (1, -1)]
    yield "beside the separatrix", [Body((3.0, 4.0, 6.0), (2.0, 0.7, 1.0 + s * d)) for s, d in off]
    yield "beside the middle axis", [Body((1.0, 2.0, 2.5), (d, 1.0, s * d * middle)) for s, d in off]


def normalised(matrix, body):
    """Rates over the body's own, moments over themselves."""
    matrix = np.array(matrix, dtype=object)
    matrix[3:] = matrix[3:] / mpf(speed(body))
    matrix[:, 3:6] = matrix[:, 3:6] * mpf(speed(body))
    matrix[:, 6:9] = matrix[:, 6:9] * np.array(list(map(mpf, body.inertia)))
    return matrix


def error(body, t, step):
    """Of the largest entry, both normalised."""
    computed = motion(body).partials(t).matrix
    with mp.workdps(60):
        true = normalised(partials(body, ATTITUDE, t, step=step), body)
        difference = normalised([[mpf(float(x)) for x in row] for row in computed], body) - true
        return float(np.abs(difference).max() / np.abs(true).max())


def campaign(count, seed, step):
    """Worst errors of the ladders and of random bodies, printed as a table."""
    print("| bodies | instants, rad | median | 99 % | worst |\n|---|---|---|---|---|")
    rng = random.Random(seed)
    angles = (1e-3, 0.4, 7.0, 300.0, 1e6, 1e9)
    for name, bodies in ladders():
        report(name, "1e-3 ... 1e9", [(body, angle) for body in bodies for angle in angles], step)
    drawn = [(random_body(rng), 10 ** rng.uniform(-2, 9)) for _ in range(count)]
    report(f"{count} at random", "1e-2 ... 1e9", drawn, step)


def report(name, instants, cases, step):
    """One row."""
    errors = []
    for body, angle in cases:
        try:
            errors.append((error(body, angle / speed(body), step), body, angle))
        except Exception as reason:
            print("!", name, body, angle, repr(reason)[:200])
    sizes = np.array([one[0] for one in errors])
    median, most = np.median(sizes), np.quantile(sizes, 0.99)
    print(f"| {name} | {instants} | {median:.0e} | {most:.0e} | {sizes.max():.1e} |")
    for one in sorted(errors, key=lambda case: -case[0])[:3]:
        if one[0] > 1e-14:
            print("#", *one, flush=True)


def cost(instants=4000, rounds=15):
    """ns an instant of attitude and rate and of all columns, interleaved, medians of the process's time."""
    bodies = {
        "theta": Body((1.0, 1.6, 2.1), (0.3, -0.5, 0.9)),
        "transformed": Body((3.0, 4.0, 6.0), (2.0, 0.7, 1.0 + 2**-20)),
        "constant rate": Body((1.0, 1.6, 2.1), (0.0, 0.0, 0.9)),
    }
    at = Instants(np.linspace(10.0, 1e4, instants), None, None)
    for name, inertia in [*((name, "moments") for name in bodies), ("theta", "tensor")]:
        batch = motion(bodies[name])._batch
        columns, samples = [], []
        for _ in range(rounds):
            begun = time.process_time_ns()
            batch.partials(at, inertia)
            middle = time.process_time_ns()
            batch.sample(at, True, True)
            columns.append((middle - begun) / instants)
            samples.append((time.process_time_ns() - middle) / instants)
        all_columns, sample = np.median(columns), np.median(samples)
        print(
            f"{name}, by {inertia}: {all_columns:.0f} ns, attitude and rate {sample:.1f} ns: "
            f"{all_columns / sample:.1f} x"
        )


def set_up_cost(count=4096, rounds=31):
    """ns a body of a batch: its set-up, and what the first call of `partials` adds before any instant."""
    rng = np.random.default_rng(0)
    moments = np.sort(rng.uniform(1.0, 2.0, (count, 3)), axis=1)
    turns, rates = Rotation.random(count, rng), rng.normal(size=(count, 3)) * 0.05
    attitudes, axes = turns.as_quat(scalar_first=True), turns.as_matrix()
    tensors = axes @ (moments[:, :, None] * np.swapaxes(axes, 1, 2))
    for name, inertia in (("moments", moments), ("tensor", tensors)):
        costs = []
        for _ in range(rounds):
            times = [time.process_time_ns()]
            body = RigidBody(inertia)
            times.append(time.process_time_ns())
            batch = Batch(body, attitudes, rates, (count,))
            times.append(time.process_time_ns())
            for instants in ([], [1000.0]):
                batch.partials(Instants(np.array(instants), None, None), name)
                times.append(time.process_time_ns())
            costs.append(np.diff(times) / count)
        body, constants, none, one = np.median(costs, axis=0)
        print(
            f"{name}: RigidBody {body:.0f} ns a body, constants of motion {constants:.0f} ns; partials at no "
            f"instant {none:.0f} ns, at one {one:.0f} ns"
        )


def store_cost(instants=100_000, rounds=9):
    """ns an instant of all columns, and of filling as many numbers of a new array."""
    batch, at = motion(Body((1.0, 1.6, 2.1), (0.3, -0.5, 0.9)))._batch, np.linspace(10.0, 1e5, instants)
    columns, fills = [], []
    for _ in range(rounds):
        begun = time.process_time_ns()
        batch.partials(Instants(at, None, None))
        middle = time.process_time_ns()
        np.empty((72, instants)).fill(1.0)
        fills.append((time.process_time_ns() - middle) / instants)
        columns.append((middle - begun) / instants)
    print(
        f"{instants} instants: {np.median(columns):.0f} ns; as many numbers filled: {np.median(fills):.0f} ns"
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--cost", action="store_true")
    parser.add_argument("--count", type=int, default=1900)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--step", type=int, default=70)
    options = parser.parse_args()
    if options.cost:
        cost()
        set_up_cost()
        store_cost()
    else:
        campaign(options.count, options.seed, options.step)
