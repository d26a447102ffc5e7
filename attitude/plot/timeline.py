"""The picture of an ephemeris: attitude, rate, energy, momentum and position in time, with events."""

from __future__ import annotations

from collections import Counter
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..errors import InputError
from .style import BLACK, BLUE, DASHED, GREEN, RED, drawn, time_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..ephemeris import Ephemeris

WIDTH, HEIGHT, MARGIN = 9.0, 2.1, 1.3  # inches: of all, of a panel, beside the panels
COLOURS = (BLACK, RED, BLUE, GREEN)
MAX_JOINED_ANGLE = 1.2  # rad from sample to sample; beyond, a line between samples would mislead
CONSERVED = 1e-9  # relative: quantities that change by less are not drawn
EVENTS = {
    "contact": ("0.35", DASHED),
    "impulse": ("#cc79a7", "-"),
    "rest": (RED, "-"),
    "torque on": ("#8c6d00", "-"),
    "torque off": ("#8c6d00", DASHED),
    "shadow entry": ("0.2", "-"),
    "shadow exit": ("#e0a000", "-"),
}


class TimelinePanel(NamedTuple):
    """Lines with an axis of their own: (n, lines) values, and the name of each line."""

    title: str
    names: tuple[str, ...]
    values: np.ndarray


def picture(ephemeris: Ephemeris, file_format: str) -> bytes:
    """An "svg" or "png" file of one body's ephemeris.

    Raises InputError for a batch of bodies, and for one instant or none.
    """
    if len(ephemeris.shape) != 1 or len(ephemeris) < 2:
        raise InputError("ephemeris", f"shape {ephemeris.shape}", "one body at two instants or more")
    panels = _panels(ephemeris)
    size = WIDTH, HEIGHT * len(panels) + MARGIN
    return drawn(partial(_draw, ephemeris, panels), size, file_format)


def _panels(ephemeris: Ephemeris) -> list[TimelinePanel]:
    names = tuple(f"q_{axis}" for axis in "wxyz")
    panels = [TimelinePanel("attitude", names, ephemeris.quaternion("wxyz"))]
    if ephemeris.has_rate:
        names = tuple(f"omega_{axis}" for axis in "xyz")
        panels.append(TimelinePanel("body rate, rad/s", names, ephemeris.angular_velocity))
    if ephemeris.body is not None and ephemeris.has_rate:
        panels += _changing(ephemeris)
    if ephemeris.translation is not None:
        panels.append(TimelinePanel("position, m", tuple("xyz"), ephemeris.translation.position))
    return panels


def _changing(ephemeris: Ephemeris) -> list[TimelinePanel]:
    """Energy and momentum over the greatest they reach, where they do not stay as they are."""
    momentum = np.linalg.norm(ephemeris.angular_momentum, axis=1)
    both = {"energy": ephemeris.kinetic_energy, "momentum": momentum}
    varying = {
        name: value / value.max() for name, value in both.items() if np.ptp(value) > CONSERVED * value.max()
    }
    return (
        [TimelinePanel("of the greatest", tuple(varying), np.stack(list(varying.values()), axis=1))]
        if varying
        else []
    )


def _draw(ephemeris: Ephemeris, panels: list[TimelinePanel], figure: Figure) -> None:
    order = np.argsort(ephemeris.elapsed, kind="stable")
    seconds = ephemeris.elapsed[order]
    unit, size = time_unit(seconds)
    styles = _styles(ephemeris, seconds)
    rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, panel in zip(rows, panels, strict=True):
        _lines(axes, panel, seconds / size, order, styles)
        axes.set_ylabel(panel.title)
    rows[0].set_ylim(-1.08, 1.08)
    rows[-1].set_xlabel(f"time{_since(ephemeris)}, {unit}")
    _events(figure, rows, ephemeris, size)
    figure.align_ylabels(rows)
    figure.suptitle(f"{ephemeris.name or 'A scene'}: attitude, body to {ephemeris.frame}", fontsize=13)


def _since(ephemeris: Ephemeris) -> str:
    return f" since {ephemeris.epoch.isot} {ephemeris.epoch.scale}" if ephemeris.epoch is not None else ""


def _styles(ephemeris: Ephemeris, seconds: np.ndarray) -> dict[str, Any]:
    """Lines through the samples, or dots where the body turns too far between them."""
    fastest = float(np.linalg.norm(ephemeris.angular_velocity, axis=1).max()) if ephemeris.has_rate else 0.0
    if fastest * float(np.median(np.diff(seconds))) > MAX_JOINED_ANGLE:
        return {"linestyle": "none", "marker": "o", "markersize": 1.3, "markeredgewidth": 0.0}
    return {"linewidth": 1.3}


def _lines(
    axes: Any, panel: TimelinePanel, time: np.ndarray, order: np.ndarray, style: dict[str, Any]
) -> None:
    for name, values, colour in zip(panel.names, panel.values.T, COLOURS, strict=False):
        axes.plot(time, values[order], color=colour, label=name, **style)
    legend = axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, handlelength=1.4)
    for handle in legend.legend_handles:
        handle.set_markersize(4.0)


def _events(figure: Figure, rows: Any, ephemeris: Ephemeris, size: float) -> None:
    """A line at each, through all panels; below, what the lines of a kind are and how many."""
    counts = Counter(event.kind for event in ephemeris.events)
    handles = {}
    for event in ephemeris.events:
        colour, dashes = EVENTS.get(event.kind, ("0.5", ":"))
        width = 0.9 if counts[event.kind] <= 40 else 0.3
        for axes in rows:
            line = axes.axvline(
                event.seconds / size, color=colour, linestyle=dashes, linewidth=width, zorder=1
            )
        handles[event.kind] = line
    if handles:
        labels = [kind if counts[kind] == 1 else f"{kind} ({counts[kind]})" for kind in handles]
        figure.legend(handles.values(), labels, loc="outside lower center", ncols=6, frameon=False)
