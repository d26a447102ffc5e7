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

AGES = {"scene": "toutatis", "times": {"start": 0, "stop": 4e6, "count": 100_000, "unit": "d"}}


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


def oem(segments: int, rows: int, method: str = "") -> str:
    """A circle in the plane of the equator, a row a second; segments end where the next one begins."""
    head = "CCSDS_OEM_VERS = 2.0\nCREATION_DATE = 2026-01-01T00:00:00\nORIGINATOR = X\n"
    meta = (
        "META_START\nOBJECT_NAME = X\nOBJECT_ID = X\nCENTER_NAME = EARTH\nREF_FRAME = ICRF\n"
        "TIME_SYSTEM = UTC\nSTART_TIME = 2026-03-20T12:00:00\nSTOP_TIME = 2026-03-21T00:00:00\n"
        + method
        + "META_STOP\n"
    )
    lines = [
        f"2026-03-20T{12 + k // 3600}:{k // 60 % 60:02}:{k % 60:02} "
        f"{7e3 * math.cos(1e-3 * k):.6f} {7e3 * math.sin(1e-3 * k):.6f} 0 0 0 0\n"
        for k in range(segments * (rows - 1) + 1)
    ]
    firsts = range(0, len(lines) - 1, rows - 1)
    return head + "".join(meta + "".join(lines[first : first + rows]) for first in firsts)


DEGREE = "INTERPOLATION = LAGRANGE\nINTERPOLATION_DEGREE = 20000\n"
ORBIT_SPAN = {"start": 0, "stop": 7000, "count": 10, "unit": "s"}

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
WINDOWS, FIT = "/v1/windows", "/v1/fit"
MANY = {"start": 0, "stop": 1e6, "count": 1_000_000, "unit": "s"}
LONG = {"start": 0, "stop": 1e8, "count": 2, "unit": "s"}
UNIT_RATE = rate(1e-15, 1, 1e-15)

NEAR_THE_SUN = {"axis": "z", "to": "sun", "below": quantity(30, "deg")}
NEAR_MOMENTUM = NEAR_THE_SUN | {"to": "momentum"}
STILL = {"q_w": 1.0, "q_x": 0.0, "q_y": 0.0, "q_z": 0.0}
SEEN = {
    "elapsed [s]": [float(k) for k in range(20_000)],
    "q_w": [math.cos(0.05 * k) for k in range(20_000)],
    "q_x": 0.0,
    "q_y": 0.0,
    "q_z": [math.sin(0.05 * k) for k in range(20_000)],
}
DIRECTIONS = {
    "elapsed [s]": SEEN["elapsed [s]"],
    "body_x": 1.0,
    "body_y": 0.0,
    "body_z": 0.0,
    "inertial_x": SEEN["q_w"],
    "inertial_y": SEEN["q_z"],
    "inertial_z": 0.0,
}
UNCERTAIN = {"attitude": quantity([1, 1, 1], "deg"), "angular_velocity": quantity([0.01] * 3, "deg/s")}


def nested(condition: dict[str, Any], levels: int) -> dict[str, Any]:
    for _ in range(levels):
        condition = {"not": condition}
    return condition


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
    # orbits in files
    "orbit of 8,000 segments": (
        EPHEMERIS,
        torques(GRADIENT, orbit={"oem": oem(8_000, 2)}, times=ORBIT_SPAN),
    ),
    "orbit of 40,000 rows": (EPHEMERIS, torques(GRADIENT, orbit={"oem": oem(1, 40_000)}, times=ORBIT_SPAN)),
    "orbit by polynomials of degree 20,000": (
        EPHEMERIS,
        torques(GRADIENT, orbit={"oem": oem(1, 40_000, DEGREE)}, times=ORBIT_SPAN),
    ),
    "message of 300,000 attributes": (
        EPHEMERIS,
        {"apm": "<apm " + " ".join(f'b{k}=""' for k in range(300_000)) + "/>", "times": FEW},
    ),
    # windows
    "windows over 30 years": (WINDOWS, {"scene": torques(), "condition": NEAR_THE_SUN}),
    "windows over 30 years in shadow": (WINDOWS, {"scene": torques(), "condition": {"shadow": "umbra"}}),
    "windows of a body that loses energy": (WINDOWS, {"scene": "explorer-1", "condition": NEAR_MOMENTUM}),
    "windows over 11,000 years": (WINDOWS, {"scene": AGES, "condition": NEAR_THE_SUN}),
    "windows of no width": (
        WINDOWS + "?width=1e-300",
        {"scene": torques(times=FEW | {"stop": 1e5}), "condition": NEAR_THE_SUN},
    ),
    "windows of 99 conditions": (
        WINDOWS,
        {"scene": torques(), "condition": {"or": [NEAR_THE_SUN | {"axis": [k, 1, 1]} for k in range(99)]}},
    ),
    "windows of 400 levels": (WINDOWS, {"scene": torques(), "condition": nested(NEAR_THE_SUN, 400)}),
    # fits
    "fit of 20,000 attitudes": (FIT, {"body": BODY, "observations": [{"columns": SEEN}]}),
    "fit of 10,000 sets": (
        FIT,
        {"body": BODY, "observations": [{"columns": SEEN | {"elapsed [s]": [0.0]} | STILL}] * 10_000},
    ),
    "fit of 20,000 directions": (FIT, {"observations": [{"columns": DIRECTIONS}]}),
    "fit of 100,000 columns": (
        FIT,
        {"body": BODY, "observations": [{"columns": {f"c{k}": [0.0] for k in range(100_000)}}]},
    ),
    # uncertainty, columns
    "covariances of a million instants": (EPHEMERIS, free(times=MANY, uncertainty=UNCERTAIN)),
    "covariances under torques": (EPHEMERIS, torques(GRADIENT, uncertainty=UNCERTAIN)),
    "a million angles to the Sun": (
        EPHEMERIS + "?format=csv&columns=" + ",".join(f"angle:{axis}:sun" for axis in ("x", "y", "z")),
        torques(times=MANY),
    ),
    "the Sun over 11,000 years": (EPHEMERIS + "?format=csv&columns=direction_to:sun", AGES),
    "axes of the Earth over 900 years": (
        EPHEMERIS + "?frame=ITRF&ut1=utc",
        free(epoch=EPOCH, times=MANY | {"stop": 3e5, "unit": "d"}),
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
    "unit of 200,000 factors": (EPHEMERIS, free(body=BODY | {"unit": " ".join(["kg"] * 200_000)})),
    "deep lists": (EPHEMERIS, free(effects=[[[[[[]]]]]] * 99)),
    "motion beside the separatrix": (MOTION, free(angular_velocity=UNIT_RATE)),
}
