"""Picture of a measurement: error against cost, and both against the horizon.

Each line is labelled and has a colour, a marker and a dash pattern of its own.
"""

from __future__ import annotations

import io
import math
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..plot.style import SETTINGS
from .cell import MEASURED, ZERO_ERROR, Cell, CostData
from .initial_value_problem import counted

SIZE = (10.0, 9.6)  # inches
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
    with rc_context(SETTINGS):
        figure = Figure(figsize=SIZE, layout="constrained")
        figure.get_layout_engine().set(w_pad=0.1, h_pad=0.07)
        canvas = FigureCanvasAgg(figure)
        panels = draw_panels(figure, report)
        canvas.draw()  # labels are placed once axes and lines have their positions
        figure.set_layout_engine("none")
        for panel in panels:
            panel.place_labels(canvas.get_renderer())
        file = io.BytesIO()
        metadata = {"Date": None} if ending == "svg" else {}
        figure.savefig(file, format=ending, dpi=150, metadata=metadata)
    return file.getvalue()


def draw_panels(figure: Figure, report: CostData) -> list[LogLogPanel]:
    """Error against cost at one horizon; error, and cost, against the horizon."""
    families = list(dict.fromkeys(cell.family for cell in report.cells))
    styles = {family: line_style(number) for number, family in enumerate(families)}
    horizon = _fullest_horizon(report)
    tightest = {family: _tightest(report, family, horizon) for family in families}
    axes = figure.subplot_mosaic([["work", "work"], ["error", "cost"]], height_ratios=[1.15, 1.0])
    work, error, cost = (LogLogPanel(axes[name]) for name in ("work", "error", "cost"))
    for family, style in styles.items():
        at = [cell for cell in report.at(horizon) if cell.family == family and cell.status == MEASURED]
        work.add(family, *_costs_and_errors(at), style)
        x, (costs, errors) = [cell.horizon for cell in tightest[family]], _costs_and_errors(tightest[family])
        error.add(family, x, errors, style)
        cost.add(family, x, costs, style)
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
        cells = [cell for cell in report.at(horizon) if cell.status == MEASURED]
        return len({cell.family for cell in cells}) if report.effects else len(cells)

    return max(report.horizons, key=lambda horizon: (measured(horizon), horizon))


def _tightest(report: CostData, family: str, horizon: float) -> list[Cell]:
    """The measured cells of a family's tightest setting; of those measured over the horizon, if any."""
    cells = [cell for cell in report.cells if cell.family == family and cell.status == MEASURED]
    there = [cell for cell in cells if cell.horizon == horizon] or cells
    if not there:
        return []
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


# -- labels ---------------------------------------------------------------------------------------

# Candidate positions of a label relative to its point: direction, distance in points; nearest first.
LABEL_OFFSETS = [
    (np.array([math.cos(angle), math.sin(angle)]), distance)
    for distance in (9.0, 16.0, 28.0, 44.0, 64.0, 90.0)
    for angle in np.deg2rad([0, 90, 270, 45, 315, 135, 225, 180, 20, 340, 70, 290])
]
LEADER_DISTANCE = 12.0  # points; labels farther off are joined to their point by a thin line
LABEL_MARGIN = 3.0  # pixels kept free about a label


@dataclass
class LabelPosition:
    """A candidate position of a label, in pixels: labelled point, centre, size, distance."""

    point: np.ndarray
    centre: np.ndarray
    size: np.ndarray
    distance: float

    @property
    def low(self) -> np.ndarray:
        """Lower left corner with its margin."""
        return self.centre - 0.5 * self.size - LABEL_MARGIN

    @property
    def high(self) -> np.ndarray:
        """Upper right corner with its margin."""
        return self.centre + 0.5 * self.size + LABEL_MARGIN

    @property
    def leader(self) -> np.ndarray:
        """Points of the line that joins the label to its point; none for a near label."""
        is_near = self.distance <= LEADER_DISTANCE
        return np.empty((0, 2)) if is_near else _filled(np.array([self.point, self.centre]))

    def hides(self, occupied: np.ndarray) -> int:
        """Number of occupied points under the label."""
        return int(((occupied > self.low) & (occupied < self.high)).all(axis=1).sum())

    def overlaps(self, other: LabelPosition) -> bool:
        """Whether two labels overlap."""
        return bool((self.low < other.high).all() and (other.low < self.high).all())


@dataclass
class LogLogPanel:
    """Axes with two logarithmic scales, and the lines drawn in them."""

    axes: Any
    lines: list[tuple[str, np.ndarray, dict[str, Any]]] = field(default_factory=list)

    def add(self, name: str, x: list[float], y: list[float], style: dict[str, Any]) -> None:
        """Draw one line."""
        if x:
            self.axes.plot(x, y, **style)
            self.lines.append((name, np.column_stack([x, y]), style))

    def finish(self, title: str, x_label: str, y_label: str) -> None:
        """Set scales, titles and margins."""
        self.axes.set(xscale="log", yscale="log", title=title, xlabel=x_label, ylabel=y_label)
        self.axes.margins(x=0.12, y=0.12)

    def place_labels(self, renderer: Any) -> None:
        """Place labels one after the other, each where it hides least."""
        scale = self.axes.figure.dpi / 72.0
        paths = [self.axes.transData.transform(points) for _, points, _ in self.lines]
        occupied = np.concatenate([np.empty((0, 2)), *map(_filled, paths)])
        frame = self.axes.get_window_extent(renderer).extents
        placed: list[LabelPosition] = []
        for (name, _, style), path in zip(self.lines, paths, strict=True):
            text = self._text(name, style, path[-1], path[-1])
            candidates = list(_label_positions(path, text.get_window_extent(renderer).size, scale))
            text.remove()
            best = min(candidates, key=lambda position: _penalty(position, occupied, placed, frame))
            self._text(name, style, best.point, best.centre, tied=best.distance > LEADER_DISTANCE)
            occupied = np.concatenate([occupied, best.leader])
            placed.append(best)

    def _text(
        self, name: str, style: dict[str, Any], point: np.ndarray, centre: np.ndarray, tied: bool = False
    ) -> Any:
        tie = {"arrowstyle": "-", "color": style["color"], "linewidth": 0.6, "shrinkA": 1, "shrinkB": 3}
        return self.axes.annotate(
            name,
            self.axes.transData.inverted().transform(point),
            xytext=(centre - point) * 72.0 / self.axes.figure.dpi,
            textcoords="offset points",
            fontsize=9.5,
            fontweight="bold" if style["zorder"] == 4 else "normal",
            color=style["color"],
            ha="center",
            va="center",
            zorder=5,
            arrowprops=tie if tied else None,
        )


def _filled(path: np.ndarray) -> np.ndarray:
    """A line and its markers as a dense set of points, pixels."""
    marker = 5.0 * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])  # its extent in pixels
    markers = (path[:, None] + marker).reshape(-1, 2)
    steps = np.linspace(0.0, 1.0, 60)[:, None]
    return np.concatenate([markers, *(a + steps * (b - a) for a, b in pairwise(path))])


def _label_positions(path: np.ndarray, size: np.ndarray, scale: float) -> Iterator[LabelPosition]:
    """Positions about the last, first and middle point of a line; `distance` is that of the nearest edge."""
    for i in dict.fromkeys((len(path) - 1, 0, len(path) // 2)):
        for direction, distance in LABEL_OFFSETS:
            centre = path[i] + direction * (distance * scale + 0.5 * size * np.abs(direction))
            yield LabelPosition(path[i], centre, size, distance)


def _penalty(
    position: LabelPosition, occupied: np.ndarray, placed: list[LabelPosition], frame: np.ndarray
) -> float:
    """Penalty of a position: hidden points and distance; crossed labels count more, overlaps most."""
    overlaps = sum(position.overlaps(other) for other in placed)
    crossed = sum(other.hides(position.leader) > 0 for other in placed)
    outside = bool((position.low < frame[:2]).any() or (position.high > frame[2:]).any())
    return (
        position.hides(occupied) + 0.02 * position.distance + 100.0 * crossed + 1000.0 * (overlaps + outside)
    )
