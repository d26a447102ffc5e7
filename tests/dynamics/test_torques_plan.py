"""What a plan says of torques, what is dropped, and what cannot be given."""

import math
import re
import warnings
from time import perf_counter, process_time

import numpy as np
import pytest

from attitude import AttitudeWarning, InputError, Scene, ToleranceError
from attitude.dynamics import solver_cost
from attitude.dynamics.step_selection import MAX_RADIANS
from tests.dynamics.motions import angle
from tests.dynamics.scenes import MOMENTS, orbit, quantity, scene
from tests.dynamics.test_torques_effects import MU

RATE = (0.03, -0.05, 0.04)
T = np.linspace(0.0, 600.0, 7)


def constant(value, **more):
    return {"type": "constant_torque", "torque": quantity(value, "N m"), "frame": "body", **more}


# Sizes


def test_plan_gives_the_size_of_a_torque_in_the_ways_that_matter():
    """0.001 N m: over L^2 / I_max; s to turn I_min at rest by 1e-9 rad, sqrt(2 I / T 1e-9); T / 2 I t^2."""
    made = scene(constant([1e-3, 0, 0]), rate=RATE, elapsed=T, tolerance=1e-9)
    (told,) = made.plan().effects
    L = math.sqrt(sum((i * w) ** 2 for i, w in zip(MOMENTS, RATE, strict=True)))
    assert told.simulated
    assert told.field == "effects[0]"
    assert told.torque == pytest.approx(1e-3, rel=1e-15)
    assert told.relative_torque == pytest.approx(1e-3 * 17.0 / L**2, rel=1e-14)
    assert told.seconds_to_tolerance == pytest.approx(math.sqrt(2.0 * 10.0 * 1e-9 / 1e-3), rel=1e-14)
    assert told.influence == pytest.approx(0.5 * 1e-3 / 10.0 * 600.0**2, rel=1e-14)


@pytest.mark.parametrize(
    ("effect", "size"),
    [
        (constant([3e-3, 4e-3, 0]), 5e-3),
        # 3/2 mu / r^3 (17 - 10)
        ({"type": "gravity_gradient"}, 1.5 * MU / 7e6**3 * 7.0),
        # m B at the pole of a dipole in its plane: at most twice 2.262e-5 T
        (
            {
                "type": "magnetic_dipole",
                "dipole": quantity([0, 3, 4], "A m2"),
                "field": {"strength": quantity(3e-5, "T"), "radius": quantity(6371.2, "km")},
            },
            5.0 * 3e-5 * (6371.2 / 7000.0) ** 3,
        ),
    ],
    ids=["constant", "gravity gradient", "dipole over the equator"],
)
def test_size_of_a_torque_is_what_it_reaches_at_most(effect, size):
    more = {} if effect["type"] == "constant_torque" else {"orbit": orbit()}
    (told,) = scene(effect, rate=RATE, elapsed=T, **more).plan().effects
    assert told.torque == pytest.approx(size, rel=1e-9)


def test_plan_names_every_effect_and_the_solver_that_runs():
    made = scene(
        {"type": "gravity_gradient"},
        {"type": "uniform_gravity", "acceleration": quantity([0, 0, -9.81], "m/s2")},
        {
            "type": "impulse",
            "time": quantity(5, "s"),
            "angular_impulse": quantity([0, 0.1, 0], "N m s"),
            "frame": "body",
        },
        constant([0, 0, 0]),
        {"type": "eddy_damping", "coefficient": 1e-3, "unit": "N m s"},
        rate=RATE,
        elapsed=T,
        orbit=orbit(),
        tolerance=1e-8,
    )
    plan = made.plan()
    assert [(told.type, told.simulated, told.acts_on) for told in plan.effects] == [
        ("gravity_gradient", True, "attitude"),
        ("uniform_gravity", False, "translation"),
        ("impulse", True, "instants"),
        ("constant_torque", False, "attitude"),
        ("eddy_damping", True, "attitude"),
    ]
    run = made.run()
    assert run.plan.solver.startswith(plan.solver)
    assert plan.predicted_error <= plan.tolerance == 1e-8
    assert run.plan.error_bound <= 1e-8
    assert [name for name, *_ in plan.candidates] == ["gauss, order 32"]
    text = plan.text()
    for told in plan.effects:
        assert " ".join(told.reason.split()) in " ".join(text.split())
    assert plan.solver in text


@pytest.mark.parametrize("solver", ["splitting", "dop853"])
def test_solver_that_left_is_named_in_a_warning_and_gauss_runs(solver):
    asked = {"rate": RATE, "elapsed": T, "tolerance": 1e-8}
    with pytest.warns(FutureWarning, match=f"solver: {solver} is no longer offered; gauss"):
        made = scene(constant([1e-3, 2e-3, 0]), **asked, solver=solver)
    other = scene(constant([1e-3, 2e-3, 0]), **asked, solver="gauss").run()
    run = made.run()
    assert run.plan.solver == other.plan.solver
    assert run.quaternion("wxyz").tobytes() == other.quaternion("wxyz").tobytes()


def test_plan_is_the_same_each_time():
    made = scene({"type": "gravity_gradient"}, rate=RATE, elapsed=T, orbit=orbit())
    assert made.plan() == made.plan()
    one, other = made.run(), made.run()
    assert one.quaternion("wxyz").tobytes() == other.quaternion("wxyz").tobytes()


# Time

SLOW = (0.02, 0.01, 0.003)


def spun_up(torque, span):
    """A body that turns slowly at first, and that a torque fixed in it spins up."""
    elapsed = np.linspace(0.0, span, 5)
    return scene(
        constant([0.01 * torque, torque, 0]), rate=(0.02, 0.01, 0.003), elapsed=elapsed, tolerance=1e-6
    )


def test_time_of_a_body_that_is_spun_up_follows_from_the_steps_it_takes():
    made = spun_up(2.0, 7200.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AttitudeWarning)
        steps, sweeps = (int(n) for n in re.findall(r"(\d+) (?:steps|sweeps)", made.run().plan.solver))
    assert steps > 100 * 7200.0 * np.linalg.norm(SLOW) / MAX_RADIANS[True]
    taken = solver_cost.of_steps(steps, sweeps, 1)
    assert 0.5 * taken < made.plan().predicted_seconds < 2.0 * taken


def test_plan_of_a_motion_that_takes_minutes_takes_seconds():
    made, begun = spun_up(1e10, 60.0), process_time()
    plan = made.plan()
    assert process_time() - begun < 5.0
    assert plan.predicted_seconds > 300.0
    assert plan.tolerance_span is not None


def test_plan_of_a_spin_without_a_bound_ends():
    """Eddies far backwards: the rate grows by a factor e each 1,000 s, and its bound is no double."""
    eddies = {"type": "eddy_damping", "coefficient": 1e-2, "unit": "N m s"}
    made = scene(eddies, constant([1e-6, 0, 1e-6]), rate=SLOW, elapsed=np.linspace(-1e7, 0.0, 5))
    begun = process_time()
    assert made.plan().predicted_error > 1e-9
    assert process_time() - begun < 5.0


# Dropping


def test_torques_below_the_threshold_are_dropped_and_the_others_not():
    """Influence at most 1.8e-6 rad and 1.8e-2 rad over the span."""
    small, great = constant([1e-10, 0, 0]), constant([0, 1e-6, 0])
    made = scene(small, great, rate=RATE, elapsed=T, tolerance=1e-9)
    assert all(told.simulated for told in made.plan().effects)
    dropped = made.plan(drop_below=1e-5).effects
    assert [told.simulated for told in dropped] == [False, True]
    assert "as asked, less than 1.0e-05 rad" in dropped[0].reason
    alone = scene(great, rate=RATE, elapsed=T, tolerance=1e-9).run()
    run = made.run(drop_below=1e-5)
    assert run.quaternion("wxyz").tobytes() == alone.quaternion("wxyz").tobytes()
    # what was left out mattered less than was said
    whole = made.run()
    apart = angle(whole.quaternion("wxyz").T, run.quaternion("wxyz").T)
    assert 1e-8 < apart < dropped[0].influence < 1e-5


PUSHED = {"type": "impulse", "time": quantity(5.0, "s"), "frame": "body"} | {
    "angular_impulse": quantity([0.0, 10.0, 0.0], "N m s")
}
# A spin about the middle axis from the epoch on; after an impulse; and one that goes back in time.
UNSTABLE = {
    "free": ((1e-6, 0.7, 1e-6), [], np.linspace(0.0, 200.0, 201)),
    "after an impulse": ((1e-6, 0.0, 1e-6), [PUSHED], np.linspace(0.0, 200.0, 201)),
    "backwards": ((1e-6, 0.7, 1e-6), [], np.linspace(-200.0, 0.0, 201)),
}


@pytest.mark.parametrize(("rate", "others", "elapsed"), UNSTABLE.values(), ids=UNSTABLE)
def test_a_torque_that_an_unstable_motion_multiplies_is_not_dropped(rate, others, elapsed):
    """At rest it would turn the body by 2.8e-7 rad; here by 0.08 rad and more."""
    made = scene(constant([1e-10, 0, 1e-10]), *others, rate=rate, elapsed=elapsed, tolerance=1e-5)
    alone = scene(*others, rate=rate, elapsed=elapsed).run()
    whole, run = made.run(), made.run(drop_below=1e-5)
    assert angle(whole.quaternion("wxyz").T, alone.quaternion("wxyz").T) > 1e-2
    assert made.plan(drop_below=1e-5).effects[0].influence < 1e-5
    assert run.plan.left_out == ()
    assert run.quaternion("wxyz").tobytes() == whole.quaternion("wxyz").tobytes()


def test_all_torques_dropped_leave_the_closed_form_to_the_bit():
    free = scene(rate=RATE, elapsed=T).run()
    run = scene(constant([1e-10, 0, 0]), rate=RATE, elapsed=T).run(drop_below=1e-5)
    assert run.quaternion("wxyz").tobytes() == free.quaternion("wxyz").tobytes()
    assert run.plan.solver == free.plan.solver


def test_nothing_is_dropped_by_default():
    tiny = scene(constant([1e-30, 0, 0]), rate=RATE, elapsed=T)
    assert tiny.plan().effects[0].simulated
    assert tiny.run().plan.solver != scene(rate=RATE, elapsed=T).run().plan.solver


def test_influence_is_never_below_what_leaving_out_changes():
    """For bodies that turn slowly, where a torque has most of its effect."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        torque = rng.normal(size=3) * 10.0 ** rng.uniform(-9, -6)
        rate = rng.normal(size=3) * 10.0 ** rng.uniform(-6, -3)
        made = scene(constant(torque.tolist()), rate=rate.tolist(), elapsed=T, tolerance=1e-9)
        (told,) = made.plan().effects
        apart = angle(
            made.run().quaternion("wxyz").T, scene(rate=rate.tolist(), elapsed=T).run().quaternion("wxyz").T
        )
        assert apart <= told.influence * (1.0 + 1e-6)


# What double precision cannot give


TUMBLING = {"moments": (45.0, 22.0, 50.0), "rate": (1e-3, -8e-4, 6e-5)}
LONG = np.linspace(0.0, 450000.0, 100)


def tumbling(elapsed, tolerance):
    """A body that the gravity gradient makes tumble: 1e-16 grows to a radian within sixty orbits."""
    gravity, around = {"type": "gravity_gradient"}, orbit(7.9e6)
    return scene(gravity, **TUMBLING, elapsed=elapsed, orbit=around, tolerance=tolerance)


def test_chaotic_motion_is_given_with_the_instant_from_which_it_cannot_be_followed():
    made = tumbling(LONG.tolist(), 1e-7)
    with pytest.warns(AttitudeWarning, match=r"tolerance: 1\.0e-07 rad is kept up to .* s from the epoch"):
        run = made.run()
    assert run.plan.error_bound > 1e-3
    start, until = run.plan.tolerance_span
    assert start == 0.0
    assert 20000.0 < until < 400000.0
    (exceeded,) = [event for event in run.events if event.kind == "tolerance exceeded"]
    assert exceeded.seconds == until
    # up to there, less the time in which errors grow e-fold, it is what a shorter span gives within the
    # tolerance: two estimates of one chaotic motion differ by some times
    early = LONG[until - 9300.0 >= LONG]
    other = tumbling(early.tolist(), 1e-7).run()
    assert other.plan.tolerance_span is None
    apart = angle(run.quaternion("wxyz").T[:, : early.size], other.quaternion("wxyz").T)
    assert apart <= 1e-7 + other.plan.error_bound


@pytest.mark.parametrize("elapsed", [[-450000.0, 0.0], [-450000.0, 0.0, 450000.0]], ids=["backwards", "both"])
def test_tolerance_is_kept_on_either_side_of_the_epoch(elapsed):
    instants = np.linspace(elapsed[0], elapsed[-1], 100).tolist()
    with pytest.warns(AttitudeWarning, match="is kept up to"):
        start, stop = tumbling(instants, 1e-7).run().plan.tolerance_span
    assert -450000.0 < start < -20000.0
    assert (stop > 20000.0) == (elapsed[-1] > 0.0)


def test_tolerance_that_holds_at_no_instant_is_refused_with_what_there_is():
    made = scene(constant([1e-3, 0, 0]), rate=(3.0, -5.0, 4.0), elapsed=[0.0, 1500.0], tolerance=1e-13)
    with pytest.raises(
        ToleranceError, match=r"under constant_torque: the least there is about (.*) rad"
    ) as refused:
        made.run()
    least = float(str(refused.value).split("about ")[1].split(" rad")[0])
    assert 1e-13 < least < 1e-10
    assert Scene.model_validate({**made.document(), "tolerance": "best"}).run().plan.error_bound < 3 * least


def test_best_answer_is_given_with_its_estimate_and_the_instant_from_which_it_is_worse():
    document = tumbling(LONG.tolist(), 1e-7).document()
    best = Scene.model_validate({**document, "tolerance": "best"})
    run = best.run()
    assert run.plan.error_bound > 1e-3
    until = float(run.plan.bound_source.split("within 1e-09 rad up to ")[1].split(" s")[0])
    early = LONG[until >= LONG]
    other = tumbling(early.tolist(), 1e-9).run()
    apart = angle(run.quaternion("wxyz").T[:, : early.size], other.quaternion("wxyz").T)
    assert early.size > 5
    assert apart <= 1e-9 + other.plan.error_bound
    assert best.document()["tolerance"] == "best"


def test_best_answer_of_a_tame_motion_is_known_to_the_rounding_of_two_solutions():
    made = scene(constant([1e-3, 0, 0]), rate=RATE, elapsed=T, tolerance=1e-9)
    best = Scene.model_validate({**made.document(), "tolerance": "best"}).run()
    # thrice what the turn of its momentum makes over 76 rad, 7e-14 at most, and 5e-14 of rounding
    assert best.plan.error_bound < 2.5e-13
    assert angle(best.quaternion("wxyz").T, made.run().quaternion("wxyz").T) < 1e-9


@pytest.mark.parametrize("span", [86400.0, 30 * 86400.0])
def test_best_answer_is_given_for_a_body_at_rest_for_long(span):
    gravity, around, still = {"type": "gravity_gradient"}, orbit(7.9e6), (0.0, 0.0, 0.0)
    made = scene(gravity, rate=still, elapsed=[0.0, 0.3 * span, span], orbit=around, tolerance=1e-9)
    best = Scene.model_validate({**made.document(), "tolerance": "best"}).run()
    assert 0.0 < best.plan.error_bound < np.inf
    assert "within 1e-09 rad up to" in best.plan.bound_source


@pytest.mark.parametrize("moments", [MOMENTS, (12.0, 12.0, 7.0)], ids=["triaxial", "symmetric"])
def test_fast_spin_over_a_long_span_is_not_known_to_1e13(moments):
    """1e4 rad in doubles: rates are good to 1e-16 of that."""
    made = scene(
        constant([1e-3, 0, 0]),
        moments=moments,
        rate=(3.0, -5.0, 4.0),
        elapsed=[0.0, 1500.0],
        tolerance=1e-13,
    )
    begun = process_time()
    with pytest.raises(ToleranceError, match="cannot be reached over this span in double precision"):
        made.run()
    assert process_time() - begun < 0.2


@pytest.mark.parametrize("tolerance", [1e-14, 0.1, 0.0, -1e-9])
def test_tolerance_out_of_reach_is_refused_in_the_document(tolerance):
    with pytest.raises(InputError, match=r"tolerance.*from 1e-13 rad .* to 0.01 rad"):
        scene(constant([1e-3, 0, 0]), rate=RATE, elapsed=T, tolerance=tolerance)


# What no plan can be made of


def test_motion_that_no_steps_can_follow_is_refused_before_long():
    """A wheel that makes the body nutate at 1e11 rad/s."""
    wheel = {"type": "wheels", "momentum": quantity([0, -8e12, 0], "N m s")}
    made = scene(wheel, rate=RATE, elapsed=T, solver="gauss")  # it would be exact
    begun = perf_counter()
    with pytest.raises(ToleranceError, match="cannot be reached over this span in double precision"):
        made.run()
    assert perf_counter() - begun < 20.0  # of which most is compiling, where that is still to do


@pytest.mark.parametrize("stop", [0.0, 5e-324, 1e-320, 1e-300])
@pytest.mark.parametrize("name", ["envisat", "gravity-gradient-capture", "drop"])
def test_span_of_no_length_is_planned_and_simulated(name, stop):
    times = {"start": 0, "stop": stop, "count": 50 if stop else 1, "unit": "s"}
    made = Scene.load({"scene": name, "times": times})
    plan = made.plan()
    assert 0.0 <= plan.predicted_seconds < 1.0
    assert np.isfinite(made.run().quaternion("wxyz")).all()
    assert 0.0 <= plan.predicted_error < 1e-12
