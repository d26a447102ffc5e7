"""The picture of a fit: residuals of every set of observations, and body rates observed and computed."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..plot.style import BLACK, BLUE, CIRCLES, DASHED, GREEN, RED, drawn, time_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .fit_result import Fit, Residuals

SIZE = 9.0, 2.6  # inches, of a panel
COLOURS = dict(zip("xyz", (RED, BLUE, GREEN), strict=True))
CURVE_POINTS = 2000


def picture(fit: Fit, file_format: str) -> bytes:
    """An "svg" or "png" file of a fit."""
    return drawn(partial(_draw, fit), (SIZE[0], SIZE[1] * len(fit.residuals)), file_format)


def _draw(fit: Fit, figure: Figure) -> None:
    seconds = np.concatenate([each.seconds for each in fit.residuals])
    unit, length = time_unit(seconds)
    panels = np.atleast_1d(figure.subplots(len(fit.residuals), 1, sharex=True))
    for each, panel in zip(fit.residuals, panels, strict=True):
        (_rates if each.unit == "rad/s" else _sizes)(fit, each, panel, length)
        panel.plot([], [], color=BLACK, marker="x", linestyle="none", label="outlier")
        panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    panels[-1].set_xlabel(f"time since the epoch, {unit}")


def _sizes(fit: Fit, residuals: Residuals, panel: Axes, length: float) -> None:
    """Components of residuals, or how far directions and ranges are off."""
    del fit
    factor, unit = (180.0 / np.pi, "deg") if residuals.unit == "rad" else (1.0, residuals.unit)
    time, values = residuals.seconds / length, residuals.vectors * factor
    for i, name in zip(range(values.shape[1]), "xyz", strict=False):
        label = f"body {name}" if values.shape[1] == 3 else "offset"
        panel.plot(time, values[:, i], color=COLOURS[name], label=label, **CIRCLES)
    far = residuals.is_outlier
    panel.plot(
        np.repeat(time[far], values.shape[1]), values[far].ravel(), color=BLACK, marker="x", linestyle="none"
    )
    panel.set_title(f"{residuals.name}: observed less computed, {unit}", loc="left")


def _rates(fit: Fit, residuals: Residuals, panel: Axes, length: float) -> None:
    """Observed rates, without their bias, over the computed ones."""
    curve = np.linspace(residuals.seconds.min(), residuals.seconds.max(), CURVE_POINTS)
    computed = np.degrees(fit.motion.at(curve).angular_velocity) * length
    observed = np.degrees(fit.motion.at(residuals.seconds).angular_velocity + residuals.vectors) * length
    far, time = residuals.is_outlier, residuals.seconds / length
    for i, (name, colour) in enumerate(COLOURS.items()):
        panel.plot(curve / length, computed[:, i], color=colour, linestyle=DASHED)
        panel.plot(time, observed[:, i], color=colour, label=f"body {name}", **CIRCLES)
        panel.plot(time[far], observed[far, i], color=BLACK, marker="x", linestyle="none")
    unit = {86400.0: "d", 3600.0: "h", 60.0: "min"}.get(length, "s")
    panel.set_title(f"{residuals.name}: observed, and computed (dashed), deg/{unit}", loc="left")
