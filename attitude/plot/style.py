"""The style of the pictures of scenes, and their encoding as SVG or PNG."""

from __future__ import annotations

import io
from collections.abc import Callable

import numpy as np
from astropy.time import Time
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

SETTINGS = {
    "font.size": 10.0,
    "font.family": "DejaVu Sans",
    "axes.titlesize": 11.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "0.92",
    "svg.fonttype": "none",  # text stays text, to be found and read aloud
    "svg.hashsalt": "attitude",  # the same scene makes the same file
}
RED, BLUE, GREEN, BLACK = "#d55e00", "#0072b2", "#009e73", "#000000"
AXIS_COLOURS = dict(zip("xyz", (RED, GREEN, BLUE), strict=True))  # as the viewer has them
DASHED = (0, (4, 2))
CIRCLES = {"linestyle": "none", "marker": "o", "markerfacecolor": "none"}


def line_colours(count: int) -> tuple[str, ...]:
    """Colours of so many lines of a panel, at most nine: three are those of the axes x, y and z."""
    axes = tuple(AXIS_COLOURS.values())
    others = ("#cc79a7", "#8c6d00", "#56b4e9", "#666666", "#7f3c8d")
    return axes if count == 3 else (BLACK, *axes, *others)[:count]


def time_unit(seconds: np.ndarray) -> tuple[str, float]:
    """The unit of the time axis of these instants, the largest with four in the span, and its seconds."""
    span = float(np.abs(seconds).max())
    units = (("d", 86400.0), ("h", 3600.0), ("min", 60.0), ("s", 1.0))
    return next((each for each in units if span >= 4.0 * each[1]), units[-1])


def time_label(epoch: Time | None, unit: str) -> str:
    """The label of a time axis in a unit, since an epoch or without one."""
    since = f" since {epoch.isot} {epoch.scale}" if epoch is not None else ""
    return f"time{since}, {unit}"


def figure_of(draw: Callable[[Figure], None], size: tuple[float, float]) -> Figure:
    """A figure of that size, inches, with what `draw` puts on it."""
    with rc_context(SETTINGS):
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasAgg(figure)
        draw(figure)
    return figure


def drawn(draw: Callable[[Figure], None], size: tuple[float, float], file_format: str) -> bytes:
    """An "svg", "png" or "pdf" file of what `draw` puts on a figure of that size, inches."""
    figure = figure_of(draw, size)
    with rc_context(SETTINGS):
        file = io.BytesIO()
        metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(file_format, {})
        figure.savefig(file, format=file_format, dpi=150, metadata=metadata)
    return file.getvalue()
