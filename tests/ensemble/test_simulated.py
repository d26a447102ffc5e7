"""Bodies under the effects of a scene, together: each against its own scene, and in whatever company."""

import pickle
from dataclasses import replace
from itertools import pairwise
from threading import Timer
from types import SimpleNamespace

import numpy as np
import pytest

from attitude import InputError, RegimeError, RigidBody, Scene, ToleranceError
from attitude.dynamics import error_estimate, integration
from attitude.dynamics.step_selection import Candidate
from attitude.effects import UserTorque
from attitude.ensemble.block_motion import is_free
from attitude.ensemble.effects_simulation import SolverChoice, choose, simulated
from attitude.frames.rotations import angle_between
from attitude.stopping import Stop, Stopped, stoppable
from attitude.times.instants import as_instants
from tests.effects.scenes import DOCUMENT, KEPLER, effect, quantity, scene

T = np.linspace(0.0, 900.0, 16)
AROUND = {"orbit": KEPLER}
CYLINDER = {"body": {"moments": [3.0, 3.0, 0.8], "unit": "kg m2"}}


def part(states, first, last):
    return SimpleNamespace(
        body=states.body[first:last],
        attitude=states.attitude[first:last],
        angular_velocity=states.angular_velocity[first:last],
    )


def dispersed(made, n, spread=0.02, seed=5):
    """Bodies about a scene's own, some with full tensors."""
    rng = np.random.default_rng(seed)
    tensor, rate = np.array(made.body.build().tensor), made.angular_velocity.build()
    noise = rng.normal(size=(n, 3, 3)).clip(-2.0, 2.0) * spread * np.trace(tensor) / 10.0
    attitude = made.attitude.build() + spread * rng.normal(size=(n, 4))
    return SimpleNamespace(
        body=RigidBody(tensor + noise + noise.swapaxes(1, 2)),
        attitude=attitude / np.linalg.norm(attitude, axis=1)[:, None],
        angular_velocity=rate + spread * np.linalg.norm(rate) * rng.normal(size=(n, 3)),
    )


def alone(made, states, i, t):
    """What `Scene.run` gives of one of the bodies."""
    body = {"tensor": np.array(states.body.tensor[i]).tolist(), "unit": "kg m2"}
    if made.body.mass is not None:
        body["mass"] = quantity(made.body.mass.si, "kg")
    changes = {
        "body": body,
        "attitude": {"quaternion": states.attitude[i].tolist(), "order": "wxyz"},
        "angular_velocity": quantity(states.angular_velocity[i].tolist(), "rad/s"),
        "times": {"elapsed": t.tolist(), "unit": "s"},
    }
    document = {name: getattr(made, name) for name in made.model_fields_set} | changes
    return Scene(
        **{**made.model_dump(exclude={"effects"}, exclude_unset=True, by_alias=True), **changes},
        effects=document["effects"],
    ).run()


def agree(made, n=5, t=T, states=None, within=1.0):
    """Every body's attitudes are those of its own scene, within both tolerances."""
    states = dispersed(made, n) if states is None else states
    at = as_instants(t, None)
    quaternion, rate = simulated(made, states, at, choose(made, at))
    for i in range(n):
        run = alone(made, states, i, t)
        assert (
            angle_between(run.quaternion("wxyz"), quaternion[i]).max() < 2.0 * within * made.asked_tolerance
        )
        scale = np.linalg.norm(run.angular_velocity, axis=1).max()
        assert np.abs(run.angular_velocity - rate[i]).max() < 1e-7 * scale


# -- each effect, against the scene of each body ----------------------------------------------------------

FIRING = effect("impulse", time=quantity(300, "s"))
SWITCHED = effect("constant_torque", start=quantity(200, "s"), stop=quantity(500, "s"))
CASES = {
    "gravity gradient": ([effect("gravity_gradient")], {}),
    "gravity gradient, cylinder": ([effect("gravity_gradient")], CYLINDER),
    "eddies and a dipole": ([effect("eddy_damping"), effect("magnetic_dipole")], {}),
    "eddies of a tensor": (
        [effect("eddy_damping", coefficient=None, tensor=[[2e-2, 1e-3, 0], [1e-3, 1e-2, 0], [0, 0, 3e-2]])],
        {},
    ),
    "wheels": ([effect("wheels", momentum=quantity([0.02, -0.01, 0.05], "N m s"))], {}),
    "sink": ([effect("dissipation")], {}),
    "sink and wheels": (
        [effect("dissipation"), effect("wheels", momentum=quantity([0.02, 0, 0.05], "N m s"))],
        {},
    ),
    "torque for a while, and an impulse": ([SWITCHED, FIRING], {}),
    "sunlight and shadow": ([effect("solar_pressure")], {"tolerance": quantity(1e-7, "rad")}),
    "drag": ([effect("drag")], {"tolerance": quantity(1e-7, "rad")}),
}


@pytest.mark.parametrize("name", CASES)
def test_each_body_moves_as_in_a_scene_of_its_own(name):
    effects, changes = CASES[name]
    effects = [{key: value for key, value in one.items() if value is not None} for one in effects]
    agree(scene(*effects, **changes), n=4, t=T)


def test_instants_before_the_epoch():
    agree(
        scene(
            effect("gravity_gradient"), FIRING, times={"start": -600, "stop": 600, "count": 3, "unit": "s"}
        ),
        t=np.array([400.0, -500.0, 0.0, -20.0, 300.0]),
    )


def test_impulses_alone_are_the_closed_form_between_them():
    firings = [
        {"time": quantity(at, "s"), "frame": frame, "angular_impulse": quantity(impulse, "N m s")}
        for at, frame, impulse in (
            (100, "body", [0, 0.05, 0.01]),
            (-50, "inertial", [0.02, 0, 0]),
            (100, "inertial", [0, 0, 0.03]),
        )
    ]
    made = scene(
        {"type": "impulse", "firings": firings},
        times={"start": -100, "stop": 900, "count": 3, "unit": "s"},
        tolerance=quantity(1e-12, "rad"),
    )
    agree(made, t=np.array([-80.0, -50.0, 0.0, 99.0, 100.0, 640.0]))
    assert choose(made, as_instants(T, None)).candidate is None


def test_bodies_over_ground_bounce_as_each_does():
    made = scene(effect("uniform_gravity"), effect("ground"))
    agree(made, n=4, t=np.linspace(0.0, 0.45, 12))


def test_effect_that_moves_the_centre_of_mass_alone_leaves_free_rotation():
    made = scene(effect("uniform_gravity"))
    assert is_free(made)
    assert not is_free(scene(FIRING))
    agree(made)


class Sideways(type(scene(effect("wheels")).effects[0])):
    """Rotors whose momentum is along the axis of the greatest moment, whichever that is."""

    def rows(self, initial_state):
        from attitude.kernels.layout import EffectCode, EffectRow

        out = np.zeros((1, EffectRow.WIDTH))
        out[0, 0] = EffectCode.WHEELS
        out[0, 1 + int(np.argmax(initial_state.moments))] = 0.03
        return out


def test_torque_of_ones_own_that_looks_at_the_moments():
    made = scene(Sideways(**effect("wheels", momentum=quantity([0, 0, 0.03], "N m s"))))
    states = dispersed(made, 4)
    order = np.array([[0, 1, 2], [2, 0, 1], [1, 2, 0], [0, 1, 2]])
    tensors = np.stack([np.array(states.body.tensor[i])[np.ix_(order[i], order[i])] for i in range(4)])
    states.body = RigidBody(tensors)
    agree(made, n=4, states=states)


def test_function_of_the_users():
    def push(t, q, w):
        return [1e-5 * np.sin(0.01 * t), 0.0, -1e-5]

    made = scene(UserTorque("push", push, size=2e-5), tolerance=quantity(1e-6, "rad"))
    agree(made, n=2, t=T[:3])


def test_what_a_function_of_the_users_raises_is_raised():
    def push(t, q, w):
        raise KeyError("nothing here")

    made, at = scene(UserTorque("push", push, size=2e-5)), as_instants(T, None)
    with pytest.raises(KeyError, match="nothing here"):
        choose(made, at)
    choice = choose(scene(UserTorque("push", lambda t, q, w: [0.0, 0.0, 1e-6], size=2e-5)), at)
    with pytest.raises(KeyError, match="nothing here"):
        simulated(made, dispersed(made, 2), at, replace(choice, key="another"))


# -- company ----------------------------------------------------------------------------------------------


def settings_seen(monkeypatch):
    """Steps of every integration, as they are made; and bodies that are solved alone."""
    seen, single = [], []
    integrate, solve_alone = error_estimate.integrate, integration.solve_alone
    monkeypatch.setattr(error_estimate, "integrate", lambda *a: seen.append(a[3].step) or integrate(*a))
    monkeypatch.setattr(integration, "solve_alone", lambda *a: single.append(a[1]) or solve_alone(*a))
    return seen, single


def stepped(choice, factor):
    """The choice, in steps longer by a factor."""
    step, dense_step = factor * choice.candidate.step, factor * choice.candidate.dense_step
    return replace(choice, candidate=replace(choice.candidate, step=step, dense_step=dense_step))


@pytest.mark.parametrize("factor", [1.0, 8, 25.0])
def test_bits_do_not_depend_on_the_company(factor, monkeypatch):
    """Also of those that are integrated again in steps of their own, or solved alone."""
    made = scene(
        effect("gravity_gradient"),
        effect("wheels", momentum=quantity([0, 0.01, 0.02], "N m s")),
    )
    at, states = as_instants(4.0 * T[:6], None), dispersed(made, 9, spread=0.1)
    chosen = choose(made, at)
    choice = stepped(chosen, factor)
    seen, single = settings_seen(monkeypatch)
    whole = simulated(made, states, at, choice)
    if factor > 1.0:
        assert single or any(len(np.unique(settings)) > 1 for settings in seen)
    for cuts in ((0, 1, 2, 3, 4, 5, 6, 7, 8, 9), (0, 4, 9)):
        pieces = [simulated(made, part(states, a, b), at, choice, a) for a, b in pairwise(cuts)]
        for one, other in zip(whole, zip(*pieces, strict=True), strict=True):
            assert np.array_equal(one, np.concatenate(other))


@pytest.mark.parametrize("factor", [4.0, 40.0])
def test_steps_that_are_too_long_are_made_shorter(factor, monkeypatch):
    made = scene(effect("gravity_gradient"))
    at, states = as_instants(T, None), dispersed(made, 4)
    chosen = choose(made, at)
    fine, _ = simulated(made, states, at, stepped(chosen, 0.3))
    seen, _ = settings_seen(monkeypatch)
    coarse, _ = simulated(made, states, at, stepped(chosen, factor))
    assert min(settings.min() for settings in seen) < factor * chosen.candidate.step
    assert angle_between(fine, coarse).max() < 2.0 * made.asked_tolerance


def test_blocks_within_do_not_show(monkeypatch):
    made = scene(effect("gravity_gradient"), FIRING)
    at, states = as_instants(T, None), dispersed(made, 7)
    choice = choose(made, at)
    whole = simulated(made, states, at, choice)
    monkeypatch.setattr(integration, "MAX_NUMBERS_PER_BLOCK", 2 * T.size * 10)
    for one, other in zip(whole, simulated(made, states, at, choice), strict=True):
        assert np.array_equal(one, other)


PUSHED = effect("impulse", time=quantity(0.2, "s"), frame="inertial")
TURNED = effect("impulse", time=quantity(0.3, "s"), frame="body")


@pytest.mark.parametrize(
    "effects", [[PUSHED, TURNED], [effect("uniform_gravity"), effect("ground")], [effect("uniform_gravity")]]
)
def test_bits_of_closed_forms_do_not_depend_on_the_company(effects):
    made, at = scene(*effects), as_instants(np.linspace(0.0, 0.45, 7), None)
    states, choice = dispersed(made, 20), choose(made, at)
    whole = simulated(made, states, at, choice)
    pieces = [simulated(made, part(states, a, a + 1), at, choice, a) for a in range(20)]
    for one, other in zip(whole, zip(*pieces, strict=True), strict=True):
        assert np.array_equal(one, np.concatenate(other))


# -- the choice -------------------------------------------------------------------------------------------


def test_choice_is_small_and_the_same_after_a_journey():
    made, at = scene(effect("gravity_gradient")), as_instants(T, None)
    choice = choose(made, at)
    assert len(pickle.dumps(choice)) < 1000
    other = pickle.loads(pickle.dumps(choice))
    states = dispersed(made, 3)
    one = simulated(made, states, at, choice)
    again = simulated(pickle.loads(pickle.dumps(made)), states, at, replace(other, key="in another process"))
    assert np.array_equal(one[0], again[0])
    assert np.array_equal(one[1], again[1])


def test_choice_by_a_few_of_the_bodies_is_for_bodies_like_them():
    """A scene's own body may be symmetric, and long steps good for it, but none of the dispersed ones is."""
    long = {"start": 0, "stop": 10, "count": 11, "unit": "h"}  # steps are parts of the span otherwise
    made = scene(effect("gravity_gradient"), **CYLINDER, tolerance=quantity(1e-5, "rad"), times=long)
    at = as_instants(10.0 * T, None)
    own, theirs = choose(made, at), choose(made, at, part(dispersed(made, 3), 0, 3))
    assert own.candidate.step > 1.2 * theirs.candidate.step


def test_scene_longer_than_the_instants_keeps_its_effects():
    """An impulse after the last instant is no error, and changes nothing."""
    late = effect("impulse", time=quantity(5000, "s"))
    made, at = scene(effect("gravity_gradient"), late), as_instants(T, None)
    without = scene(effect("gravity_gradient"))
    states = dispersed(made, 2)
    one, _ = simulated(made, states, at, choose(made, at))
    other, _ = simulated(without, states, at, choose(without, at))
    assert angle_between(one, other).max() < 1e-9


# -- errors -----------------------------------------------------------------------------------------------


def test_body_that_cannot_be_followed_is_named():
    made = scene(effect("gravity_gradient"), tolerance=quantity(1e-12, "rad"))
    at, states = as_instants(T, None), dispersed(made, 4)
    choice = choose(made, at)
    states.angular_velocity[2] *= 300.0  # rounding of 1e4 rad is more than is asked for
    with pytest.raises(ToleranceError, match=r"^bodies\[42\]: tolerance: 1.0e-12 rad cannot be reached"):
        simulated(made, states, at, choice, first=40)


def test_body_too_fast_for_its_sink_is_named():
    made = scene(effect("dissipation"))
    at, states = as_instants(T, None), dispersed(made, 4)
    choice = choose(made, at)
    states.angular_velocity[3] *= 1e3
    with pytest.raises(InputError, match=r"^bodies\[13\].dissipation: a coefficient so small"):
        simulated(made, states, at, choice, first=10)


def test_body_that_comes_to_rest_before_the_last_instant_is_named():
    made = scene(effect("uniform_gravity"), effect("ground"))
    at = as_instants(np.linspace(0.0, 60.0, 13), None)
    with pytest.raises(RegimeError, match=r"^bodies\[7\]: times: the body comes to rest on the ground at"):
        simulated(made, dispersed(made, 2), at, choose(made, at), first=7)


def test_body_in_the_ground_is_named():
    upright = {"quaternion": [1, 0, 0, 0], "order": "wxyz"}
    lying = {"position": quantity([0, 0, 0.6], "m"), "attitude": upright}
    made = scene(effect("uniform_gravity"), effect("ground"), **lying)
    at, states = as_instants(np.linspace(0.0, 0.01, 2), None), dispersed(made, 3)
    states.attitude[1] = np.cos(0.4), np.sin(0.4), 0.0, 0.0  # an edge of the cube down
    with pytest.raises(InputError, match=r"^bodies\[1\].position: a body above the ground"):
        simulated(made, states, at, choose(made, at))


def test_effects_outside_the_span_of_scene_and_instants_are_refused_as_in_scenes():
    made = scene(effect("impulse", time=quantity(7000, "s")), effect("gravity_gradient"))
    with pytest.raises(InputError, match=r"effects\[0\].time"):
        choose(made, as_instants(T, None))
    assert choose(made, as_instants(np.array([0.0, 8000.0]), None)).stop == 8000.0


def test_document_is_not_changed():
    made = scene(effect("gravity_gradient"))
    before = made.to_json()
    choose(made, as_instants(T, None))
    assert made.to_json() == before
    assert DOCUMENT["times"]["stop"] == 6000


def test_what_nobody_waits_for_is_stopped():
    made = scene(effect("gravity_gradient"))
    at, states = as_instants(np.linspace(0.0, 1e7, 3), None), dispersed(made, 3)
    choice = SolverChoice(Candidate(0.5), 0.0, 1e7)  # minutes of work
    stop = Stop()
    timer = Timer(0.3, stop.set)
    timer.start()
    with pytest.raises(Stopped), stoppable(stop):
        simulated(made, states, at, choice)
    timer.join()
