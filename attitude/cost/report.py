"""The report of a measurement: table, JSON, CSV, picture."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import cast

import numpy as np

from .answers import CostAnswer, CostCell, CostGrowth
from .cell import LOST, ZERO_ERROR, Cell, CostData
from .initial_value_problem import counted
from .method import method_name

WIDTH = 110  # of a table, in characters
ROW = "{:<37}{:>13}{:>11}{:>11}{:>13}{:>12}{:>8}"


@dataclass(frozen=True)
class Growth:
    """Exponents of a method's error and cost as powers of the horizon, by a line through the logarithms.

    `error` leaves out horizons with errors over 1 rad.  None with fewer than two horizons.
    """

    family: str
    setting: str
    error: float | None
    cost: float | None


@dataclass(frozen=True)
class Report(CostData):
    """The results of `measure`, as text, JSON, CSV and picture."""

    def growth(self) -> list[Growth]:
        """One Growth for each method with a measured cell."""
        methods: dict[tuple[str, str], list[Cell]] = {}
        for cell in self.cells:
            if cell.status == "measured":
                methods.setdefault((cell.family, cell.setting), []).append(cell)
        growths = []
        for method, cells in methods.items():
            errors = [
                (c.horizon, c.attitude_error_rad) for c in cells if (c.attitude_error_rad or 0.0) <= LOST
            ]
            costs = [(c.horizon, c.ns_per_sample) for c in cells]
            growths.append(Growth(*method, _exponent(errors), _exponent(costs)))
        return growths

    # -- for readers ------------------------------------------------------------------------

    def header(self) -> list[str]:
        """The circumstances of the measurement, one line each."""
        motion = f"{self.regime.replace('_', ' ')} regime"
        routes = " and ".join(sorted({route for _, route in self.truths}))
        largest = f"largest error at {max(count for count, _ in self.truths)} samples (seed {self.seed})"
        if not self.effects:
            attitude, other = f"fifty digits ({routes} route)", "largest relative error at any sample"
        else:
            off = f", itself off by about {self.truth_off_rad:.0e} rad" if self.truth_off_rad else ""
            attitude, other = f"{routes}{off}", "largest relative error against the same"
            motion = f"{', '.join(self.effects)}; {motion} at the epoch"
        return [
            f"{self.name or 'motion'}: {motion}",
            f"horizons in {self.unit_name} ({self.unit_s:.9g} s), {self.samples} samples each",
            f"attitude: {largest} against {attitude}",
            f"energy, momentum (inertial vector){' of the body' if self.effects else ''}: {other}",
            f"{self.processor}; budget {self.budget_s:g} s",
            self.packages,
        ]

    def table(self) -> str:
        """Table for a terminal 110 columns wide."""
        lines = [*_wrapped(self.header())]
        titles = ("attitude, rad", "energy", "momentum", "ns a sample", "set-up, s", "repeats")
        for horizon in self.horizons:
            count = f"{horizon:g}" if horizon < 1e4 else f"{horizon:.0e}".replace("e+0", "e")
            lines += ["", ROW.format(f"horizon {count} = {horizon * self.unit_s:.3g} s", *titles)]
            lines += [_row(cell) for cell in self.at(horizon)]
        growth_row = "{:<37}{:>13}{:>35}"
        lines += ["", growth_row.format("growth, as horizon to the power of", "attitude", "ns a sample")]
        for growth in self.growth():
            exponents = [
                each if each is None else f"{each + 0.0:+.2f}" for each in (growth.error, growth.cost)
            ]
            if any(exponents):
                name = _cut(method_name(growth.family, growth.setting), 37)
                lines.append(growth_row.format(name, *(each or "" for each in exponents)))
        # by family, the time of a first use that is much longer than later set-ups
        first = {"the library's kernels": self.compilation_s} if self.compilation_s > 0.1 else {}
        for cell in self.cells:
            if cell.first_use_s is not None and cell.first_use_s > 0.1 + 10.0 * (cell.setup_s or 0.0):
                first[cell.family] = max(cell.first_use_s, first.get(cell.family, 0.0))
        if first:
            listed = "; ".join(f"{family} {seconds:.2g} s" for family, seconds in first.items())
            note = f"first use in this process (compilation, JVM), not in the figures above: {listed}"
            lines += ["", *_wrapped([note])]
        return "\n".join(lines) + "\n"

    def markdown(self) -> str:
        """Table in Markdown: each family at its tightest setting, error and cost by horizon."""
        titles = ["error in rad, ns a sample", *(counted(each, self.unit_name) for each in self.horizons)]
        last = {cell.family: (cell.family, cell.setting) for cell in self.cells}
        rows = [
            [next(cell.method for cell in self.cells if (cell.family, cell.setting) == method)]
            + [_entry(c) for h in self.horizons for c in self.at(h) if (c.family, c.setting) == method]
            for method in last.values()
        ]
        lines = [titles, ["---"] * len(titles), *rows]
        return "".join(f"| {' | '.join(line)} |\n" for line in lines)

    # -- for machines -----------------------------------------------------------------------

    def document(self) -> CostAnswer:
        """Plain data; what was not measured is None."""
        answer: CostAnswer = {
            "kind": "attitude-cost/1",
            "name": self.name,
            "regime": self.regime,
            "unit": {"name": self.unit_name, "s": self.unit_s},
            "samples": self.samples,
            "budget_s": self.budget_s,
            "seed": self.seed,
            "compilation_s": self.compilation_s,
            "machine": self.machine,
            "versions": self.versions,
            "truth": [
                {"horizon": horizon, "instants": count, "route": route}
                for horizon, (count, route) in zip(self.horizons, self.truths, strict=True)
            ],
            "cells": [cast("CostCell", asdict(cell)) for cell in self.cells],
            "growth": [cast("CostGrowth", asdict(growth)) for growth in self.growth()],
        }
        if self.effects:
            answer |= {"effects": list(self.effects), "truth_off_rad": self.truth_off_rad}
        return answer

    def picture(self, format: str) -> bytes:  # noqa: A002 (public name)
        """The picture of `plot` as the bytes of an "svg" or "png" file."""
        from .plot import draw_costs

        return draw_costs(self, format)

    def plot(self, path: str | Path) -> None:
        """Three panels: error against cost; error, and cost, against the horizon.

        Raises FormatError for another ending than svg and png, or where the file cannot be written;
        AttitudeError where matplotlib is missing.
        """
        from ..runtime.output_paths import check_picture, write

        write(path, self.picture(check_picture(path)))


def _wrapped(lines: Iterable[str]) -> Iterator[str]:
    for line in lines:
        yield from textwrap.wrap(line, WIDTH, subsequent_indent="  ", break_on_hyphens=False) or [""]


def _row(cell: Cell) -> str:
    name = _cut(cell.method, 37)
    if cell.status == "measured":
        errors = map(_error, (cell.attitude_error_rad, cell.energy_error, cell.momentum_error))
        return ROW.format(name, *errors, _three(cell.ns_per_sample), f"{cell.setup_s:.1e}", cell.repeats)
    if cell.predicted_s is not None:
        reason = f"{cell.status}, predicted {cell.predicted_s:.1e} s"
    else:  # an absent method's detail says so itself
        reason = cell.detail if cell.status == "absent" else f"{cell.status}: {cell.detail}"
    return f"{name:<37}  {_cut(reason, WIDTH - 39)}"


def _entry(cell: Cell) -> str:
    """Text of a cell in the Markdown table, with the reason in a word."""
    if cell.status == "measured":
        return f"{_error(cell.attitude_error_rad)}, {_three(cell.ns_per_sample)}"
    if cell.predicted_s is not None:
        return f"not run ({_three(cell.predicted_s)} s)"
    return "lost" if "attitude lost" in cell.detail else cell.status


def _exponent(points: list[tuple[float, float | None]]) -> float | None:
    """Slope of log value over log horizon, by least squares."""
    if len(points) < 2:
        return None
    x, y = np.log10([(horizon, max(value or 0.0, ZERO_ERROR)) for horizon, value in points]).T
    return float(np.polyfit(x, y, 1)[0])


def _error(value: float | None) -> str:
    return "0" if value == 0.0 else f"{value:.1e}"


def _three(value: float | None) -> str:
    """Three digits, as a plain number."""
    value = value or 0.0
    return f"{value:.1f}" if value < 99.95 else f"{float(f'{value:.2e}'):,.0f}"


def _cut(text: str, width: int) -> str:
    return text if len(text) <= width else text[: width - 3] + "..."
