"""Partial derivatives under torques, impulses and rotors: against differences of SciPy's DOP853."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from attitude import Scene

TOLERANCE = 1e-6  # of the largest entry
MOMENTS, RATE = np.array([1.0, 1.6, 2.1]), np.array([0.05, -0.09, 0.3])
ATTITUDE = (0.1, -0.7, 0.5, 0.5)
STOP = 40.0


def scene(**members):
    return Scene.model_validate(
        {
            "body": {"moments": MOMENTS.tolist(), "unit": "kg m2"},
            "attitude": {"quaternion": ATTITUDE, "order": "wxyz"},
            "angular_velocity": {"value": RATE.tolist(), "unit": "rad/s"},
            "times": {"elapsed": [0.0, 0.5 * STOP, STOP], "unit": "s"},
            **members,
        }
    )


def vector(value, unit):
    return {"value": value, "unit": unit}


CONSTANT = {"type": "constant_torque", "torque": vector([0.01, 0.004, -0.003], "N m"), "frame": "body"}
INERTIAL = {"type": "constant_torque", "torque": vector([0.002, -0.006, 0.004], "N m"), "frame": "inertial"}

IMPULSE = {
    "type": "impulse",
    "time": {"value": 0.25 * STOP, "unit": "s"},
    "angular_impulse": vector([0.02, 0.0, 0.01], "N m s"),
    "frame": "body",
}
ROTORS = {"type": "wheels", "momentum": vector([0.1, 0.0, -0.2], "N m s")}


MU, RADIUS, DENSITY, DIPOLE = 3.986004418e14, 7e6, 5e-10, 8e15  # m3/s2, m, kg/m3, T m3
ORBIT = {
    "semi_major_axis": vector(RADIUS, "m"),
    "eccentricity": 0.0,
    "inclination": vector(90, "deg"),
    "mu": vector(MU, "m3/s2"),
}
GRADIENT = {"type": "gravity_gradient"}
EDDIES = {"type": "eddy_damping", "coefficient": 0.02, "unit": "N m s"}
SINK = {"type": "dissipation", "coefficient": vector(0.5, "1/(N m s)")}
PLATES = [([0.0, 0.0, 1.0], [0.5, -0.2, 0.4], 2.0), ([0.6, 0.8, 0.0], [0.1, 0.9, -0.4], 1.5)]
DRAG = {
    "type": "drag",
    "plates": [
        {"normal": n, "centre": vector(c, "m"), "area": vector(area, "m2"), "coefficient": 2.2}
        for n, c, area in PLATES
    ],
    "density": vector(DENSITY, "kg/m3"),
    "corotating": False,
}


def torques(kinds, t, q, w, tensors):
    """(n, 3), body axes."""
    R = Rotation.from_quat(q, scalar_first=True)
    total = np.zeros_like(w)
    angle = np.sqrt(MU / RADIUS**3) * t
    down = R.inv().apply([np.cos(angle), 0.0, np.sin(angle)])
    if "gradient" in kinds:
        total += 3.0 * MU / RADIUS**3 * np.cross(down, np.einsum("nij,nj->ni", tensors, down))
    if "eddies" in kinds:
        total -= 0.02 * w
    if "drag" in kinds:
        along = R.inv().apply([-np.sin(angle), 0.0, np.cos(angle)])
        for normal, centre, area in PLATES:
            force = -0.5 * DENSITY * MU / RADIUS * 2.2 * area * np.maximum(along @ normal, 0.0)
            total += np.cross(centre, force[:, None] * along)
    if "constant" in kinds:
        total += CONSTANT["torque"]["value"]
    if "inertial" in kinds:
        total += R.inv().apply(INERTIAL["torque"]["value"])
    return total


def moved(columns, steps, inertia, attitude=ATTITUDE, rate=RATE):
    """Tensors (n, 3, 3), attitudes and rates of bodies whose inputs are changed, two for each column."""
    change = np.concatenate([np.diag(steps), -np.diag(steps)])[:, columns]
    S = Rotation.from_rotvec(change[:, 9:] if inertia == "moments" else np.zeros((len(change), 3)))
    if inertia == "moments":
        S = S.as_matrix()
        tensors = S * (MOMENTS + change[:, None, 6:9]) @ np.swapaxes(S, 1, 2)
    else:
        elements = [[0, 3, 4], [3, 1, 5], [4, 5, 2]]
        tensors = np.diag(MOMENTS) + change[:, 6:][:, elements]
    q = Rotation.from_quat(attitude, scalar_first=True) * Rotation.from_rotvec(change[:, :3])
    return tensors, q.as_quat(scalar_first=True), rate + change[:, 3:6]


def rates(kinds, tensors, m):
    """Rates I^-1 (m - h), of the body without its sink, and Omega, of the body (docs/torques.md, T1)."""
    h = np.array(ROTORS["momentum"]["value"]) if "rotors" in kinds else np.zeros(3)
    w = np.linalg.solve(tensors, (m - h)[..., None])[..., 0]
    return w, w + (SINK["coefficient"]["value"] * np.cross(m, w) if "sink" in kinds else 0.0)


def momentum_of(kinds, tensors, rate):
    """The momentum, along body axes, of bodies that turn at a rate: by Newton's method on `rates`."""
    h = np.array(ROTORS["momentum"]["value"]) if "rotors" in kinds else np.zeros(3)
    m = np.einsum("nij,nj->ni", tensors, rate) + h
    for _ in range(6):
        slopes = [
            (rates(kinds, tensors, m + d)[1] - rates(kinds, tensors, m - d)[1]) / 2e-3
            for d in 1e-3 * np.eye(3)
        ]
        off = rates(kinds, tensors, m)[1] - rate
        m = m - np.linalg.solve(np.stack(slopes, axis=-1), off[..., None])[..., 0]
    return m


def flight(tensors, q, w, kinds, seconds, impulse=None):
    """Attitudes and rates at the seconds by DOP853, all bodies at once; an impulse in body axes."""
    n = len(w)

    def slope(t, state):
        q, m = state[: 4 * n].reshape(n, 4), state[4 * n :].reshape(n, 3)
        own, rate = rates(kinds, tensors, m)
        dm = np.cross(m, rate) + torques(kinds, t, q, own, tensors)
        s, v = q[:, :1], q[:, 1:]
        dq = 0.5 * np.concatenate(
            [-(v * rate).sum(axis=1, keepdims=True), s * rate + np.cross(v, rate)], axis=1
        )
        return np.concatenate([dq.ravel(), dm.ravel()])

    out, state, at = [], np.concatenate([q.ravel(), momentum_of(kinds, tensors, w).ravel()]), 0.0
    for t in seconds:
        if impulse is not None and at <= 0.25 * STOP < t:
            state = solve_ivp(slope, (at, 0.25 * STOP), state, "DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
            at = 0.25 * STOP
            state[4 * n :] += np.tile(impulse, n)
        if t > at:
            state = solve_ivp(slope, (at, t), state, "DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
        at = t
        m = state[4 * n :].reshape(n, 3)
        out.append((state[: 4 * n].reshape(n, 4).copy(), rates(kinds, tensors, m)[1]))
    return out


def differences(kinds, inertia, impulse=None, h=1e-4):
    """(m, 6, 12) by central differences extrapolated from two steps."""
    estimates = []
    for size in (h, 2.0 * h):
        steps = np.full(12, size)
        steps[3:6] *= 0.1
        bodies = moved(np.arange(12), steps, inertia)
        rows = []
        for q, w in flight(*bodies, kinds, (0.0, 0.5 * STOP, STOP), impulse):
            R = Rotation.from_quat(q, scalar_first=True)
            theta = (R[12:].inv() * R[:12]).as_rotvec()
            rows.append(np.concatenate([theta, w[:12] - w[12:]], axis=1).T / (2.0 * steps))
        estimates.append(np.array(rows))
    return (4.0 * estimates[0] - estimates[1]) / 3.0


CASES = {
    "rotors": ([ROTORS], {"rotors"}, None),
    "constant torque": ([CONSTANT], {"constant"}, None),
    "inertial torque": ([CONSTANT, INERTIAL], {"constant", "inertial"}, None),
    "gravity gradient": ([GRADIENT], {"gradient"}, None),
    "eddies": ([EDDIES], {"eddies"}, None),
    "dissipation": ([SINK], {"sink"}, None),
    "drag": ([DRAG], {"drag"}, None),
    "all at once": (
        [GRADIENT, EDDIES, SINK, CONSTANT, ROTORS],
        {"gradient", "eddies", "sink", "constant", "rotors"},
        None,
    ),
    "impulse": (
        [IMPULSE],
        set(),
        np.array([0.02, 0.0, 0.01]),
    ),
}


@pytest.mark.parametrize("inertia", ["moments", "tensor"])
@pytest.mark.parametrize(("effects", "kinds", "impulse"), CASES.values(), ids=list(CASES))
def test_partials_under_effects_are_differences_of_another_integrator(effects, kinds, impulse, inertia):
    orbit = {"orbit": ORBIT} if GRADIENT in effects or DRAG in effects else {}
    computed = scene(effects=effects, **orbit).run().partials(inertia).matrix
    expected = differences(kinds, inertia, impulse)
    size = np.abs(expected).max(axis=(-1, -2))
    assert (np.abs(computed - expected).max(axis=(-1, -2)) <= TOLERANCE * size).all()


def test_partials_after_an_impulse_that_starts_an_unstable_spin_are_those_of_the_free_motion_from_then_on():
    """Nearly at rest before it; changes far from linear, of either sign, lead to one attitude at the end."""
    kick = {"type": "impulse", "time": {"value": 1e-9, "unit": "s"}, "frame": "body"}
    kick["angular_impulse"] = vector([0.0, 10.0, 0.0], "N m s")
    body = {"body": {"moments": [10.0, 14.0, 17.0], "unit": "kg m2"}}
    rate = {"angular_velocity": vector([1e-6, 0.0, 1e-6], "rad/s")}
    seconds = {"times": {"elapsed": [20.0, 80.0], "unit": "s"}}
    computed = scene(**body, **rate, **seconds, effects=[kick]).run().partials().by_rate
    rate["angular_velocity"]["value"][1] = 10.0 / 14.0
    expected = scene(**body, **rate, **seconds, effects=[]).run().partials().by_rate
    assert np.abs(computed - expected).max() <= 1e-6 * np.abs(expected).max()


def test_of_a_torque_too_weak_to_matter_differences_give_the_closed_form():
    weak = {"type": "constant_torque", "torque": vector([1e-15, 0.0, 0.0], "N m"), "frame": "body"}
    forced, free = scene(effects=[weak]).run().partials().matrix, scene().run().partials().matrix
    assert np.abs(forced - free).max() <= 1e-8 * np.abs(free).max()


GRAVITY, HEIGHT, SPEED, MASS, RESTITUTION = 9.81, 2.0, -1.0, 3.0, 0.5
CORNERS = 0.5 * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
FALL = {
    "body": {"moments": MOMENTS.tolist(), "unit": "kg m2", "mass": vector(MASS, "kg")},
    "position": vector([0.0, 0.0, HEIGHT], "m"),
    "velocity": vector([0.0, 0.0, SPEED], "m/s"),
    "attitude": {"euler": [40, 30, 20], "sequence": "ZYX", "unit": "deg"},
    "angular_velocity": vector([0.5, -0.9, 3.0], "rad/s"),
    "times": {"elapsed": [0.2, 0.5, 0.75], "unit": "s"},
    "effects": [
        {"type": "uniform_gravity", "acceleration": vector([0.0, 0.0, -GRAVITY], "m/s2")},
        {
            "type": "ground",
            "normal": [0, 0, 1],
            "height": vector(0.0, "m"),
            "shape": {"box": [1, 1, 1], "unit": "m"},
            "restitution": RESTITUTION,
            "friction": 0.0,
        },
    ],
}


def fall(tensor, q, w, seconds):
    """Attitudes and rates at the seconds of one box that touches the ground once, with one corner."""
    inverse = np.linalg.inv(tensor)

    def slope(_t, state):
        q, w = state[:4], state[4:]
        dq = 0.5 * np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)])
        return np.concatenate([dq, inverse @ np.cross(tensor @ w, w)])

    def lowest(t, state):
        below = Rotation.from_quat(state[:4], scalar_first=True).apply(CORNERS)[:, 2].min()
        return HEIGHT + SPEED * t - 0.5 * GRAVITY * t * t + below

    lowest.terminal = True
    accurate = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}
    start = np.concatenate([q, w])
    down = solve_ivp(slope, (0.0, 2.0), start, events=lowest, dense_output=True, **accurate)
    t = brentq(lambda t: lowest(t, down.sol(t)), 0.9 * down.t[-1], down.t[-1] + 1e-6, xtol=1e-15)
    touched = solve_ivp(slope, (0.0, t), start, **accurate).y[:, -1]
    R = Rotation.from_quat(touched[:4], scalar_first=True)
    arm = CORNERS[R.apply(CORNERS)[:, 2].argmin()]
    normal = R.inv().apply([0.0, 0.0, 1.0])
    speed = SPEED - GRAVITY * t + normal @ np.cross(touched[4:], arm)
    turned = inverse @ np.cross(arm, normal)
    impulse = -(1.0 + RESTITUTION) * speed / (1.0 / MASS + normal @ np.cross(turned, arm))
    after = touched + np.concatenate([np.zeros(4), impulse * turned])
    states = [
        solve_ivp(slope, (begin, s), state, **accurate).y[:, -1]
        for s, begin, state in ((s, 0.0, start) if s < t else (s, t, after) for s in seconds)
    ]
    assert seconds[0] < t < seconds[1]
    return np.array(states)


@pytest.mark.parametrize("inertia", ["moments", "tensor"])
def test_partials_through_a_contact_are_differences_of_boxes_that_hit_the_ground(inertia):
    ephemeris = scene(**FALL).run()
    assert len([event for event in ephemeris.events if event.kind == "contact"]) == 1
    seconds, estimates = FALL["times"]["elapsed"], []
    for size in (2e-4, 4e-4):
        steps = np.full(12, size)
        q = Rotation.from_euler("ZYX", FALL["attitude"]["euler"], degrees=True).as_quat(scalar_first=True)
        bodies = moved(np.arange(12), steps, inertia, q, np.array(FALL["angular_velocity"]["value"]))
        states = np.array([fall(*each, seconds) for each in zip(*bodies, strict=True)])
        R = [
            Rotation.from_quat(part[..., :4].reshape(-1, 4), scalar_first=True)
            for part in np.split(states, 2)
        ]
        theta = (R[1].inv() * R[0]).as_rotvec().reshape(12, -1, 3)
        rate = states[:12, :, 4:] - states[12:, :, 4:]
        difference = np.concatenate([theta, rate], axis=-1) / (2.0 * steps[:, None, None])
        estimates.append(np.moveaxis(difference, 0, -1))
    expected = (4.0 * estimates[0] - estimates[1]) / 3.0
    size = np.abs(expected).max(axis=(-1, -2))
    computed = ephemeris.partials(inertia).matrix
    assert (np.abs(computed - expected).max(axis=(-1, -2)) <= TOLERANCE * size).all()
