"""Ephemerides as files: one module a format, and here the way in and out.

parts    what every format says: metadata and columns, with their units in the names
events   what happened at instants, as plain data
table    an astropy QTable, and ECSV through it
csv      comma-separated text, in blocks
json     the columnar answer that the service gives too
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable, Iterable
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from ..errors import FormatError

if TYPE_CHECKING:
    from ..ephemeris import Ephemeris

FORMATS = {"ecsv": "table", "csv": "csv", "json": "json"}
STANDARD_STREAM = "-"


def write(
    ephemeris: Ephemeris,
    path: str | Path,
    format: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> None:
    """See `Ephemeris.write`; the path "-" is standard output, and then the format must be named."""
    if not all(ephemeris.shape):
        raise FormatError("an ephemeris of no instants is not written", str(path))
    blocks = check(path, format).blocks(ephemeris, progress or _no_progress)
    write_whole(blocks, path)


def read(path: str | Path, format: str | None = None) -> Ephemeris:
    """See `Ephemeris.read`."""
    module = check(path, format)
    try:
        text = Path(path).read_bytes()
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        raise FormatError(f"cannot be read ({getattr(error, 'strerror', error)})", str(path)) from None
    return module.parse(text, str(path))


def check(path: str | Path, format: str | None) -> ModuleType:
    """The module for a format, by its name or else by the path's ending; refuses an unknown one."""
    name = (format or Path(path).suffix.removeprefix(".")).lower()
    if name not in FORMATS:
        found = f"format {name!r}" if name else "no format and no file ending"
        raise FormatError(f"{found}; this version knows {', '.join(FORMATS)}", str(path))
    return import_module(f".{FORMATS[name]}", __name__)


def _no_progress(done: float) -> None:
    pass


def write_whole(blocks: Iterable[bytes], path: str | Path) -> None:
    """To a file, whole or not at all, or to standard output."""
    if str(path) == STANDARD_STREAM:
        _to_standard_output(blocks)
    else:
        _to_file(blocks, Path(path))


def _to_standard_output(blocks: Iterable[bytes]) -> None:
    for block in blocks:
        sys.stdout.buffer.write(block)
    sys.stdout.buffer.flush()


def _to_file(blocks: Iterable[bytes], path: Path) -> None:
    """Whole or not at all: written beside the target under another name, then renamed.

    A device or pipe is written to as it is: renaming would put a file in its place.
    """
    name = None
    try:
        if path.exists() and not path.is_file():
            with open(path, "wb") as stream:
                stream.writelines(blocks)
            return
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}.", delete=False) as file:
            name = file.name
            file.writelines(blocks)
        os.chmod(name, 0o666 & ~_umask())
        os.replace(name, path)
    except (OSError, ValueError) as error:
        raise FormatError(f"cannot be written ({getattr(error, 'strerror', error)})", str(path)) from None
    finally:
        if name is not None and os.path.exists(name):
            os.unlink(name)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
