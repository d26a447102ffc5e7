"""A scene to put effects in, one document of each effect, and their torques written out once more."""

import copy

import numpy as np

from attitude import Scene
from attitude.kernels.layout import EffectCode
from tests.tables import replaced

DOCUMENT = {
    "body": {"moments": [2.0, 3.0, 4.0], "unit": "kg m2"},
    "epoch": {"time": "2026-03-20T12:00:00", "scale": "utc"},
    "frame": "GCRF",
    "attitude": {"quaternion": [0.5, 0.1, -0.7, 0.5], "order": "wxyz"},
    "angular_velocity": {"value": [0.03, -0.02, 0.01], "unit": "rad/s"},
    "times": {"start": 0, "stop": 6000, "count": 11, "unit": "s"},
}


def quantity(value, unit):
    return {"value": value, "unit": unit}


KEPLER = {
    "semi_major_axis": quantity(7000, "km"),
    "eccentricity": 0.01,
    "inclination": quantity(60, "deg"),
    "raan": quantity(30, "deg"),
    "argument_of_pericentre": quantity(100, "deg"),
    "true_anomaly": quantity(-20, "deg"),
}
PLATE = {"area": quantity(2, "m2"), "normal": [0, 0, 2], "centre": quantity([0.5, -0.2, 1], "m")}
OTHER_PLATE = {"area": quantity(1.5, "m2"), "normal": [1, 1, 0], "centre": quantity([0.1, 0.9, -0.4], "m")}
SHAPE = {"box": [1, 1, 1], "unit": "m"}
FALLING = {
    "position": quantity([0, 0, 2], "m"),
    "velocity": quantity([0, 0, -1], "m/s"),
    "body": {**DOCUMENT["body"], "mass": quantity(3, "kg")},
}
EFFECTS = {
    "uniform_gravity": {"acceleration": quantity([0, 0, -9.81], "m/s2")},
    "ground": {
        "normal": [0, 0, 1],
        "height": quantity(0, "m"),
        "shape": SHAPE,
        "restitution": 0.5,
        "friction": 0.2,
    },
    "impulse": {
        "time": quantity(10, "s"),
        "angular_impulse": quantity([0, 0.1, 0.2], "N m s"),
        "frame": "body",
    },
    "constant_torque": {"torque": quantity([1, 2, 3], "mN m"), "frame": "body"},
    "gravity_gradient": {},
    "dissipation": {"coefficient": quantity(0.5, "1/(N m s)")},
    "eddy_damping": {"coefficient": 0.01, "unit": "N m s"},
    "magnetic_dipole": {"dipole": quantity([1, -2, 0.5], "A m2")},
    "solar_pressure": {
        "plates": [{**PLATE, "specular": 0.2, "diffuse": 0.3}, OTHER_PLATE],
        "sun": {"direction": [1, 0, 0.2]},
    },
    "drag": {"plates": [PLATE, {**OTHER_PLATE, "coefficient": 2.2}], "density": quantity(1e-12, "kg/m3")},
    "wheels": {"momentum": quantity([1, 2, 3], "N m s")},
}
ON_ORBIT = ("gravity_gradient", "magnetic_dipole", "solar_pressure", "drag")
TORQUES = [name for name in EFFECTS if name not in ("uniform_gravity", "ground", "impulse")]


def effect(name, **changes):
    """An effect's document, members replaced, or taken away where they are GONE."""
    return replaced({"type": name, **copy.deepcopy(EFFECTS[name])}, changes)


def document(*effects, **changes):
    """A scene's document with these effects, and what they need of an orbit or a fall."""
    names = [part["type"] for part in effects if isinstance(part, dict)]
    needed = {"orbit": KEPLER} if set(names) & set(ON_ORBIT) else {}
    needed |= FALLING if "ground" in names else {}
    return replaced(copy.deepcopy(DOCUMENT | needed) | {"effects": list(effects)}, changes)


def scene(*effects, **changes):
    return Scene.model_validate(document(*effects, **changes))


def built(name, changes=None, **parts):
    """(the effect, its initial state) of a scene with it alone."""
    made = scene(effect(name, **(changes or {})), **parts)
    return made.effects[0], made.initial_state()


def torque(row, moments, R, rate, r, v, t, to_sun=None):
    """N m, along the principal axes: what `kernels.layout` says a row means.

    R (3, 3) inertial to principal; rate (3,) principal; r, v (3,) inertial; to_sun (3,) m.
    """
    code, n = int(row[0]), row[1:]
    if code == EffectCode.CONSTANT_BODY:
        return n[:3]
    if code == EffectCode.CONSTANT_INERTIAL:
        return R @ n[:3]
    if code == EffectCode.EDDY:
        return -n[:9].reshape(3, 3) @ rate
    if code == EffectCode.WHEELS:
        return np.cross(n[:3], rate)
    if code == EffectCode.DISSIPATION:
        m = moments * rate
        return n[0] * np.cross(m, np.cross(m, rate))
    down, distance = R @ r / np.linalg.norm(r), np.linalg.norm(r)
    if code == EffectCode.GRAVITY_GRADIENT:
        return 3.0 * n[0] / distance**3 * np.cross(down, moments * down)
    if code == EffectCode.MAGNETIC:
        phase = 2.0 * np.pi * t * (n[13] + n[14])
        d = n[4:7] + np.cos(phase) * n[7:10] + np.sin(phase) * n[10:13]
        B = n[3] / distance**3 * (3.0 * (d @ r) * r / distance**2 - d)
        return np.cross(n[:3], R @ B)
    normal, centre = n[:3], n[3:6]
    if code == EffectCode.SOLAR_PLATE:
        area, specular, diffuse, pressure = n[6:10]
        s = R @ to_sun / np.linalg.norm(to_sun)
        c = max(0.0, normal @ s)
        pressure = pressure * (AU / np.linalg.norm(to_sun)) ** 2
        push = (1.0 - specular) * s + 2.0 * (specular * c + diffuse / 3.0) * normal
        return np.cross(centre, -pressure * area * c * push)
    assert code == EffectCode.DRAG_PLATE
    area, density, radius, height = n[6:10]
    flow = v - np.cross(n[10:13], r)
    speed = np.linalg.norm(flow)
    along = R @ flow / speed
    density = density * np.exp(-(distance - radius) / height)
    return np.cross(centre, -0.5 * density * speed**2 * area * max(0.0, normal @ along) * along)


AU = 149597870700.0
