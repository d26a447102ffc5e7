"""Stores of an ensemble's attitudes, in Zarr or Parquet: `read` opens one that is complete."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from ...errors import FormatError, InputError
from . import store

if TYPE_CHECKING:
    from .store_head import StoreTarget


def target(to: str | os.PathLike[str]) -> StoreTarget:
    """Return the store of this name, in the format that its ending names.

    Raises InputError for an ending other than .zarr and .parquet.
    """
    from .parquet import ParquetTarget
    from .zarr import ZarrTarget

    formats: dict[str, type[ZarrTarget] | type[ParquetTarget]] = {
        ".zarr": ZarrTarget,
        ".parquet": ParquetTarget,
    }
    try:
        path = Path(os.path.abspath(to))
    except TypeError:
        raise InputError("to", to, "the name of a directory, NAME.zarr or NAME.parquet") from None
    if path.suffix not in formats:
        raise InputError("to", str(to), f"a name that ends in {' or '.join(formats)}")
    return formats[path.suffix](path)


def read(path: str | os.PathLike[str]) -> store.Stored:
    """Open what a run has stored.  Raises FormatError unless it is a complete store of an ensemble."""
    stored = target(path)
    try:
        head = stored.head() if stored.path.is_dir() else None
        if head is None:
            raise FormatError("no store of an ensemble", str(path))
        if not head["complete"]:
            message = "not complete: the same run once more computes what is missing"
            raise FormatError(message, str(path))
        return store.Stored(stored, head)
    except OSError as error:
        raise FormatError(f"cannot be read ({error.strerror or error})", str(path)) from None
