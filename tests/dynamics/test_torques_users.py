"""Torques of the user's own: as good as the built-in ones, and failures that reach the user."""

import ctypes
import math

import numpy as np
import pytest
from numba import cfunc, types

from attitude import AttitudeError, InputError
from attitude.effects import UserTorque
from tests.dynamics.motions import angle, matrix
from tests.dynamics.scenes import quantity, scene

T = np.array([0.02, -0.01, 0.015])
RATE = (0.3, -0.5, 0.4)
SECONDS = np.linspace(-10.0, 60.0, 15)
C_TORQUE = types.void(
    types.float64, types.CPointer(types.float64), types.CPointer(types.float64), types.CPointer(types.float64)
)


@cfunc(C_TORQUE)
def compiled_constant(t, attitude, rate, torque):
    torque[0] = 0.02
    torque[1] = -0.01
    torque[2] = 0.015


@cfunc(C_TORQUE)
def compiled_damping(t, attitude, rate, torque):
    for i in range(3):
        torque[i] = -0.05 * rate[i]


@cfunc(C_TORQUE)
def compiled_stop(t, attitude, rate, torque):
    for i in range(3):
        torque[i] = math.nan if t > 200.0 else 0.01


def inertial(t, attitude, rate):
    return matrix(attitude).T @ T


PAIRS = {
    "constant, Python": (
        lambda: UserTorque("mine", lambda t, q, w: T, size=0.03),
        {"type": "constant_torque", "torque": quantity(T.tolist(), "N m"), "frame": "body"},
    ),
    "constant, compiled": (
        lambda: UserTorque("mine", compiled=compiled_constant, size=0.03),
        {"type": "constant_torque", "torque": quantity(T.tolist(), "N m"), "frame": "body"},
    ),
    "constant, address": (
        lambda: UserTorque("mine", compiled=compiled_constant.address, size=0.03),
        {"type": "constant_torque", "torque": quantity(T.tolist(), "N m"), "frame": "body"},
    ),
    "inertial, Python": (
        lambda: UserTorque("mine", inertial, size=0.03),
        {"type": "constant_torque", "torque": quantity(T.tolist(), "N m"), "frame": "inertial"},
    ),
    "damping, Python": (
        lambda: UserTorque("mine", lambda t, q, w: -0.05 * w, size=0.05),
        {"type": "eddy_damping", "coefficient": 0.05, "unit": "N m s"},
    ),
    "damping, compiled": (
        lambda: UserTorque("mine", compiled=compiled_damping, size=0.05),
        {"type": "eddy_damping", "coefficient": 0.05, "unit": "N m s"},
    ),
}
# Axes in no special order, and a tensor that turns them: the function is asked in the body's own frame.
BODIES = {
    "moments": {"moments": [14.0, 10.0, 17.0], "unit": "kg m2"},
    "tensor": {"tensor": [[10.0, 0.5, -0.3], [0.5, 14.0, 0.25], [-0.3, 0.25, 17.0]], "unit": "kg m2"},
    "symmetric": {"moments": [12.0, 7.0, 12.0], "unit": "kg m2"},
}


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
@pytest.mark.parametrize("made", PAIRS.values(), ids=PAIRS)
def test_own_torque_is_as_good_as_the_built_in_one(made, body):
    own, built_in = made
    more = {"body": body, "rate": RATE, "elapsed": SECONDS, "tolerance": 1e-8}
    mine, theirs = scene(own(), **more).run(), scene(built_in, **more).run()
    assert angle(mine.quaternion("wxyz").T, theirs.quaternion("wxyz").T) < 1e-8
    assert np.abs(mine.angular_velocity - theirs.angular_velocity).max() < 1e-8
    assert angle(mine.quaternion("wxyz")[:1].T, mine.quaternion("wxyz")[-1:].T) > 0.1


def test_compiled_and_plain_function_give_the_same_bits():
    more = {"rate": RATE, "elapsed": SECONDS, "tolerance": 1e-8}
    plain = scene(UserTorque("mine", lambda t, q, w: T, size=0.03), **more).run()
    compiled = scene(UserTorque("mine", compiled=compiled_constant, size=0.03), **more).run()
    assert plain.quaternion("wxyz").tobytes() == compiled.quaternion("wxyz").tobytes()


def test_the_plan_calls_it_by_its_name():
    mine = scene(UserTorque("outgassing", lambda t, q, w: T, size=0.03), rate=RATE, elapsed=SECONDS)
    assert [effect.type for effect in mine.plan().effects] == ["outgassing"]


def test_function_sees_the_time_attitude_and_rate_of_the_body():
    seen = []

    def watching(t, attitude, rate):
        seen.append((t, attitude.copy(), rate.copy()))
        return np.zeros(3)

    t = np.linspace(0.0, 60.0, 5)
    scene(UserTorque("watching", watching, size=1e-9), rate=RATE, elapsed=t, tolerance=1e-8).run()
    times = np.array([at for at, _, _ in seen])
    assert times.min() >= 0.0
    assert times.max() <= 60.0
    order = np.argsort(times)[:: max(1, len(times) // 50)]
    free = scene(rate=RATE, elapsed=times[order]).run()
    q, w = np.array([seen[i][1] for i in order]), np.array([seen[i][2] for i in order])
    # stages of a step that is refused, or not yet settled, are rougher than its end
    assert np.median(np.abs(w - free.angular_velocity)) < 1e-6
    near = np.minimum(
        np.abs(q - free.quaternion("wxyz")).max(axis=1), np.abs(q + free.quaternion("wxyz")).max(axis=1)
    )
    assert np.median(near) < 1e-6


# Failures


def failing(t, attitude, rate):
    if t > 20.0:
        raise ZeroDivisionError("the fuel is used up")
    return T


def test_exception_in_the_function_reaches_the_user():
    made = scene(UserTorque("tank", failing, size=0.03), rate=RATE, elapsed=SECONDS, tolerance=1e-8)
    with pytest.raises(ZeroDivisionError, match="the fuel is used up"):
        made.run()
    # and leaves nothing behind: before the failure the same effect works
    early = scene(*made.effects, rate=RATE, elapsed=[0.0, 10.0], tolerance=1e-8).run()
    assert np.isfinite(early.quaternion("wxyz")).all()


@pytest.mark.parametrize(
    "result", [(math.nan, 0.0, 0.0), (0.0, math.inf, 0.0), (0.0, 0.0), None, "much"], ids=str
)
def test_what_is_no_torque_is_refused_with_the_effects_name(result):
    effect = UserTorque("odd one", lambda t, q, w: result, size=0.03)
    made = scene(effect, rate=RATE, elapsed=SECONDS, tolerance=1e-8)
    with pytest.raises(InputError, match=r"effect 'odd one'.*three finite numbers"):
        made.run()


@pytest.mark.parametrize("tolerance", [1e-8, 1e-3])
@pytest.mark.parametrize("elapsed", [(0.0, 300.0), (0.0, 100.0, 201.0), (0.0, -50.0, 300.0)], ids=str)
def test_nan_of_a_compiled_function_stops_with_a_clear_error(elapsed, tolerance):
    """Nobody can say more than that the torque was not a number; but never an answer with nan in it, nor
    with what was in memory.  The nan comes later than the turns in which steps are tried."""
    effect = UserTorque("stop", compiled=compiled_stop, size=0.03)
    made = scene(effect, rate=RATE, elapsed=elapsed, tolerance=tolerance)
    with pytest.raises(AttitudeError, match="not finite"):
        made.run()


def test_ctypes_function_is_taken():
    library_type = ctypes.CFUNCTYPE(
        None,
        ctypes.c_double,
        ctypes.POINTER(ctypes.c_double),
        ctypes.POINTER(ctypes.c_double),
        ctypes.POINTER(ctypes.c_double),
    )

    @library_type
    def constant(t, attitude, rate, torque):
        torque[0], torque[1], torque[2] = T

    more = {"rate": RATE, "elapsed": SECONDS, "tolerance": 1e-8}
    mine = scene(UserTorque("mine", compiled=constant, size=0.03), **more).run()
    theirs = scene(UserTorque("mine", compiled=compiled_constant, size=0.03), **more).run()
    assert mine.quaternion("wxyz").tobytes() == theirs.quaternion("wxyz").tobytes()
