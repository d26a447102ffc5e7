"""Paths of reports and pictures, checked for writing before anything is computed."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from ..errors import AttitudeError, FormatError, file_errors
from .atomic_files import STANDARD_STREAM as STANDARD_STREAM
from .atomic_files import write_whole


def check(path: str | Path) -> None:
    """Raises FormatError where the file cannot be written."""
    if str(path) == STANDARD_STREAM:
        return
    target = Path(path)
    with file_errors(path, "written"):
        if target.is_dir():
            raise IsADirectoryError(21, os.strerror(21))
        if target.exists() and not target.is_file():  # a pipe or device, written to directly
            if not os.access(target, os.W_OK):
                raise PermissionError(13, os.strerror(13))
            return
        with tempfile.TemporaryFile(dir=target.parent):
            return


def check_picture(path: str | Path) -> str:
    """The format of a picture's file: its ending, svg, png or pdf.

    Raises FormatError for another ending, AttitudeError where matplotlib is not installed.
    """
    ending = Path(path).suffix.removeprefix(".").lower()
    if ending not in ("svg", "png", "pdf"):
        raise FormatError("a picture's ending is svg, png or pdf", str(path))
    try:
        import matplotlib  # noqa: F401
    except ModuleNotFoundError as error:
        raise AttitudeError(f"the picture needs {error.name}: pip install 'attitude[plot]'") from None
    check(path)
    return ending


def write(path: str | Path, content: bytes) -> None:
    """Writes the content to a file atomically, or to standard output for the path "-"."""
    write_whole([content], path)
