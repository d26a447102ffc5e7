"""The picture of two ephemerides compared: rotation and difference of rates between them in time."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..plot.style import AXIS_COLOURS, BLACK, DASHED, drawn, time_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .compare import EphemerisComparison


def picture(comparison: EphemerisComparison, file_format: str) -> bytes:
    """An "svg" or "png" file of a comparison."""
    count = 1 if comparison.rate_difference is None else 2
    return drawn(partial(_draw, comparison), (9.0, 3.0 * count), file_format)


def _draw(comparison: EphemerisComparison, figure: Figure) -> None:
    panels = [("rotation between them, rad", comparison.rotation)]
    if comparison.rate_difference is not None:
        panels.append(("difference of rates, rad/s", comparison.rate_difference))
    seconds = comparison.instants.seconds
    unit, length = time_unit(seconds)
    axes = np.atleast_1d(figure.subplots(len(panels), 1, sharex=True))
    for axis, (title, vectors) in zip(axes, panels, strict=True):
        axis.plot(seconds / length, np.linalg.norm(vectors, axis=1), color=BLACK, label="size")
        for i, (name, colour) in enumerate(AXIS_COLOURS.items()):
            axis.plot(seconds / length, vectors[:, i], color=colour, linestyle=DASHED, label=f"body {name}")
        axis.set_title(title, loc="left")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=4, frameon=False)
    axes[-1].set_xlabel(f"time since the epoch, {unit}")
