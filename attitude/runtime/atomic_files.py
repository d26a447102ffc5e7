"""Files that appear whole or not at all, and standard output."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from ..errors import AttitudeError, FormatError

STANDARD_STREAM = "-"


def write_whole(blocks: Iterable[bytes], path: str | Path) -> None:
    """To a file, whole or not at all, or to standard output."""
    if str(path) == STANDARD_STREAM:
        _to_standard_output(blocks)
    else:
        write_together({Path(path): blocks})


def write_together(files: Mapping[Path, Iterable[bytes]]) -> None:
    """Files that belong together: all of them whole, or none.

    Written beside their targets under other names, then renamed.  A device or pipe is written to as it is:
    renaming would put a file in its place.
    """
    written: dict[str, Path] = {}
    try:
        for path, blocks in files.items():
            with _named_in_errors(path):
                _beside(path, blocks, written)
        for name, path in written.items():
            with _named_in_errors(path):
                os.replace(name, path)
    finally:
        for blocks in files.values():
            if isinstance(blocks, Generator):
                blocks.close()  # what it has open, too, it lets go now and not when somebody looks
        for name in written:
            if os.path.exists(name):
                os.unlink(name)


def _to_standard_output(blocks: Iterable[bytes]) -> None:
    for block in blocks:
        sys.stdout.buffer.write(block)
    sys.stdout.buffer.flush()


def _beside(path: Path, blocks: Iterable[bytes], written: dict[str, Path]) -> None:
    if path.exists() and not path.is_file():
        with open(path, "wb") as stream:
            stream.writelines(blocks)
        return
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}.", delete=False) as file:
        written[file.name] = path
        for block in blocks:
            file.write(block)
    os.chmod(file.name, 0o666 & ~_umask())


@contextmanager
def _named_in_errors(path: Path) -> Iterator[None]:
    try:
        yield
    except AttitudeError:  # of what the blocks are made of: an InputError is a ValueError too
        raise
    except (OSError, ValueError) as error:
        raise FormatError(f"cannot be written ({getattr(error, 'strerror', error)})", str(path)) from None


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
