"""An Arrow IPC file (Feather, version 2): batches of columns, and at the end where each of them is."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, BinaryIO

from . import arrow_batches
from .arrow_batches import pyarrow
from .binary import seekable
from .samples import Samples

if TYPE_CHECKING:
    from ..ephemeris import Ephemeris


def blocks(samples: Samples) -> Iterator[bytes]:
    return arrow_batches.blocks(samples, pyarrow("pyarrow.ipc").new_file)


def parse(stream: BinaryIO, source: str) -> Ephemeris:
    return arrow_batches.parse(pyarrow("pyarrow.ipc").open_file, seekable(stream, source), source)
