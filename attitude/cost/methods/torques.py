"""The equations of motion under torques, compiled independently of the library's kernels.

Principal axes, and time in a unit that makes the fastest motion of order one: y = (q, w), with m = I w + h
the whole momentum, h that of the rotors, W = w + alpha m x w the rate of the attitude,

    q' = q W / 2,     I w' = m x W + torque.

Effects, orbit and Sun are rows of numbers as in `kernels.layout`; their formulas are written here a second
time.  `extrapolated` integrates to the last digits of a double: the truth where the oracle lacks a torque.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from scipy.spatial.transform import Rotation

from ... import stopping
from ...dynamics.arcs import Arc, instants_within
from ...kernels.layout import ORBIT_WIDTH, EffectCode, EffectRow, OrbitCode
from ...problem.torque_rows import number_pieces
from ..initial_value_problem import InitialValueProblem, TorqueEnvironment, environment_of
from .euler import kernel, routine

TURN = 2.0 * np.pi


# Codes of this file, by the library's names, so that numba's cache depends on nothing outside it.
class TorqueCode(IntEnum):
    """The first number of an effect's row."""

    CONSTANT_BODY = 0
    CONSTANT_INERTIAL = 1
    GRAVITY_GRADIENT = 2
    EDDY = 3
    MAGNETIC = 4
    SOLAR_PLATE = 5
    DRAG_PLATE = 6
    WHEELS = 7
    DISSIPATION = 8


class PathCode(IntEnum):
    """The first number of an orbit."""

    NONE = 0
    KEPLER = 1
    TABLE = 2


@dataclass(frozen=True)
class TorqueEquations:
    """Equations of motion and initial state of a body under the torques of one arc.

    Attributes
    ----------
    start : (7,), wxyz of the principal axes and rate in them, rad a unit of time
    second : units of time in a second; a power of two
    arguments : of `derivative`: body, effects, orbit, its pieces, Sun, its pieces, those of the density
    axes : of the principal frame in the body frame
    moments, rotors : (3,), kg m2 and N m s; alpha : 1/(N m s)
    """

    start: np.ndarray
    second: float
    arguments: tuple[np.ndarray, ...]
    axes: Rotation
    moments: np.ndarray
    rotors: np.ndarray
    alpha: float

    @classmethod
    def of(cls, problem: InitialValueProblem, arc: Arc | None = None) -> TorqueEquations:
        """The equations on an arc; under all torques of the scene without one."""
        environment = environment_of(problem)
        initial_state = environment.initial_state
        axes = Rotation.from_matrix(initial_state.axes.T)
        torques = environment.torques if arc is None else arc.torques
        rows = [torque.rows(initial_state) for torque in torques]
        air = number_pieces(rows, torques, initial_state)
        table = np.concatenate([np.zeros((0, EffectRow.WIDTH)), *rows])
        rotors = table[table[:, 0] == EffectCode.WHEELS, 1:4].sum(axis=0)
        alpha = float(table[table[:, 0] == EffectCode.DISSIPATION, 1].sum())
        second = 2.0 ** int(np.frexp(environment.pace)[1])
        attitude = (Rotation.from_quat(problem.attitude, scalar_first=True) * axes).as_quat(scalar_first=True)
        rate = _own_rate(
            initial_state.moments, axes.apply(problem.angular_velocity, inverse=True), rotors, alpha
        )
        body = np.concatenate([initial_state.moments, rotors, [alpha, second]])
        table[:, 0] = [TorqueCode[EffectCode(int(code)).name] for code in table[:, 0]]
        start = np.concatenate([attitude, rate / second])
        arguments = body, table, *_orbit_and_sun(environment), air
        return cls(start, second, arguments, axes, initial_state.moments, rotors, alpha)

    def to_body(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(n, 7) states as unit quaternions (n, 4) and rates W (n, 3), rad/s, in the body frame."""
        q = Rotation.from_quat(y[:, :4], scalar_first=True) * self.axes.inv()
        w = y[:, 4:] * self.second
        attitude_rate = w + self.alpha * np.cross(self.moments * w + self.rotors, w)
        return q.as_quat(scalar_first=True), self.axes.apply(attitude_rate)

    def extrapolated(
        self, start: np.ndarray, begin: float, end: float, instants: np.ndarray, tolerance: float
    ) -> np.ndarray:
        """States (n + 1, 7) at the instants and at the end, in the equations' time; see `extrapolated`."""
        out = np.empty((instants.size + 1, 7))
        stop = stopping.current()
        extrapolated(start, begin, end, instants, tolerance, out, self.arguments, stop.flag)
        stop.check()
        return out


# (equations, state, begin, end, instants) -> (n + 1, 7), states at the instants and at the end
Integrate = Callable[[TorqueEquations, np.ndarray, float, float, np.ndarray], np.ndarray]


def over_arcs(
    problem: InitialValueProblem, instants: np.ndarray, integrate: Integrate
) -> tuple[np.ndarray, np.ndarray]:
    """Quaternions (n, 4) and rates (n, 3) at ascending instants from 0, s, arc by arc."""
    arcs = environment_of(problem).arcs(float(instants[-1]))
    attitudes, rates, y = np.empty((instants.size, 4)), np.empty((instants.size, 3)), None
    for arc, index in zip(arcs, instants_within(arcs, instants, np.zeros_like(instants)), strict=True):
        equations = TorqueEquations.of(problem, arc)
        second = equations.second
        y = equations.start if y is None else y
        states = integrate(equations, y, arc.start * second, arc.stop * second, instants[index] * second)
        attitudes[index], rates[index] = equations.to_body(states[:-1])
        y = states[-1]
    return attitudes, rates


def _own_rate(moments: np.ndarray, attitude_rate: np.ndarray, rotors: np.ndarray, alpha: float) -> np.ndarray:
    """w of W = w + alpha (I w + h) x w, by fixed-point iteration, since dissipation is slow."""
    w = attitude_rate
    for _ in range(100 if alpha else 0):
        w = attitude_rate - alpha * np.cross(moments * w + rotors, w)
    return w


def _orbit_and_sun(environment: TorqueEnvironment) -> tuple[np.ndarray, ...]:
    """Orbit, its pieces, Sun (start, length, 1 where there is one), its pieces."""
    course, initial_state = environment.initial_state.orbit_path, environment.initial_state
    orbit, orbit_pieces = np.zeros(ORBIT_WIDTH), np.zeros((1, 3, 1))
    sun, sun_pieces = np.array([0.0, 1.0, 0.0]), np.zeros((1, 3, 1))
    if course is not None:
        orbit, orbit_pieces = course.numbers.copy(), course.coefficients
    orbit[0] = PathCode[OrbitCode(int(orbit[0])).name]
    for torque in environment.torques:
        if (pieces := torque.sun(initial_state)) is not None:
            sun, sun_pieces = np.array([pieces.start, pieces.length, 1.0]), pieces.coefficients
    return orbit, np.ascontiguousarray(orbit_pieces), sun, np.ascontiguousarray(sun_pieces)


# -- vectors --------------------------------------------------------------------------------------


@routine
def cross(a, b):
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@routine
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@routine
def plus(a, b, factor):
    """a + factor b."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


@routine
def inverse_length(a):
    """1 / abs(a)."""
    return 1.0 / np.sqrt(dot(a, a))


@routine
def two_sum(a, b):
    """The rounded sum and its rounding error."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@routine
def to_body(q, v):
    """conj(q) v q."""
    u = -q[1], -q[2], -q[3]
    twice = cross(u, v)
    twice = 2.0 * twice[0], 2.0 * twice[1], 2.0 * twice[2]
    return plus(plus(v, twice, q[0]), cross(u, twice), 1.0)


@routine
def three(row, first):
    """Three numbers of a row as a vector."""
    return row[first], row[first + 1], row[first + 2]


# -- positions ---------------------------------------------------------------------------------------


@routine
def on_orbit(orbit, pieces, t):
    """Position and velocity on the orbit, m and m/s."""
    if int(orbit[0]) == PathCode.TABLE:
        return on_pieces(pieces, orbit[1], orbit[2], t)
    a, e, rate = orbit[1], orbit[2], orbit[6]
    turns = orbit[3] + t * orbit[4] + t * orbit[5]
    mean = TURN * (turns - np.round(turns))
    E = mean + e * np.sin(mean)
    for _ in range(50):
        step = (E - e * np.sin(E) - mean) / (1.0 - e * np.cos(E))
        E -= step
        if abs(step) < 1e-15:
            break
    s, c, minor = np.sin(E), np.cos(E), np.sqrt(1.0 - e * e)
    speed = a * rate / (1.0 - e * c)
    zero = 0.0, 0.0, 0.0
    P, Q = three(orbit, 7), three(orbit, 10)
    r = plus(plus(zero, P, a * (c - e)), Q, a * minor * s)
    return r, plus(plus(zero, P, -speed * s), Q, speed * minor * c)


@routine
def on_pieces(pieces, start, length, t):
    """Value and derivative of a piecewise polynomial, in powers from -1 to 1 on each interval."""
    index = min(max(int((t - start) / length), 0), pieces.shape[0] - 1)
    x = 2.0 * ((t - start) / length - index) - 1.0
    r, v = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for k in range(pieces.shape[2] - 1, -1, -1):
        v = v[0] * x + r[0], v[1] * x + r[1], v[2] * x + r[2]
        r = (
            r[0] * x + pieces[index, 0, k],
            r[1] * x + pieces[index, 1, k],
            r[2] * x + pieces[index, 2, k],
        )
    half = 0.5 * length
    return r, (v[0] / half, v[1] / half, v[2] / half)


# -- torques --------------------------------------------------------------------------------------


@routine
def gravity_gradient(row, moments, q, r):
    """Torque 3 mu / r^3 e x I e, N m, body frame."""
    shorter = inverse_length(r)
    down = to_body(q, (r[0] * shorter, r[1] * shorter, r[2] * shorter))
    I1, I2, I3 = moments
    crossed = (I3 - I2) * down[1] * down[2], (I1 - I3) * down[2] * down[0], (I2 - I1) * down[0] * down[1]
    return plus((0.0, 0.0, 0.0), crossed, 3.0 * row[1] * shorter**3)


@routine
def magnetic(row, q, r, t):
    """Torque of a dipole in the field of the central body's dipole, N m, body frame."""
    angle = TURN * (t * row[14] + t * row[15])
    d = plus(plus(three(row, 5), three(row, 8), np.cos(angle)), three(row, 11), np.sin(angle))
    shorter = inverse_length(r)
    field = plus((-d[0], -d[1], -d[2]), r, 3.0 * dot(d, r) * shorter**2)
    return plus((0.0, 0.0, 0.0), cross(three(row, 1), to_body(q, field)), row[4] * shorter**3)


@routine
def solar_plate(row, q, to_sun):
    """Torque of sunlight on a plate, N m, body frame."""
    n, area, specular, diffuse = three(row, 1), row[7], row[8], row[9]
    shorter = inverse_length(to_sun)
    s = to_body(q, plus((0.0, 0.0, 0.0), to_sun, shorter))
    cosine = max(dot(n, s), 0.0)
    pressure = row[10] * (149597870700.0 * shorter) ** 2  # at 1 au
    push = plus(plus((0.0, 0.0, 0.0), s, 1.0 - specular), n, 2.0 * (specular * cosine + diffuse / 3.0))
    return plus((0.0, 0.0, 0.0), cross(three(row, 4), push), -pressure * area * cosine)


@routine
def log_density(air, first, count, t):
    """Logarithm of the density, kg/m3, on the last of the pieces that begins before t, or the first.

    A piece is its start, a factor of time, and coefficients of the powers of the time so scaled.
    """
    piece = first
    while piece + 1 < first + count and air[piece + 1, 0] <= t:
        piece += 1
    x, value = (t - air[piece, 0]) * air[piece, 1] - 1.0, 0.0
    for k in range(air.shape[1] - 1, 1, -1):
        value = value * x + air[piece, k]
    return value


@routine
def drag_plate(row, q, t, r, v, air):
    """Torque of drag on a plate, N m, body frame."""
    n, area, density, reference, height = three(row, 1), row[7], row[8], row[9], row[10]
    wind = plus(v, cross(three(row, 11), r), -1.0)
    speed = np.sqrt(dot(wind, wind))
    ahead = to_body(q, plus((0.0, 0.0, 0.0), wind, 1.0 / speed))
    first, count = int(row[14]), int(row[15])
    exponent = log_density(air, first, count, t) if count > 0 else (reference - np.sqrt(dot(r, r))) / height
    density *= np.exp(exponent)
    push = -0.5 * density * speed**2 * area * max(dot(n, ahead), 0.0)
    return plus((0.0, 0.0, 0.0), cross(three(row, 4), ahead), push)


@routine
def torque(row, moments, q, w, t, place, s, air):  # noqa: PLR0911 (a return for each effect)
    """Torque of one effect, N m, body frame."""
    code, (r, v) = int(row[0]), place
    if code == TorqueCode.CONSTANT_BODY:
        return three(row, 1)
    if code == TorqueCode.CONSTANT_INERTIAL:
        return to_body(q, three(row, 1))
    if code == TorqueCode.GRAVITY_GRADIENT:
        return gravity_gradient(row, moments, q, r)
    if code == TorqueCode.EDDY:
        return -dot(three(row, 1), w), -dot(three(row, 4), w), -dot(three(row, 7), w)
    if code == TorqueCode.MAGNETIC:
        return magnetic(row, q, r, t)
    if code == TorqueCode.SOLAR_PLATE:
        return solar_plate(row, q, plus(s, r, -1.0))
    if code == TorqueCode.DRAG_PLATE:
        return drag_plate(row, q, t, r, v, air)
    return 0.0, 0.0, 0.0  # rotors and dissipation enter by the momentum


@routine
def own_spin(moments, w):
    """(I w) x w; a component is exactly zero where its two moments are equal."""
    I1, I2, I3 = moments
    return (I2 - I3) * w[1] * w[2], (I3 - I1) * w[2] * w[0], (I1 - I2) * w[0] * w[1]


@routine
def slope(time, y, f, arguments):
    """Write y' to f (7,); `body` holds moments, rotors, alpha, second."""
    body, rows, orbit, pieces, sun, sun_pieces, air = arguments
    moments, rotors, alpha, second = three(body, 0), three(body, 3), body[6], body[7]
    norm = 1.0 / np.sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + y[3] * y[3])
    q = y[0] * norm, y[1] * norm, y[2] * norm, y[3] * norm
    w = second * y[4], second * y[5], second * y[6]
    inner = plus(own_spin(moments, w), cross(rotors, w), 1.0)
    m = moments[0] * w[0] + rotors[0], moments[1] * w[1] + rotors[1], moments[2] * w[2] + rotors[2]
    W = plus(w, inner, alpha)
    t = time / second
    r, v, s = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    if int(orbit[0]) != PathCode.NONE:
        r, v = on_orbit(orbit, pieces, t)
    if sun[2] != 0.0:
        s, _ = on_pieces(sun_pieces, sun[0], sun[1], t)
    push = plus(inner, cross(m, inner), alpha)
    for k in range(rows.shape[0]):
        push = plus(push, torque(rows[k], moments, q, w, t, (r, v), s, air), 1.0)
    a, b, c = 0.5 * W[0] / second, 0.5 * W[1] / second, 0.5 * W[2] / second
    f[0] = -(y[1] * a + y[2] * b + y[3] * c)
    f[1] = y[0] * a + y[2] * c - y[3] * b
    f[2] = y[0] * b + y[3] * a - y[1] * c
    f[3] = y[0] * c + y[1] * b - y[2] * a
    for i in range(3):
        f[4 + i] = push[i] / moments[i] / (second * second)


@kernel
def derivative(time, y, arguments):
    """y', (7,)."""
    f = np.empty(7)
    slope(time, y, f, arguments)
    return f


# -- truth ----------------------------------------------------------------------------------------

# Extrapolation magnifies rounding: of 4 to 8 columns, 4 come nearest to the oracle.
COLUMNS = 4


@routine
def midpoints(time, y, h, n, arguments, work):
    """Increment of y over h in n steps of Gragg's smoothed midpoint rule, into work[1].

    The smoothing evaluates the torque at the end too, so that a change just before it is seen.
    """
    before, here, at, f = work[0], work[1], work[2], work[3]
    step = h / n
    slope(time, y, f, arguments)
    for i in range(7):
        before[i], here[i] = 0.0, step * f[i]
    for k in range(1, n + 1):
        for i in range(7):
            at[i] = y[i] + here[i]
        slope(time + k * step, at, f, arguments)
        for i in range(7):
            if k < n:
                before[i], here[i] = here[i], before[i] + 2.0 * step * f[i]
            else:
                here[i] = 0.5 * (here[i] + before[i] + step * f[i])


@routine
def extrapolated_step(time, y, h, arguments, table, work):
    """Write the increment of y over h to table[0]; the difference of the last two extrapolations.

    From 2, 4, 6 ... steps, extrapolated to a step of zero.
    Source: Hairer, Norsett and Wanner, Solving Ordinary Differential TorqueEquations I, section II.9.
    """
    for j in range(COLUMNS):
        midpoints(time, y, h, 2 * (j + 1), arguments, work)
        for i in range(7):
            table[j, i] = work[1, i]
        for k in range(j - 1, -1, -1):
            ratio = ((j + 1.0) / (k + 1.0)) ** 2 - 1.0
            for i in range(7):
                table[k, i] = table[k + 1, i] + (table[k + 1, i] - table[k, i]) / ratio
    difference = 0.0
    for i in range(7):
        difference = max(difference, abs(table[0, i] - table[1, i]))
    return difference


@kernel
def extrapolated(start, begin, end, instants, tolerance, out, arguments, halted):
    """Write states (n, 7) at ascending instants from begin to end, and the state at the end in the last row.

    The state is held in two parts, so that only the increments are rounded.
    start : (7,); begin, end, instants : in the equations' unit of time; out : (n + 1, 7), written
    tolerance : error in a unit of time, estimated by the difference of the last two extrapolations
    halted : (1,), set to another number than 0 by another thread to end it
    """
    root = 1.0 / (2 * COLUMNS - 2)
    table, work = np.empty((COLUMNS, 7)), np.empty((4, 7))
    y, low, time, time_low, h, written = start.copy(), np.zeros(7), begin, 0.0, 0.5, 0
    while halted[0] == 0.0:
        left = (end - time) - time_low
        ends = h >= left
        step = left if ends else h
        difference = extrapolated_step(time, y, step, arguments, table, work)
        if difference > tolerance * step and step > 1e-9:
            h = step * max(0.2, 0.9 * (tolerance * step / difference) ** root)
            continue
        increment = table[0].copy()
        while written < instants.size and (ends or (instants[written] - time) - time_low < step):
            if halted[0] != 0.0:
                return
            extrapolated_step(time, y, (instants[written] - time) - time_low, arguments, table, work)
            out[written] = y + (low + table[0])
            written += 1
        for i in range(7):
            y[i], low[i] = two_sum(y[i], low[i] + increment[i])
        if ends:
            out[written] = y
            return
        time, time_low = two_sum(time, time_low + step)
        h = step * min(4.0, max(0.2, 0.9 * (tolerance * step / max(difference, 1e-30)) ** root))
