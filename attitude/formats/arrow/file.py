"""An Arrow IPC file (Feather, version 2): record batches, and a footer with their offsets."""

from __future__ import annotations

from collections.abc import Iterator
from typing import BinaryIO

from pyarrow import ipc

from ...samples.chunks import Samples
from ...samples.ephemeris_data import EphemerisData
from ..binary import seekable
from . import record_batches


def blocks(samples: Samples) -> Iterator[bytes]:
    """The file of these samples, block by block, in the memory of one chunk."""
    return record_batches.blocks(samples, ipc.new_file)


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    """The ephemeris in a stream of this format; FormatError, with its place, for anything else."""
    return record_batches.parse(ipc.open_file, seekable(stream, source), source)
