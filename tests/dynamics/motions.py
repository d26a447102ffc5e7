"""Motions under torques by the solver, and by SciPy from equations written out here."""

import numpy as np
from scipy.integrate import solve_ivp

from attitude import RigidBody
from attitude.dynamics.batch_states import Bodies
from attitude.dynamics.momentum import initial_momenta
from attitude.dynamics.solver import OUTPUTS, SolverTask, StepSetting, take_steps
from attitude.dynamics.solver_arguments import most_symmetric
from attitude.effects.effect import row
from attitude.kernels.layout import EffectCode
from attitude.orbit.kepler import Kepler
from attitude.problem.initial_state import CentralBody, InitialState, OrbitPath
from attitude.problem.torque_model import CachedTorque
from attitude.times import turn_rates

# Where the numbers of a row are vectors along the body's axes: the place of each one's first.
BODY_VECTORS = {
    EffectCode.CONSTANT_BODY: (1,),
    EffectCode.WHEELS: (1,),
    EffectCode.MAGNETIC: (1,),
    EffectCode.SOLAR_PLATE: (1, 4),
    EffectCode.DRAG_PLATE: (1, 4),
}


class Rows:
    """A torque by one row of numbers as `kernels.layout` has it, but along the axes of the body's frame."""

    type = "rows"

    def __init__(self, code, *numbers, intervals=None, sun=None, size=0.0):
        self.row, self._intervals, self._sun, self._size = row(code, *numbers), intervals, sun, size

    def rows(self, initial_state):
        out = self.row.copy()
        for place in BODY_VECTORS.get(int(out[0]), ()):
            out[place : place + 3] = initial_state.axes @ out[place : place + 3]
        if out[0] == EffectCode.EDDY:
            out[1:10] = (initial_state.axes @ out[1:10].reshape(3, 3) @ initial_state.axes.T).ravel()
        return out[None]

    def intervals(self, initial_state):
        return self._intervals

    def passages(self, initial_state):
        return None

    def raise_failure(self):
        return None

    def sun(self, initial_state):
        return self._sun

    def air(self, initial_state):
        return None

    def size(self, initial_state):
        return self._size


def initial_state(inertia, rate, attitude=(1.0, 0.0, 0.0, 0.0), start=0.0, stop=0.0, orbit_path=None):
    """A body (moments along x, y, z, or a tensor) with its state at the epoch."""
    inertia = np.asarray(inertia, dtype=float)
    body = RigidBody.from_moments(inertia) if inertia.ndim == 1 else RigidBody(inertia)
    attitude = np.asarray(attitude, dtype=float)
    return InitialState(
        body,
        attitude / np.linalg.norm(attitude),
        np.asarray(rate, dtype=float),
        start,
        stop,
        orbit_path=orbit_path,
    )


def kepler(mu, a, e=0.0, inclination=0.0, node=0.0, pericentre=0.0, mean_anomaly=0.0):
    """Course of a Keplerian orbit; m3/s2, m, rad."""
    angles = {
        "inclination": inclination,
        "raan": node,
        "argument_of_pericentre": pericentre,
        "mean_anomaly": mean_anomaly,
    }
    orbit = Kepler(
        mu={"value": mu, "unit": "m3/s2"},
        semi_major_axis={"value": a, "unit": "m"},
        eccentricity=e,
        **{name: {"value": angle, "unit": "rad"} for name, angle in angles.items()},
    )
    path = orbit.path(0.0, 0.0, None, "ICRF")
    return OrbitPath(path.numbers, path.coefficients, path.period, CentralBody(mu, None, False))


def integrate_arc(
    initial_state, torques, step, seconds, state=None, start=0.0, stop=None, decay=1e-16, dense=False
):
    """Rows (OUTPUTS, n) at instants between start and stop, one arc; and the work, (1,) each.

    step : s; decay : of a step's last Legendre coefficients, without effect for smooth torques; dense :
        whether instants are read off polynomials
    state : (attitude, momentum) at the start, if not that at the epoch
    """
    seconds = np.atleast_1d(np.asarray(seconds, dtype=float))
    stop = seconds[-1] if stop is None else stop
    body, torques = Bodies.of(initial_state), [CachedTorque(torque, initial_state) for torque in torques]
    arguments = most_symmetric(initial_state, body, torques)
    if state is None:
        state = initial_state.attitude, initial_momenta(initial_state, body, torques)[0]
    states = arguments.states(*(np.asarray(each)[None] for each in state))
    setting = StepSetting(np.array([step]), np.array([decay]), dense)
    out, at = np.full((1, OUTPUTS, seconds.size), np.nan), np.array([seconds, np.zeros_like(seconds)])
    task = SolverTask(arguments, np.array([0]), states, float(start), float(stop), at, setting, out)
    return out[0], take_steps(task, torques)


def angle(p, q):
    """rad, greatest over the columns (4, n) of both, or of two attitudes (4,), of any length."""
    p, q = (np.asarray(each, dtype=float) for each in (p, q))
    p, q = p / np.linalg.norm(p, axis=0), q / np.linalg.norm(q, axis=0)
    cross = np.cross(p[1:], q[1:], axis=0)
    vector = p[0] * q[1:] - q[0] * p[1:] - cross
    return float(2.0 * np.arcsin(np.minimum(1.0, np.sqrt((vector**2).sum(axis=0)))).max())


def matrix(q):
    """(3, 3), v_inertial = matrix @ v_body."""
    w, v = q[0], np.asarray(q[1:])
    skew = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + 2.0 * (w * skew + skew @ skew)


def integrated(initial_state, torque, seconds, rtol=1e-13, rotors=(0.0, 0.0, 0.0)):
    """(attitudes (4, n), rates (3, n)) by SciPy's DOP853 of Euler's equations; seconds ascend (or descend).

    torque : (t, R, w) -> N m along the body's axes, R (3, 3) body to inertial
    rotors : N m s, their momentum in the body
    """
    tensor, inverse = initial_state.body.tensor, np.linalg.inv(initial_state.body.tensor)
    rotors = np.asarray(rotors)
    unit = max(np.linalg.norm(initial_state.rate), 1e-3 * np.pi / max(np.abs(seconds)))

    def slope(t, y):
        q, w = y[:4] / np.linalg.norm(y[:4]), y[4:] * unit
        spin = 0.5 * np.array(
            [
                -q[1:] @ w,
                q[0] * w[0] + q[2] * w[2] - q[3] * w[1],
                q[0] * w[1] + q[3] * w[0] - q[1] * w[2],
                q[0] * w[2] + q[1] * w[1] - q[2] * w[0],
            ]
        )
        turn = inverse @ (np.cross(tensor @ w + rotors, w) + torque(t, matrix(q), w))
        return np.concatenate([spin, turn / unit])

    start = np.concatenate([initial_state.attitude, initial_state.rate / unit])
    seconds = np.asarray(seconds, dtype=float)
    found = solve_ivp(slope, (0.0, seconds[-1]), start, "DOP853", t_eval=seconds, rtol=rtol, atol=rtol)
    assert found.success
    q = found.y[:4] / np.linalg.norm(found.y[:4], axis=0)
    return q, found.y[4:] * unit


CODES = {
    "constant_body": EffectCode.CONSTANT_BODY,
    "constant_inertial": EffectCode.CONSTANT_INERTIAL,
    "gravity_gradient": EffectCode.GRAVITY_GRADIENT,
    "eddy": EffectCode.EDDY,
    "dissipation": EffectCode.DISSIPATION,
    "wheels": EffectCode.WHEELS,
}


def acting(name, *numbers):
    """A torque of the 50-digit oracle's, as solvers take it."""
    if name != "magnetic":
        return Rows(CODES[name], *numbers)
    dipole, strength, axis, turning = numbers
    axis, rate = np.array(axis), float(np.linalg.norm(turning))
    pole = np.array(turning) / rate
    still = pole * (axis @ pole)
    around = axis - still
    return Rows(
        EffectCode.MAGNETIC,
        dipole,
        strength,
        still,
        around,
        np.cross(pole, around),
        turn_rates.turns(rate),
    )
