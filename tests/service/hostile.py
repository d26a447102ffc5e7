"""Documents that would take minutes, by the kind of loop that they lengthen: the service must end them."""

from __future__ import annotations

import math
from typing import Any

BODY = {"moments": [1.0, 2.0, 2.5], "unit": "kg m2"}
THIN = {"moments": [1.0, 1.0, 1e-9], "unit": "kg m2"}  # a needle
ORBIT = {"altitude": {"value": 600, "unit": "km"}, "inclination": {"value": 98, "unit": "deg"}}
LOW_ORBIT = {"altitude": {"value": 200, "unit": "km"}}
EPOCH = {"time": "2026-03-20T12:00:00", "scale": "utc"}
PLATE = {
    "area": {"value": 2, "unit": "m2"},
    "normal": [0, 0.1, 1],
    "centre": {"value": [0.5, -0.2, 1], "unit": "m"},
}
TIGHT = {"tolerance": {"value": 1e-13, "unit": "rad"}}
FEW = {"start": 0, "stop": 1e9, "count": 3, "unit": "s"}
FREE: dict[str, Any] = {
    "body": BODY,
    "attitude": {"quaternion": [1, 0, 0, 0], "order": "wxyz"},
    "angular_velocity": {"value": [0.1, 1.0, 0.2], "unit": "rad/s"},
    "times": FEW,
}


def quantity(value: Any, unit: str) -> dict[str, Any]:
    return {"value": value, "unit": unit}


def free(**changes: Any) -> dict[str, Any]:
    return FREE | changes


def torques(*effects: dict[str, Any], **changes: Any) -> dict[str, Any]:
    return FREE | {"epoch": EPOCH, "orbit": ORBIT, "effects": list(effects)} | changes


def drop(
    shape: dict[str, Any], restitution: float = 0.9999, friction: float = 0.2, **changes: Any
) -> dict[str, Any]:
    """A body that bounces until the end of its instants."""
    ground = {"type": "ground", "normal": [0, 0, 1], "height": quantity(0, "m"), "shape": shape}
    gravity = {"type": "uniform_gravity", "acceleration": quantity([0, 0, -9.81], "m/s2")}
    falling = {
        "body": BODY | {"mass": quantity(1, "kg")},
        "position": quantity([0, 0, 2], "m"),
        "velocity": quantity([0, 0, -1], "m/s"),
        "effects": [gravity, ground | {"restitution": restitution, "friction": friction}],
    }
    return FREE | falling | changes


def rate(*components: float) -> dict[str, Any]:
    return quantity(list(components), "rad/s")


BOX = {"box": [1, 1, 1], "unit": "m"}
NEEDLE = {"box": [1e-3, 1e-3, 10], "unit": "m"}
PLATE_SHAPE = {"cylinder": {"radius": 1, "height": 1e-6, "axis": "z"}, "unit": "m"}
BALL = [
    [math.cos(k * 2.4) * math.sqrt(1 - z * z), math.sin(k * 2.4) * math.sqrt(1 - z * z), z]
    for k, z in ((k, -1 + (2 * k + 1) / 20_000) for k in range(20_000))
]
FIRINGS = [
    {"time": quantity(0.01 * k, "s"), "frame": "body", "angular_impulse": quantity([0, 1e-6, 2e-6], "N m s")}
    for k in range(18_000)
]
TABLE = {
    "times": quantity([60.0 * k for k in range(20_000)], "s"),
    "positions": {
        "value": [[7000 * math.cos(0.06 * k), 7000 * math.sin(0.06 * k), 0.0] for k in range(20_000)],
        "unit": "km",
    },
}

GRADIENT = {"type": "gravity_gradient"}
DIPOLE = {"type": "magnetic_dipole", "dipole": quantity([1, -2, 0.5], "A m2")}
SUNLIGHT = {"type": "solar_pressure", "plates": [PLATE], "sun": "astropy"}
DRAG = {"type": "drag", "plates": [PLATE], "density": quantity(1e-10, "kg/m3")}
DAMPING = {"type": "eddy_damping", "coefficient": 1e-6, "unit": "N m s"}
SINK = {"type": "dissipation", "coefficient": quantity(1e-4, "1/(N m s)")}
WHEELS = {"type": "wheels", "momentum": quantity([1, 2, 3], "N m s")}
CONSTANT = {"type": "constant_torque", "torque": quantity([1, 2, 3], "mN m"), "frame": "inertial"}
PLAN_OF_FIRINGS = {"type": "impulse", "firings": FIRINGS}
INTERVALS = [
    CONSTANT | {"start": quantity(100.0 * k, "s"), "stop": quantity(100.0 * k + 50, "s")} for k in range(100)
]

EPHEMERIS, PLAN, MOTION, COST = "/v1/ephemeris", "/v1/plan", "/v1/motion", "/v1/cost"
MANY = {"start": 0, "stop": 1e6, "count": 1_000_000, "unit": "s"}
LONG = {"start": 0, "stop": 1e8, "count": 2, "unit": "s"}
UNIT_RATE = rate(1e-15, 1, 1e-15)

# name: route and document
HOSTILE: dict[str, tuple[str, Any]] = {
    # contacts
    "box that hardly loses energy": (EPHEMERIS, drop(BOX)),
    "box that loses none": (EPHEMERIS, drop(BOX, 1.0, 0.0)),
    "needle that bounces": (
        EPHEMERIS,
        drop(NEEDLE, body=THIN | {"mass": quantity(1, "kg")}, angular_velocity=rate(1, 1, 1)),
    ),
    "thin disc that bounces": (EPHEMERIS, drop(PLATE_SHAPE)),
    "cylinder that rolls": (
        EPHEMERIS,
        drop({"cylinder": {"radius": 1, "height": 1, "axis": "x"}, "unit": "m"}, 0.0, 1.0),
    ),
    "sphere of 20,000 vertices": (EPHEMERIS, drop({"vertices": BALL, "unit": "m"})),
    "box that spins fast beside the ground": (EPHEMERIS, drop(BOX, angular_velocity=rate(1e6, 1e6, 1e5))),
    "box that spins fast without gravity": (
        EPHEMERIS,
        drop(BOX, angular_velocity=rate(1e3, 1e2, 1e3), velocity=quantity([0, 0, 1e-9], "m/s"))
        | {"effects": drop(BOX)["effects"][1:], "position": quantity([0, 0, 0.8661], "m")},
    ),
    "a million instants of bounces": (EPHEMERIS, drop(BOX, times=MANY)),
    "plan of bounces": (PLAN, drop(BOX)),
    # impulses
    "18,000 firings": (EPHEMERIS, free(effects=[PLAN_OF_FIRINGS])),
    "18,000 firings under torques": (EPHEMERIS, torques(PLAN_OF_FIRINGS, GRADIENT)),
    "plan of 18,000 firings under torques": (PLAN, torques(PLAN_OF_FIRINGS, GRADIENT)),
    "18,000 firings of a body that bounces": (
        EPHEMERIS,
        drop(BOX) | {"effects": [*drop(BOX)["effects"], PLAN_OF_FIRINGS]},
    ),
    # torques
    "gravity gradient over 30 years": (EPHEMERIS, torques(GRADIENT)),
    "gravity gradient, tight": (EPHEMERIS, torques(GRADIENT, **TIGHT)),
    "gravity gradient, plan": (PLAN, torques(GRADIENT, **TIGHT)),
    "gravity gradient of a needle": (EPHEMERIS, torques(GRADIENT, body=THIN)),
    "magnetic dipole": (EPHEMERIS, torques(DIPOLE, **TIGHT)),
    "sunlight and shadows": (EPHEMERIS, torques(SUNLIGHT)),
    "sunlight and shadows, plan": (PLAN, torques(SUNLIGHT, times=LONG)),
    "drag": (EPHEMERIS, torques(DRAG, orbit=LOW_ORBIT)),
    "eddy damping": (EPHEMERIS, torques(DAMPING, angular_velocity=rate(1e4, 1e4, 1e3))),
    "sink of energy": (EPHEMERIS, torques(SINK, **TIGHT)),
    "rotors": (EPHEMERIS, torques(WHEELS)),
    "constant torque from rest": (EPHEMERIS, torques(CONSTANT, angular_velocity=rate(0, 0, 0))),
    "torques that come and go": (EPHEMERIS, torques(*INTERVALS, times=LONG)),
    "plan of torques that come and go": (PLAN, torques(*INTERVALS, times=LONG, **TIGHT)),
    "all torques at once": (
        EPHEMERIS,
        torques(GRADIENT, DIPOLE, SUNLIGHT, DRAG, DAMPING, SINK, WHEELS, **TIGHT),
    ),
    "plan of all torques at once": (
        PLAN,
        torques(GRADIENT, DIPOLE, SUNLIGHT, DRAG, DAMPING, SINK, WHEELS, **TIGHT),
    ),
    "torque at a huge rate": (EPHEMERIS, torques(GRADIENT, angular_velocity=rate(1e12, 1e11, 1e12))),
    "torque beside the separatrix": (EPHEMERIS, torques(GRADIENT, angular_velocity=UNIT_RATE)),
    "a million instants under a torque": (EPHEMERIS, torques(GRADIENT, times=MANY)),
    "a million instants in one step": (
        EPHEMERIS,
        torques(DAMPING, times=MANY | {"stop": 1e-3}, angular_velocity=rate(1e-9, 0, 0)),
    ),
    "4,000 plates": (EPHEMERIS, torques(SUNLIGHT | {"plates": [PLATE] * 4000})),
    "plan of 20,000 plates": (PLAN, torques(DRAG | {"plates": [PLATE] * 20_000}, times=LONG)),
    "table of 20,000 positions": (EPHEMERIS, torques(GRADIENT, orbit=TABLE, times=FEW | {"stop": 1.19e6})),
    "dop853 at the least tolerance": (EPHEMERIS, torques(GRADIENT, solver="dop853", **TIGHT)),
    "splitting over 30 years": (EPHEMERIS, torques(GRADIENT, solver="splitting")),
    # formats
    "CZML of a million": (EPHEMERIS + "?format=czml", free(times=MANY, epoch=EPOCH)),
    "AEM whose nodes keep 1e-13 rad": (
        EPHEMERIS + "?format=aem&interpolation_error=1e-13",
        free(times=MANY, epoch=EPOCH),
    ),
    "STK of a bouncing box with nodes": (
        EPHEMERIS + "?format=stk&interpolation_error=1e-12",
        drop(BOX, 0.5, times=FEW | {"stop": 5}, epoch=EPOCH),
    ),
    # cost
    "cost beside the separatrix": (COST, free(angular_velocity=UNIT_RATE)),
    "cost on the separatrix": (
        COST,
        free(body={"moments": [1, 2, 3], "unit": "kg m2"}, angular_velocity=rate(1, 0, 1)),
    ),
    "cost of a thin body": (COST, free(body=THIN)),
    "cost of a plain body": (COST, free()),
    "cost under torques": (COST, torques(GRADIENT, DIPOLE)),
    "cost under drag": (COST, torques(DRAG, orbit=LOW_ORBIT)),
    "cost of 100,000 samples": (COST + "?samples=100000", free()),
    # lists
    "list of 1000 scenes under torques": (EPHEMERIS, [torques(GRADIENT)] * 1000),
    "list of 1000 scenes that bounce": (EPHEMERIS, [drop(BOX)] * 1000),
    "list of 1000 wrong scenes": (EPHEMERIS, [{"effects": [{}] * 100}] * 1000),
    # documents
    "a million effects": (EPHEMERIS, free(effects=[{}] * 1_000_000)),
    "a million empty times": (EPHEMERIS, free(times={"elapsed": [""] * 1_000_000, "unit": "s"})),
    "a million dates": (
        EPHEMERIS,
        free(epoch=EPOCH, times={"dates": ["2026-03-20"] * 250_000, "scale": "utc"}),
    ),
    "200,000 unknown keys": (EPHEMERIS, free(**{f"key{k}": 0 for k in range(200_000)})),
    "deep lists": (EPHEMERIS, free(effects=[[[[[[]]]]]] * 99)),
    "motion beside the separatrix": (MOTION, free(angular_velocity=UNIT_RATE)),
}
