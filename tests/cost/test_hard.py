"""Near-singular cases: the closed form keeps its accuracy, and failures of other methods are reported."""

import csv
import io
import json
import math

import numpy as np
import pytest

from attitude.cost import AbsentError, Method
from attitude.cost.hard_cases import cases
from attitude.cost.hard_ladders import HardCell, error_figure, hard, scientific
from attitude.cost.methods import ours
from tests.bodies import ATTITUDE_TOLERANCE

SEED = 0
CASES = cases(SEED)
COMPARED = ("ours", "published", "dop853", "heyoka", "orekit")


@pytest.fixture(scope="module")
def report():
    """All methods; the budget leaves the integrators no more than the shortest of the huge times."""
    return hard(budget=1.0, seed=SEED)


def by_family(report, family):
    return [cell for cell in report.cells if cell.family == family]


def test_ours_is_exact_on_every_rung_of_every_ladder(report):
    for cells in (by_family(report, "closed form"), hard(ours.methods()[-1:], seed=1).cells):
        assert len(cells) == len(CASES)
        for cell in cells:
            assert cell.status == "measured", cell
            assert cell.attitude_error_rad <= ATTITUDE_TOLERANCE, cell


def test_every_case_is_asked_of_every_method(report):
    asked = [(cell.ladder, cell.distance) for cell in report.cells]
    assert asked == [(case.ladder, case.distance) for case in CASES for _ in COMPARED]


def test_every_cell_is_a_finite_error_or_says_why_not(report):
    for cell in report.cells:
        if cell.status == "measured":
            assert 0.0 <= cell.attitude_error_rad <= math.pi
            assert cell.detail == ""
        else:
            assert cell.status in ("NaN", "failed", "absent", "not run")
            assert cell.attitude_error_rad is None
            assert cell.detail


def test_published_formulas_fail_where_they_must(report):
    cells = {(cell.ladder, cell.distance): cell for cell in by_family(report, "van Zon & Schofield (SciPy)")}
    for case in ("on the separatrix", "near symmetry, oblate", "near the sphere", "beside the least axis"):
        assert cells[case, 0.0].status == "failed"
    assert cells["beside the least axis", 1e-9].status == "failed"
    assert cells["beside the separatrix, outside", 1e-9].attitude_error_rad > 1e-12
    assert cells["near symmetry, oblate", 1e-1].attitude_error_rad < 1e-12


def test_integrators_are_not_run_over_huge_times(report):
    for cell in by_family(report, "DOP853 (SciPy)"):
        if cell.ladder.startswith("huge") and cell.distance > 1e3:
            assert cell.status == "not run"
            assert "of the" in cell.detail


# -- the cases ------------------------------------------------------------------------------------


def test_instants_ascend_from_the_epoch():
    for case in CASES:
        assert case.instants[0] == 0.0
        assert (np.diff(case.instants) > 0.0).all()
        assert case.instants.size <= 6


def test_seed_changes_the_cases_and_not_the_ladders():
    others = cases(1)
    assert [(c.ladder, c.distance) for c in others] == [(c.ladder, c.distance) for c in CASES]
    assert not all(
        (a.problem.attitude == b.problem.attitude).all() for a, b in zip(CASES, others, strict=True)
    )


def test_separatrix_is_met_to_the_last_bit():
    (case,) = [case for case in CASES if case.ladder == "on the separatrix"]
    moments, rate = case.problem.moments, case.problem.angular_velocity
    assert (moments * (moments - np.median(moments)) * rate**2).sum() == 0.0


# -- the measurement ------------------------------------------------------------------------------


def method(prepare, steps=False):
    return Method("theirs", "", prepare, steps)


def exact(problem):
    return ours.methods()[-1].prepare(problem)


def test_nan_failure_and_absence_are_different_statuses():
    def nan(problem):
        def solve(t):
            attitudes, rates = exact(problem)(t)
            rates = rates.copy()
            rates[-1, 2] = np.nan
            return attitudes, rates

        return solve

    def failing(problem):
        raise ZeroDivisionError("nothing to divide by")

    def absent(problem):
        raise AbsentError("pip install it")

    cells = hard([method(nan), method(failing), method(absent)]).cells[:3]
    assert [cell.status for cell in cells] == ["NaN", "failed", "absent"]
    assert [cell.detail for cell in cells] == [
        "not finite at 1 of 6 instants",
        "ZeroDivisionError: nothing to divide by",
        "pip install it",
    ]


def test_steps_beyond_the_budget_are_not_computed():
    horizons = []

    def stepping(problem):
        def solve(t):
            horizons.append(t[-1] * np.linalg.norm(problem.angular_velocity))
            return exact(problem)(t)

        return solve

    cells = hard([method(stepping, steps=True)], budget=0.05).cells
    assert cells[-1].status == "not run"
    assert max(horizons) < 1e9


def test_each_ladder_is_announced_once():
    announced = []
    hard([], say=announced.append)
    assert announced == list(dict.fromkeys(case.ladder for case in CASES))


# -- reports -------------------------------------------------------------------------------------


def test_table_fits_a_terminal_and_holds_every_cell(report):
    lines = report.table().splitlines()
    assert max(map(len, lines)) <= 110
    last = [str(cell) for cell in report.cells[len(COMPARED) - 1 :: len(COMPARED)]]
    assert all(line.endswith(f" {cell}") for line, cell in zip(lines[-len(last) :], last, strict=True))


def test_markdown_has_a_column_for_each_method(report):
    lines = report.markdown().splitlines()
    assert len(lines) == len(CASES) + 2
    assert {line.count("|") for line in lines} == {len(COMPARED) + 3}


def test_json_and_csv_hold_what_was_found(report):
    document = json.loads(report.to_json())
    assert document["kind"] == "attitude-hard/1"
    assert [HardCell(**cell) for cell in document["cells"]] == list(report.cells)
    text = "".join(line for line in io.StringIO(report.to_csv()) if not line.startswith("#"))
    rows = list(csv.DictReader(io.StringIO(text)))
    errors = [float(row["attitude_error_rad"] or "nan") for row in rows]
    expected = [math.nan if c.attitude_error_rad is None else c.attitude_error_rad for c in report.cells]
    assert np.array_equal(errors, expected, equal_nan=True)


@pytest.mark.parametrize(
    ("value", "text"), [(3.2e-16, "3e-16"), (0.0, "0"), (9.96e-4, "1e-3"), (0.48, "0.5"), (3.1, "3")]
)
def test_errors_that_are_none_are_seen_at_once(value, text):
    assert error_figure(value) == text


@pytest.mark.parametrize(("value", "text"), [(0.1, "1e-1"), (1e-150, "1e-150"), (1e12, "1e12"), (0.0, "0")])
def test_distances_are_powers_of_ten(value, text):
    assert scientific(value) == text
