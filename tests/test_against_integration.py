"""Against numerical integration of Euler's equations, by SciPy's DOP853: the physics, stated once more.

The library and its truth both rest on the closed form or on the same exact invariants; the integrator knows
only I omega' = (I omega) x omega and q' = q omega / 2.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.bodies import (
    ATTITUDE,
    ATTITUDE_TOLERANCE,
    GENERIC,
    LONG_AXIS,
    NAMED,
    RATE_TOLERANCE,
    SEPARATRIX,
    Body,
    angle_between,
    distance,
    each,
    motion,
    sample,
    speed,
)

# SciPy takes no tolerance below 100 eps = 2.2e-14.
FINE = 3e-14
# Runs that measure the integrator's own error: a hundred times coarser; much more beside the saddle,
# where rounding grows in the fine run too.
COARSE, COARSE_BESIDE_SADDLE = 3e-12, 3e-9
# The fine run errs by less than this share of the coarse one: by a hundredth, and a margin of ten.
SHARE = 0.1
# What the comparison must be able to see: a coarse run worse than this would prove nothing.
BLUNT = 2e-6

TENSORS = {
    "full tensor": Body(((2.0, 0.3, -0.2), (0.3, 2.5, 0.1), (-0.2, 0.1, 1.5)), (0.4, -0.9, 0.3)),
    "full tensor, nearly symmetric": Body(
        ((2.0, 0.0, 1e-3), (0.0, 2.0, 0.5), (1e-3, 0.5, 3.0)), (0.4, 0.2, 0.8)
    ),
}
# A thousandth off the separatrix: at the millionth of the table of bodies the integrator's rounding rules.
BESIDE_SADDLE = {
    "outside the separatrix": Body((3.0, 4.0, 6.0), (2.0, 0.7, 1.001)),
    "inside the separatrix": Body((3.0, 4.0, 6.0), (2.0, 0.7, 0.999)),
    "Dzhanibekov": LONG_AXIS["Dzhanibekov"],
}
STEADY = {
    name: body for name, body in GENERIC.items() if "separatrix" not in name and name not in BESIDE_SADDLE
}
STEADY |= {name: NAMED[name] for name in ("oblate", "prolate")} | TENSORS

# Name: body, rad, the coarser tolerance. On the separatrix rounding grows by e^u' t without end.
CASES = (
    {name: (body, 300.0, COARSE) for name, body in STEADY.items()}
    | {name: (body, 300.0, COARSE_BESIDE_SADDLE) for name, body in BESIDE_SADDLE.items()}
    | {name: (body, 30.0, COARSE_BESIDE_SADDLE) for name, body in SEPARATRIX.items()}
)


def integrate(body, t, rtol):
    """Quaternions and rates at t, from ATTITUDE; unit quaternions restored only at the end."""
    inertia = np.array(body.inertia)
    tensor = inertia if inertia.ndim == 2 else np.diag(inertia)
    rows, inverse = tensor.tolist(), np.linalg.inv(tensor).tolist()

    def derivative(_, state):
        w, x, y, z, p, q, r = state.tolist()
        A, B, C = (a * p + b * q + c * r for a, b, c in rows)
        torque = B * r - C * q, C * p - A * r, A * q - B * p
        return [
            (-x * p - y * q - z * r) / 2,
            (w * p + y * r - z * q) / 2,
            (w * q + z * p - x * r) / 2,
            (w * r + x * q - y * p) / 2,
            *(a * torque[0] + b * torque[1] + c * torque[2] for a, b, c in inverse),
        ]

    size = np.array([1.0] * 4 + [speed(body)] * 3)
    start = [*ATTITUDE, *body.omega]
    solution = solve_ivp(derivative, (0.0, t[-1]), start, "DOP853", t, rtol=rtol, atol=rtol * size)
    q, omega = solution.y[:4].T, solution.y[4:].T
    return q / np.linalg.norm(q, axis=1, keepdims=True), omega


@pytest.mark.parametrize("direction", [1, -1], ids=["forward", "backward"])
@pytest.mark.parametrize(("body", "radians", "coarser"), **each(CASES))
def test_closed_form_is_what_integration_gives(body, radians, coarser, direction):
    t = np.linspace(0.0, direction * radians / speed(body), 200)
    q, omega = sample(body, t)
    fine, coarse = integrate(body, t, FINE), integrate(body, t, coarser)
    angle = np.max(angle_between(fine[0], coarse[0]))
    rate = np.max(distance(coarse[1], fine[1]))
    assert max(angle, rate) < BLUNT
    assert np.max(angle_between(fine[0], q)) <= SHARE * angle + ATTITUDE_TOLERANCE
    assert np.max(distance(omega, fine[1])) <= SHARE * rate + RATE_TOLERANCE


def test_the_comparison_spans_tens_of_periods():
    for body in STEADY.values():
        assert 300.0 / speed(body) > 15 * motion(body).polhode_period


@pytest.mark.parametrize("shift", [1 / 9, 1 / 3, 2.0])
def test_a_constant_added_to_each_inverse_moment_leaves_the_path_of_the_momentum(shift):
    """L' = L x (a L), and L x L = 0: so (3, 5, 9), which no body has, flips as (2.25, 45/14, 4.5) does."""
    inverse, start = np.array([1 / 3, 1 / 5, 1 / 9]), np.array([0.0, 2.0, 0.01])
    t = np.linspace(0.0, 250.0, 501)
    path = {}
    for rtol in (FINE, COARSE_BESIDE_SADDLE):
        path[rtol] = solve_ivp(
            lambda _, L: np.cross(L, inverse * L), (0.0, t[-1]), start, "DOP853", t, rtol=rtol, atol=rtol
        ).y.T
    moments = 1 / (inverse + shift)
    _, omega = sample(Body(tuple(moments), tuple(start / moments)), t)
    error = np.max(distance(path[COARSE_BESIDE_SADDLE], path[FINE]))
    assert error < BLUNT
    assert np.max(distance(omega * moments, path[FINE])) <= SHARE * error
