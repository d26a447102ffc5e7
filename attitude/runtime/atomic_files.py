"""Atomic writing of files, and standard output."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Generator, Iterable, Mapping
from pathlib import Path

from ..errors import file_errors

STANDARD_STREAM = "-"


def write_whole(blocks: Iterable[bytes], path: str | Path) -> None:
    """Writes a file atomically, or standard output for the path "-"."""
    if str(path) == STANDARD_STREAM:
        sys.stdout.buffer.writelines(blocks)
        sys.stdout.buffer.flush()
    else:
        write_together({Path(path): blocks})


def write_together(files: Mapping[Path, Iterable[bytes]]) -> None:
    """Writes several files atomically: all of them, or none.

    They are written beside their targets under temporary names, then renamed.  A device or pipe is written to
    directly, since renaming would replace it by a file.
    """
    written: dict[str, Path] = {}
    try:
        for path, blocks in files.items():
            with file_errors(path, "written"):
                _beside(path, blocks, written)
        for name, path in written.items():
            with file_errors(path, "written"):
                os.replace(name, path)
    finally:
        for blocks in files.values():
            if isinstance(blocks, Generator):
                blocks.close()  # releases what it has open now, not at garbage collection
        for name in written:
            if os.path.exists(name):
                os.unlink(name)


def _beside(path: Path, blocks: Iterable[bytes], written: dict[str, Path]) -> None:
    if path.exists() and not path.is_file():
        with open(path, "wb") as stream:
            stream.writelines(blocks)
        return
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}.", delete=False) as file:
        written[file.name] = path
        for block in blocks:
            file.write(block)
    os.umask(umask := os.umask(0))  # it can only be read by setting it
    os.chmod(file.name, 0o666 & ~umask)
