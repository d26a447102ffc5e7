"""What accuracy costs in time: methods measured side by side against a truth that none of them supplied.

problem.py  method.py   what is given: a body and its state; a way to its attitudes
methods/        the methods
truth.py        errors against fifty digits, and of what is conserved
measurement.py  who runs when, within a budget of time
cell.py  report.py  records.py  plot.py   what was found; as table, JSON, CSV and picture
hard_cases.py  hard_ladders.py   the hardest motions there are; every method on them
machine.py   on what it was measured
"""

from .cell import Cell
from .hard_ladders import HardCell, HardReport, hard
from .measurement import measure
from .method import AbsentError, Method
from .problem import Problem
from .report import Report

__all__ = ["AbsentError", "Cell", "HardCell", "HardReport", "Method", "Problem", "Report", "hard", "measure"]
