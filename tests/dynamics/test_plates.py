"""Bodies of plates against an integration that is cut at every edge, and what is said of errors that grow."""

import copy

import numpy as np
import pytest

from attitude import AttitudeWarning, Scene, ToleranceError
from attitude.effects import UserTorque
from tests.dynamics.motions import angle
from tests.dynamics.scenes import quantity
from tests.oracles.plate_motion import PlateMotion

# What SciPy is off by over these spans (in penumbrae 4e-12; no finer arcs of ours are nearer to it).
AGREEMENT = 1e-11


def box(**more):
    """Six plates of 10 by 10 by 34 cm, whose centre is not the centre of mass."""
    half, out = [0.05, 0.05, 0.17], []
    for axis in range(3):
        for sign in (1.0, -1.0):
            normal = np.zeros(3)
            normal[axis] = sign
            centre = normal * half + [-0.003, 0.0, -0.02]
            area = 4.0 * half[(axis + 1) % 3] * half[(axis + 2) % 3]
            plate = {"normal": normal.tolist(), "centre": quantity(centre.tolist(), "m")}
            out.append(plate | {"area": quantity(area, "m2")} | more)
    return out


DRAG = {
    "type": "drag",
    "plates": box(coefficient=2.2),
    "density": quantity(3e-12, "kg/m3"),
    "rotation": quantity(7.2921e-5, "rad/s"),
}
# sunlight on ten times the area, for it to matter beside drag; the shadow begins after 5 minutes
LIGHT = {
    "type": "solar_pressure",
    "plates": [p | {"area": quantity(10 * p["area"]["value"], "m2")} for p in box(specular=0.1, diffuse=0.2)],
    "sun": {"direction": [0.005, -0.62, -0.78]},
    "shadow": "conical",
}
CUBESAT = {
    "body": {"moments": [0.0067, 0.0333, 0.0340], "unit": "kg m2"},
    "frame": "INERTIAL",
    "attitude": {"quaternion": [1, 0, 0, 0], "order": "wxyz"},
    "angular_velocity": quantity([1.0, 0.7, -0.4], "deg/s"),
    "times": {"elapsed": [0, 200, 450], "unit": "s"},
    "orbit": {
        "altitude": quantity(400, "km"),
        "inclination": quantity(51.6, "deg"),
        "mu": quantity(3.986004e14, "m3/s2"),
        "radius": quantity(6378100, "m"),
    },
    "effects": [{"type": "gravity_gradient"}, DRAG, LIGHT],
}
WHEELS = {"type": "wheels", "momentum": quantity([1e-4, -2e-4, 3e-4], "N m s")}
PUSH = {
    "type": "impulse",
    "time": quantity(123.4, "s"),
    "frame": "body",
    "angular_impulse": quantity([2e-5, -1e-5, 1e-4], "N m s"),
}
REST = {"angular_velocity": quantity([0, 0, 0], "deg/s")}
BACKWARDS = {"times": {"elapsed": [0, -200, -450], "unit": "s"}}


def cubesat(*effects, **changes):
    document = copy.deepcopy(CUBESAT) | changes
    return document | {"effects": list(effects or document["effects"])}


def user(t, rate):
    return [1e-8 * np.sin(0.05 * t), -2e-6 * rate[1], 1e-8 * np.cos(0.03 * t)]


CASES = {
    "drag, sunlight and a penumbra": cubesat(),
    "a shadow without penumbra": cubesat(DRAG, LIGHT | {"shadow": "cylindrical"}),
    "no shadow": cubesat(LIGHT | {"shadow": False}),
    "backwards": cubesat(**BACKWARDS),
    "at rest": cubesat(**REST),
    "at rest, backwards": cubesat(DRAG, **REST, **BACKWARDS),
    "twenty degrees a second": cubesat(
        DRAG, angular_velocity=quantity([12, -9, 13], "deg/s"), times={"elapsed": [0, 60], "unit": "s"}
    ),
    "wheels, and an impulse": cubesat(DRAG, WHEELS, PUSH),
    "a needle of a symmetric body": cubesat(DRAG, body={"moments": [0.0004, 0.04, 0.04], "unit": "kg m2"}),
}


def run_and_truth(document, user=None):
    """(ephemeris, truth (n, 4), edges) at the instants after the epoch."""
    scene = Scene.model_validate(document)
    if user is not None:
        torque = UserTorque("pump", lambda t, q, w: user(t, w), size=2e-8)
        scene = scene.model_copy(update={"effects": [*scene.effects, torque]})
    states, edges = PlateMotion(document, user).states(document["times"]["elapsed"][1:])
    return scene.run(), states[:, :4] / np.linalg.norm(states[:, :4], axis=1)[:, None], edges


@pytest.mark.parametrize("name", CASES)
def test_motion_is_that_of_an_integration_cut_at_every_edge(name):
    run, truth, edges = run_and_truth(CASES[name])
    assert edges >= 2
    assert angle(run.quaternion("wxyz")[1:].T, truth.T) < AGREEMENT
    assert run.plan.error_bound < AGREEMENT


@pytest.mark.parametrize("rate", [1e-30, 1e-18, 1e-16])
def test_body_of_plates_nearly_at_rest_moves_as_one_at_rest(rate):
    slow = cubesat(DRAG, angular_velocity=quantity([rate, -0.3 * rate, 0.2 * rate], "deg/s"))
    run, rest = (Scene.model_validate(one).run() for one in (slow, cubesat(DRAG, **REST)))
    apart = angle(run.quaternion("wxyz").T, rest.quaternion("wxyz").T)
    assert apart <= run.plan.error_bound + rest.plan.error_bound < 1e-12


def test_torque_of_the_users_acts_beside_plates():
    run, truth, _ = run_and_truth(cubesat(DRAG), user)
    assert angle(run.quaternion("wxyz")[1:].T, truth.T) < AGREEMENT
    assert run.plan.error_bound < 1e-9


def test_answers_between_edges_do_not_depend_on_the_other_instants():
    few, many = (
        Scene.model_validate(cubesat(times={"elapsed": t, "unit": "s"})).run()
        for t in ([0, 300, 450], np.linspace(0, 450, 901).tolist())
    )
    assert (few.quaternion("wxyz")[1] == many.quaternion("wxyz")[600]).all()
    assert (few.quaternion("wxyz")[2] == many.quaternion("wxyz")[900]).all()


def test_plates_edge_on_for_ever_are_no_endless_work():
    """The Sun along an axis that the body spins about: four of its plates stay edge-on to rounding."""
    light = LIGHT | {"sun": {"direction": [0, 0, 1]}, "shadow": False}
    for rate in ([0, 0, 0], [0, 0, 3]):
        made = cubesat(light, angular_velocity=quantity(rate, "deg/s"), orbit=None, frame="INERTIAL")
        run = Scene.model_validate(made).run()
        assert int(run.plan.solver.split(": ")[1].split(" arcs")[0]) < 200
        assert run.plan.error_bound < AGREEMENT


TUMBLING = cubesat(
    DRAG | {"density": quantity(6e-12, "kg/m3")},
    attitude={"quaternion": [0.5, 0.5, -0.1, 0.7], "order": "wxyz"},
    times={"start": 0, "stop": 86400, "step": 1200, "unit": "s"},
)


def test_error_that_outgrows_the_tolerance_is_said_with_the_instant():
    scene = Scene.model_validate(TUMBLING)
    with pytest.warns(AttitudeWarning, match=r"1\.0e-09 rad is kept up to \d+ s from the epoch"):
        run = scene.run()
    start, stop = run.plan.tolerance_span
    (event,) = (event for event in run.events if event.kind == "tolerance exceeded")
    assert start == 0.0 < stop < 86400
    assert event.seconds == stop
    assert run.plan.error_bound > 1e-3
    # another motion, whose moments differ by their rounding, is as near as said until then, and not
    # afterwards
    moments = [moment * (1.0 + 2e-15) for moment in TUMBLING["body"]["moments"]]
    with pytest.warns(AttitudeWarning):
        other = Scene.model_validate(TUMBLING | {"body": {"moments": moments, "unit": "kg m2"}}).run()
    within = run.elapsed <= stop
    assert angle(run.quaternion("wxyz")[within].T, other.quaternion("wxyz")[within].T) < 1e-8
    assert angle(run.quaternion("wxyz")[-9:].T, other.quaternion("wxyz")[-9:].T) > 1e-6
    plan = scene.plan()
    assert plan.tolerance_span is not None
    assert 0.1 < plan.predicted_error / run.plan.error_bound < 10.0


def test_plan_foretells_the_error_of_a_regular_motion():
    scene = Scene.model_validate(cubesat(times={"start": 0, "stop": 20000, "step": 1000, "unit": "s"}))
    plan, run = scene.plan(), scene.run()
    assert plan.tolerance_span is None is run.plan.tolerance_span
    assert 0.1 < plan.predicted_error / run.plan.error_bound < 10.0


def test_tolerance_below_rounding_is_refused_before_the_work():
    fast = cubesat(DRAG, angular_velocity=quantity([20, 15, -16], "deg/s"), tolerance=quantity(1e-13, "rad"))
    fast |= {"times": {"start": 0, "stop": 864000, "step": 6000, "unit": "s"}}
    with pytest.raises(ToleranceError, match=r"1\.0e-13 rad cannot be reached over this span"):
        Scene.model_validate(fast).run()
