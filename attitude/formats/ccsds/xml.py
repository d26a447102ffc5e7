"""CCSDS attitude ephemeris message (AEM), 504.0-B-2, section 7: XML."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..interpolation_nodes import Nodes
from ..writer_options import takes_options
from .keywords import ATTITUDE_TYPES, UNITS, Q
from .message_options import Pairs, element_lines, xml_head
from .reader import parse as parse
from .writer import AemOptions, AemWriter
from .writer import interpolant as interpolant
from .writer import other_interpolants as other_interpolants


@takes_options(AemOptions)
def blocks(nodes: Nodes, **options: Any) -> Iterator[bytes]:
    """File, with the options of `AemOptions`."""
    return _blocks(nodes, AemWriter(nodes, AemOptions(**options)))


def _blocks(nodes: Nodes, writer: AemWriter) -> Iterator[bytes]:
    comments: Pairs = [("COMMENT", line) for line in writer.comments()]
    yield xml_head("aem", comments + writer.options.header()).encode()
    separators = _state_template(writer.attitude_type).encode().split(b"%s")
    for segment in nodes.segments:
        metadata = element_lines(writer.metadata(segment))
        yield f"<segment>\n<metadata>\n{metadata}</metadata>\n<data>\n".encode()
        yield from writer.rows.write(segment, separators)
        yield b"</data>\n</segment>\n"
    yield b"</body>\n</aem>\n"


def _state_template(attitude_type: str) -> str:
    """AttitudeState with %s for its epoch and each of its numbers."""
    kind = ATTITUDE_TYPES[attitude_type]
    parts = []
    for element, names in (("quaternion", kind.attitude), ("angVel", kind.rate)):
        units = [f' units="{UNITS[name]}"' if name in UNITS else "" for name in names]
        numbers = "".join(f"<{name}{unit}>%s</{name}>\n" for name, unit in zip(names, units, strict=True))
        is_group = kind.attitude is Q and names
        parts.append(f"<{element}>\n{numbers}</{element}>\n" if is_group else numbers)
    state = kind.elements[0]
    content = f"<EPOCH>%s</EPOCH>\n{''.join(parts)}"
    return f"<attitudeState>\n<{state}>\n{content}</{state}>\n</attitudeState>\n"
