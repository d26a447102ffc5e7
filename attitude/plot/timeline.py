"""The picture of an ephemeris: attitude, rate, energy, momentum and position in time, with events."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.patches import Patch

from ..errors import InputError
from ..frames.rotations import TURNING_FRAMES
from . import choices, spread
from .choices import TimelinePanel
from .curves import CURVES, line_style
from .style import DASHED, RED, drawn, figure_of, line_colours, time_label, time_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..samples.ephemeris_data import EphemerisData

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


def picture(ephemeris: EphemerisData, file_format: str, what: Sequence[str] = ()) -> bytes:
    """An "svg", "png" or "pdf" file of one body's ephemeris: of `what` (`choices`), or of all it holds.

    Raises InputError for a batch of bodies, and for one instant or none.
    """
    return drawn(*_prepared(ephemeris, what), file_format)


def figure(ephemeris: EphemerisData, what: Sequence[str] = ()) -> Figure:
    """The timeline as a figure of matplotlib."""
    return figure_of(*_prepared(ephemeris, what))


def _prepared(
    ephemeris: EphemerisData, what: Sequence[str]
) -> tuple[Callable[[Figure], None], tuple[float, float]]:
    """What draws it, and the size, inches."""
    if len(ephemeris.shape) != 1 or len(ephemeris) < 2:
        raise InputError("ephemeris", f"shape {ephemeris.shape}", "one body at two instants or more")
    curves = [CURVES[name] for name in what if name in CURVES]
    names = [name for name in what if name not in CURVES]
    panels = list(choices.panels(ephemeris, names)) if what else panels_of(ephemeris)
    if spread.has_spread(ephemeris) and panels:
        panels = with_sigma(ephemeris, panels, names)
    heights = [2.1 * len(panels) + 1.3] * bool(panels) + [5.0] * len(curves)

    def draw_all(whole: Figure) -> None:
        parts = np.atleast_1d(whole.subfigures(len(heights), 1, height_ratios=heights))
        if panels:
            draw(ephemeris, panels, parts[0])
        for curve, part in zip(curves, parts[len(heights) - len(curves) :], strict=True):
            curve(ephemeris, part)

    return draw_all, (9.0, sum(heights))


def panels_of(ephemeris: EphemerisData) -> list[TimelinePanel]:
    """The panels of what the ephemeris holds."""
    names = tuple(f"q_{axis}" for axis in "wxyz")
    panels = [TimelinePanel("attitude", names, ephemeris.quaternion("wxyz"))]
    if ephemeris.has_rate:
        names = tuple(f"omega_{axis}" for axis in "xyz")
        panels.append(TimelinePanel("body rate, rad/s", names, ephemeris.angular_velocity))
    is_inertial = ephemeris.frame not in TURNING_FRAMES
    if ephemeris.body is not None and ephemeris.has_rate and is_inertial:
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


def with_sigma(
    ephemeris: EphemerisData, panels: list[TimelinePanel], names: Sequence[str]
) -> list[TimelinePanel]:
    """The panels, of names or of what the ephemeris holds, with 1 sigma where it is not zero."""
    exact = [name for name in names if not choices.has_own_uncertainty(name)]

    def functions(moved: EphemerisData) -> Iterator[tuple[str, str, np.ndarray]]:
        for panel in choices.panels(moved, exact) if names else panels_of(moved):
            yield panel.title, panel.title.rpartition(", ")[2], panel.values

    sigmas = spread.sigmas(ephemeris, functions)
    return [
        panel._replace(sigma=sigmas[panel.title]) if sigmas.get(panel.title, np.zeros(1)).any() else panel
        for panel in panels
    ]


def draw(ephemeris: EphemerisData, panels: list[TimelinePanel], figure: Any) -> None:
    """Draw the panels: lines through the samples, or dots where the body turns too far between them."""
    order = np.argsort(ephemeris.elapsed, kind="stable")
    seconds = ephemeris.elapsed[order]
    unit, size = time_unit(seconds)
    style = line_style(ephemeris)
    rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, panel in zip(rows, panels, strict=True):
        for i, (name, colour) in enumerate(zip(panel.names, line_colours(len(panel.names)), strict=True)):
            axes.plot(seconds / size, panel.values[order, i], color=colour, label=name, **style)
        draw_bands(axes, seconds / size, panel, order, "marker" in style)
        if any(panel.names):
            legend = axes.legend(
                loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, handlelength=1.4
            )
            for handle in legend.legend_handles:
                handle.set_markersize(4.0)
        axes.set_ylabel(panel.title)
    rows[-1].set_xlabel(time_label(ephemeris.epoch, unit))
    marks = draw_events(rows, ephemeris, size) | draw_limit(rows, ephemeris, panels, (unit, size))
    if panels[0].title == "attitude":
        rows[0].set_ylim(-1.08, 1.08)
    if marks:
        figure.legend(marks.values(), marks.keys(), loc="outside lower center", ncols=6, frameon=False)
    figure.align_ylabels(rows)
    figure.suptitle(f"{ephemeris.name or 'A scene'}: attitude, body to {ephemeris.frame}", fontsize=13)


def draw_bands(axes: Any, times: np.ndarray, panel: TimelinePanel, order: np.ndarray, has_dots: bool) -> None:
    """Draw 1 sigma to either side of the panel's values, as bands or, of dots, as bars."""
    if panel.sigma is None:
        return
    for values, sigma, line in zip(
        panel.values[order].T, panel.sigma[order].T, axes.get_lines(), strict=False
    ):
        ends, colour = (values - sigma, values + sigma), line.get_color()
        if has_dots:
            axes.vlines(times, *ends, color=colour, alpha=0.3, linewidth=0.8)
        else:
            axes.fill_between(times, *ends, color=colour, alpha=0.2, linewidth=0.0)


def set_limits(axes: Any, panel: TimelinePanel, is_linear: np.ndarray) -> None:
    """Limits of the ordinate that hold the values, and the bands where these are to be trusted."""
    if panel.sigma is None:
        return
    sigma = np.where(is_linear[:, None], panel.sigma, 0.0)
    low, high = float((panel.values - sigma).min()), float((panel.values + sigma).max())
    margin = 0.05 * (high - low) or 1.0
    axes.set_ylim(low - margin, high + margin)


def draw_events(rows: Any, ephemeris: EphemerisData, size: float) -> dict[str, Any]:
    """Draw a line at each event, through all panels; the lines by their kind, and how many there are."""
    counts = Counter(event.kind for event in ephemeris.events)
    handles = {}
    for event in ephemeris.events:
        colour, dashes = EVENTS.get(event.kind, ("0.5", ":"))
        width = 0.9 if counts[event.kind] <= 40 else 0.3
        for axes in rows:
            line = axes.axvline(
                event.seconds / size, color=colour, linestyle=dashes, linewidth=width, zorder=1
            )
        label = event.kind if counts[event.kind] == 1 else f"{event.kind} ({counts[event.kind]})"
        handles[label] = line
    return handles


def draw_limit(
    rows: Any, ephemeris: EphemerisData, panels: list[TimelinePanel], scale: tuple[str, float]
) -> dict[str, Any]:
    """Shade where the uncertainty is no longer of first order; what bands and shade mean, by their label."""
    if ephemeris.uncertainty is None or all(panel.sigma is None for panel in panels):
        return {}
    (unit, size), limit = scale, ephemeris.uncertainty.linear_until or np.inf
    elapsed = ephemeris.elapsed
    for axes, panel in zip(rows, panels, strict=True):
        set_limits(axes, panel, np.abs(elapsed) < limit)
    marks = {"band: 1 sigma to either side": Patch(color="0.4", alpha=0.3, linewidth=0.0)}
    for start, stop in ((limit, float(elapsed.max())), (float(elapsed.min()), -limit)):
        if start < stop:
            for axes in rows:
                shade = axes.axvspan(
                    start / size, stop / size, facecolor="0.92", edgecolor="0.5", linestyle=":", zorder=0
                )
            marks[f"from {limit / size:.4g} {unit} on the first order is off by > 10 % at 3 sigma"] = shade
    return marks
