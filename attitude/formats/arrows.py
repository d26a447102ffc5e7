"""An Arrow IPC stream: batches of columns one after the other, for pipes and sockets."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, BinaryIO

from . import arrow_batches
from .arrow_batches import pyarrow
from .samples import Samples

if TYPE_CHECKING:
    from ..ephemeris import Ephemeris


def blocks(samples: Samples) -> Iterator[bytes]:
    return arrow_batches.blocks(samples, pyarrow("pyarrow.ipc").new_stream)


def parse(stream: BinaryIO, source: str) -> Ephemeris:
    return arrow_batches.parse(pyarrow("pyarrow.ipc").open_stream, stream, source)
