"""Messages of the command on standard error: remarks, warnings, a progress bar."""

from __future__ import annotations

import shutil
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from ..errors import AttitudeWarning

if TYPE_CHECKING:
    from argparse import Namespace


def warn(text: str) -> None:
    """Print a line to standard error."""
    print(f"attitude: {text}", file=sys.stderr)


def is_watched(options: Namespace) -> bool:
    """Whether standard error is a terminal, and --quiet was not given."""
    return sys.stderr.isatty() and not getattr(options, "quiet", False)


def remark(options: Namespace, text: str) -> None:
    """Print a line to standard error where a person reads it."""
    if is_watched(options):
        warn(text)


def announce_compilation(options: Namespace) -> None:
    """Say so when kernels are compiled, for some seconds of the first run on a new machine."""
    from ..runtime import kernel_cache

    kernel_cache.on_compilation.clear()
    if is_watched(options):
        text = "compiling {} kernels for this processor, once: about ten seconds"
        kernel_cache.on_compilation.append(lambda count: warn(text.format(count)))


@contextmanager
def progress_bar(options: Namespace) -> Iterator[Callable[[float], None] | None]:
    """Yield what draws a bar, called with the fraction done; None where standard error is no terminal.

    It has the rate and the time that is left, which are estimated from the first fraction: where a resumed
    run begins.
    """
    if not is_watched(options):
        yield None
        return
    from tqdm import tqdm  # type: ignore[import-untyped]

    bar = None

    def show(fraction: float) -> None:
        nonlocal bar
        if bar is None:
            if fraction >= 1.0:
                return
            form = "{percentage:3.0f}% |{bar:30}| {rate_fmt}, {remaining} left"
            columns, rows = shutil.get_terminal_size()  # 80 and 24 of a terminal that says neither
            look = {
                "unit": "%",
                "bar_format": form,
                "leave": False,
                "miniters": 0,
                "ncols": columns,
                "nrows": rows,
            }
            bar = tqdm(total=100.0, initial=100.0 * fraction, file=sys.stderr, **look)
        bar.update(100.0 * fraction - bar.n)

    try:
        yield show
    finally:
        if bar is not None:
            bar.close()


@contextmanager
def warnings_on_one_line() -> Iterator[None]:
    """Print the library's own warnings without the line of source that Python puts before them.

    Those of erfa, one a call, become one line.
    """
    python_shows = warnings.showwarning
    is_year_announced = False

    def show(message: Warning | str, category: type[Warning], *source: Any, **more: Any) -> None:
        nonlocal is_year_announced
        if issubclass(category, AttitudeWarning):
            warn(str(message))
        elif category.__name__ == "ErfaWarning" and "dubious year" in str(message):
            if not is_year_announced:
                cure = "TAI - UTC is that of the nearest known year"
                warn(f"UTC of years whose leap seconds are not known: {cure}")
            is_year_announced = True
        else:
            python_shows(message, category, *source, **more)

    with warnings.catch_warnings():
        warnings.simplefilter("default", AttitudeWarning)
        warnings.showwarning = show
        yield
