"""Accuracy against computing time: methods measured side by side against an independent truth.

initial_value_problem.py  one body, its state, its torques
method.py, methods/       what a method is; the methods
free_truth.py             free motion: attitudes to fifty digits, conserved quantities
torque_truth.py           motion under torques: attitudes, energy and momentum
measurement.py            every method over every horizon, within a budget of time
cell.py, report.py, records.py, plot.py   the results; as table, JSON, CSV and picture
hard_cases.py, hard_ladders.py            near-singular motions; the error of every method on them
machine.py                processor, system and versions of a measurement
"""

import warnings
from typing import Any

from .cell import Cell
from .hard_ladders import HardCell, HardReport, hard
from .initial_value_problem import InitialValueProblem
from .measurement import measure
from .method import AbsentError, Method
from .report import Report

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
        return InitialValueProblem
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
