"""The cost report: injected errors are reported as such, and the budget of time is kept."""

import json
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from attitude import AttitudeError, InputError, RigidBody, Scene, TorqueFreeMotion
from attitude.cost import AbsentError, InitialValueProblem, Method, measure, measurement
from attitude.cost.methods import fixed_step, ours, scipy_integrators, select_methods

IDENTITY = (1.0, 0.0, 0.0, 0.0)
TOUTATIS = Scene.builtin("toutatis")
PROBLEM = InitialValueProblem.of_motion(TOUTATIS.motion())
EXACT = ours.methods()[0].prepare(PROBLEM)
ANGLE = 1e-7  # rad: an injected error, far above the 1e-15 of the answers it is injected into


def turned(attitudes, vector):
    """By a rotation vector in the inertial frame."""
    turn = Rotation.from_rotvec(vector) * Rotation.from_quat(attitudes, scalar_first=True)
    return turn.as_quat(scalar_first=True)


def method(name, solve, steps=False):
    return Method(name, "", lambda problem: solve, steps)


def measured(*methods, **options):
    options = {"budget": 1000.0, "samples": 200, "horizons": (1.0, 100.0)} | options
    return measure(TOUTATIS, methods=methods, **options)


def by_name(report, horizon):
    return {cell.family: cell for cell in report.at(horizon)}


# -- errors ---------------------------------------------------------------------------------------


def test_turn_of_the_attitudes_is_reported_as_that_angle():
    momentum = TOUTATIS.motion().angular_momentum
    axis = np.cross(momentum, (1.0, 0.0, 0.0))
    axis /= np.linalg.norm(axis)

    def solve(t):
        attitudes, rates = EXACT(t)
        return -3.0 * turned(attitudes, ANGLE * axis), rates  # sign and length are no error

    for cell in measured(method("turned", solve)).cells:
        assert cell.status == "measured"
        assert cell.attitude_error_rad == pytest.approx(ANGLE, rel=1e-7)
        assert cell.momentum_error == pytest.approx(ANGLE, rel=1e-7)  # it is turned across the momentum
        assert cell.energy_error < 4e-15


def test_error_of_the_rates_is_reported_as_energy_and_momentum():
    def solve(t):
        attitudes, rates = EXACT(t)
        off = rates.copy()
        off[len(t) // 2] *= 1.0 + ANGLE  # one sample in all, which is enough
        return attitudes, off

    for cell in measured(method("fast", solve)).cells:
        assert cell.energy_error == pytest.approx(2 * ANGLE, rel=1e-6)
        assert cell.momentum_error == pytest.approx(ANGLE, rel=1e-6)
        assert cell.attitude_error_rad < 4e-15


def test_error_at_the_last_sample_is_never_overlooked():
    def solve(t):
        attitudes, rates = EXACT(t)
        attitudes = attitudes.copy()
        attitudes[-1] = attitudes[0]
        return attitudes, rates

    assert all(cell.attitude_error_rad > 1e-3 for cell in measured(method("late", solve)).cells)


def test_error_that_grows_with_the_horizon_has_its_exponent():
    def solve(t):
        attitudes, rates = EXACT(t)
        angle = 1e-9 * (t[-1] / PROBLEM.unit) ** 1.5
        return turned(attitudes, (angle, 0.0, 0.0)), rates

    # at 3e6 the attitude is lost (5.2 rad, which is 1.1 the other way), which would spoil the slope
    report = measured(method("drift", solve), horizons=(1.0, 1e2, 1e4, 3e6))
    assert report.growth()[0].error == pytest.approx(1.5, abs=1e-3)


def test_truth_is_the_same_for_the_same_seed():
    def errors(seed):
        return [cell.attitude_error_rad for cell in measured(*ours.methods(), seed=seed).cells]

    assert errors(1) == errors(1) != errors(2)


def test_theta_route_serves_where_taylor_cannot_reach():
    motion = TorqueFreeMotion(RigidBody((3.0, 4.0, 6.0)), IDENTITY, (2.0, 0.7, 1.0), order="wxyz")
    report = measure(motion, methods=["ours"], horizons=(1.0, 1e4), samples=100)
    assert report.regime == "separatrix"
    assert report.unit_name == "turns of the body rate"
    assert report.truths == ((30, "Taylor"), (30, "theta"))
    assert all(cell.attitude_error_rad < 4e-15 for cell in report.cells)


# -- methods --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def tensor_motion():
    turn = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))[0]
    tensor = turn @ np.diag([1.0, 2.0, 2.7]) @ turn.T
    return TorqueFreeMotion(
        RigidBody(0.5 * (tensor + tensor.T)), (0.1, 0.7, -0.5, 0.5), (0.3, -0.4, 0.5), order="wxyz"
    )


@pytest.mark.parametrize("tensor", [False, True], ids=["moments", "tensor"])
def test_runge_kutta_is_of_fourth_order(tensor, tensor_motion):
    steps = [
        Method("RK4", str(count), lambda problem, count=count: fixed_step.prepare(problem, count), True)
        for count in (800, 1600)  # fine enough for interpolation of a lower order to show
    ]
    motion = tensor_motion if tensor else TOUTATIS
    coarse, fine = measure(motion, methods=steps, horizons=(1.0,), samples=300).cells
    assert 14.0 < coarse.attitude_error_rad / fine.attitude_error_rad < 20.0


@pytest.mark.parametrize("tensor", [False, True], ids=["moments", "tensor"])
@pytest.mark.parametrize("family", [scipy_integrators.dop853, scipy_integrators.lsoda])
def test_tighter_tolerance_is_a_smaller_error_at_a_higher_cost(family, tensor, tensor_motion):
    motion = tensor_motion if tensor else TOUTATIS
    errors = [
        cell.attitude_error_rad
        for cell in measure(motion, methods=family(), horizons=(1.0,), samples=300).cells
    ]
    assert errors == sorted(errors, reverse=True)
    assert 1e-7 < errors[0] < 1e-3
    assert 1e-10 < errors[1] < 1e-6
    assert 1e-14 < errors[3] < 1e-11


def test_ours_keeps_its_promise_at_any_horizon(tensor_motion):
    for motion in (TOUTATIS, tensor_motion):
        for cell in measure(motion, methods=["ours"], samples=200).cells:
            assert cell.attitude_error_rad <= 4e-15
            assert cell.energy_error <= 4e-15
            assert cell.momentum_error <= 4e-15


def test_body_at_rest_is_measured_too():
    motion = TorqueFreeMotion(
        RigidBody((1.0, 2.0, 2.5)), (0.1, 0.7, -0.5, 0.5), (0.0, 0.0, 0.0), order="wxyz"
    )
    cells = measure(motion, methods=["ours", "rk4", "dop853"], samples=50, horizons=(1.0, 10.0)).cells
    assert {cell.status for cell in cells} == {"measured"}
    assert max(cell.attitude_error_rad for cell in cells) < 1e-15
    assert {(cell.energy_error, cell.momentum_error) for cell in cells} == {(0.0, 0.0)}


def test_names_select_families_in_any_case_and_one_order():
    families = [each.family for each in select_methods(["LSODA", "ours"])]
    assert families == ["closed form"] + ["LSODA (SciPy)"] * 4
    with pytest.raises(InputError, match=r"method: one of ours, .*; got 'rk5'"):
        select_methods(["rk5"])


# -- what goes wrong ------------------------------------------------------------------------------


def raising(error):
    def solve(_):
        raise error

    return solve


def missing_package(_):
    raise AbsentError("peer is not installed: pip install 'attitude[peers]'")


def poisoned(t):
    attitudes, rates = EXACT(t)
    if t[-1] > 50.0 * PROBLEM.unit:
        attitudes = attitudes.copy()
        attitudes[7] = np.nan
    return attitudes, rates


def lost(t):
    attitudes, rates = EXACT(t)
    return np.broadcast_to(attitudes[0], attitudes.shape), rates


def test_each_misfortune_is_a_row_that_says_so():
    report = measured(
        Method("gone", "", missing_package, steps=True),
        method("raising", raising(ZeroDivisionError("by zero"))),
        method("refused", raising(AttitudeError("no such motion"))),
        method("poisoned", poisoned, steps=True),
        method("short", lambda t: (EXACT(t)[0][1:], EXACT(t)[1])),
        method("lost", lost, steps=True),
        *ours.methods(),
        horizons=(1.0, 100.0, 1e4),
    )
    expected = {
        "gone": [("absent", "peer is not installed: pip install 'attitude[peers]'")] * 3,
        "raising": [("failed", "ZeroDivisionError: by zero")] * 3,
        "refused": [("failed", "no such motion")] * 3,
        "poisoned": [
            ("measured", ""),
            ("failed", f"no finite attitude at 1 of 200 instants, from {700 / 199 * PROBLEM.unit:.6g} s"),
            ("not run", "failed over 100 already"),
        ],
        "short": [("failed", "2 instants")] * 3,
        "lost": [("measured", ""), *[("not run", "attitude lost over 1 already")] * 2],
        "closed form": [("measured", "")] * 3,
    }
    for family, outcomes in expected.items():
        for horizon, (status, detail) in zip(report.horizons, outcomes, strict=True):
            cell = by_name(report, horizon)[family]
            assert cell.status == status
            assert detail in cell.detail
            assert (cell.attitude_error_rad is None) == (status != "measured")


# -- budget ---------------------------------------------------------------------------------------


class Clock:
    """Time that passes only where a method says so."""

    now = 0.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(measurement, "perf_counter", clock)
    return clock


def slow(clock, name, seconds, steps=True, calls=None):
    """Takes so long for one unit of time, or in all where it does not step."""

    def solve(t):
        clock.now += seconds * (t[-1] / PROBLEM.unit if steps else t.size / 200)
        if calls is not None:
            calls.append((name, round(t[-1] / PROBLEM.unit, 2)))
        return EXACT(t)

    return method(name, solve, steps)


def test_what_does_not_fit_is_predicted_and_not_run(clock):
    report = measured(slow(clock, "steps", 1.0), slow(clock, "leaps", 2.0, steps=False),
                      budget=120.0, horizons=(1.0, 100.0, 1e4))  # fmt: skip
    steps = [by_name(report, horizon)["steps"] for horizon in report.horizons]
    assert [cell.status for cell in steps] == ["measured", "measured", "not run"]
    assert [cell.predicted_s for cell in steps] == [None, None, pytest.approx(1e4)]
    assert [cell.ns_per_sample for cell in steps[:2]] == pytest.approx([1e9 / 200, 1e11 / 200])
    leaps = [by_name(report, horizon)["leaps"] for horizon in report.horizons]
    assert [cell.ns_per_sample for cell in leaps] == pytest.approx([2e9 / 200] * 3)
    assert clock.now <= 120.0
    assert "not run, predicted 1.0e+04 s" in report.table()


def test_cheapest_cell_of_all_goes_first(clock):
    calls = []
    dear, cheap = slow(clock, "dear", 30.0, calls=calls), slow(clock, "cheap", 1.0, calls=calls)
    measured(dear, cheap, budget=1000.0)
    assert [call for call in calls if call[1] >= 1.0] == [("cheap", 1), ("dear", 1), ("cheap", 100)]


def test_budget_too_small_names_one_that_is_enough(clock):
    with pytest.raises(InputError, match=r"budget: at least \S+ s for this scene; got 0.5") as caught:
        measured(slow(clock, "steps", 1.0), budget=0.5)
    enough = float(caught.value.expected.split()[2])
    assert 1.0 < enough < 2.0
    clock.now = 0.0
    assert measured(slow(clock, "steps", 1.0), budget=enough).cells[0].status == "measured"


def test_method_that_there_is_no_time_to_try_says_so(clock):
    first, late = slow(clock, "first", 100.0, steps=False), slow(clock, "late", 1.0)  # a trial takes 2 s
    report = measured(first, late, budget=3.0, samples=2)
    assert by_name(report, 1.0)["first"].status == "measured"
    assert by_name(report, 1.0)["late"].status == "not run"
    assert "not run: half the budget was used up before its trial" in report.table()


def test_cost_is_the_median_of_repeats_without_the_first(clock):
    durations = iter([0.5, 0.001, 0.9, 0.03, 0.01, 0.02, 0.04, 0.05, 0.06, 0.07])

    def solve(t):
        clock.now += next(durations)
        return EXACT(t)

    measurement_of = measured(method("uneven", solve), horizons=(1.0,)).cells[0]
    assert (measurement_of.repeats, measurement_of.ns_per_sample) == (1, pytest.approx(0.9e9 / 200))
    durations = iter([0.5, 0.001, 0.002, 0.03, 0.01, 0.02, 0.04, 0.05, 0.06, 0.07])
    cell = measured(method("uneven", solve), horizons=(1.0,)).cells[0]
    assert (cell.repeats, cell.ns_per_sample) == (7, pytest.approx(0.04e9 / 200))
    assert cell.first_use_s == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"budget": 0.0}, "budget: a number of seconds greater than zero"),
        ({"samples": 1}, "samples: a whole number from 2"),
        ({"horizons": ()}, "horizons: numbers greater than zero"),
        ({"horizons": (1.0, 1.0)}, "horizons: numbers greater than zero, in ascending order"),
        ({"horizons": (0.0, 1.0)}, "horizons: numbers greater than zero"),
    ],
)
def test_senseless_measurement_is_refused(options, message):
    with pytest.raises(InputError, match=message):
        measured(*ours.methods(), **options)


def test_problem_is_the_former_name_of_the_initial_value_problem():
    from attitude import cost

    with pytest.warns(DeprecationWarning, match="is called InitialValueProblem"):
        assert cost.Problem is InitialValueProblem


def test_many_bodies_are_refused():
    motion = TorqueFreeMotion(RigidBody((1.0, 2.0, 2.5)), IDENTITY, [(1, 2, 3), (3, 2, 1)], order="wxyz")
    with pytest.raises(InputError, match="one body"):
        measure(motion)


# -- the report -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def report():
    """One of each kind of row."""
    return measured(
        *ours.methods(),
        *fixed_step.methods(),
        Method("gone", "", missing_package, steps=True),
        method("poisoned", poisoned, steps=True),
        horizons=(1.0, 100.0, 1e3),
    )


def no_constant(name):
    raise ValueError(name)


def test_json_holds_every_cell_and_no_nan(report):
    document = json.loads(report.to_json(), parse_constant=no_constant)
    assert {cell["status"] for cell in document["cells"]} == {"measured", "absent", "failed", "not run"}
    for cell, plain in zip(report.cells, document["cells"], strict=True):
        assert plain["attitude_error_rad"] == cell.attitude_error_rad
        assert plain["detail"] == cell.detail
        assert (plain["ns_per_sample"] is None) == (plain["status"] != "measured")
    assert document["truth"][2] == {"horizon": 1e3, "instants": 30, "route": "Taylor"}
    assert document["versions"]["numpy"] == np.__version__


def test_nan_in_a_report_is_not_written():
    report = measured(*ours.methods(), horizons=(1.0,))
    broken = replace(report, cells=(replace(report.cells[0], energy_error=np.nan),))
    with pytest.raises(ValueError, match="not JSON compliant"):
        broken.to_json()


def test_csv_holds_every_cell(report):
    lines = [line for line in report.to_csv().splitlines() if not line.startswith("#")]
    names = lines[0].split(",")
    rows = np.genfromtxt(lines[1:], delimiter=",", usecols=names.index("attitude_error_rad"))
    expected = [
        np.nan if cell.attitude_error_rad is None else cell.attitude_error_rad for cell in report.cells
    ]
    np.testing.assert_array_equal(rows, expected)


def test_table_has_a_row_for_every_cell_and_fits_a_terminal(report):
    lines = report.table().splitlines()
    assert max(map(len, lines)) <= 110
    for cell in report.cells:
        assert any(line.startswith(cell.method) for line in lines)
    assert sum("peer is not installed" in line for line in lines) == 3
    assert sum("failed: no finite attitude at 1 of 200" in line for line in lines) == 1


def test_svg_names_every_family_that_has_a_line(report):
    root = ElementTree.fromstring(report.picture("svg"))
    texts = ["".join(text.itertext()) for text in root.iter("{http://www.w3.org/2000/svg}text")]
    for family in ("closed form", "RK4", "poisoned"):
        assert texts.count(family) == 1
    assert any(text.startswith("Without a line: gone (absent)") for text in texts)
    assert any("200 samples over" in text for text in texts)


def test_picture_is_written_as_its_ending_says(report, tmp_path):
    report.plot(tmp_path / "cost.png")
    assert (tmp_path / "cost.png").read_bytes().startswith(b"\x89PNG\r\n")
    with pytest.raises(AttitudeError, match="a picture's ending is svg, png or pdf"):
        report.plot(tmp_path / "cost.gif")
