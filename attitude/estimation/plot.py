"""The picture of a fit: residuals of every set of observations, and body rates observed and computed."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..plot.style import AXIS_COLOURS, BLACK, CIRCLES, DASHED, drawn, time_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..motion import TorqueFreeMotion
    from .residuals import Residuals


def picture(motion: TorqueFreeMotion, residuals: Sequence[Residuals], file_format: str) -> bytes:
    """An "svg" or "png" file of the residuals of a fit, and of the rates of its motion."""
    return drawn(partial(_draw, motion, residuals), (9.0, 2.6 * len(residuals)), file_format)


def _draw(motion: TorqueFreeMotion, residuals: Sequence[Residuals], figure: Figure) -> None:
    unit, length = time_unit(np.concatenate([each.seconds for each in residuals]))
    panels = np.atleast_1d(figure.subplots(len(residuals), 1, sharex=True))
    for each, panel in zip(residuals, panels, strict=True):
        if each.unit == "rad/s":
            _rates(motion, each, panel, (unit, length))
        else:
            _sizes(each, panel, length)
        if each.is_outlier.any():
            panel.plot([], [], color=BLACK, marker="x", linestyle="none", label="outlier")
        panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    panels[-1].set_xlabel(f"time since the epoch, {unit}")


def _sizes(residuals: Residuals, panel: Axes, length: float) -> None:
    """Components of residuals, or how far directions and ranges are off."""
    factor, unit = (180.0 / np.pi, "deg") if residuals.unit == "rad" else (1.0, residuals.unit)
    time, values = residuals.seconds / length, residuals.vectors * factor
    for i, name in zip(range(values.shape[1]), "xyz", strict=False):
        label = f"body {name}" if values.shape[1] == 3 else "offset"
        panel.plot(time, values[:, i], color=AXIS_COLOURS[name], label=label, **CIRCLES)
    far = residuals.is_outlier
    panel.plot(
        np.repeat(time[far], values.shape[1]), values[far].ravel(), color=BLACK, marker="x", linestyle="none"
    )
    panel.set_title(f"{residuals.name}: observed less computed, {unit}", loc="left")


def _rates(motion: TorqueFreeMotion, residuals: Residuals, panel: Axes, time: tuple[str, float]) -> None:
    """Observed rates, without their bias, over the computed ones."""
    unit, length = time
    curve = np.linspace(residuals.seconds.min(), residuals.seconds.max(), 2000)
    computed = np.degrees(motion.at(curve).angular_velocity) * length
    observed = np.degrees(motion.at(residuals.seconds).angular_velocity + residuals.vectors) * length
    far, seconds = residuals.is_outlier, residuals.seconds / length
    for i, (name, colour) in enumerate(AXIS_COLOURS.items()):
        panel.plot(curve / length, computed[:, i], color=colour, linestyle=DASHED)
        panel.plot(seconds, observed[:, i], color=colour, label=f"body {name}", **CIRCLES)
        panel.plot(seconds[far], observed[far, i], color=BLACK, marker="x", linestyle="none")
    panel.set_title(f"{residuals.name}: observed, and computed (dashed), deg/{unit}", loc="left")
