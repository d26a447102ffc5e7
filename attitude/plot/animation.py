"""A film of the body: a box of its inertia with its axes, and its angular velocity's path in the body."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.animation import FuncAnimation, PillowWriter, writers
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..errors import AttitudeError, FormatError, InputError
from ..runtime import output_paths
from ..samples.ephemeris_data import EphemerisData
from .curves import line_style, name_axes
from .style import AXIS_COLOURS, BLACK, SETTINGS, time_unit

FRAMES_A_SECOND = 20
CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))
EDGES = [(i, j) for i, j in product(range(8), repeat=2) if i < j and (CORNERS[i] != CORNERS[j]).sum() == 1]


def film(data: EphemerisData, seconds: float = 10.0) -> FuncAnimation:
    """An animation of matplotlib that shows the ephemeris, from first to last, in so many seconds.

    Raises InputError for a batch of bodies, for fewer than two instants, or a length that is not above zero.
    """
    if len(data.shape) != 1 or len(data) < 2:
        raise InputError("ephemeris", f"shape {data.shape}", "one body at two instants or more")
    if not 0.0 < seconds <= 600.0:
        raise InputError("seconds", seconds, "above 0, at most 600")
    with rc_context(SETTINGS):
        figure = Figure(figsize=(9.0, 4.6), layout="constrained")
        FigureCanvasAgg(figure)
        update = _prepare(figure, data)
    count = min(len(data), max(2, round(seconds * FRAMES_A_SECOND)))
    frames = np.linspace(0, len(data) - 1, count).round().astype(int)
    return FuncAnimation(figure, update, frames=frames, interval=1000.0 * seconds / count, blit=False)


def write(data: EphemerisData, path: str | Path, seconds: float = 10.0) -> None:
    """Write the film as .gif, .mp4 (needs ffmpeg) or .html (pictures inside, with buttons).

    Raises FormatError for another ending, AttitudeError where ffmpeg is missing.
    """
    ending = Path(path).suffix.removeprefix(".").lower()
    if ending not in ("gif", "mp4", "html"):
        raise FormatError("a film's ending is gif, mp4 or html", str(path))
    if ending == "mp4" and not writers.is_available("ffmpeg"):
        raise AttitudeError("an .mp4 needs the program ffmpeg; .gif and .html do not")
    output_paths.check(path)
    shown = film(data, seconds)
    if ending == "html":
        output_paths.write(path, shown.to_jshtml(default_mode="loop").encode())
    else:
        writer = PillowWriter(fps=FRAMES_A_SECOND) if ending == "gif" else "ffmpeg"
        shown.save(str(path), writer=writer, dpi=90)


def _prepare(figure: Figure, data: EphemerisData) -> Any:
    """Draw what stands still; return what draws a sample, by its index."""
    space: Any = figure.add_subplot(1, 2, 1, projection="3d")
    space.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-1, 1), xlabel="X", ylabel="Y", zlabel="Z")
    space.set(xticks=[-1, 0, 1], yticks=[-1, 0, 1], zticks=[-1, 0, 1])
    space.set_aspect("equal")
    box = [space.plot([], [], [], color="0.35", linewidth=1.2)[0] for _ in EDGES]
    axes = [space.plot([], [], [], color=colour, linewidth=2.0)[0] for colour in AXIS_COLOURS.values()]
    names = [space.text(0, 0, 0, name, color=colour) for name, colour in AXIS_COLOURS.items()]
    corners = CORNERS * _half_sides(data)
    dot: Any = None  # that moves along the path of the angular velocity in the body
    if data.has_rate:
        panel: Any = figure.add_subplot(1, 2, 2, projection="3d")
        panel.plot(*data.angular_velocity.T, color="0.6", **line_style(data))
        panel.set_title("polhode: angular velocity, rad/s")
        name_axes(panel)
        dot = panel.plot([], [], [], "o", color=BLACK, markersize=5)[0]
    unit, size = time_unit(data.elapsed)
    rotations = data.rotation

    def update(i: int) -> list[Any]:
        turned = rotations[i].apply(corners)
        for line, edge in zip(box, EDGES, strict=True):
            line.set_data_3d(*turned[list(edge)].T)
        for line, end in zip(axes, rotations[i].as_matrix().T, strict=True):
            line.set_data_3d(*np.stack([np.zeros(3), 0.95 * end], axis=1))
        for name, end in zip(names, rotations[i].as_matrix().T, strict=True):
            name.set_position_3d(1.05 * end)
        if dot is not None:
            dot.set_data_3d(*data.angular_velocity[i : i + 1].T)
        space.set_title(f"{data.elapsed[i] / size:.4g} {unit}")
        return [*box, *axes, *names]

    return update


def _half_sides(data: EphemerisData) -> np.ndarray:
    """Half the edges of a box with the body's moments, along the body's axes, the largest 0.6."""
    if data.body is None:
        return np.full(3, 0.45)
    moments = np.diagonal(data.body.tensor)
    squares = np.maximum(0.5 * moments.sum() - moments, 1e-3 * moments.sum())
    sides = np.sqrt(squares)
    return np.asarray(0.6 * sides / sides.max())
