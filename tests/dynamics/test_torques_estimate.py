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
from tests.dynamics.test_torques_effects import orbit, plate, quantity

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
    document = {
        "body": {"moments": inertia.tolist(), "unit": "kg m2"},
        "frame": "INERTIAL",
        "attitude": {"quaternion": (q / np.linalg.norm(q)).tolist(), "order": "wxyz"},
        "angular_velocity": quantity(rate.tolist(), "rad/s"),
        "times": {
            "start": 0,
            "stop": turns * 2 * np.pi / np.linalg.norm(rate),
            "count": SAMPLES,
            "unit": "s",
        },
        "effects": acting,
        "tolerance": quantity(tolerance, "rad"),
    }
    return Scene.model_validate(document | ({} if around is None else {"orbit": around}))


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


# Two scenes in which both solutions began with the same rounding, of nothing and of rotors: the body, the
# span, the impulse and the other effects, and the attitude at the far end by Taylor series in 80-bit numbers.
FROM_REST = {
    "under gravity gradient": (
        [240.5687676462961, 360.85315146944413, 481.1375352925922],
        [-0.38134465641601584, -0.7388418069964076, -0.007178605700345994, -0.5555515321528987],
        (-36823.49542792791, -6534.865918862946),
        [-2.8560534787234086e-06, -2.745877659122237e-06, 2.7609214888580737e-06],
        [
            {
                "type": "constant_torque",
                "torque": quantity(
                    [2.4535557999528013e-09, 2.1121965869198992e-09, -3.5830521311522776e-09], "N m"
                ),
                "frame": "body",
            },
            {"type": "gravity_gradient"},
        ],
        [0.5683053254365426, -0.7926456916272302, -0.2207547819661428, -0.0030316438339800375],
    ),
    "with rotors": (
        [2.4141418857203694, 1.4484851314322216, 2.4141418857203694],
        [-0.0430537855055506, 0.7953664023179023, 0.4314388856953469, -0.4235553630016697],
        (-35350.5246124776, -920.8365232992073),
        [0.00021423294693321908, -0.000620975580221616, -7.568231265392077e-06],
        [
            {
                "type": "wheels",
                "momentum": quantity(
                    [0.011432610094920002, -0.006079435121920006, 0.01306472713826869], "N m s"
                ),
            }
        ],
        [0.05559523143237876, -0.7986781579020502, -0.2909588908273516, 0.523798906242353],
    ),
}


@pytest.mark.filterwarnings("ignore:tolerance")
@pytest.mark.parametrize("name", FROM_REST)
def test_estimate_of_a_body_at_rest_sees_the_rounding_of_what_turns_it(name):
    body, attitude, (start, time), angular, effects, expected = FROM_REST[name]
    kick = {
        "type": "impulse",
        "time": quantity(time, "s"),
        "frame": "inertial",
        "angular_impulse": quantity(angular, "N m s"),
    }
    document = {
        "body": {"moments": body, "unit": "kg m2"},
        "frame": "INERTIAL",
        "attitude": {"quaternion": attitude, "order": "wxyz"},
        "angular_velocity": quantity([0.0, 0.0, 0.0], "rad/s"),
        "times": {"start": start, "stop": 0.0, "count": 41, "unit": "s"},
        "effects": [*effects, kick],
        "orbit": {
            "semi_major_axis": quantity(8351877.160132577, "m"),
            "eccentricity": 0.0,
            "inclination": quantity(2.7065114350214903, "rad"),
            "raan": quantity(-2.7254117640435243, "rad"),
            "argument_of_pericentre": quantity(1.911862152783776, "rad"),
            "mean_anomaly": quantity(-2.553733663802584, "rad"),
            "mu": quantity(3.986004418e14, "m3/s2"),
            "radius": quantity(6378137.0, "m"),
        },
        "tolerance": quantity(1.9034234882537907e-11, "rad"),
    }
    run = Scene.model_validate(document).run()
    error = angle(run.quaternion("wxyz").T[:, :1], np.array(expected)[:, None])
    assert 1e-14 < error < run.plan.error_bound < 1e-9


# Two scenes whose estimate did not see rounding: the change at the epoch was across that which the motion
# multiplies, beside a separatrix and by a gravity gradient.  Attitudes at the far end by Taylor series in
# 80-bit numbers.
MULTIPLIED = {
    "beside a separatrix": {
        "body": {"moments": [12.077898605912017, 27.767088894991726, 15.701268187685622], "unit": "kg m2"},
        "attitude": [0.49662509314481224, 0.002326198515869393, -0.848885941425829, -0.18097172184889898],
        "angular_velocity": [0.05614452633752898, 0.0202915778257382, -0.012891284236421482],
        "times": {"start": -472.2759581236795, "stop": 0.0, "count": 41, "unit": "s"},
        "effects": [
            {"type": "dissipation", "coefficient": quantity(1.3613176638673338e-06, "1/(N m s)")},
            {
                "type": "magnetic_dipole",
                "dipole": quantity(
                    [-0.005055960407766904, -0.01514764758657764, -0.01610127070436089], "A m2"
                ),
                "field": {
                    "strength": quantity(3e-05, "T"),
                    "radius": quantity(6371200.0, "m"),
                    "tilt": quantity(0.0532403966780551, "rad"),
                    "longitude": quantity(-2.9795801700404185, "rad"),
                    "rotation": quantity(7.292115e-05, "rad/s"),
                },
            },
        ],
        "orbit": (19782687.58780899, 0.5878589698167708, 2.787508124400394),
        "angles": (0.9263707022178429, -1.254092210500076, 1.939801971147018),
        "tolerance": 6.433519284712741e-12,
        "expected": [-0.044823687138063215, 0.04660477799501918, -0.1865592414041479, -0.9803134606778042],
    },
    "under gravity gradient": {
        "body": {"moments": [233.19335304365694, 412.3934758825902, 179.37950234127456], "unit": "kg m2"},
        "attitude": [0.6268002610151728, -0.39209191270908733, 0.13403876710263563, -0.6598628446071548],
        "angular_velocity": [-0.0009392673046374181, 9.462890271787565e-05, -0.0006228284517864036],
        "times": {"start": 0.0, "stop": 34447.44952232742, "count": 5, "unit": "s"},
        "effects": [
            {
                "type": "constant_torque",
                "torque": quantity(
                    [-3.6987256186022348e-09, -5.898190301132456e-10, -2.3439000328639932e-08], "N m"
                ),
                "frame": "body",
            },
            {"type": "gravity_gradient"},
        ],
        "orbit": (8259128.521130409, 0.0, 0.2594521812568966),
        "angles": (-1.6961412137459297, 0.8272147381829464, 1.3536153695415223),
        "tolerance": 2.8653637806143325e-12,
        "expected": [-0.1805293695359351, -0.2903070122025653, -0.05754061736214689, -0.9379872401874987],
    },
}


@pytest.mark.filterwarnings("ignore:tolerance")
@pytest.mark.parametrize("name", MULTIPLIED)
def test_estimate_sees_rounding_that_the_motion_multiplies_a_thousandfold(name):
    document = dict(MULTIPLIED[name])
    a, eccentricity, inclination = document["orbit"]
    raan, argument, anomaly = document.pop("angles")
    expected = np.array(document.pop("expected"))[:, None]
    run = Scene.model_validate(
        document
        | {
            "frame": "INERTIAL",
            "attitude": {"quaternion": document["attitude"], "order": "wxyz"},
            "angular_velocity": quantity(document["angular_velocity"], "rad/s"),
            "orbit": {
                "semi_major_axis": quantity(a, "m"),
                "eccentricity": eccentricity,
                "inclination": quantity(inclination, "rad"),
                "raan": quantity(raan, "rad"),
                "argument_of_pericentre": quantity(argument, "rad"),
                "mean_anomaly": quantity(anomaly, "rad"),
                "mu": quantity(3.986004418e14, "m3/s2"),
                "radius": quantity(6378137.0, "m"),
            },
            "tolerance": quantity(document["tolerance"], "rad"),
        }
    ).run()
    far = int(np.abs(run.elapsed).argmax())
    error = angle(run.quaternion("wxyz").T[:, [far]], expected)
    assert 1e-13 < 3.0 * error < run.plan.error_bound < 1e-10


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
