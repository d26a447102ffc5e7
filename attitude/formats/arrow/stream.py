"""An Arrow IPC stream: record batches one after the other, for pipes and sockets."""

from __future__ import annotations

from collections.abc import Iterator
from typing import BinaryIO

from pyarrow import ipc

from ...samples.chunks import Samples
from ...samples.ephemeris_data import EphemerisData
from . import record_batches


def blocks(samples: Samples) -> Iterator[bytes]:
    """The file of these samples, block by block, in the memory of one chunk."""
    return record_batches.blocks(samples, ipc.new_stream)


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    """The ephemeris in a stream of this format; FormatError, with its place, for anything else."""
    return record_batches.parse(ipc.open_stream, stream, source)
