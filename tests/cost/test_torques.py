"""Cost under torques: truths that agree, methods that converge to them, errors as they were put in."""

import json

import numpy as np
import pytest

from attitude import InputError, Scene
from attitude.cli import command
from attitude.cost import AbsentError, InitialValueProblem, Method, measure, plot, torque_truth
from attitude.cost.methods import UNDER_TORQUES, select_methods
from attitude.cost.report import Report
from attitude.effects import UserTorque
from attitude.oracle import truth
from tests.effects.scenes import effect, quantity, scene

SPAN = 400.0  # s: fifteen radians of the scenes' body
TIMES = {"start": 0, "stop": SPAN, "count": 5, "unit": "s"}
# weak enough for the body to turn as it did
WEAK = {
    "constant_torque": {"torque": quantity([0.3, -0.2, 0.1], "mN m")},
    "gravity_gradient": {},
    "eddy_damping": {"coefficient": 0.001},
    "dissipation": {"coefficient": quantity(0.05, "1/(N m s)")},
    "wheels": {"momentum": quantity([0.1, 0.05, -0.08], "N m s")},
    "magnetic_dipole": {},
}
# What is left where a plate comes to face the wind, within a step; smooth torques leave 1e-14.
THROUGH_EDGES = 1e-11
SWITCHED = {"start": quantity(100, "s"), "stop": quantity(250.5, "s")}


def under(*names, times=TIMES, **changes):
    effects = [effect(name, **WEAK.get(name, {})) for name in names]
    return scene(*effects, times=times, **changes)


def problem(*names, **changes):
    return InitialValueProblem.of_scene(under(*names, **changes))


def answers(answer, instants):
    attitudes, rates = answer
    assert attitudes.shape == (instants.size, 4)
    assert rates.shape == (instants.size, 3)
    return attitudes.tolist(), rates


def apart(answer, attitudes, rates):
    """Largest angle, rad, and difference of rates over the largest rate."""
    q, w = answer
    angle = max(truth.attitude_error(a, b) for a, b in zip(q, attitudes, strict=True))
    return angle, float(np.abs(w - rates).max() / np.abs(rates).max())


def method(name, setting):
    return next(each for each in select_methods([name], UNDER_TORQUES) if each.setting == setting)


def test_closed_form_is_a_method_where_rotors_act_alone(exact):
    posed, attitudes, rates = exact(["wheels"])
    angle, _ = apart(answers(method("exact", "").prepare(posed)(GRID), GRID), attitudes, rates)
    assert angle < 4e-15
    with pytest.raises(AbsentError, match="no closed form"):
        method("exact", "").prepare(problem("wheels", "gravity_gradient"))


# -- truth ----------------------------------------------------------------------------------------

GRID = np.linspace(0.0, SPAN, 5)
BY_ORACLE = [["wheels"], ["gravity_gradient"], [*WEAK]]


@pytest.fixture(scope="module")
def exact():
    """By the oracle, of each scene once: (problem, attitudes, rates)."""
    known = {}

    def of(names):
        key = tuple(names)
        if key not in known:
            posed = problem(*names)
            assert torque_truth.is_known(posed.environment)
            known[key] = (posed, *torque_truth.by_oracle(posed, GRID)[:2])
        return known[key]

    return of


@pytest.mark.parametrize("names", BY_ORACLE, ids="+".join)
def test_extrapolation_and_oracle_share_nothing_and_agree(names, exact):
    posed, attitudes, rates = exact(names)
    q, w, route, off = torque_truth.by_extrapolation(posed, GRID)
    angle, rate = apart((q, w), attitudes, rates)
    assert route == "extrapolation in doubles"
    assert angle < 2e-14
    assert rate < 2e-14
    assert off < 1e-13


ELSEWISE = {
    "sunlight": ["solar_pressure"],
    "drag": ["drag"],
    "switched": [],
}


@pytest.mark.parametrize("name", ELSEWISE)
def test_truth_without_oracle_is_what_the_librarys_own_formulas_give(name):
    effects = [effect("constant_torque", **WEAK["constant_torque"], **SWITCHED)] if name == "switched" else []
    effects += [effect(each) for each in ELSEWISE[name]]
    posed = InitialValueProblem.of_scene(scene(*effects, times=TIMES))
    assert not torque_truth.is_known(posed.environment)
    attitudes, rates, _, off = torque_truth.by_extrapolation(posed, GRID)
    if name == "drag":  # the run itself, whose arcs end at edges of plates; a method's steps are halved there
        run = scene(*effects, times={"elapsed": GRID.tolist(), "unit": "s"}).run()
        ours = answers((run.quaternion("wxyz"), run.angular_velocity), GRID)
    else:
        ours = answers(method("gauss", "2.5 rad").prepare(posed)(GRID), GRID)
    angle, rate = apart(ours, attitudes, rates)
    assert off < 1e-12
    assert max(angle, rate) < THROUGH_EDGES


def test_orbit_by_table_is_followed_by_both():
    t = np.linspace(-100.0, SPAN + 100.0, 101)
    places = 7e6 * np.stack([np.cos(1e-3 * t), np.sin(1e-3 * t), 0.0 * t], axis=1)
    orbit = {
        "times": {"value": t.tolist(), "unit": "s"},
        "positions": {"value": places.tolist(), "unit": "m"},
    }
    posed = problem("gravity_gradient", orbit=orbit)
    assert not torque_truth.is_known(posed.environment)
    attitudes, rates, _, _ = torque_truth.by_extrapolation(posed, GRID)
    ours = answers(method("gauss", "2.5 rad").prepare(posed)(GRID), GRID)
    assert max(apart(ours, attitudes, rates)) < 1e-12
    pytest.importorskip("heyoka")
    with pytest.raises(AbsentError, match="orbits other than Keplerian"):
        method("heyoka", "tol eps").prepare(posed)


# -- methods --------------------------------------------------------------------------------------

# Family, setting: the greatest error that is right, rad, over fifteen radians.
TIGHT = {
    ("automatic", "tol 1e-12"): 1e-12,
    ("gauss", "2.5 rad"): 1e-13,
    ("dop853", "rtol 2.3e-14"): 1e-12,
    ("heyoka", "tol eps"): 1e-13,
}


@pytest.mark.parametrize("names", BY_ORACLE, ids="+".join)
@pytest.mark.parametrize(("name", "setting"), TIGHT, ids=[name for name, _ in TIGHT])
def test_tightest_of_every_family_is_right(name, setting, names, exact):
    if name == "heyoka":
        pytest.importorskip("heyoka")
    posed, attitudes, rates = exact(names)
    angle, _ = apart(answers(method(name, setting).prepare(posed)(GRID), GRID), attitudes, rates)
    assert angle < TIGHT[name, setting]


@pytest.mark.parametrize("name", ["gauss", "dop853"])
def test_finer_settings_are_more_exact(name, exact):
    posed, attitudes, rates = exact(["wheels"])
    families = {}
    for each in select_methods([name], UNDER_TORQUES):
        error, _ = apart(answers(each.prepare(posed)(GRID), GRID), attitudes, rates)
        families.setdefault(each.family, []).append(error)
    for errors in families.values():
        above = [error for error in errors if error > 1e-13]
        assert above == sorted(above, reverse=True)
        assert errors[0] > 10.0 * errors[-1]


@pytest.mark.parametrize("name", ["solar_pressure", "drag"])
def test_heyoka_says_why_it_is_absent(name):
    pytest.importorskip("heyoka")
    with pytest.raises(AbsentError, match=f"cannot integrate {name} here: it is not smooth in time"):
        method("heyoka", "tol eps").prepare(InitialValueProblem.of_scene(scene(effect(name), times=TIMES)))


# -- errors as they were put in -------------------------------------------------------------------


def measured(*methods, **options):
    options = {"budget": 1000.0, "samples": 40, "horizons": (0.1, 1.0)} | options
    return measure(under("gravity_gradient"), methods=methods, **options)


def altered(change):
    """The tight Gauss, its answers changed."""

    def prepare(posed):
        solve = method("gauss", "2.5 rad").prepare(posed)
        return lambda t: change(*solve(t))

    return Method("altered", "", prepare, steps=True)


# -- what is measured -----------------------------------------------------------------------------


def test_horizons_are_parts_of_the_span():
    report = measure(under("gravity_gradient"), methods=["gauss"])
    assert report.horizons == pytest.approx((0.01, 0.1, 1.0))
    assert (report.unit_s, report.unit_name, report.samples) == (SPAN, "spans of the scene", 101)
    assert report.effects == ("gravity_gradient",)
    assert report.truths == ((30, "Taylor, eighteen digits"),) * 3
    assert {cell.status for cell in report.cells} == {"measured"}


def test_no_horizon_is_longer_than_there_is_time_for_its_truth():
    times = {"start": 0, "stop": 1e6, "count": 5, "unit": "s"}
    turning, pushed = problem("gravity_gradient", times=times), problem("constant_torque", times=times)
    reach = torque_truth.reach(turning, 60.0)
    assert reach < 0.1
    assert torque_truth.reach(turning, 30.0) == pytest.approx(0.5 * reach, rel=0.1)
    # a constant torque makes it spin ever faster: few radians by the rate at the epoch, many in truth
    assert torque_truth.reach(pushed, 60.0) < 0.1 * reach
    with pytest.raises(InputError, match=r"horizons: at most 0\.0\d+ spans of the scene, as far as .* truth"):
        measure(under("gravity_gradient", times=times), methods=["gauss"], horizons=(0.01, 1.0))


def test_scene_whose_effects_turn_nothing_is_a_free_body():
    falling = {"position": quantity([0, 0, 2], "m"), "velocity": quantity([0, 0, -1], "m/s")}
    posed = InitialValueProblem.of_scene(scene(effect("uniform_gravity"), times=TIMES, **falling))
    assert posed.environment is None
    assert posed.unit_name == "polhode periods"


IMPULSE = effect("impulse")
REFUSED = {
    "ground": (lambda: scene(effect("ground"), times=TIMES), r"effects\[0\]\.type.*ground"),
    "impulse": (
        lambda: scene(effect("gravity_gradient"), IMPULSE, times=TIMES),
        r"effects\[1\]\.type: effects that act all the time.*got 'impulse'",
    ),
    "user": (lambda: _with_users(), r"effects\[0\]\.type: an effect of the library's own"),
    "backwards": (
        lambda: under("gravity_gradient", times={"start": -100, "stop": 0, "count": 5, "unit": "s"}),
        r"times: instants after the epoch, under torques",
    ),
}


def _with_users():
    made = scene(times=TIMES).model_copy()
    made.effects.append(UserTorque("mine", lambda t, q, w: (0.0, 0.0, 1e-5), size=1e-5))
    return made


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_judged_is_refused_by_name(name):
    make, message = REFUSED[name]
    with pytest.raises(InputError, match=message):
        measure(make(), methods=["gauss"])


def test_families_of_free_bodies_are_none_under_torques():
    with pytest.raises(InputError, match=r"method: one of automatic, gauss, dop853, .*'orekit'"):
        measure(under("gravity_gradient"), methods=["orekit"])
    with pytest.raises(InputError, match=r"method: one of ours, .*'gauss'"):
        measure(scene(times=TIMES), methods=["gauss"])


# -- reports --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def report() -> Report:
    return measure(
        Scene.model_validate(under("drag").document() | {"name": "wind"}),
        methods=["gauss", "automatic", "heyoka"],
        samples=20,
        horizons=(0.1, 0.5),
    )


def test_report_says_what_its_truth_is_worth(report):
    pytest.importorskip("heyoka")
    text = report.table()
    assert text.startswith("wind: drag; long axis regime at the epoch\n")
    assert "against extrapolation in doubles, itself off by about " in text
    assert text.count("heyoka cannot integrate drag here") == 8
    assert 0.0 < report.truth_off_rad < 1e-12
    assert max(map(len, text.splitlines())) <= 110


def test_json_has_effects_only_where_there_are_torques(report):
    document = json.loads(report.to_json())
    assert document["effects"] == ["drag"]
    assert document["truth_off_rad"] == report.truth_off_rad
    free = measure(scene(times=TIMES), methods=["ours"], samples=20, horizons=(1.0,))
    assert "effects" not in json.loads(free.to_json())


def test_every_family_of_a_picture_has_a_look_of_its_own():
    families = {each.family for each in select_methods(None, UNDER_TORQUES)}
    styles = [plot.line_style(number) for number in range(len(families))]
    for part in ("color", "marker", "linestyle"):
        assert len({str(style[part]) for style in styles}) == len(families)


def test_picture_names_every_family_that_was_measured(report):
    text = report.picture("svg").decode()
    assert text.count(">gauss, order 32<") == text.count(">automatic<") == 1
    assert "over 0.5 spans of the scene" in text


def test_command_measures_a_scene_with_torques(tmp_path, capsys):
    path = tmp_path / "scene.json"
    path.write_text(under("gravity_gradient").to_json())
    assert command.main(["cost", str(path), "--method", "gauss", "--samples", "5", "--json", "-", "-q"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert {cell["family"] for cell in document["cells"]} == {"gauss, order 32"}
    assert [cell["status"] for cell in document["cells"]] == ["measured"] * 12
