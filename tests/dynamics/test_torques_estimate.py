"""The error that an answer says it may have, against the error it has."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from attitude import RigidBody, Scene, ToleranceError, TorqueFreeMotion
from attitude.dynamics.arc_integration import ALONG_AND_ACROSS, integrate, rounding
from attitude.dynamics.batch_states import Bodies, TorqueProblem
from attitude.dynamics.solver import StepSetting
from attitude.scene.simulation import resolve
from tests.dynamics.motions import angle
from tests.dynamics.scenes import orbit, plate, quantity, scene
from tests.tables import table

# In steps of half a radian, as finely as doubles allow (every kind of torque is held to fifty digits or SciPy
# elsewhere): what that is off by after these turns.
TRUTH = 1e-12
LOOSEST = 5000.0  # an estimate above the error; most are within a hundred
SAMPLES = 9


def moments(rng, symmetric):
    """Of 1 to 10, or 1000 times that, kg m2, in any order, no flat body."""
    while True:
        found = np.sort(rng.uniform(1.0, 10.0, 3))
        if symmetric:
            found[1] = found[0] if rng.random() < 0.5 else found[2]
        if found[2] < 0.98 * (found[0] + found[1]):
            return rng.permutation(found) * 10.0 ** rng.uniform(0, 3)


def effects(rng, kind, size):
    """(effects, orbit or none); size : N m, of what is not gravity."""
    around = orbit(
        9e6, inclination=quantity(rng.uniform(0, 90), "deg"), mean_anomaly=quantity(rng.uniform(-3, 3), "rad")
    )
    if kind == "gravity gradient":
        return [{"type": "gravity_gradient"}], around
    if kind == "eccentric orbit":
        return [{"type": "gravity_gradient"}], around | {"eccentricity": rng.uniform(0.05, 0.25)}
    if kind == "constant torque":
        direction = rng.normal(size=3)
        torque = (size * direction / np.linalg.norm(direction)).tolist()
        frame = "body" if rng.random() < 0.5 else "inertial"
        return [{"type": "constant_torque", "torque": quantity(torque, "N m"), "frame": frame}], None
    plates = [
        plate(rng.uniform(0.5, 2), rng.normal(size=3).tolist(), rng.normal(size=3).tolist()) for _ in range(3)
    ]
    return [{"type": "drag", "plates": plates, "density": quantity(size / 6.6e3**2, "kg/m3")}], around


def random_scene(rng, kind, symmetric, tolerance, turns):
    inertia, rate, q = moments(rng, symmetric), rng.normal(size=3), rng.normal(size=4)
    rate *= 10.0 ** rng.uniform(-2, -1) / np.linalg.norm(rate)
    energy = np.linalg.norm(inertia * rate) ** 2 / inertia.max()
    acting, around = effects(rng, kind, energy * 10.0 ** rng.uniform(-5, -2))
    stop = turns * 2 * np.pi / np.linalg.norm(rate)
    return scene(
        *acting,
        moments=inertia.tolist(),
        rate=rate.tolist(),
        tolerance=tolerance,
        q=(q / np.linalg.norm(q)).tolist(),
        times={"start": 0, "stop": stop, "count": SAMPLES, "unit": "s"},
        **({} if around is None else {"orbit": around}),
    )


def truth(made):
    """(4, n), in short steps; in short arcs, which are counted in radians, where there are plates."""
    way = resolve(made)
    problem, seconds = (
        TorqueProblem(way.initial_state, way.torques, way.kicks),
        made.times.build(None).seconds,
    )
    at = np.array([seconds, np.zeros_like(seconds)])
    has_plates = any(effect.type == "drag" for effect in made.effects)
    step = 0.3 if has_plates else 0.5 / np.linalg.norm(way.initial_state.rate)
    return integrate(problem, problem.body, at, StepSetting(np.array([step]), np.array([1e-15]))).rows[0, :4]


def told_and_true(made):
    run = made.run()
    return run.plan.error_bound, angle(run.quaternion("wxyz").T, truth(made))


@pytest.mark.parametrize("kind", ["gravity gradient", "eccentric orbit", "constant torque"])
def test_estimate_is_not_below_the_error_nor_far_above(kind):
    """Sixteen bodies each, symmetric and not, of five to forty turns, at tolerances from 1e-5 to 1e-9 rad."""
    rng = np.random.default_rng([40, *kind.encode()])
    ratios = []
    for i in range(16):
        tolerance, turns = 10.0 ** -rng.integers(5, 10), rng.uniform(5, 40)
        told, true = told_and_true(random_scene(rng, kind, i % 2 == 0, tolerance, turns))
        assert told <= tolerance
        assert true <= told + TRUTH
        ratios.append(told / max(true, TRUTH))
    assert max(ratios) < LOOSEST
    assert np.median(ratios) < 300.0


def test_estimate_holds_where_plates_turn_out_of_the_flow():
    """In arcs that end at the edges of the plates."""
    rng = np.random.default_rng(41)
    ratios = []
    for i in range(16):
        made = random_scene(rng, "drag", i % 2 == 0, 10.0 ** -rng.integers(4, 10), rng.uniform(3, 10))
        told, true = told_and_true(made)
        assert told <= made.asked_tolerance
        assert true <= told + TRUTH
        ratios.append(told / max(true, TRUTH))
    assert np.median(ratios) < 300.0


def test_rounding_is_in_the_estimate():
    """A triaxial body over 1e4 rad: what is told is more than the part of 1e-16 that is lost each step."""
    run = random_scene(np.random.default_rng(42), "constant torque", False, 1e-6, 1500.0).run()
    assert 1e-16 * 1500.0 * 2.0 * np.pi < run.plan.error_bound <= 1e-6


def test_refusal_is_not_for_falling_a_little_short_at_the_first_attempt():
    """Tolerances down to 1e-10 rad for tame motions of some turns: always reached."""
    rng = np.random.default_rng(43)
    for i in range(30):
        kind = ("gravity gradient", "eccentric orbit", "constant torque")[i % 3]
        made = random_scene(rng, kind, i % 2 == 0, 10.0 ** -rng.integers(7, 11), rng.uniform(3, 40))
        try:
            assert made.run().plan.error_bound <= made.asked_tolerance
        except ToleranceError as error:
            pytest.fail(f"scene {i}: {error}")


@pytest.mark.parametrize("stop", [6.0, 7.0, 7.5, 8.0, 9.0])
def test_span_of_few_steps_is_refined_until_there_are_more_of_them(stop):
    """A setting that is a little finer may make the same two or three steps, and fail in the same way."""
    torque = {"value": [0.01, -0.02, 0.03], "unit": "N m"}
    document = {
        "body": {"moments": [1.0, 1.6, 2.1], "unit": "kg m2"},
        "attitude": {"quaternion": [0.1, -0.7, 0.5, 0.5], "order": "wxyz"},
        "angular_velocity": {"value": [0.3, -0.5, 0.9], "unit": "rad/s"},
        "effects": [{"type": "constant_torque", "torque": torque, "frame": "body"}],
        "times": {"elapsed": [stop], "unit": "s"},
    }
    found = Scene.model_validate(document).run()
    exact = Scene.model_validate({**document, "tolerance": {"value": 1e-12, "unit": "rad"}})
    q, p = (each.quaternion("xyzw")[0] for each in (found, exact.run()))
    assert (Rotation.from_quat(q) * Rotation.from_quat(p).inv()).magnitude() < found.plan.error_bound <= 1e-9


# Scenes whose estimate did not see rounding: both solutions began with the same rounding, of nothing and of
# rotors; or the change at the epoch was across that which the motion multiplies, beside a separatrix and by a
# gravity gradient.  Attitudes at the far end by Taylor series in 80-bit numbers.
ROUNDED = table("rounding_scenes")


@pytest.mark.filterwarnings("ignore:tolerance")
@pytest.mark.parametrize("name", ROUNDED)
def test_estimate_sees_rounding_of_the_state_at_the_epoch_and_what_the_motion_makes_of_it(name):
    case = ROUNDED[name]
    run = Scene.model_validate(case["scene"]).run()
    far = int(np.abs(run.elapsed).argmax())
    error = angle(run.quaternion("wxyz").T[:, far], case["expected"])
    assert case["least"] < case["factor"] * error < run.plan.error_bound < case["most"]


def random_states(count=200):
    """(moments, rate), beside the middle axis and beside the separatrix."""
    rng, found = np.random.default_rng(50), []
    for _ in range(count):
        a, b, c = inertia = np.sort(moments(rng, symmetric=False))
        aside, rate = 10.0 ** rng.uniform(-8, -1) * rng.normal(size=3), rng.normal(size=3)
        found.append((inertia, np.array([0.0, 1.0, 0.0]) + aside))
        rate[0] = np.sqrt(c * (c - b) / (a * (b - a))) * rate[2] + 10.0 ** rng.uniform(-8, -2)
        found.append((inertia, rate))
    return found


SPINS = [
    ([1.0, 1.5, 2.0], [0.0, 1.0, 0.0]),
    ([1.0, 1.5, 2.0], [1.0, 0.0, 0.0]),
    ([1.0, 1.5, 2.0], [0.3, -0.5, 0.4]),
    ([12.08, 27.77, 15.7], [0.05614452633752898, 0.0202915778257382, -0.012891284236421482]),
    ([1.0, 1.0, 0.6], [0.3, 0.2, -0.5]),
    ([1.0, 1.0, 1.0], [1.0, 0.0, 0.0]),
]


def test_change_at_the_epoch_is_a_fair_part_of_what_the_motion_multiplies_most():
    """Of free motions, over 5 to 40 rad: by their partial derivatives in closed form."""
    rng, shares = np.random.default_rng(51), []
    for inertia, rate in [*SPINS, *random_states()]:
        body, rate = RigidBody(inertia), np.array(rate)
        bodies = Bodies(body.broadcast_to((1,)), np.array([[1.0, 0.0, 0.0, 0.0]]), rate[None])
        (change,) = rounding(bodies, np.zeros(3), ALONG_AND_ACROSS, np.ones(1))
        t = np.linspace(0.0, rng.uniform(5.0, 40.0) / np.linalg.norm(rate), 31)
        motion = TorqueFreeMotion(body, [1.0, 0.0, 0.0, 0.0], rate, order="wxyz")
        grown = motion.partials(t).matrix[:, :3, 3:6] / np.array(inertia)
        worst = np.linalg.norm(change) * np.linalg.norm(grown, 2, axis=(1, 2)).max()
        shares.append(np.linalg.norm(grown @ change, axis=1).max() / worst)
    assert min(shares) > 0.3
    assert np.median(shares) > 0.5
