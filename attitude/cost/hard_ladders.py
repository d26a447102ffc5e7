"""The hard ladders: the error of every method, at its most exact, where torque-free motion is hardest.

What is hard, and how it is approached, is in hard_cases.py; here methods are run on it, and the errors told.
"""

from __future__ import annotations

import math
import textwrap
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass
from itertools import groupby
from time import perf_counter
from typing import Any

import numpy as np

from ..errors import InputError
from . import records
from .cell import ABSENT, FAILED, MEASURED, NOT_RUN
from .hard_cases import Case, cases
from .machine import machine, versions
from .method import AbsentError, Method
from .methods import ladder as methods_named
from .truth import Truth, oracle

KIND = "attitude-hard/1"
BUDGET = 60.0  # s
COMPARED = ("ours", "published", "dop853", "heyoka", "orekit")
NAN = "NaN"

WIDTH = 110
METHOD_WIDTH = 13
ROW = "{:<32}{:>8}"


@dataclass(frozen=True)
class HardCell:
    """One method in one case.

    Attributes
    ----------
    ladder, distance : of the case; family, setting : of the method
    status : "measured", "NaN", "failed", "absent" or "not run"
    detail : why it is not "measured"
    attitude_error_rad : rad, the largest angle to the truth over the instants; None unless measured
    """

    ladder: str
    distance: float
    family: str
    setting: str
    status: str
    detail: str = ""
    attitude_error_rad: float | None = None

    @property
    def method(self) -> str:
        return f"{self.family}, {self.setting}" if self.setting else self.family

    def __str__(self) -> str:
        return self.status if self.attitude_error_rad is None else error_figure(self.attitude_error_rad)


@dataclass(frozen=True)
class HardReport:
    """What `hard` found.

    Attributes
    ----------
    seed, budget_s : as they were asked for
    machine, versions : of processor and system; of Python and packages
    cells : one for each case and method; ladder by ladder towards the hard place, methods in their order
    """

    seed: int
    budget_s: float
    machine: dict[str, str | int]
    versions: dict[str, str]
    cells: tuple[HardCell, ...]

    # -- for readers ------------------------------------------------------------------------

    def header(self) -> list[str]:
        """The circumstances, a line each."""
        packages = ", ".join(f"{name} {version}" for name, version in self.versions.items())
        return [
            "largest attitude error [rad] by distance from the hard place; truth: fifty digits, theta route",
            f"{self.machine['processor']}, {self.machine['cores']} cores, {self.machine['system']}; "
            f"seed {self.seed}, budget {self.budget_s:g} s",
            packages,
        ]

    def table(self) -> str:
        """For a terminal; with five methods, 110 columns wide."""
        lines = [
            part for line in self.header() for part in textwrap.wrap(line, WIDTH, break_on_hyphens=False)
        ]
        return "\n".join([*lines, "", *self._titles(), *self._rows()]) + "\n"

    def markdown(self) -> str:
        """The table alone, for a document."""
        titles = ("attitude error [rad]", "distance", *self._methods())
        rules = ("---", *["--:"] * (len(titles) - 1))
        rows = ((ladder, distance, *map(str, row)) for ladder, distance, row in self._named_once())
        return "".join(f"| {' | '.join(line)} |\n" for line in (titles, rules, *rows))

    def _titles(self) -> Iterator[str]:
        wrapped = [textwrap.wrap(name, METHOD_WIDTH - 2) for name in self._methods()]
        for i in range(max(map(len, wrapped))):
            yield _line("", "", (title[i] if i < len(title) else "" for title in wrapped))

    def _rows(self) -> Iterator[str]:
        for ladder, distance, row in self._named_once():
            yield _line(ladder, distance, map(str, row))

    def _methods(self) -> list[str]:
        return list(dict.fromkeys(cell.method for cell in self.cells))

    def _named_once(self) -> Iterator[tuple[str, str, list[HardCell]]]:
        """Ladder, beside its first row only; distance; the row's cells."""
        for ladder, rungs in groupby(self.cells, lambda cell: cell.ladder):
            for distance, row in groupby(rungs, lambda cell: cell.distance):
                yield ladder, scientific(distance), list(row)
                ladder = ""

    # -- for machines -----------------------------------------------------------------------

    def document(self) -> dict[str, Any]:
        """Plain data; what was not measured is None."""
        return {
            "kind": KIND,
            "seed": self.seed,
            "budget_s": self.budget_s,
            "machine": self.machine,
            "versions": self.versions,
            "cells": [asdict(cell) for cell in self.cells],
        }

    def to_json(self) -> str:
        return records.to_json(self.document())

    def to_csv(self) -> str:
        """The circumstances in comment lines, then one line a cell; empty where nothing was measured."""
        return records.to_csv(self.header(), HardCell, self.cells)


def _line(ladder: str, distance: str, entries: Iterable[str]) -> str:
    line = ROW.format(ladder, distance) + "".join(f"{entry:>{METHOD_WIDTH}}" for entry in entries)
    return line.rstrip()


def scientific(value: float) -> str:
    """3e-16, 1e3, 0."""
    if value == 0.0:
        return "0"
    digit, _, exponent = f"{value:.0e}".partition("e")
    return f"{digit}e{int(exponent)}"


def error_figure(error: float) -> str:
    """3e-16; but 0.5 from a thousandth of a radian on, to be seen at once."""
    return f"{error:.1g}" if error >= 1e-3 else scientific(error)


# -- the measurement --------------------------------------------------------------------------


def hard(
    methods: Iterable[str | Method] | None = None,
    budget: float = BUDGET,
    seed: int = 0,
    say: Callable[[str], None] | None = None,
) -> HardReport:
    """The largest attitude error of each method in every case of every ladder.

    Parameters
    ----------
    methods : names of families, each then at its most exact, or Methods; ours, the published formulas,
        DOP853, heyoka and Orekit by default
    budget : s, what all methods that step through time may take together; the rest takes a few seconds
    seed : of what the ladders leave open: attitudes, the order of axes, signs
    say : is told of each ladder as it begins

    Raises
    ------
    InputError : a budget or seed that cannot be taken, a name that is no family's.
    AttitudeError : mpmath is missing.
    """
    if not 0.0 < budget < math.inf:
        raise InputError("budget", budget, "a number of seconds greater than zero")
    if seed < 0:
        raise InputError("seed", seed, "a whole number, not negative")
    given = COMPARED if methods is None else methods
    chosen = [methods_named([each])[-1] if isinstance(each, str) else each for each in given]
    rungs = cases(seed)
    trials = [Trial(method, rungs[0]) for method in chosen]
    cells: list[HardCell] = []
    for name, group in groupby(rungs, lambda case: case.ladder):
        if say is not None:
            say(name)
        for case in group:
            truth = _truth(case)
            for trial in trials:
                left = budget - sum(each.spent for each in trials if each.method.steps)
                cells.append(trial.cell(case, truth, left))
    return HardReport(seed, budget, machine(), versions(), tuple(cells))


def _truth(case: Case) -> Truth:
    """By theta quotients: Taylor series would follow a needle, or a body beside an axis, for minutes."""
    exact, problem = oracle().attitude_and_rate, case.problem
    vectors = (np.diag(problem.tensor), problem.angular_velocity, problem.attitude)
    body = [vector.tolist() for vector in vectors]
    attitudes = [exact(*body, t, route="theta")[0] for t in case.instants.tolist()]
    return Truth(np.arange(case.instants.size), attitudes, "theta")


class Trial:
    """One method on its way through the cases: whether it is there at all, and how fast it steps.

    Attributes
    ----------
    spent : s, in all cases so far; pace : s a radian, in the last of them
    """

    def __init__(self, method: Method, first: Case):
        self.method, self.absence, self.spent, self.pace = method, "", 0.0, 0.0
        try:
            _run(method, first)  # what is compiled and started once is not the first case's
        except AbsentError as error:
            self.absence = str(error)
        except Exception:  # the case itself meets it again, and names it
            return

    def cell(self, case: Case, truth: Truth, left: float) -> HardCell:
        """`left` is what remains of the budget, s."""
        status, detail, error = self._found(case, truth, left)
        method = self.method
        return HardCell(case.ladder, case.distance, method.family, method.setting, status, detail, error)

    def _found(self, case: Case, truth: Truth, left: float) -> tuple[str, str, float | None]:
        """Status, detail, error."""
        if self.absence:
            return ABSENT, self.absence, None
        predicted = self.pace * case.radians
        if self.method.steps and predicted > left:
            return NOT_RUN, f"would take {predicted:.2g} s of the {max(left, 0.0):.2g} s left", None
        start = perf_counter()
        try:
            answer = _run(self.method, case)
        except Exception as error:
            return FAILED, f"{type(error).__name__}: {error}", None
        finally:
            taken = perf_counter() - start
            self.spent, self.pace = self.spent + taken, taken / case.radians
        return _judged(*answer, truth)


def _run(method: Method, case: Case) -> tuple[np.ndarray, np.ndarray]:
    """Warnings are a method's own affair: what counts is what it answers."""
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return method.prepare(case.problem)(case.instants)


def _judged(attitudes: np.ndarray, rates: np.ndarray, truth: Truth) -> tuple[str, str, float | None]:
    fine = np.isfinite(attitudes).all(axis=-1) & np.isfinite(rates).all(axis=-1)
    if not fine.all():
        return NAN, f"not finite at {np.sum(~fine)} of {fine.size} instants", None
    return MEASURED, "", truth.error(attitudes)
