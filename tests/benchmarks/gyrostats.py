"""Errors of gyrostats' attitudes against Taylor series continued by the period of the momentum, up to 1e9 s.

    python -m tests.benchmarks.gyrostats [--bodies 30] [--seed 1] [--ladders | --cost]

Random bodies with rotors along a principal axis, in a principal plane, along any axis, and bodies by tensors;
or, with --ladders, motions ever nearer to equilibria, symmetry, the sphere, vanishing and huge rotors.  Where
the momentum does not return soon, the first two instants are compared.  --cost: time of samples.
"""

import argparse
import random
from collections import defaultdict
from time import process_time

import numpy as np
from scipy.spatial.transform import Rotation

from attitude.dynamics.exact_motion import ExactMotion
from attitude.oracle.truth import attitude_error
from attitude.rigid_body.body import RigidBody
from attitude.times.instants import Instants
from tests.oracles.gyrostat_motion import GyrostatMotion

KINDS = ("axis", "plane", "any", "tensor")
ATTITUDE = (1.0, 0.0, 0.0, 0.0)
SECONDS = (0.3, 7.0, 1e4, 1e9)
MOMENTS = ((1.25, 1.5, 2.0), (1.5, 2.0, 1.25), (2.0, 1.25, 1.5))


def random_motion(kind, draw):
    """(inertia, rate, rotors)."""
    moments = [draw.uniform(1.0, 2.0) for _ in range(3)]
    if draw.random() < 0.2:
        i = draw.randrange(3)
        moments[i] = moments[(i + 1) % 3]
    rate = [draw.gauss(0.0, 1.0) for _ in range(3)]
    if draw.random() < 0.3:
        rate[draw.randrange(3)] *= 5.0
    rotors = [draw.gauss(0.0, 1.0) * 10.0 ** draw.uniform(-2.0, 1.0) for _ in range(3)]
    if kind == "axis":
        size, rotors = rotors[0], [0.0, 0.0, 0.0]
        rotors[draw.randrange(3)] = size
    elif kind == "plane":
        rotors[draw.randrange(3)] = 0.0
    elif kind == "tensor":
        R = Rotation.random(random_state=draw.randrange(10**6)).as_matrix()
        tensor = R @ np.diag(moments) @ R.T
        return (0.5 * (tensor + tensor.T)).tolist(), rate, rotors
    return moments, rate, rotors


def ladders():
    """Yield (name, inertia, rate, rotors, decimal digits by which the motion is near something special)."""
    for moments in MOMENTS:
        a = [1.0 / moment for moment in moments]
        for h in (0.25, -0.25, -4.0):
            for n in (3, 8, 15):
                yield "spin about the rotor", moments, (10.0**-n, 2.0 * 10.0**-n, 1.0), (0.0, 0.0, h), n
        for n in (4, 9, 30):
            yield "vanishing rotor", moments, (0.3, -0.5, 0.4), (0.0, 0.0, 10.0**-n), 0
        for n in (3, 8):
            yield "huge rotor", moments, (0.3, -0.5, 0.4), (0.0, 0.0, 10.0**n), 0
        for axis in (0, 1):
            momentum = [0.0, 0.0, a[2] * 0.25 / (a[2] - a[axis])]
            momentum[axis] = 1.0
            rate = [x * y for x, y in zip(a, momentum, strict=True)]
            rate[2] -= a[2] * 0.25
            for n in (3, 7, 12):
                beside = list(rate)
                beside[1 - axis] += 10.0**-n
                yield "equilibrium in a plane", moments, beside, (0.0, 0.0, 0.25), n
            h = (a[2] - a[axis]) / a[2]
            for n in (2, 4, 7):
                rate = 10.0**-n, 10.0**-n, (1.0 - h) * a[2]
                yield "where equilibria branch off", moments, rate, (0.0, 0.0, h), n
    for n in (3, 7, 12):
        for rotors in ((0.0, 0.0, 0.3), (0.3, 0.0, 0.0), (0.3, 0.2, 0.0), (0.3, 0.1, 0.2)):
            d, rate = 10.0**-n, (0.3, -0.5, 0.4)
            yield "near symmetry", (1.5, 1.5 + d, 2.0), rate, rotors, 0
            yield "near the sphere", (1.5, 1.5 + d, 1.5 + 3.0 * d), rate, rotors, 0
    for n in (4, 9, 20):
        d, rate = 10.0**-n, (0.3, -0.5, 0.4)
        yield "near an axis", MOMENTS[0], rate, (d, 2.0 * d, 0.3), 0
        yield "near the middle axis", MOMENTS[0], rate, (d, 0.3, 2.0 * d), 0
        yield "near a plane", MOMENTS[0], rate, (d, 0.5, 0.3), 0
        yield "any vanishing rotor", MOMENTS[0], rate, (d, -2.0 * d, d), 0
    h = (0.3, -0.2, 0.25)
    for turning in (0.45, 0.55, 0.6, 0.72, -0.3):
        rate = [turning * x / (1.0 - turning * y) for x, y in zip(h, MOMENTS[0], strict=True)]
        for n in (3, 7, 12):
            yield "equilibrium of any rotor", MOMENTS[0], (rate[0] + 10.0**-n, *rate[1:]), h, n


def errors(inertia, rate, rotors, digits):
    """(form, error of the attitude in rad at each of SECONDS)."""
    body = RigidBody(np.array(inertia)) if np.ndim(inertia) == 2 else RigidBody.from_moments(inertia)
    batch = ExactMotion(np.array(rotors)).of(body, np.array(ATTITUDE), np.array(rate, float))
    truth = GyrostatMotion(inertia, rate, ATTITUDE, rotors, digits=40 + 3 * digits)
    faster = max(1.0, float(np.linalg.norm(rotors)))
    seconds = [t / faster for t in SECONDS]
    try:
        expected = [truth.at(t)[0] for t in seconds]
    except ArithmeticError:
        seconds = seconds[:2]
        expected = [q for q, _ in truth.motion.at(seconds)]
    q, _ = batch.sample(Instants(np.array(seconds), None, None), quaternion=True, rate=False)
    return batch.solution[0], [
        attitude_error(one.tolist(), true) for one, true in zip(q, expected, strict=True)
    ]


TIMED = {
    "free": ((1.0, 2.0, 2.5), (0.3, -0.5, 0.4), (0.0, 0.0, 0.0)),
    "free, beside the separatrix": ((1.0, 2.0, 2.5), (1e-4, 0.5, 1e-4), (0.0, 0.0, 0.0)),
    "circling": ((1.0, 2.0, 2.5), (0.25, 0.5, 0.175), (0.0, 0.0, 0.0625)),
    "swinging": ((1.0, 2.0, 2.5), (1.0, 0.125, -0.15), (0.0, 0.0, 0.5)),
    "circling, transformed": ((1.0, 2.5, 2.0), (0.5, 0.2, 0.46875), (0.0, 0.0, 0.0625)),
    "swinging, transformed": ((1.0, 2.0, 2.5), (0.25, 0.125, 0.075), (0.0, 0.0, 0.0625)),
    "any rotor": ((1.0, 2.0, 2.5), (0.3, -0.5, 0.4), (0.3, -0.2, 0.7)),
}


def print_cost(samples=200_000, rounds=40):
    """Print the processor's time for a sample, medians of interleaved rounds."""
    t = Instants(np.linspace(0.0, 1e4, samples), None, None)
    out = np.moveaxis(np.empty((4, samples)), 0, -1)
    batches = {
        name: ExactMotion(np.array(rotors)).of(
            RigidBody.from_moments(moments), np.array(ATTITUDE), np.array(rate)
        )
        for name, (moments, rate, rotors) in TIMED.items()
    }
    times = defaultdict(list)
    for _ in range(rounds):
        for name, batch in batches.items():
            begun = process_time()
            batch.sample(t, True, False, 1, out)
            times[name].append(process_time() - begun)
    for name, seconds in times.items():
        print(f"{name:30} {1e9 * np.median(seconds) / samples:5.2f} ns a sample")
    moments, rates = np.random.default_rng(1).uniform(1.0, 1.7, (2, 2000, 3))
    for name, rotors in (("rotor along an axis", (0.0, 0.0, 0.7)), ("any rotor", (0.3, -0.2, 0.7))):
        attitudes = np.tile(ATTITUDE, (2000, 1))
        begun = process_time()
        ExactMotion(np.array(rotors)).of(RigidBody.from_moments(moments), attitudes, rates)
        print(f"{name:30} {1e6 * (process_time() - begun) / 2000:5.1f} us for the constants of a body")


def main():
    """Print the greatest error of each kind or ladder."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--bodies", type=int, default=30)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--ladders", action="store_true")
    parser.add_argument("--cost", action="store_true")
    options = parser.parse_args()
    if options.cost:
        print_cost()
        return
    draw, greatest, count = random.Random(options.seed), defaultdict(float), defaultdict(int)
    motions = (
        ladders()
        if options.ladders
        else ((kind, *random_motion(kind, draw), 0) for kind in KINDS for _ in range(options.bodies))
    )
    for name, inertia, rate, rotors, digits in motions:
        form, error = errors(inertia, rate, rotors, digits)
        count[name] += 1
        if max(error) > 4e-15:
            print(f"{name} {inertia} {rate} {rotors}: {form}: {error}", flush=True)
        greatest[name] = max(greatest[name], *error)
    for name, error in greatest.items():
        print(f"{name:30} {count[name]:4} motions, at most {error:.1e} rad")


if __name__ == "__main__":
    main()
