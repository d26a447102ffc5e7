"""The error of every method at its tightest setting on the near-singular motions of hard_cases.py."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass
from itertools import groupby, zip_longest
from time import perf_counter
from typing import Any

import numpy as np

from .free_truth import Truth, true_attitudes
from .hard_cases import Case, cases
from .machine import machine, versions
from .method import AbsentError, Method, method_name, quiet
from .methods import select_methods
from .records import Records, check_budget

METHOD_WIDTH = 13  # of a column of the table


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
        """Family and setting in one line."""
        return method_name(self.family, self.setting)

    def __str__(self) -> str:
        return self.status if self.attitude_error_rad is None else error_figure(self.attitude_error_rad)


@dataclass(frozen=True)
class HardReport(Records):
    """The results of `hard`.

    Attributes
    ----------
    cells : one for each case and method; ladder by ladder, with decreasing distance; methods in their order
    """

    cells: tuple[HardCell, ...]

    @property
    def records(self) -> tuple[HardCell, ...]:
        """The cells."""
        return self.cells

    # -- for readers ------------------------------------------------------------------------

    def header(self) -> list[str]:
        """The circumstances of the measurement, one line each."""
        return [
            "largest attitude error [rad] by distance from the hard case; truth: fifty digits, theta route",
            f"{self.processor}; seed {self.seed}, budget {self.budget_s:g} s",
            self.packages,
        ]

    def table(self) -> str:
        """Text for a terminal; 110 columns wide with five methods."""
        lines = [part for line in self.header() for part in textwrap.wrap(line, 110, break_on_hyphens=False)]
        titles = [textwrap.wrap(name, METHOD_WIDTH - 2) for name in self.methods]
        rows = [("", "", words) for words in zip_longest(*titles, fillvalue="")]
        lines.append("")
        for ladder, distance, entries in [*rows, *self.rows()]:
            columns = "".join(f"{entry:>{METHOD_WIDTH}}" for entry in entries)
            lines.append(f"{ladder:<32}{distance:>8}{columns}".rstrip())
        return "\n".join(lines) + "\n"

    def markdown(self) -> str:
        """The table in Markdown."""
        titles = ("attitude error [rad]", "distance", *self.methods)
        rules = ("---", *["--:"] * (len(titles) - 1))
        rows = ((ladder, distance, *entries) for ladder, distance, entries in self.rows())
        return "".join(f"| {' | '.join(line)} |\n" for line in (titles, rules, *rows))

    @property
    def methods(self) -> list[str]:
        """Their names, in order."""
        return list(dict.fromkeys(cell.method for cell in self.cells))

    def rows(self) -> Iterator[tuple[str, str, tuple[str, ...]]]:
        """Ladder (empty after its first row), distance, texts of the cells of the row."""
        for ladder, cells in groupby(self.cells, lambda cell: cell.ladder):
            for i, (distance, row) in enumerate(groupby(cells, lambda cell: cell.distance)):
                yield "" if i else ladder, scientific(distance), tuple(map(str, row))

    # -- for machines -----------------------------------------------------------------------

    def document(self) -> dict[str, Any]:
        """Plain data; what was not measured is None."""
        return {
            "kind": "attitude-hard/1",
            "seed": self.seed,
            "budget_s": self.budget_s,
            "machine": self.machine,
            "versions": self.versions,
            "cells": [asdict(cell) for cell in self.cells],
        }


def scientific(value: float) -> str:
    """One digit and the exponent: 3e-16, 1e3, 0."""
    if value == 0.0:
        return "0"
    digit, _, exponent = f"{value:.0e}".partition("e")
    return f"{digit}e{int(exponent)}"


def error_figure(error: float) -> str:
    """3e-16; from a thousandth of a radian on 0.5, so that large errors stand out."""
    return f"{error:.1g}" if error >= 1e-3 else scientific(error)


# -- the measurement --------------------------------------------------------------------------


def hard(
    methods: Iterable[str | Method] | None = None,
    budget: float = 60.0,
    seed: int = 0,
    say: Callable[[str], None] | None = None,
) -> HardReport:
    """The largest attitude error of each method in every case of every ladder.

    Parameters
    ----------
    methods : names of families, each at its tightest setting, or Methods; ours, the published formulas,
        DOP853, heyoka and Orekit by default
    budget : s, limit for all integrators together; the rest takes a few seconds
    seed : of attitudes, the order of axes and signs
    say : called with the name of each ladder as it begins

    Raises
    ------
    InputError : a budget or seed out of range, an unknown family.
    AttitudeError : mpmath is not installed.
    """
    check_budget(budget, seed)
    compared = [
        select_methods([method])[-1] if isinstance(method, str) else method
        for method in (("ours", "published", "dop853", "heyoka", "orekit") if methods is None else methods)
    ]
    all_cases = cases(seed)
    trials = [Trial(method, all_cases[0]) for method in compared]
    cells: list[HardCell] = []
    for name, group in groupby(all_cases, lambda case: case.ladder):
        if say is not None:
            say(name)
        for case in group:
            # by theta functions: Taylor series take minutes for a needle, or beside an axis
            truth = Truth(
                np.arange(case.instants.size), true_attitudes(case.problem, case.instants, "theta"), "theta"
            )
            for trial in trials:
                left = budget - sum(other.spent for other in trials if other.method.steps)
                cells.append(trial.cell(case, truth, left))
    return HardReport(budget, seed, machine(), versions(), tuple(cells))


class Trial:
    """One method over all cases: its absence, its speed.

    Attributes
    ----------
    spent : s, in all cases so far; seconds_per_radian : in the last case
    """

    def __init__(self, method: Method, first: Case):
        self.method, self.absence, self.spent, self.seconds_per_radian = method, "", 0.0, 0.0
        try:
            _run(method, first)  # compilation and start-up are no part of the first case
        except AbsentError as error:
            self.absence = str(error)
        except Exception:  # raised, and reported, again in the case itself
            return

    def cell(self, case: Case, truth: Truth, left: float) -> HardCell:
        """The method in one case; `left` is the rest of the budget, s."""
        status, detail, error = self._outcome(case, truth, left)
        method = self.method
        return HardCell(case.ladder, case.distance, method.family, method.setting, status, detail, error)

    def _outcome(self, case: Case, truth: Truth, left: float) -> tuple[str, str, float | None]:
        """Status, detail, error."""
        if self.absence:
            return "absent", self.absence, None
        predicted = self.seconds_per_radian * case.radians
        if self.method.steps and predicted > left:
            return "not run", f"would take {predicted:.2g} s of the {max(left, 0.0):.2g} s left", None
        start = perf_counter()
        try:
            attitudes, rates = _run(self.method, case)
        except Exception as error:
            return "failed", f"{type(error).__name__}: {error}", None
        finally:
            seconds = perf_counter() - start
            self.spent, self.seconds_per_radian = self.spent + seconds, seconds / case.radians
        finite = np.isfinite(attitudes).all(axis=-1) & np.isfinite(rates).all(axis=-1)
        if not finite.all():
            return "NaN", f"not finite at {np.sum(~finite)} of {finite.size} instants", None
        return "measured", "", truth.error(attitudes)


def _run(method: Method, case: Case) -> tuple[np.ndarray, np.ndarray]:
    """Samples of the method at the case's instants, its warnings suppressed."""
    with quiet():
        return method.prepare(case.problem)(case.instants)
