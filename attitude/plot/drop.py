"""The picture of a drop: attitude with gravity, without, and by the closed form, through a collision."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..dynamics.drop_comparison import Drop
from ..frames.rotations import angle_between
from .style import BLUE, CIRCLES, DASHED, GREEN, RED, drawn

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LABEL_WIDTH = 0.14  # of the span: the label of a contact


def picture(drop: Drop, file_format: str, name: str = "") -> bytes:
    """An "svg" or "png" file."""
    return drawn(partial(draw, drop, name), (9.0, 9.0), file_format)


def draw(drop: Drop, name: str, figure: Figure) -> None:
    """Four panels of the quaternion's components, and one of the angle from the model."""
    if len(drop.falling.seconds) < len(drop.model.seconds):  # it came to rest, and is followed no further
        drop = Drop(*(curve.part(curve.seconds <= drop.falling.seconds[-1]) for curve in drop))
    step = max(1, len(drop.weightless.seconds) // 60)  # few circles, so that the line below them is seen
    drop = drop._replace(weightless=drop.weightless.part(slice(None, None, step)))
    panels = figure.subplots(5, 1, sharex=True, height_ratios=[1, 1, 1, 1, 1.1])
    for component, axes in enumerate(panels[:4]):
        draw_component(axes, drop, component)
    draw_departure(panels[4], drop)
    panels[4].set_xlabel("time, s")
    for axes in panels:
        for moment in drop.falling.contacts:
            axes.axvline(moment, color="0.45", linewidth=0.9, linestyle=DASHED, zorder=1)
    figure.suptitle(f"{name or 'A drop'}: attitude through a collision with the ground", fontsize=13)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, frameon=False)


def draw_component(axes: Any, drop: Drop, component: int) -> None:
    """Draw one component of the quaternions."""
    curves = {
        "model: the closed form, without ground": {"color": GREEN, "linewidth": 4.5, "alpha": 0.45},
        "simulation with gravity": {"color": BLUE, "linewidth": 1.5},
        "simulation without gravity": {"color": RED, **CIRCLES, "markersize": 4.0},
    }
    for curve, (label, style) in zip(
        (drop.model, drop.falling, drop.weightless), curves.items(), strict=True
    ):
        axes.plot(curve.seconds, curve.quaternion[:, component], label=label, **style)
    start = drop.falling.seconds[:1], drop.falling.quaternion[:1, component]
    axes.plot(*start, color="black", marker="o", markersize=6, linestyle="none", label="start")
    axes.set(ylabel=f"q_{'wxyz'[component]}", ylim=(-1.08, 1.08))


def draw_departure(axes: Any, drop: Drop) -> None:
    """Draw the angle between simulated and modelled attitudes, and the contacts."""
    for curve, style in ((drop.falling, {"color": BLUE}), (drop.weightless, {"color": RED, **CIRCLES})):
        model = drop.model.quaternion[np.searchsorted(drop.model.seconds, curve.seconds)]
        angle = np.rad2deg(angle_between(model, curve.quaternion))
        axes.plot(curve.seconds, angle, linewidth=1.5, markersize=4, **style)
    axes.set(ylabel="from the model, deg", ylim=(-5, 185), yticks=[0, 90, 180])
    start, stop = float(drop.falling.seconds[0]), float(drop.falling.seconds[-1])
    width = LABEL_WIDTH * (stop - start)
    for number, moment in enumerate(apart(drop.falling.contacts, width)):
        text = f"contact, {moment:.3f} s" if number == 0 else f"{moment:.3f} s"
        shift, side = (-5, "right") if moment - start > width else (5, "left")
        offset = {"xytext": (shift, 0), "textcoords": "offset points", "ha": side, "va": "center"}
        axes.annotate(text, (moment, 150.0), color="0.25", fontsize=9, **offset)


def apart(moments: list[float], distance: float) -> list[float]:
    """Which of ascending moments have labels that do not overlap."""
    labelled: list[float] = []
    for moment in moments:
        if not labelled or moment - labelled[-1] >= distance:
            labelled.append(moment)
    return labelled
