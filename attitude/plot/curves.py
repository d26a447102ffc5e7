"""Curves that are not against time: the polhode, the momentum on its sphere, the track on the ground."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.ticker import MaxNLocator

from ..pointing.surface_points import ground_points
from ..samples.ephemeris_data import EphemerisData
from . import spread
from .style import BLACK, BLUE, RED

MAX_JOINED_ANGLE = 1.2  # rad from sample to sample; beyond, a line between samples would mislead


def line_style(data: EphemerisData) -> dict[str, Any]:
    """Lines through the samples, or dots where the body turns too far between them."""
    fastest = float(np.linalg.norm(data.angular_velocity, axis=1).max()) if data.has_rate else 0.0
    if fastest * float(np.median(np.diff(np.sort(data.elapsed)))) > MAX_JOINED_ANGLE:
        return {"linestyle": "none", "marker": "o", "markersize": 1.3, "markeredgewidth": 0.0}
    return {"linewidth": 1.3}


def polhode(data: EphemerisData, figure: Any) -> None:
    """Draw the angular velocity in the body."""
    axes = figure.add_subplot(projection="3d")
    rate = data.angular_velocity
    axes.plot(*rate.T, color=BLUE, **line_style(data))
    axes.plot(*rate[:1].T, "o", color=BLACK, markersize=4)
    name_axes(axes)
    axes.set_title("polhode: the angular velocity in the body, rad/s")


def momentum_sphere(data: EphemerisData, figure: Any) -> None:
    """Draw the direction of the angular momentum in the body, on the unit sphere."""
    axes = figure.add_subplot(projection="3d")
    momentum = data.rotation.inv().apply(data.angular_momentum)
    size = np.linalg.norm(momentum, axis=1, keepdims=True)
    direction = momentum / np.where(size > 0.0, size, 1.0)
    angle = np.linspace(0.0, 2.0 * np.pi, 121)
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)])
    for turn in range(3):
        axes.plot(*np.roll(circle, turn, axis=0), color="0.8", linewidth=0.8)
    axes.plot(*direction.T, color=RED, **line_style(data))
    axes.plot(*direction[:1].T, "o", color=BLACK, markersize=4)
    name_axes(axes)
    axes.set_title("the angular momentum's direction in the body")


def ground_track(data: EphemerisData, figure: Any) -> None:
    """Draw where the body's z axis meets the ground."""
    axes = figure.add_subplot()
    points = ground_points(data, "z")
    longitude, latitude = (np.rad2deg(values).compressed() for values in (points.longitude, points.latitude))
    axes.plot((longitude + 180.0) % 360.0 - 180.0, latitude, ".", color=BLUE, markersize=2)
    if spread.has_spread(data):
        _ground_ellipses(data, axes)
    axes.set(xlim=(-180, 180), ylim=(-90, 90), xticks=range(-180, 181, 60), yticks=range(-90, 91, 30))
    axes.set(xlabel="longitude, deg", ylabel="latitude, deg", aspect="equal")
    axes.set_title("where the body's z axis meets the ground")


def _ground_ellipses(data: EphemerisData, axes: Any) -> None:
    """Draw where the z axis meets the ground when it goes once around its ellipse of 1 sigma."""
    assert data.uncertainty is not None
    limit = data.uncertainty.linear_until or np.inf
    is_shown = ~np.ma.getmaskarray(ground_points(data, "z").longitude) & (np.abs(data.elapsed) < limit)
    index = np.flatnonzero(is_shown)
    if not index.size:
        return
    some = data[index[np.unique(np.linspace(0, index.size - 1, 24).round().astype(int))]]
    angles = np.linspace(0.0, 2.0 * np.pi, 49)
    points = ground_points(spread.around(some, np.array([0.0, 0.0, 1.0]), angles), "z")
    longitude, latitude = (
        np.rad2deg(values.filled(np.nan)).reshape(-1, angles.size)
        for values in (points.longitude, points.latitude)
    )
    longitude = (longitude + 180.0) % 360.0 - 180.0
    # where an ellipse crosses the edge of the map its line is broken
    longitude[:, 1:][np.abs(np.diff(longitude, axis=1)) > 180.0] = np.nan
    axes.plot(longitude.T, latitude.T, color=RED, linewidth=0.8)
    axes.plot([], [], color=RED, linewidth=0.8, label="ellipse of 1 sigma")
    axes.legend(loc="upper right")


def name_axes(axes: Any) -> None:
    """Name the axes of a picture in space, with few ticks along short ones, whose labels would meet."""
    axes.set(xlabel="x", ylabel="y", zlabel="z")
    axes.set_aspect("equal")
    limits = np.array([axes.get_xlim(), axes.get_ylim(), axes.get_zlim()])
    spans, middles = np.ptp(limits, axis=1), limits.mean(axis=1)
    for axis, span, middle in zip((axes.xaxis, axes.yaxis, axes.zaxis), spans, middles, strict=True):
        if span < 0.2 * spans.max():
            axis.set_ticks([middle], [f"{middle:.4g}"])
        else:
            axis.set_major_locator(MaxNLocator(1 + round(3 * span / spans.max())))
        axis.labelpad = 8.0


CURVES: dict[str, Callable[[EphemerisData, Any], None]] = {
    "polhode": polhode,
    "momentum-sphere": momentum_sphere,
    "ground-track": ground_track,
}
