"""Torques as expressions of heyoka, in principal axes.

Constant torques, gravity gradient and a magnetic dipole on two-body orbits, eddy damping, dissipation and
rotors, each acting all the time.  Sunlight and drag are not smooth in the attitude, as a Taylor series needs.
Vectors are numpy's, of expressions; heyoka leaves out terms whose factor is zero.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...kernels.layout import EffectCode, OrbitCode
from ..initial_value_problem import InitialValueProblem, TorqueEnvironment, environment_of
from ..method import AbsentError
from . import torques


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
    smooth = "constant_torque", "gravity_gradient", "eddy_damping", "dissipation", "wheels", "magnetic_dipole"
    for torque in environment.torques:
        if torque.type not in smooth or torque.intervals(environment.initial_state) is not None:
            raise AbsentError(f"heyoka cannot integrate {torque.type} here: it is not smooth in time")
    course = environment.initial_state.orbit_path
    if course is not None and int(course.numbers[0]) != OrbitCode.KEPLER:
        raise AbsentError("heyoka takes no orbits other than Keplerian ones here")
    numbers = torques.TorqueEquations.of(problem)
    q0, q1, q2, q3, x, y, z = variables = heyoka.make_vars("q0", "q1", "q2", "q3", "x", "y", "z")
    (I1, I2, I3), moments, w = numbers.moments.tolist(), _vector(numbers.moments), _vector((x, y, z))
    rotors = _vector(numbers.rotors / numbers.second)
    whole = moments * w + rotors
    inner = numbers.alpha * numbers.second * np.cross(whole, w)
    a, b, c = w + inner  # W
    own = _vector(((I2 - I3) / I1 * (y * z), (I3 - I1) / I2 * (z * x), (I1 - I2) / I3 * (x * y)))
    total = own + (np.cross(rotors, w) + np.cross(whole, inner)) / moments
    for torque in environment.torques:
        for row in torque.rows(environment.initial_state):
            one = _torque(row, environment, numbers, (q0, q1, q2, q3), w)
            total = total + one / (moments * numbers.second**2)
    slopes = [
        -0.5 * (q1 * a + q2 * b + q3 * c),
        0.5 * (q0 * a + q2 * c - q3 * b),
        0.5 * (q0 * b + q3 * a - q1 * c),
        0.5 * (q0 * c + q1 * b - q2 * a),
        *(heyoka.expression(0.0) + slope for slope in total),
    ]
    return list(zip(variables, slopes, strict=True)), numbers


def _torque(
    row: np.ndarray,
    environment: TorqueEnvironment,
    numbers: torques.TorqueEquations,
    q: tuple[Any, ...],
    w: np.ndarray,
) -> np.ndarray:
    """Torque of one row of effects, along the principal axes; rotors and dissipation are in the rates."""
    code, values = int(row[0]), _vector(row[1:])
    if code == EffectCode.CONSTANT_BODY:
        return values[:3]
    if code == EffectCode.CONSTANT_INERTIAL:
        return _to_body(q, values[:3])
    if code == EffectCode.EDDY:
        return -numbers.second * values[:9].reshape(3, 3) @ w
    if code == EffectCode.GRAVITY_GRADIENT:  # 3 mu / r^3 e x I e; terms of equal moments vanish
        e, distance = _direction(environment, numbers)
        x, y, z = _to_body(q, e)
        I1, I2, I3 = numbers.moments.tolist()
        crossed = (I3 - I2) * (y * z), (I1 - I3) * (z * x), (I2 - I1) * (x * y)
        return 3.0 * values[0] * distance**-3.0 * _vector(crossed)
    if code == EffectCode.MAGNETIC:
        return _magnetic(values, environment, numbers, q)
    return _vector((0.0, 0.0, 0.0))


def _magnetic(
    values: np.ndarray, environment: TorqueEnvironment, numbers: torques.TorqueEquations, q: tuple[Any, ...]
) -> np.ndarray:
    import heyoka

    e, distance = _direction(environment, numbers)
    angle = 2.0 * np.pi * (values[13] + values[14]) / numbers.second * heyoka.time
    axis = values[4:7] + values[7:10] * heyoka.cos(angle) + values[10:13] * heyoka.sin(angle)
    field = _to_body(q, 3.0 * (axis @ e) * e - axis)
    return values[3] * distance**-3.0 * np.cross(values[:3], field)


def _direction(environment: TorqueEnvironment, numbers: torques.TorqueEquations) -> tuple[np.ndarray, Any]:
    """Unit vector from the central body, inertial, and distance, m, as functions of time."""
    import heyoka

    course = environment.initial_state.orbit_path
    assert course is not None
    a, e, start, high, low = course.numbers[1:6].tolist()
    mean = 2.0 * np.pi * start + 2.0 * np.pi * (high + low) / numbers.second * heyoka.time
    if e == 0.0:
        c, s, distance = heyoka.cos(mean), heyoka.sin(mean), a
    else:
        E = heyoka.kepE(e, mean)
        nearer = 1.0 - e * heyoka.cos(E)
        c, s = (heyoka.cos(E) - e) / nearer, float(np.sqrt(1.0 - e * e)) * heyoka.sin(E) / nearer
        distance = a * nearer
    return _vector(course.numbers[7:10]) * c + _vector(course.numbers[10:13]) * s, distance


def _vector(components: Any) -> np.ndarray:
    """Expressions, or Python's floats, which these can be multiplied by."""
    plain = components.tolist() if isinstance(components, np.ndarray) else components
    return np.array(plain, dtype=object)


def _to_body(q: tuple[Any, ...], v: np.ndarray) -> np.ndarray:
    """conj(q) v q, for a unit quaternion."""
    w, x, y, z = q
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
        [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return _vector(rows) @ v
