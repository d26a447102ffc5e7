"""How the error of each solver falls with the step, with the torque, and where it ends."""

from itertools import pairwise

import numpy as np
import pytest

from attitude import TorqueFreeMotion
from attitude.dynamics import schemes
from attitude.dynamics.solvers import SOLVERS, SPLITTINGS
from tests.dynamics.motions import Rows, angle, initial_state, integrate_arc, kepler, layout

RATE, ATTITUDE = np.array([0.3, -0.5, 0.6]), (0.1, -0.7, 0.5, 0.5)
SYMMETRIC, TRIAXIAL = (2.0, 2.0, 1.2), (2.0, 3.0, 4.0)
BODIES = {"symmetric": SYMMETRIC, "triaxial": TRIAXIAL}
SPAN = 12.0  # s, ten radians
GAUSS = SOLVERS["gauss, order 16"]


def body(moments):
    return initial_state(moments, RATE, ATTITUDE)


def pushed(moments, share, kind=layout.CONSTANT_BODY):
    """A torque of that share of L^2 / I."""
    L = np.linalg.norm(np.array(moments) * RATE)
    return (Rows(kind, share * L * L / max(moments) * np.array([0.6, -0.48, 0.64])),)


def end(solver, moments, torques, step, **more):
    return integrate_arc(solver, body(moments), torques, step, [SPAN], **more)


def departure(p, q):
    """(3,) rad: the small rotation from q to p."""
    w = p[0] * q[0] + p[1:] @ q[1:]
    return 2.0 * np.sign(w) * (q[0] * p[1:] - p[0] * q[1:] - np.cross(p[1:], q[1:]))


def errors(solver, moments, torques, divisions):
    """rad, after the span in so many steps, against collocation in steps of a sixteenth of a radian."""
    truth = end(GAUSS, moments, torques, 0.06)[0][:4]
    return np.array([angle(end(solver, moments, torques, SPAN / n)[0][:4], truth) for n in divisions])


def slopes(found, divisions):
    return np.log(found[:-1] / found[1:]) / np.log(np.divide(divisions[1:], divisions[:-1]))


# The order in the step


@pytest.mark.parametrize("moments", BODIES.values(), ids=BODIES)
@pytest.mark.parametrize(
    ("name", "share", "divisions"),
    [
        ("order 2", 1.0, (96, 192, 384)),
        ("order 4", 1.0, (96, 192, 384)),
        ("order 6", 1.0, (48, 96, 192)),
        ("order 8", 1.0, (32, 48, 64)),
        # the part of third power in the torque, which is the last to be left
        ("order (8, 6, 4)", 0.1, (64, 96, 128)),
        ("order (10, 6, 4)", 0.1, (64, 96, 128)),
    ],
)
def test_composition_has_its_order(name, share, divisions, moments):
    order = schemes.COMPOSITIONS[name].order
    found = errors(SOLVERS[f"splitting, {name}"], moments, pushed(moments, share), divisions)
    assert (found > 3e-14).all()
    assert slopes(found, divisions) == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize(
    ("name", "share", "divisions"),
    [
        ("order 2", 1e-6, (12, 24, 48)),
        ("order 4", 1e-6, (12, 24, 36)),
        ("order 6", 1e-6, (6, 8, 12)),
        ("order 8", 1e-4, (4, 6, 8)),
        ("order (8, 6, 4)", 1e-4, (4, 6, 8)),
        ("order (10, 6, 4)", 1e-4, (3, 4, 5)),
    ],
)
def test_part_of_the_error_proportional_to_the_torque_has_the_order_in_front(name, share, divisions):
    """Half the difference between a torque and its opposite: what is of second power in it drops out."""
    solver, found = SOLVERS[f"splitting, {name}"], []
    for n in divisions:
        parts = []
        for sign in (1.0, -1.0):
            torques = pushed(SYMMETRIC, sign * share)
            truth = end(GAUSS, SYMMETRIC, torques, 0.06)[0][:4, 0]
            parts.append(departure(end(solver, SYMMETRIC, torques, SPAN / n)[0][:4, 0], truth))
        found.append(0.5 * np.linalg.norm(parts[0] - parts[1]))
    assert min(found) > 5e-15
    assert slopes(np.array(found), divisions).mean() == pytest.approx(
        schemes.COMPOSITIONS[name].small, rel=0.1
    )


def test_collocation_has_order_sixteen():
    """In few, long steps, half a radian to one: from 1e-7 to 1e-13."""
    divisions = (16, 18, 20, 24)
    for kind in (layout.CONSTANT_BODY, layout.CONSTANT_INERTIAL):
        found = errors(GAUSS, TRIAXIAL, pushed(TRIAXIAL, 1.0, kind), divisions)
        assert (found > 1e-13).all()
        assert slopes(found, divisions).mean() == pytest.approx(16.0, abs=1.0)


@pytest.mark.parametrize("moments", BODIES.values(), ids=BODIES)
def test_error_of_runge_kutta_is_proportional_to_its_tolerance(moments):
    torques = pushed(moments, 0.1)
    truth = end(GAUSS, moments, torques, 0.06)[0][:4]
    tolerances = 10.0 ** -np.arange(8, 15)
    found = [
        angle(end(SOLVERS["dop853"], moments, torques, tolerance)[0][:4], truth) for tolerance in tolerances
    ]
    assert np.polyfit(np.log10(tolerances), np.log10(found), 1)[0] == pytest.approx(1.0, abs=0.05)
    assert (found < 1000.0 * tolerances).all()


# The error and the torque


@pytest.mark.parametrize("solver", [*SPLITTINGS, GAUSS], ids=lambda solver: solver.name)
def test_error_is_proportional_to_the_torque(solver):
    """Torques of 1e-3, 1e-6 and 1e-9 of L^2/I; steps so long that the error of the last is still seen,
    where a double allows: order 2 and 4.  Else until it is rounding."""
    long = {"gauss": 2, "splitting": 6 if solver.order <= 4 else 3}[solver.kind]
    found = [
        angle(
            end(solver, SYMMETRIC, pushed(SYMMETRIC, share), SPAN / long)[0][:4],
            end(GAUSS, SYMMETRIC, pushed(SYMMETRIC, share), 0.06)[0][:4],
        )
        for share in (1e-3, 1e-6, 1e-9)
    ]
    # those of the first power alone; with brackets also of the second: more than a thousandth
    for greater, smaller in pairwise(found):
        assert smaller <= max(2e-3 * greater, 5e-15)
        if smaller > 1e-13 and "(" not in solver.name:
            assert smaller == pytest.approx(1e-3 * greater, rel=0.1)


@pytest.mark.parametrize("solver", SPLITTINGS, ids=lambda solver: solver.name)
def test_error_of_splitting_a_triaxial_body_is_proportional_to_the_torque_too(solver):
    """A thousandth of the torque, a thousandth of the error, or rounding: steps of two radians."""
    found = [
        angle(
            end(solver, TRIAXIAL, pushed(TRIAXIAL, share), 2.0)[0][:4],
            end(GAUSS, TRIAXIAL, pushed(TRIAXIAL, share), 0.06)[0][:4],
        )
        for share in (1e-3, 1e-6, 1e-9)
    ]
    assert found[1] <= max(1.2e-3 * found[0], 2e-14)
    assert found[2] <= max(1.2e-3 * found[1], 2e-14)


# Back again, and without torque


@pytest.mark.parametrize("moments", BODIES.values(), ids=BODIES)
@pytest.mark.parametrize("solver", [*SPLITTINGS, GAUSS], ids=lambda solver: solver.name)
def test_forward_and_back_returns_to_the_start(solver, moments):
    """The same steps backwards: time-symmetric, so that only rounding is left (errors are 1e-3 to 1e-13)."""
    start, torques = body(moments), pushed(moments, 0.05)
    there, _ = integrate_arc(solver, start, torques, 0.5, [SPAN])
    back, _ = integrate_arc(
        solver, start, torques, 0.5, [0.0], state=(there[:4, 0], there[7:, 0]), start=SPAN, stop=0.0
    )
    assert angle(there[:4], start.attitude[:, None]) > 0.1
    # a triaxial body's rate is read off the attitude, whose rounding at every drift it keeps for the span
    within = 5e-14 if moments == TRIAXIAL else 1e-14
    assert angle(back[:4], start.attitude[:, None]) < within
    assert np.abs(back[4:7, 0] - RATE).max() < within


@pytest.mark.parametrize("share", [0.0, 1e-30, 1e-17])
@pytest.mark.parametrize("moments", [*BODIES.values(), (1.2, 2.0, 2.0), (1.0, 1.6, 1.6000001)])
@pytest.mark.parametrize("solver", SOLVERS.values(), ids=SOLVERS)
def test_without_torque_every_solver_gives_the_closed_form(solver, moments, share):
    """Two turns.  Splitting in two steps of many drifts, each exact but for its rounding, which a triaxial
    body remembers.  Runge-Kutta, to which free rotation is nothing special, within its tolerance."""
    start, t = body(moments), np.linspace(0.0, 15.0, 16)
    torques = pushed(moments, share) if share else ()
    setting = {"dop853": 1e-15, "gauss": 1.0, "splitting": 7.5}[solver.kind]
    rows, _ = integrate_arc(solver, start, torques, setting, t)
    free = TorqueFreeMotion(start.body, start.attitude, RATE, order="wxyz").at(t)
    is_symmetric = len(set(moments)) == 2
    within = {"dop853": 5e-14, "gauss": 1e-14, "splitting": 1e-14 if is_symmetric else 2e-14}[solver.kind]
    assert angle(rows[:4], free.quaternion("wxyz").T) < within
    assert np.abs(rows[4:7] - free.angular_velocity.T).max() < within


# Dense output


@pytest.mark.parametrize("moments", BODIES.values(), ids=BODIES)
@pytest.mark.parametrize("solver", SOLVERS.values(), ids=SOLVERS)
def test_dense_output_changes_no_step_and_is_as_good_as_stepping_there(solver, moments):
    start = initial_state(moments, RATE, ATTITUDE, orbit_path=kepler(4.0, 10.0, 0.3, 0.5))
    torques = (Rows(layout.GRAVITY_GRADIENT, 4.0), *pushed(moments, 1e-3))
    setting = 1e-13 if solver.kind == "dop853" else 0.25
    t = np.sort(np.random.default_rng(5).uniform(0.0, SPAN, 40))
    alone, few = integrate_arc(solver, start, torques, setting, [SPAN])
    dense, many = integrate_arc(solver, start, torques, setting, [*t, SPAN])
    assert dense[:, -1].tobytes() == alone[:, 0].tobytes()
    assert many.steps == few.steps
    truth, _ = integrate_arc(GAUSS, start, torques, 0.06, t)
    at_end = angle(alone[:4], integrate_arc(GAUSS, start, torques, 0.06, [SPAN])[0][:4])
    assert angle(dense[:4, :-1], truth[:4]) < 2.0 * at_end + 2e-13
