"""Files that documents name: where they lie, and whether they may be read."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from ..errors import InputError

_folder: ContextVar[Path | None] = ContextVar("folder", default=Path())


@contextmanager
def files_in(folder: Path | None) -> Iterator[None]:
    """Documents read in this block name files relative to a folder; None: they may name none."""
    token = _folder.set(folder)
    try:
        yield
    finally:
        _folder.reset(token)


def document_path(name: str, instead: str) -> str:
    """The path of a file that a document names; InputError, with what to give `instead`, if it may not."""
    folder = _folder.get()
    if folder is None:
        raise InputError("file", name, f"{instead}; no file is read here")
    return str(folder / name)
