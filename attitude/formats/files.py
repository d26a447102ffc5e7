"""Files that appear whole or not at all, and standard output."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

from ..errors import FormatError

STANDARD_STREAM = "-"


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
