"""The picture of a report: error against cost, and how both grow with the horizon.

Every line carries its name beside it, and has a marker and a dash pattern of its own beside its colour.
"""

from __future__ import annotations

import io
import math
import textwrap
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from .cell import MEASURED, Cell
from .problem import counted

if TYPE_CHECKING:
    from .report import Report

# What an exact zero is drawn at: below any double's last place.
FLOOR = 1e-17

SIZE = (10.0, 9.6)  # inches
SETTINGS = {
    "font.size": 10.0,
    "font.family": "DejaVu Sans",
    "axes.titlesize": 11.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "0.92",
    "svg.fonttype": "none",  # text stays text, to be found and read aloud
    "svg.hashsalt": "attitude",  # the same report makes the same file
}
COLOURS = ("#000000", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#8c6d00", "#56b4e9", "#7f3c8d", "#666666")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*", "h")
DASHES = ("-", "--", "-.", ":", (0, (5, 1)), (0, (3, 1, 1, 1)), (0, (7, 2)), (0, (1, 1)), (0, (4, 2, 1, 2)))


def picture(report: Report, format: str) -> bytes:
    """An "svg" or "png" file."""
    with rc_context(SETTINGS):
        figure = Figure(figsize=SIZE, layout="constrained")
        canvas = FigureCanvasAgg(figure)
        panels = _draw(figure, report)
        canvas.draw()  # labels are placed among what has its place
        figure.set_layout_engine("none")
        for panel in panels:
            panel.place_labels(canvas.get_renderer())
        file = io.BytesIO()
        metadata = {"Date": None} if format == "svg" else {}
        figure.savefig(file, format=format, dpi=150, metadata=metadata)
    return file.getvalue()


def _draw(figure: Figure, report: Report) -> list[Panel]:
    families = list(dict.fromkeys(cell.family for cell in report.cells))
    styles = {family: _style(number) for number, family in enumerate(families)}
    horizon = _fullest_horizon(report)
    tightest = {family: _tightest(report, family, horizon) for family in families}
    axes = figure.subplot_mosaic([["work", "work"], ["error", "cost"]], height_ratios=[1.15, 1.0])
    work, error, cost = (Panel(axes[name]) for name in ("work", "error", "cost"))
    for family, style in styles.items():
        at = [cell for cell in report.at(horizon) if cell.family == family and cell.status == MEASURED]
        work.add(family, [_cost(cell) for cell in at], [_error(cell) for cell in at], style)
        x = [cell.horizon for cell in tightest[family]]
        error.add(family, x, [_error(cell) for cell in tightest[family]], style)
        cost.add(family, x, [_cost(cell) for cell in tightest[family]], style)
    unit = report.unit_name
    work.finish(
        f"Error against cost, {report.samples} samples over {counted(horizon, unit)}",
        "cost, ns a sample", "largest attitude error, rad",
    )  # fmt: skip
    error.finish("Error as the horizon grows", f"horizon, {unit}", "largest attitude error, rad")
    cost.finish("Cost as the horizon grows", f"horizon, {unit}", "cost, ns a sample")
    name = report.name or "Motion"
    figure.suptitle(f"{name}: what accuracy costs in time", fontsize=13)
    figure.supxlabel(_note(report, tightest), fontsize=8.5, x=0.01, ha="left")
    return [work, error, cost]


def _style(number: int) -> dict[str, Any]:
    """The first, which is the library's own, is drawn the strongest."""
    return {
        "color": COLOURS[number % len(COLOURS)],
        "marker": MARKERS[number % len(MARKERS)],
        "linestyle": DASHES[number % len(DASHES)],
        "linewidth": 2.4 if number == 0 else 1.4,
        "markersize": 8.0 if number == 0 else 5.5,
        "zorder": 4 if number == 0 else 3,
    }


def _fullest_horizon(report: Report) -> float:
    """The longest of those over which most methods were measured."""

    def measured(horizon: float) -> int:
        return sum(cell.status == MEASURED for cell in report.at(horizon))

    return max(report.horizons, key=lambda horizon: (measured(horizon), horizon))


def _tightest(report: Report, family: str, horizon: float) -> list[Cell]:
    """The measured cells of a family's tightest setting; of those measured over the horizon, if any."""
    cells = [cell for cell in report.cells if cell.family == family and cell.status == MEASURED]
    there = [cell for cell in cells if cell.horizon == horizon] or cells
    if not there:
        return []
    return [cell for cell in cells if cell.setting == there[-1].setting]


def _error(cell: Cell) -> float:
    return max(cell.attitude_error_rad or 0.0, FLOOR)


def _cost(cell: Cell) -> float:
    return cell.ns_per_sample or math.nan


def _note(report: Report, tightest: dict[str, list[Cell]]) -> str:
    """What a reader has to know of the lines."""
    first = [cells[0] for cells in tightest.values() if cells]
    settings = ", ".join(cell.method for cell in first if cell.setting)
    below = f"only the tightest: {settings}." if settings else "the same methods."
    lines = textwrap.wrap(
        f"Above: a line for each family, from its loosest setting to its tightest. Below: {below}", 130
    )
    lines.append("A line ends where the budget did, where its method failed, or where the attitude was lost.")
    if any(cell.attitude_error_rad == 0.0 for cell in report.cells):
        lines.append(f"Errors of exactly zero are drawn at {FLOOR:g} rad.")
    missing = {cell.family: cell.status for cell in report.cells if not tightest[cell.family]}
    if missing:
        lines.append(
            f"Without a line: {', '.join(f'{name} ({status})' for name, status in missing.items())}."
        )
    lines.append(f"{report.machine['processor']}, Python {report.versions['python']}.")
    return "\n".join(lines)


# -- labels ---------------------------------------------------------------------------------------

# Where a label may stand, from its point: direction and, in points, distance; the nearest first.
PLACES = [
    (math.cos(angle), math.sin(angle), distance)
    for distance in (9.0, 16.0, 28.0, 44.0, 64.0, 90.0)
    for angle in np.deg2rad([0, 90, 270, 45, 315, 135, 225, 180, 20, 340, 70, 290])
]
LEADER = 12.0  # points; labels farther off are tied to their point by a thin line


@dataclass
class Panel:
    """Axes with logarithms on both, and the lines drawn in them."""

    axes: Any
    lines: list[tuple[str, np.ndarray, dict[str, Any]]] = field(default_factory=list)

    def add(self, name: str, x: list[float], y: list[float], style: dict[str, Any]) -> None:
        if x:
            self.axes.plot(x, y, **style)
            self.lines.append((name, np.column_stack([x, y]), style))

    def finish(self, title: str, x_label: str, y_label: str) -> None:
        self.axes.set(xscale="log", yscale="log", title=title, xlabel=x_label, ylabel=y_label)
        self.axes.margins(x=0.12, y=0.12)

    def place_labels(self, renderer: Any) -> None:
        """One after the other, each where it hides the least; the most crowded lines first."""
        scale = self.axes.figure.dpi / 72.0
        paths = [self.axes.transData.transform(points) for _, points, _ in self.lines]
        taken = np.concatenate([_filled(path) for path in paths]) if paths else np.empty((0, 2))
        frame = self.axes.get_window_extent(renderer).extents
        placed: list[np.ndarray] = []
        for (name, points, style), path in zip(self.lines, paths, strict=True):
            text = self.axes.annotate(
                name, points[-1], xytext=(0, 0), textcoords="offset points", fontsize=9.5, va="center",
                color=style["color"], ha="center", fontweight="bold" if style["zorder"] == 4 else "normal",
            )  # fmt: skip
            size = text.get_window_extent(renderer).size
            candidates = [
                (*_box(path[i], place, size, scale), place, i)
                for i in dict.fromkeys((len(path) - 1, 0, len(path) // 2))
                for place in PLACES
            ]
            costs = [
                _hidden(box, taken, placed, frame) + 0.02 * place[2] + 0.1 * (i != len(path) - 1)
                for box, _, place, i in candidates
            ]
            box, centre, place, i = candidates[int(np.argmin(costs))]
            placed.append(box)
            text.remove()
            tie = {"arrowstyle": "-", "color": style["color"], "linewidth": 0.6, "shrinkA": 1, "shrinkB": 3}
            self.axes.annotate(
                name, points[i], xytext=(centre - path[i]) / scale, textcoords="offset points", fontsize=9.5,
                va="center", ha="center", color=style["color"], zorder=5,
                fontweight="bold" if style["zorder"] == 4 else "normal",
                arrowprops=tie if place[2] > LEADER else None,
            )  # fmt: skip


def _filled(path: np.ndarray) -> np.ndarray:
    """A line as points in pixels, close enough to find what a label would hide."""
    if len(path) == 1:
        return path
    steps = np.linspace(0.0, 1.0, 40)[:, None]
    return np.concatenate([a + steps * (b - a) for a, b in pairwise(path)])


def _box(
    point: np.ndarray, place: tuple[float, float, float], size: np.ndarray, scale: float
) -> tuple[np.ndarray, np.ndarray]:
    """(x0, y0, x1, y1) of a label, pixels, and its centre; the label's near edge is `distance` off."""
    across, up, distance = place
    centre = point + np.array([across, up]) * (distance * scale + 0.5 * size * np.abs([across, up]))
    return np.concatenate([centre - 0.5 * size - 2.0, centre + 0.5 * size + 2.0]), centre


def _hidden(box: np.ndarray, taken: np.ndarray, placed: list[np.ndarray], frame: np.ndarray) -> float:
    """How much a label would hide; other labels and the frame weigh the most."""
    inside = ((taken > box[:2]) & (taken < box[2:])).all(axis=1).sum()
    overlap = sum(bool((box[:2] < other[2:]).all() and (other[:2] < box[2:]).all()) for other in placed)
    outside = bool((box[:2] < frame[:2]).any() or (box[2:] > frame[2:]).any())
    return float(inside) + 1000.0 * overlap + 1000.0 * outside
