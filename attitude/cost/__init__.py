"""Accuracy against computing time: methods measured side by side against an independent truth.

initial_value_problem.py  one body, its state, its torques
method.py, methods/       what a method is; the methods
free_truth.py             free motion: attitudes to fifty digits, conserved quantities
torque_truth.py           motion under torques: attitudes, energy and momentum
measurement.py            every method over every horizon, within a budget of time
cell.py, report.py, records.py, plot.py   the results; as table, JSON, CSV and picture
answers.py                the JSON, described
hard_cases.py, hard_ladders.py            near-singular motions; the error of every method on them
machine.py                processor, system and versions of a measurement
"""

import warnings
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .cell import Cell
    from .hard_ladders import HardCell, HardReport, hard
    from .initial_value_problem import InitialValueProblem
    from .measurement import measure
    from .method import AbsentError, Method
    from .report import Report


# Each is imported when first asked for: what measures takes 100 MiB, a description of the answers nothing.
_WHERE = {
    "AbsentError": "method",
    "Cell": "cell",
    "HardCell": "hard_ladders",
    "HardReport": "hard_ladders",
    "InitialValueProblem": "initial_value_problem",
    "Method": "method",
    "Report": "report",
    "hard": "hard_ladders",
    "measure": "measurement",
}

__all__ = [
    "AbsentError",
    "Cell",
    "HardCell",
    "HardReport",
    "InitialValueProblem",
    "Method",
    "Report",
    "hard",
    "measure",
]


def __getattr__(name: str) -> Any:
    if name == "Problem":
        warnings.warn("attitude.cost.Problem is called InitialValueProblem", DeprecationWarning, stacklevel=2)
        name = "InitialValueProblem"
    if name in _WHERE:
        return getattr(import_module(f".{_WHERE[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
