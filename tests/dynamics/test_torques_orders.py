"""How the solver's error falls with the step and with the torque, and where it ends."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from attitude import TorqueFreeMotion
from attitude.effects import UserTorque
from attitude.kernels.layout import EffectCode
from tests.dynamics.motions import Rows, angle, initial_state, integrate_arc, kepler
from tests.dynamics.scenes import scene as users_scene

RATE, ATTITUDE = np.array([0.3, -0.5, 0.6]), (0.1, -0.7, 0.5, 0.5)
SYMMETRIC, TRIAXIAL = (2.0, 2.0, 1.2), (2.0, 3.0, 4.0)
BODIES = {"symmetric": SYMMETRIC, "triaxial": TRIAXIAL}
SPAN = 12.0  # s, ten radians
FINE = 1.0  # s, steps of less than a radian


def body(moments):
    return initial_state(moments, RATE, ATTITUDE)


def pushed(moments, share, kind=EffectCode.CONSTANT_BODY):
    """A torque of that share of L^2 / I."""
    L = np.linalg.norm(np.array(moments) * RATE)
    return (Rows(kind, share * L * L / max(moments) * np.array([0.6, -0.48, 0.64])),)


def errors(moments, torques, divisions, span):
    """rad, after the span in so many steps, against short steps."""

    def end(step):
        return integrate_arc(body(moments), torques, step, [span])[0][:4]

    truth = end(FINE)
    return np.array([angle(end(span / n), truth) for n in divisions])


@pytest.mark.parametrize("kind", [EffectCode.CONSTANT_BODY, EffectCode.CONSTANT_INERTIAL])
def test_error_falls_with_at_least_the_sixteenth_power_of_the_step(kind):
    """Steps of six to ten radians, and a torque that changes the spin: from 1e-5 to 1e-12."""
    divisions = np.array([5, 8, 11])
    found = errors(TRIAXIAL, pushed(TRIAXIAL, 0.03, kind), divisions, 5.0 * SPAN)
    assert found[0] > 1e-9
    for (coarse, fine), (n, m) in zip(pairwise(found), pairwise(divisions), strict=True):
        assert fine < max(coarse * (n / m) ** 16, 2e-14)


def test_error_is_proportional_to_the_torque():
    """Torques of 1e-4, 1e-7 and 1e-10 of L^2/I on a symmetric body, in steps of 25 radians."""
    shares = (1e-4, 1e-7, 1e-10)
    found = [errors(SYMMETRIC, pushed(SYMMETRIC, share), [3], 7.5 * SPAN)[0] for share in shares]
    assert found[0] > 1e-9
    for greater, smaller in pairwise(found):
        assert smaller == pytest.approx(1e-3 * greater, rel=0.1)


@pytest.mark.parametrize("moments", BODIES.values(), ids=BODIES)
def test_forward_and_back_returns_to_the_start(moments):
    """The same steps backwards: time-symmetric, so that only rounding is left."""
    start, torques = body(moments), pushed(moments, 0.05)
    there, _ = integrate_arc(start, torques, 3.0, [SPAN])
    state = there[:4, 0], there[7:, 0]
    back, _ = integrate_arc(start, torques, 3.0, [0.0], state=state, start=SPAN, stop=0.0)
    assert angle(there[:4], start.attitude[:, None]) > 0.1
    assert angle(back[:4], start.attitude[:, None]) < 2e-14
    assert np.abs(back[4:7, 0] - RATE).max() < 2e-14


@pytest.mark.parametrize("share", [0.0, 1e-30, 1e-17])
@pytest.mark.parametrize("moments", [*BODIES.values(), (1.2, 2.0, 2.0), (1.0, 1.6, 1.6000001)])
def test_without_torque_the_solver_gives_the_closed_form(moments, share):
    start, t = body(moments), np.linspace(0.0, 15.0, 16)
    rows, _ = integrate_arc(start, pushed(moments, share) if share else (), 3.0, t)
    free = TorqueFreeMotion(start.body, start.attitude, RATE, order="wxyz").at(t)
    assert angle(rows[:4], free.quaternion("wxyz").T) < 1e-14
    assert np.abs(rows[4:7] - free.angular_velocity.T).max() < 1e-14


@pytest.mark.parametrize("moments", [TRIAXIAL, (1.0, 1.01, 1.9)], ids=["triaxial", "nearly symmetric"])
def test_rounding_of_an_unsymmetric_body_stays_below_its_estimate_over_thousands_of_steps(moments):
    """Free rotation over 3e4 rad against the closed form: the attitude is in two parts between steps."""
    start, stop = body(moments), 3.6e4
    rows, work = integrate_arc(start, (), 3.0, [stop])
    free = TorqueFreeMotion(start.body, start.attitude, RATE, order="wxyz").at(np.array([stop]))
    turned = stop * np.linalg.norm(RATE)
    assert work.steps[0] == 12000
    assert angle(rows[:4], free.quaternion("wxyz").T) < 7e-17 * turned * np.sqrt(work.steps[0])


@pytest.mark.parametrize("dense", [False, True], ids=["by shortened steps", "by polynomials"])
@pytest.mark.parametrize("moments", BODIES.values(), ids=BODIES)
def test_instants_change_no_step_and_are_as_good_as_steps(moments, dense):
    start = initial_state(moments, RATE, ATTITUDE, orbit_path=kepler(4.0, 10.0, 0.3, 0.5))
    torques = (Rows(EffectCode.GRAVITY_GRADIENT, 4.0), *pushed(moments, 1e-3))
    t = np.sort(np.random.default_rng(5).uniform(0.0, SPAN, 40))
    step = 0.5 if dense else 1.5
    alone, few = integrate_arc(start, torques, step, [SPAN])
    read, many = integrate_arc(start, torques, step, [*t, SPAN], dense=dense)
    assert read[:, -1].tobytes() == alone[:, 0].tobytes()
    assert many.steps == few.steps
    truth, _ = integrate_arc(start, torques, FINE, t)
    assert angle(read[:4, :-1], truth[:4]) < 2e-13
    assert np.abs(read[4:7, :-1] - truth[4:7]).max() < 2e-13
    assert np.abs(read[7:, :-1] - truth[7:]).max() < 2e-13


def test_polynomials_within_a_step_are_off_by_less_the_shorter_it_is():
    start, torques, stop = body(TRIAXIAL), pushed(TRIAXIAL, 0.05), 5.0 * SPAN
    t = np.linspace(0.0, stop, 41)[1:-1]
    truth, _ = integrate_arc(start, torques, FINE, t)
    off = []
    for step in (6.0, 4.0, 3.0):
        rows, _ = integrate_arc(start, torques, step, t, stop=stop, dense=True)
        off.append(angle(rows[:4], truth[:4]))
    assert off[0] > 1e-8
    for coarse, fine in pairwise(off):
        assert fine < 0.03 * coarse


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_step_that_meets_a_break_is_halved_down_to_it(tolerance):
    """A torque that sets in when an axis passes a plane: edges that no solver is told of."""
    made = broken(tolerance).run()
    truth = broken_truth()
    error = angle(made.quaternion("wxyz").T, truth.quaternion("wxyz").T)
    assert error <= made.plan.error_bound + truth.plan.error_bound
    assert made.plan.error_bound <= tolerance


@cache
def broken_truth():
    return broken(1e-13).run()


def broken(tolerance):
    def breaking(t, attitude, rate):
        return max(0.0, float(attitude[0] * attitude[1])) * np.array([0.02, -0.01, 0.03])

    more = {"rate": (0.3, -0.5, 0.4), "elapsed": np.linspace(0.0, 20.0, 5), "tolerance": tolerance}
    return users_scene(UserTorque("breaking", breaking, size=0.04), **more)
