"""Windows: the intervals in which a condition holds, as a table, CSV and JSON."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from astropy.time import Time
from pydantic import Field, GetPydanticSchema
from typing_extensions import TypedDict

from ..errors import InputError
from ..samples.chunks import Progress
from ..times.instants import Instants, as_instants
from .bounded_functions import BoundedMotion, bounded_function
from .condition import Condition
from .root_search import crossings

DEFAULT_WIDTH = 1e-6  # of the shortest period of the motion
RATE_INSTANTS = 15  # over the span of a motion under torques, at which that period is taken


class WindowsAnswer(TypedDict):
    """The intervals in which a condition holds, within the scene's instants."""

    kind: Literal["attitude-windows/1"]
    name: str
    condition: Annotated[dict[str, Any], GetPydanticSchema(lambda _, handler: handler(Condition))]
    epoch: dict[str, str] | None
    span_s: list[float]
    width_s: Annotated[
        float, Field(description="windows, and gaps between them, that are narrower may be missed")
    ]
    total_s: float
    windows: list[dict[str, Any]]


@dataclass(frozen=True, eq=False)
class Windows:
    """The intervals in which a condition holds.

    Attributes
    ----------
    condition : Condition
    start, stop : Instants (n,), ascending, when each begins and ends
    span : (start, stop), s since the epoch, that was searched
    width : s; windows, and gaps between them, that are narrower may be missed
    name : of the scene
    """

    condition: Condition
    start: Instants
    stop: Instants
    span: tuple[float, float]
    width: float
    name: str = ""

    def __len__(self) -> int:
        return len(self.start.seconds)

    def __repr__(self) -> str:
        return f"<Windows: {len(self)}, {self.duration.sum():.9g} s of {self.span[1] - self.span[0]:.9g} s>"

    @property
    def duration(self) -> np.ndarray:
        """(n,) s."""
        return (self.stop.seconds - self.start.seconds) + (self.stop.low - self.start.low)

    @property
    def begins_before(self) -> np.ndarray:
        """(n,): whether the window is open at the start of the span, so that it may begin before."""
        return self.start.seconds <= self.span[0]

    @property
    def ends_after(self) -> np.ndarray:
        """(n,): whether the window is open at the end of the span."""
        return self.stop.seconds >= self.span[1]

    @property
    def epoch(self) -> Time | None:
        """The instant that seconds count from; None without one."""
        return self.start.epoch

    def columns(self) -> dict[str, list[Any]]:
        """Columns by name: dates where there is an epoch, seconds since it, what is cut off by the span."""
        ends = {"start": self.start, "stop": self.stop}
        dates = {name: _dates(each.time) for name, each in ends.items() if each.time is not None}
        seconds = {f"{name}_s": each.seconds.tolist() for name, each in ends.items()}
        cut = {"begins_before": self.begins_before.tolist(), "ends_after": self.ends_after.tolist()}
        return {**dates, **seconds, "duration_s": self.duration.tolist(), **cut}

    def rows(self) -> Iterator[dict[str, Any]]:
        """A dictionary of each window."""
        columns = self.columns()
        for values in zip(*columns.values(), strict=True):
            yield dict(zip(columns, values, strict=True))

    def to_dict(self) -> WindowsAnswer:
        """Return plain data."""
        epoch = self.epoch
        return {
            "kind": "attitude-windows/1",
            "name": self.name,
            "condition": self.condition.document(),
            "epoch": None if epoch is None else {"time": _dates(epoch)[0], "scale": epoch.scale},
            "span_s": list(self.span),
            "width_s": self.width,
            "total_s": float(self.duration.sum()),
            "windows": list(self.rows()),
        }

    def to_json(self) -> str:
        """Return JSON text."""
        return json.dumps(self.to_dict(), indent=2)

    def to_csv(self) -> str:
        """Return CSV: comments with the condition and the span, then a line a window."""
        text = io.StringIO()
        text.write(f"# {json.dumps(self.condition.document())}\n")
        scale = f", dates in {self.epoch.scale}" if self.epoch is not None else ""
        text.write(f"# from {self.span[0]!r} to {self.span[1]!r} s{scale}\n")
        columns = self.columns()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(
            [str(value).lower() if isinstance(value, bool) else value for value in row]
            for row in zip(*columns.values(), strict=True)
        )
        return text.getvalue()

    def text(self) -> str:
        """Return a table for people."""
        columns = {name: values for name, values in self.columns().items() if not name.startswith(("b", "e"))}
        cells = [
            [f"{value:.9f}" if isinstance(value, float) else str(value) for value in column]
            for column in columns.values()
        ]
        widths = [
            max(map(len, (name, *column)), default=0) for name, column in zip(columns, cells, strict=True)
        ]
        lines = [list(columns), *map(list, zip(*cells, strict=True))]
        table = [
            "  ".join(f"{cell:>{width}}" for cell, width in zip(line, widths, strict=True)) for line in lines
        ]
        total, span = float(self.duration.sum()), self.span[1] - self.span[0]
        table.append(f"{len(self)} windows, {total:.9g} s of {span:.9g} s")
        return "\n".join(table) + "\n"


def _dates(time: Time) -> list[str]:
    time = time.copy()
    time.precision = 9
    return np.atleast_1d(time.isot).tolist()


def span_of(start: Any, stop: Any, epoch: Time | None) -> tuple[float, float]:
    """Two instants as s since the epoch; InputError unless the second is after the first."""
    ends = [as_instants(end, epoch, name).seconds for name, end in (("start", start), ("stop", stop))]
    for name, end, given in zip(("start", "stop"), ends, (start, stop), strict=True):
        if end.shape:
            raise InputError(name, given, "one instant")
    if not ends[1] > ends[0]:
        raise InputError("stop", stop, f"an instant after start ({start})")
    return float(ends[0]), float(ends[1])


def find_windows(
    motion: BoundedMotion,
    condition: Condition,
    width: float | None,
    name: str = "",
    progress: Progress | None = None,
) -> Windows:
    """The intervals of a motion's span in which a condition holds.

    Parameters
    ----------
    width : s; windows and gaps that are narrower may be missed; by default 1e-6 of a turn at the greatest
        rate that the body reaches from its states at some instants
    progress : called with the fraction that is done

    Raises
    ------
    InputError : a width that is not above 0; a condition that needs dates where there are none.
    RegimeError : a condition that needs an orbit or a momentum that is not known; one whose value stays at
        its threshold.
    """
    if width is None:
        # torques and impulses may spin the body up
        within = [cut for cut in motion.cuts if motion.start < cut < motion.stop]
        even = np.linspace(motion.start, motion.stop, RATE_INSTANTS if motion.growth else 1)
        seconds = np.unique(np.append(even, within))
        rate = float(motion.rate(motion.sampled(seconds, np.zeros_like(seconds))).max())
        width = DEFAULT_WIDTH * 2.0 * np.pi / rate if rate > 0.0 else DEFAULT_WIDTH
    if not 0.0 < width < np.inf:
        raise InputError("width", width, "a time above 0, s")
    elementary = list(dict.fromkeys(condition.elementary()))
    found = {}
    for k, each in enumerate(elementary):
        part = None if progress is None else lambda done, k=k: progress((k + done) / len(elementary))
        function = bounded_function(motion, each)
        found[each] = crossings(function, motion.start, motion.stop, width, motion.cuts, part)
    changes = _merged([(each.seconds, each.seconds_low) for each in found.values()], motion)
    states = {
        key: each.starts_negative ^ (_count(changes, each.seconds, each.seconds_low) % 2 == 1)
        for key, each in found.items()
    }

    holds = condition.holds(states.__getitem__)
    # crossings of two functions within 1e-9 s are one instant
    for i in np.flatnonzero(np.diff(changes[0]) + np.diff(changes[1]) <= 1e-9):
        holds[i] = holds[i - 1] if i else holds[min(1, holds.size - 1)]
    before = np.concatenate([[False], holds, [False]])
    begins, ends = np.flatnonzero(before[1:] & ~before[:-1]), np.flatnonzero(~before[1:] & before[:-1])
    start, stop = (Instants(changes[0][i], changes[1][i], motion.epoch) for i in (begins, ends))
    return Windows(condition, start, stop, (motion.start, motion.stop), width, name)


def _merged(
    instants: list[tuple[np.ndarray, np.ndarray]], motion: BoundedMotion
) -> tuple[np.ndarray, np.ndarray]:
    """All instants in order, each once, between the ends of the span."""
    ends = np.array([motion.start, motion.stop])
    high = np.concatenate([ends[:1], *(each[0] for each in instants), ends[1:]])
    low = np.concatenate([np.zeros(1), *(each[1] for each in instants), np.zeros(1)])
    pairs = np.unique(np.stack([high, low], axis=1), axis=0)
    return pairs[:, 0], pairs[:, 1]


def _count(changes: tuple[np.ndarray, np.ndarray], high: np.ndarray, low: np.ndarray) -> np.ndarray:
    """(n - 1,): how many of some instants are not after the start of each interval between the changes."""

    def key(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return a + 1j * b  # numpy orders complex numbers by their real, then their imaginary part

    return np.searchsorted(np.sort(key(high, low)), key(*changes)[:-1], side="right")
