"""An Arrow IPC file (Feather, version 2): batches of columns, and at the end where each of them is."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, BinaryIO

from pyarrow import ipc

from . import arrow_batches
from .binary import seekable
from .samples import Samples

if TYPE_CHECKING:
    from ..ephemeris import Ephemeris


def blocks(samples: Samples) -> Iterator[bytes]:
    return arrow_batches.blocks(samples, ipc.new_file)


def parse(stream: BinaryIO, source: str) -> Ephemeris:
    return arrow_batches.parse(ipc.open_file, seekable(stream, source), source)
