"""The picture of windows: the intervals of a condition, and of its parts, in time."""

from __future__ import annotations

import json
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..plot.style import BLUE, drawn, time_label, time_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .window_table import Windows


def picture(windows: Windows, file_format: str) -> bytes:
    """An "svg" or "png" file: a bar for each window, and below the share of time that is open."""
    return drawn(partial(draw, windows), (9.0, 3.2), file_format)


def draw(windows: Windows, figure: Figure) -> None:
    """Draw bars of the windows, and how much of the time before each instant was open."""
    span = np.array(windows.span)
    unit, size = time_unit(span)
    bars, share = figure.subplots(2, 1, sharex=True, height_ratios=(1.0, 1.4))
    pairs = list(zip(windows.start.seconds / size, windows.duration / size, strict=True))
    bars.broken_barh(pairs, (0.0, 1.0), facecolors=BLUE, edgecolors=BLUE, linewidth=0.6)
    bars.set_yticks([])
    bars.set_ylim(-0.1, 1.1)
    bars.set_ylabel("open")
    edges = np.concatenate(
        [[span[0]], np.stack([windows.start.seconds, windows.stop.seconds], 1).reshape(-1)]
    )
    opened = np.concatenate([[0.0], np.repeat(np.cumsum(windows.duration), 2)])
    opened[1::2] -= windows.duration
    share.plot(np.append(edges, span[1]) / size, np.append(opened, opened[-1]) / size, color=BLUE)
    share.set_ylabel(f"open in all, {unit}")
    share.set_xlim(*(span / size))
    share.set_xlabel(time_label(windows.epoch, unit))
    figure.suptitle(f"{windows.name or 'A scene'}: {label(windows.condition.document())}", fontsize=11)


def label(document: dict[str, Any]) -> str:
    """The condition as one line."""
    text = described(document)
    return text if len(text) <= 90 else text[:87] + "..."


def described(document: dict[str, Any]) -> str:
    """A condition in words: "z to sun below 10 deg and not in the umbra"."""
    for word in ("and", "or"):
        if word in document:
            return f" {word} ".join(f"({described(part)})" for part in document[word])
    if "not" in document:
        return f"not ({described(document['not'])})"
    if "shadow" in document:
        return f"in the {document['shadow']}"
    axis = json.dumps(document["axis"]).strip('"')
    if "above_plane" in document:
        return f"{axis} above the plane of {json.dumps(document['above_plane']).strip(chr(34))}"
    limits = [
        f"{name} {document[name]['value']:.6g} {document[name]['unit']}"
        for name in ("above", "below")
        if name in document
    ]
    return f"{axis} to {json.dumps(document['to']).strip(chr(34))} {' and '.join(limits)}"
