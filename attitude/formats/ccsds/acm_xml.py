"""CCSDS attitude comprehensive message (ACM), 504.0-B-2, section 7: XML."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...samples.chunks import Samples
from ..writer_options import takes_options
from .acm import parse as parse
from .acm_writer import XML, AcmOptions, acm_blocks


@takes_options(AcmOptions)
def blocks(samples: Samples, **options: Any) -> Iterator[bytes]:
    """File, with the options of `AcmOptions`."""
    return acm_blocks(samples, XML, AcmOptions(**options))
