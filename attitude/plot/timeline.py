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

MAX_JOINED_ANGLE = 1.2  # rad from sample to sample; beyond, a line between samples would mislead
EVENTS = {
    "contact": ("0.35", DASHED),
    "impulse": ("#cc79a7", "-"),
    "rest": (RED, "-"),
    "torque on": ("#8c6d00", "-"),
    "torque off": ("#8c6d00", DASHED),
    "shadow entry": ("0.2", "-"),
    "shadow exit": ("#e0a000", "-"),
    "penumbra entry": ("0.2", DASHED),
    "penumbra exit": ("#e0a000", DASHED),
    "tolerance exceeded": (RED, DASHED),
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
    panels = panels_of(ephemeris)
    size = 9.0, 2.1 * len(panels) + 1.3  # inches
    return drawn(partial(draw, ephemeris, panels), size, file_format)


def panels_of(ephemeris: Ephemeris) -> list[TimelinePanel]:
    """The panels of what the ephemeris holds."""
    names = tuple(f"q_{axis}" for axis in "wxyz")
    panels = [TimelinePanel("attitude", names, ephemeris.quaternion("wxyz"))]
    if ephemeris.has_rate:
        names = tuple(f"omega_{axis}" for axis in "xyz")
        panels.append(TimelinePanel("body rate, rad/s", names, ephemeris.angular_velocity))
    if ephemeris.body is not None and ephemeris.has_rate:
        # energy and momentum over the greatest they reach, where they do not stay as they are
        momentum = np.linalg.norm(ephemeris.angular_momentum, axis=1)
        both = {"energy": ephemeris.kinetic_energy, "momentum": momentum}
        varying = {
            name: value / value.max() for name, value in both.items() if np.ptp(value) > 1e-9 * value.max()
        }
        if varying:
            values = np.stack(list(varying.values()), axis=1)
            panels.append(TimelinePanel("of the greatest", tuple(varying), values))
    if ephemeris.translation is not None:
        panels.append(TimelinePanel("position, m", tuple("xyz"), ephemeris.translation.position))
    return panels


def draw(ephemeris: Ephemeris, panels: list[TimelinePanel], figure: Figure) -> None:
    """Draw the panels: lines through the samples, or dots where the body turns too far between them."""
    order = np.argsort(ephemeris.elapsed, kind="stable")
    seconds = ephemeris.elapsed[order]
    unit, size = time_unit(seconds)
    fastest = float(np.linalg.norm(ephemeris.angular_velocity, axis=1).max()) if ephemeris.has_rate else 0.0
    style: dict[str, Any] = {"linewidth": 1.3}
    if fastest * float(np.median(np.diff(seconds))) > MAX_JOINED_ANGLE:
        style = {"linestyle": "none", "marker": "o", "markersize": 1.3, "markeredgewidth": 0.0}
    rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, panel in zip(rows, panels, strict=True):
        for name, values, colour in zip(panel.names, panel.values.T, (BLACK, RED, BLUE, GREEN), strict=False):
            axes.plot(seconds / size, values[order], color=colour, label=name, **style)
        legend = axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, handlelength=1.4)
        for handle in legend.legend_handles:
            handle.set_markersize(4.0)
        axes.set_ylabel(panel.title)
    rows[0].set_ylim(-1.08, 1.08)
    epoch = ephemeris.epoch
    since = f" since {epoch.isot} {epoch.scale}" if epoch is not None else ""
    rows[-1].set_xlabel(f"time{since}, {unit}")
    draw_events(figure, rows, ephemeris, size)
    figure.align_ylabels(rows)
    figure.suptitle(f"{ephemeris.name or 'A scene'}: attitude, body to {ephemeris.frame}", fontsize=13)


def draw_events(figure: Figure, rows: Any, ephemeris: Ephemeris, size: float) -> None:
    """Draw a line at each event, through all panels; below, what the lines of a kind are and how many."""
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
