"""Random scenes of bodies at rest at the epoch, and of the same bodies turning at next to nothing there."""

import numpy as np

from attitude import Scene
from tests.dynamics import scenes
from tests.dynamics.scenes import plate, quantity

NEXT_TO_REST = 1e-12  # rad/s
SPAN = 60.0  # s
BROKEN = {"solar_pressure", "drag"}  # torques with kinks, which few tolerances are in reach of


def direction(rng, size):
    vector = rng.normal(size=3)
    return (size * vector / np.linalg.norm(vector)).tolist()


def constant(rng):
    torque = {
        "type": "constant_torque",
        "torque": quantity(direction(rng, between(rng, 1e-3, 0.1)), "N m"),
    }
    return torque | {"frame": rng.choice(["body", "inertial"]).item()}


def started(rng):
    """A torque that begins in the middle of the span."""
    return constant(rng) | {"start": quantity(rng.uniform(0.3, 0.7) * SPAN, "s")}


def impulse(rng, at=None):
    at = rng.uniform(-0.2, 0.9) * SPAN if at is None else at
    fired = {
        "time": quantity(at, "s"),
        "angular_impulse": quantity(direction(rng, between(rng, 0.1, 10)), "N m s"),
    }
    return fired | {"type": "impulse", "frame": rng.choice(["body", "inertial"]).item()}


def impulses(rng):
    firings = [impulse(rng) for _ in range(3)]
    for firing in firings:
        del firing["type"]
    return {"type": "impulse", "firings": firings}


def plates(rng):
    return [plate(rng.uniform(0.5, 2), direction(rng, 1.0), direction(rng, 0.3)) for _ in range(2)]


def between(rng, low, high):
    """Random numbers whose logarithms are spread evenly."""
    return 10.0 ** rng.uniform(np.log10(low), np.log10(high))


def lit(rng):
    sun = {"direction": direction(rng, 1.0)}
    return {"type": "solar_pressure", "plates": plates(rng), "sun": sun, "shadow": bool(rng.random() < 0.5)}


def made(name, **numbers):
    return {"type": name, **numbers}


EFFECTS = {
    "eddy_damping": lambda rng: made("eddy_damping", coefficient=between(rng, 0.01, 1), unit="N m s"),
    "dissipation": lambda rng: made(
        "dissipation", coefficient=quantity(between(rng, 1e-3, 0.1), "1/(N m s)")
    ),
    "wheels": lambda rng: made("wheels", momentum=quantity(direction(rng, between(rng, 0.1, 10)), "N m s")),
    "constant_torque": constant,
    "started": started,
    "impulse": impulse,
    "impulses": impulses,
    "gravity_gradient": lambda rng: made("gravity_gradient"),
    "magnetic_dipole": lambda rng: made("magnetic_dipole", dipole=quantity(direction(rng, 3.0), "A m2")),
    "solar_pressure": lit,
    "drag": lambda rng: made("drag", plates=plates(rng), density=quantity(1e-12, "kg/m3")),
}


def moments(rng):
    """Triaxial, symmetric or spherical, in any order, 3 to 30 kg m2."""
    found = np.sort(rng.uniform(1.0, 2.0, 3))
    kind = rng.integers(4)
    if kind == 1:
        found[1] = found[rng.choice([0, 2])]
    if kind == 2:
        found[:] = found[0]
    return (rng.permutation(found) * rng.uniform(3.0, 15.0)).tolist()


def random_scene(rng, names):
    """The document of a body at rest under the effects of these names."""
    q, inertia = rng.normal(size=4), moments(rng)
    document = scenes.document(
        *(EFFECTS[name](rng) for name in names),
        moments=inertia,
        elapsed=np.linspace(-0.2 * SPAN, SPAN, 7),
        tolerance=1e-10 if BROKEN.isdisjoint(names) else 1e-5,
        q=(q / np.linalg.norm(q)).tolist(),
    )
    angles = {name: quantity(rng.uniform(0, 90), "deg") for name in ("inclination", "raan", "mean_anomaly")}
    return document | {"orbit": {"semi_major_axis": quantity(7e6, "m"), **angles}}


def differences(document):
    """(difference of rates, rad/s, of attitudes, rad, each over what it may be).

    May be: the error bounds of both, and what the other's first rate turns in the span, ten times over for a
    motion that makes differences grow; of rates 1e-10 rad/s and what these bounds are of the greatest.
    """
    turning = quantity([NEXT_TO_REST, 0.0, 0.0], "rad/s")
    runs = [Scene.model_validate(one).run() for one in (document, document | {"angular_velocity": turning})]
    bounds = sum(run.plan.error_bound for run in runs)
    rates, others = (run.angular_velocity for run in runs)
    apart = (runs[0].rotation * runs[1].rotation.inv()).magnitude().max()
    most = 1e-10 + bounds * np.abs(rates).max()
    return np.abs(rates - others).max() / most, apart / (bounds + 10.0 * NEXT_TO_REST * SPAN)
