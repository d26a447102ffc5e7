"""The picture of an ensemble: density of an axis, growth of the spread, times of flips."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..plot.style import AXIS_COLOURS, BLACK, BLUE, DASHED, GREEN, RED, drawn, time_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .density import AxisDensity
    from .statistics import Statistics


def picture(
    statistics: Statistics,
    density: AxisDensity,
    flips: np.ndarray | None,
    ending: str,
    name: str = "",
    axis: str = "",
) -> bytes:
    """Draw an "svg" or "png" file: the density at its last instant, the statistics over theirs.

    flips : (n, k), s: of free bodies; drawn if most of them flip before the last instant
    """
    if flips is not None and not np.median(flips[:, 0]) < statistics.seconds.max():
        flips = None
    return drawn(partial(draw, statistics, density, flips, name, axis), (9.0, 8.6), ending)


def draw(
    statistics: Statistics,
    density: AxisDensity,
    flips: np.ndarray | None,
    name: str,
    axis: str,
    figure: Figure,
) -> None:
    """Draw the sphere above, growth and flips below it."""
    rows = figure.add_gridspec(2, 2, height_ratios=[1.25, 1.0])
    draw_sphere(figure, rows[0, :], density, axis)
    draw_growth(figure.add_subplot(rows[1, 0] if flips is not None else rows[1, :]), statistics)
    if flips is not None:
        draw_flips(figure.add_subplot(rows[1, 1]), flips)
    title = f"{name or 'An ensemble'}: {statistics.count} bodies in {statistics.frame}"
    figure.suptitle(title, fontsize=13)


def draw_sphere(figure: Figure, cell: Any, density: AxisDensity, axis: str) -> None:
    """Draw where an axis points, as densities on the sphere."""
    axes = figure.add_subplot(cell, projection="mollweide")
    relative = density.relative[-1]
    longitude = np.linspace(-np.pi, np.pi, relative.shape[1] + 1)
    latitude = np.arcsin(np.linspace(-1.0, 1.0, relative.shape[0] + 1))
    occupied = np.ma.masked_equal(relative, 0.0)
    mesh = axes.pcolormesh(longitude, latitude, occupied, cmap="viridis", norm="log", rasterized=True)
    axes.grid(color="0.85")
    axes.tick_params(labelsize=7)
    unit, seconds = time_unit(density.instants.seconds[-1:])
    after = f"{float(density.instants.seconds[-1]) / seconds:.6g} {unit} after the epoch"
    covered = f"95 % in {100.0 * density.covered[-1]:.3g} % of the sphere"
    axes.set_title(f"where the {axis or 'body'} axis points {after}: {covered}", pad=14)
    bar = figure.colorbar(mesh, ax=axes, shrink=0.8, pad=0.03)
    bar.set_label("density over that of any direction")


def draw_growth(axes: Any, statistics: Statistics) -> None:
    """Draw the spread of attitudes and of the body axes in time."""
    unit, seconds = time_unit(statistics.seconds)
    t = statistics.seconds / seconds
    spread = np.degrees(np.sqrt(np.trace(statistics.covariance, axis1=1, axis2=2)))
    axes.plot(t, spread, color=BLACK, linewidth=1.8, label="attitude, all directions")
    for k, (name, color) in enumerate(AXIS_COLOURS.items()):
        angle = np.degrees(statistics.spreads[:, k])
        axes.plot(t, angle, color=color, linestyle=(DASHED, "-.", ":")[k], label=f"axis {name}")
    axes.set(xlabel=f"time, {unit}", ylabel="spread, deg", title="how the spread grows")
    greatest = float(spread.max())
    if np.median(spread) < 0.3 * greatest:  # most of the curve would be too low on a linear scale
        above_rounding = spread[spread > 1e-9 * greatest]
        axes.set(yscale="log", ylim=(0.5 * above_rounding.min(), 2.0 * greatest))
    after = t[t > 0.0]
    if after.size and after.max() > 500.0 * after.min():  # instants are denser at the beginning
        axes.set(xscale="log", xlim=(after.min(), after.max()))
    axes.legend(frameon=False, fontsize=8)


def draw_flips(axes: Any, flips: np.ndarray) -> None:
    """Draw when the bodies flip, without the long tail of those close to the separatrix."""
    last = float(np.quantile(flips[:, -1], 0.98))
    unit, seconds = time_unit(np.array([last]))
    edges = np.linspace(0.0, last / seconds, 161)
    width = edges[1] - edges[0]
    for k, color in enumerate((RED, BLUE, GREEN)[: flips.shape[1]]):
        counts, _ = np.histogram(flips[:, k] / seconds, edges)
        label = (
            f"flip {k + 1}: {np.mean(flips[:, k]) / seconds:.4g} ± {np.std(flips[:, k]) / seconds:.2g} {unit}"
        )
        axes.stairs(counts / (len(flips) * width), edges, color=color, fill=True, alpha=0.35)
        axes.stairs(counts / (len(flips) * width), edges, color=color, label=label)
    axes.set(xlabel=f"time, {unit}", ylabel=f"bodies, of all, per {unit}", title="when they flip")
    axes.legend(frameon=False, fontsize=8)
