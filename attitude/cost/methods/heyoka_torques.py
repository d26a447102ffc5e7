"""Torques as expressions of heyoka, in principal axes.

Constant torques, gravity gradient and a magnetic dipole on two-body orbits, eddy damping, dissipation and
rotors, each acting all the time.  Sunlight and drag are not smooth in the attitude, as a Taylor series needs.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...kernels import layout
from ..initial_value_problem import InitialValueProblem, TorqueEnvironment, environment_of
from ..method import AbsentError
from . import torques

Vector = Sequence[Any]
SUPPORTED_TORQUES = (
    *("constant_torque", "gravity_gradient", "eddy_damping", "dissipation", "wheels", "magnetic_dipole"),
)


def equations_of_motion(
    problem: InitialValueProblem,
) -> tuple[list[tuple[Any, Any]], torques.TorqueEquations]:
    """Pairs of variable and its rate of change, in the unit of time of the returned `TorqueEquations`.

    Raises
    ------
    AbsentError : a torque or an orbit that is not written here.
    """
    import heyoka

    environment = environment_of(problem)
    for torque in environment.torques:
        if torque.type not in SUPPORTED_TORQUES or torque.intervals(environment.initial_state) is not None:
            raise AbsentError(f"heyoka cannot integrate {torque.type} here: it is not smooth in time")
    course = environment.initial_state.orbit_path
    if course is not None and int(course.numbers[0]) != layout.KEPLER:
        raise AbsentError("heyoka takes no orbits other than Keplerian ones here")
    numbers = torques.TorqueEquations.of(problem)
    q0, q1, q2, q3, x, y, z = variables = heyoka.make_vars("q0", "q1", "q2", "q3", "x", "y", "z")
    q, w = (q0, q1, q2, q3), (x, y, z)
    W, spins = _rates(numbers, w)
    torque_terms = _torque_terms(environment, numbers, q, w)
    slopes = [
        -0.5 * (q1 * W[0] + q2 * W[1] + q3 * W[2]),
        0.5 * (q0 * W[0] + q2 * W[2] - q3 * W[1]),
        0.5 * (q0 * W[1] + q3 * W[0] - q1 * W[2]),
        0.5 * (q0 * W[2] + q1 * W[1] - q2 * W[0]),
        *(heyoka.expression(0.0) + a + b for a, b in zip(spins, torque_terms, strict=True)),
    ]
    return list(zip(variables, slopes, strict=True)), numbers


def _rates(numbers: torques.TorqueEquations, w: Vector) -> tuple[Vector, Vector]:
    """W, and I^-1 (m x W), without the terms that are zero."""
    I1, I2, I3 = numbers.moments.tolist()
    x, y, z = w
    spins = [
        _term((I2 - I3) / I1, y * z),
        _term((I3 - I1) / I2, z * x),
        _term((I1 - I2) / I3, x * y),
    ]
    h = numbers.rotors / numbers.second
    if h.any():
        gyroscopic = _cross(h.tolist(), w)
        spins = [a + b / c for a, b, c in zip(spins, gyroscopic, (I1, I2, I3), strict=True)]
    if not numbers.alpha:
        return w, spins
    m = [a * b + c for a, b, c in zip((I1, I2, I3), w, h.tolist(), strict=True)]
    inner = [numbers.alpha * numbers.second * component for component in _cross(m, w)]
    dissipated = _cross(m, inner)
    spins = [a + b / c for a, b, c in zip(spins, dissipated, (I1, I2, I3), strict=True)]
    return [a + b for a, b in zip(w, inner, strict=True)], spins


def _torque_terms(
    environment: TorqueEnvironment, numbers: torques.TorqueEquations, q: Vector, w: Vector
) -> list[Any]:
    """I^-1 torque, over `second` squared."""
    initial_state, second = environment.initial_state, numbers.second
    total: list[Any] = [0.0, 0.0, 0.0]
    for torque in environment.torques:
        for row in torque.rows(initial_state):
            one = _torque(row, environment, numbers, q, w)
            scale = [1.0 / (moment * second**2) for moment in numbers.moments.tolist()]
            total = [a + _term(b, c) for a, b, c in zip(total, scale, one, strict=True)]
    return total


def _torque(
    row: np.ndarray, environment: TorqueEnvironment, numbers: torques.TorqueEquations, q: Vector, w: Vector
) -> Vector:
    code, values = int(row[0]), row[1:].tolist()
    if code == layout.CONSTANT_BODY:
        return values[:3]
    if code == layout.CONSTANT_INERTIAL:
        return _to_body(q, values[:3])
    if code == layout.EDDY:
        return [_dot([-numbers.second * c for c in values[i : i + 3]], w) for i in (0, 3, 6)]
    if code == layout.GRAVITY_GRADIENT:
        return _gradient(values[0], environment, numbers, q)
    if code == layout.MAGNETIC:
        return _magnetic(values, environment, numbers, q)
    return [0.0, 0.0, 0.0]  # rotors and dissipation are in the rates


def _gradient(
    mu: float, environment: TorqueEnvironment, numbers: torques.TorqueEquations, q: Vector
) -> Vector:
    """3 mu / r^3 e x I e, component by component: terms of equal moments vanish."""
    e, distance = _direction(environment, numbers)
    down = _to_body(q, e)
    size = 3.0 * mu * distance**-3.0
    I1, I2, I3 = numbers.moments.tolist()
    return [
        _term(I3 - I2, size * (down[1] * down[2])),
        _term(I1 - I3, size * (down[2] * down[0])),
        _term(I2 - I1, size * (down[0] * down[1])),
    ]


def _magnetic(
    values: list[float], environment: TorqueEnvironment, numbers: torques.TorqueEquations, q: Vector
) -> Vector:
    import heyoka

    e, distance = _direction(environment, numbers)
    angle = 2.0 * np.pi * (values[13] + values[14]) / numbers.second * heyoka.time
    c, s = heyoka.cos(angle), heyoka.sin(angle)
    axis = [values[4 + i] + _term(values[7 + i], c) + _term(values[10 + i], s) for i in range(3)]
    radial = 3.0 * _dot(axis, e)
    field = _to_body(q, [radial * a - b for a, b in zip(e, axis, strict=True)])
    size = values[3] * distance**-3.0
    return [size * component for component in _cross(values[:3], field)]


def _direction(environment: TorqueEnvironment, numbers: torques.TorqueEquations) -> tuple[Vector, Any]:
    """Unit vector from the central body, inertial, and distance, m, as functions of time."""
    import heyoka

    course = environment.initial_state.orbit_path
    assert course is not None
    a, e, start, high, low = course.numbers[1:6].tolist()
    P, Q = course.numbers[7:10].tolist(), course.numbers[10:13].tolist()
    mean = 2.0 * np.pi * start + 2.0 * np.pi * (high + low) / numbers.second * heyoka.time
    if e == 0.0:
        c, s, distance = heyoka.cos(mean), heyoka.sin(mean), a
    else:
        E = heyoka.kepE(e, mean)
        nearer = 1.0 - e * heyoka.cos(E)
        c, s = (heyoka.cos(E) - e) / nearer, np.sqrt(1.0 - e * e) * heyoka.sin(E) / nearer
        distance = a * nearer
    return [_term(p, c) + _term(r, s) for p, r in zip(P, Q, strict=True)], distance


# -- expressions, without the terms that are zero ---------------------------------------------------


def _term(factor: float, value: Any) -> Any:
    return 0.0 if factor == 0.0 or (isinstance(value, float) and value == 0.0) else factor * value


def _dot(a: Vector, b: Vector) -> Any:
    return _product(a[0], b[0]) + _product(a[1], b[1]) + _product(a[2], b[2])


def _cross(a: Vector, b: Vector) -> Vector:
    return [
        _product(a[1], b[2]) - _product(a[2], b[1]),
        _product(a[2], b[0]) - _product(a[0], b[2]),
        _product(a[0], b[1]) - _product(a[1], b[0]),
    ]


def _product(a: Any, b: Any) -> Any:
    if isinstance(a, float):
        return _term(a, b)
    return _term(b, a) if isinstance(b, float) else a * b


def _to_body(q: Vector, v: Vector) -> Vector:
    """conj(q) v q, for a unit quaternion."""
    w, x, y, z = q
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
        [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return [_dot(row, v) for row in rows]
