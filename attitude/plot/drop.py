"""The picture of a drop: attitude with gravity, without, and by the closed form, through a collision."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..dynamics.drop_comparison import Curve, Drop
from .style import BLUE, DASHED, GREEN, RED, drawn

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZE = (9.0, 9.0)  # inches
MODEL = "model: the closed form, without ground"
FALLING = "simulation with gravity"
WEIGHTLESS = "simulation without gravity"
MAX_CIRCLES = 60  # of the weightless curve, so that the line below them is seen
LABEL_WIDTH = 0.14  # of the span: the label of a contact


def picture(drop: Drop, file_format: str, name: str = "") -> bytes:
    """An "svg" or "png" file."""
    return drawn(partial(_draw, drop, name), SIZE, file_format)


def _draw(drop: Drop, name: str, figure: Figure) -> None:
    if len(drop.falling.seconds) < len(drop.model.seconds):  # it came to rest, and is followed no further
        drop = Drop(*(_until(curve, drop.falling.seconds[-1]) for curve in drop))
    panels = figure.subplots(5, 1, sharex=True, height_ratios=[1, 1, 1, 1, 1.1])
    for component, axes in enumerate(panels[:4]):
        _attitude(axes, drop, component)
    _departure(panels[4], drop)
    panels[4].set_xlabel("time, s")
    for axes in panels:
        for moment in drop.falling.contacts:
            axes.axvline(moment, color="0.45", linewidth=0.9, linestyle=DASHED, zorder=1)
    figure.suptitle(f"{name or 'A drop'}: attitude through a collision with the ground", fontsize=13)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, frameon=False)


def _attitude(axes: Any, drop: Drop, component: int) -> None:
    """One component of the quaternions."""
    name = f"q_{'wxyz'[component]}"
    model, falling, circles = drop.model, drop.falling, _thinned(drop.weightless)
    start = falling.seconds[:1], falling.quaternion[:1, component]
    axes.plot(
        model.seconds, model.quaternion[:, component], color=GREEN, linewidth=4.5, alpha=0.45, label=MODEL
    )
    axes.plot(falling.seconds, falling.quaternion[:, component], color=BLUE, linewidth=1.5, label=FALLING)
    style = {"color": RED, "marker": "o", "markersize": 4.0, "markerfacecolor": "none", "linestyle": "none"}
    axes.plot(circles.seconds, circles.quaternion[:, component], label=WEIGHTLESS, **style)
    axes.plot(*start, color="black", marker="o", markersize=6, linestyle="none", label="start")
    axes.set(ylabel=name, ylim=(-1.08, 1.08))


def _departure(axes: Any, drop: Drop) -> None:
    """The angle between simulated and modelled attitudes, and the contacts."""
    for curve, color, style in ((drop.falling, BLUE, "-"), (_thinned(drop.weightless), RED, "o")):
        model = drop.model.quaternion[np.searchsorted(drop.model.seconds, curve.seconds)]
        angle = np.rad2deg(_angle(model, curve.quaternion))
        axes.plot(
            curve.seconds, angle, style, color=color, linewidth=1.5, markersize=4, markerfacecolor="none"
        )
    axes.set(ylabel="from the model, deg", ylim=(-5, 185), yticks=[0, 90, 180])
    start, stop = float(drop.falling.seconds[0]), float(drop.falling.seconds[-1])
    for number, moment in enumerate(_apart(drop.falling.contacts, LABEL_WIDTH * (stop - start))):
        text = f"contact, {moment:.3f} s" if number == 0 else f"{moment:.3f} s"
        side = (-5, "right") if moment - start > LABEL_WIDTH * (stop - start) else (5, "left")
        offset = {"xytext": (side[0], 0), "textcoords": "offset points", "ha": side[1], "va": "center"}
        axes.annotate(text, (moment, 150.0), color="0.25", fontsize=9, **offset)


def _apart(moments: list[float], distance: float) -> list[float]:
    """Those of ascending moments whose labels do not overlap."""
    labelled: list[float] = []
    for moment in moments:
        if not labelled or moment - labelled[-1] >= distance:
            labelled.append(moment)
    return labelled


def _until(curve: Curve, seconds: float) -> Curve:
    count = int(np.searchsorted(curve.seconds, seconds, side="right"))
    return Curve(curve.seconds[:count], curve.quaternion[:count], curve.contacts)


def _thinned(curve: Curve) -> Curve:
    step = max(1, len(curve.seconds) // MAX_CIRCLES)
    return Curve(curve.seconds[::step], curve.quaternion[::step], curve.contacts)


def _angle(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """(n,), rad, of the rotation between attitudes: 2 asin of the vector part of conj(p) q."""
    scalar, rest = q[:, :1], q[:, 1:]
    vector = p[:, :1] * rest - scalar * p[:, 1:] - np.cross(p[:, 1:], rest)
    return 2.0 * np.arcsin(np.minimum(np.linalg.norm(vector, axis=1), 1.0))
