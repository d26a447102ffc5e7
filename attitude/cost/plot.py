"""Picture of a measurement: error against cost, and both against the horizon.

Each family's line has a colour, a marker and a dash pattern of its own, which the legend names.
"""

from __future__ import annotations

import math
import textwrap
from functools import partial
from typing import TYPE_CHECKING, Any

from ..plot.style import drawn
from .cell import ZERO_ERROR, Cell, CostData
from .initial_value_problem import counted

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Colour, marker and dash pattern of each family's line.
STYLES = (
    ("#000000", "o", "-"),
    ("#d55e00", "s", "--"),
    ("#0072b2", "^", "-."),
    ("#009e73", "D", ":"),
    ("#cc79a7", "v", (0, (5, 1))),
    ("#8c6d00", "P", (0, (3, 1, 1, 1))),
    ("#56b4e9", "X", (0, (7, 2))),
    ("#7f3c8d", "*", (0, (1, 1))),
    ("#666666", "h", (0, (4, 2, 1, 2))),
    ("#b2182b", "<", (0, (2, 1))),
    ("#3b6e22", "p", (0, (6, 1, 1, 1, 1, 1))),
)


def draw_costs(report: CostData, ending: str) -> bytes:
    """The picture as the bytes of an "svg" or "png" file."""
    return drawn(partial(draw_panels, report), (10.0, 10.2), ending)


def draw_panels(report: CostData, figure: Figure) -> None:
    """Error against cost at one horizon; error, and cost, against the horizon."""
    axes = figure.subplot_mosaic([["work", "work"], ["error", "cost"]], height_ratios=[1.15, 1.0])
    horizon = _fullest_horizon(report)
    tightest: dict[str, list[Cell]] = {}
    lines = {}
    for number, family in enumerate(dict.fromkeys(cell.family for cell in report.cells)):
        cells = tightest[family] = _tightest(report, family, horizon)
        at = [cell for cell in report.at(horizon) if cell.family == family and cell.status == "measured"]
        costs, errors = _costs_and_errors(cells)
        horizons = [cell.horizon for cell in cells]
        drawings = ("work", *_costs_and_errors(at)), ("error", horizons, errors), ("cost", horizons, costs)
        for panel, x, y in drawings:
            if x:
                (lines[family],) = axes[panel].plot(x, y, **line_style(number))
    unit, error, cost = report.unit_name, "largest attitude error, rad", "cost, ns a sample"
    over = f"{report.samples} samples over {counted(horizon, unit)}"
    axes["work"].set(title=f"Error against cost, {over}", xlabel=cost, ylabel=error)
    axes["error"].set(title="Error as the horizon grows", xlabel=f"horizon, {unit}", ylabel=error)
    axes["cost"].set(title="Cost as the horizon grows", xlabel=f"horizon, {unit}", ylabel=cost)
    for panel in axes.values():
        panel.set(xscale="log", yscale="log")
    figure.legend(lines.values(), lines.keys(), loc="outside upper center", ncols=4, handlelength=4.0)
    figure.suptitle(f"{report.name or 'Motion'}: what accuracy costs in time", fontsize=13)
    figure.supxlabel(_note(report, tightest), fontsize=8.5, x=0.01, ha="left")


def line_style(number: int) -> dict[str, Any]:
    """Line style of a family by its number; the first, the library's own, is drawn heaviest."""
    colour, marker, dashes = STYLES[number % len(STYLES)]
    return {
        "color": colour,
        "marker": marker,
        "linestyle": dashes,
        "linewidth": 2.4 if number == 0 else 1.4,
        "markersize": 8.0 if number == 0 else 5.5,
        "zorder": 4 if number == 0 else 3,
    }


def _fullest_horizon(report: CostData) -> float:
    """The longest horizon over which most methods were measured; under torques, most families.

    Under torques the coarsest setting of a family loses the attitude over horizons that separate the others.
    """

    def measured(horizon: float) -> int:
        cells = [cell for cell in report.at(horizon) if cell.status == "measured"]
        return len({cell.family for cell in cells}) if report.effects else len(cells)

    return max(report.horizons, key=lambda horizon: (measured(horizon), horizon))


def _tightest(report: CostData, family: str, horizon: float) -> list[Cell]:
    """The measured cells of a family's tightest setting; of those measured over the horizon, if any."""
    cells = [cell for cell in report.cells if cell.family == family and cell.status == "measured"]
    there = [cell for cell in cells if cell.horizon == horizon] or cells
    return [cell for cell in cells if cell.setting == there[-1].setting]


def _costs_and_errors(cells: list[Cell]) -> tuple[list[float], list[float]]:
    """ns a sample, and largest attitude errors, rad, as a logarithmic scale takes them."""
    return (
        [cell.ns_per_sample or math.nan for cell in cells],
        [max(cell.attitude_error_rad or 0.0, ZERO_ERROR) for cell in cells],
    )


def _note(report: CostData, tightest: dict[str, list[Cell]]) -> str:
    """The text below the panels."""
    first = [cells[0] for cells in tightest.values() if cells]
    settings = "; ".join(cell.method for cell in first if cell.setting)
    below = f"only the tightest: {settings}." if settings else "the same methods."
    lines = textwrap.wrap(
        f"Above: a line for each family, from its loosest setting to its tightest. Below: {below}", 130
    )
    lines.append("A line ends where the budget did, where its method failed, or where the attitude was lost.")
    if any(cell.attitude_error_rad == 0.0 for cell in report.cells):
        lines.append(f"Errors of exactly zero are drawn at {ZERO_ERROR:g} rad.")
    missing = {cell.family: cell.status for cell in report.cells if not tightest[cell.family]}
    if missing:
        lines.append(
            f"Without a line: {', '.join(f'{name} ({status})' for name, status in missing.items())}."
        )
    lines.append(f"{report.machine['processor']}, Python {report.versions['python']}.")
    return "\n".join(lines)
