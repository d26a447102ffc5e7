"""SPICE CK, types 3, 5, 6 and 2, with the text kernels beside it that SPICE needs to use it.

Conventions (NAIF, CK and rotation required reading): a C-matrix takes inertial components to body components,
and its quaternion is the conjugate of this library's, scalar first; the angular velocity is in rad/s with
INERTIAL components; instants are ticks of a spacecraft's clock.  SPICE's J2000 is the ICRF.

Readers of type 3 rotate at a constant rate from record to record, and interpolate angular velocities
linearly.  Type 5 (subtype 0) holds quaternions and their derivatives, through which readers lay Hermite's
polynomials; angular velocities follow from these; type 6 likewise, with all segments of an ephemeris as
mini-segments of one segment of the file.  Type 2 consists of intervals of constant angular velocity:
where the body's rate is constant from the first instant to the last, one record covers
`ck_writer.MAX_ROTATION` radians; elsewhere one record covers an interval, at the rate that takes its first
attitude to the next.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ...errors import FormatError
from .. import time_origin
from ..date_text import one_date
from ..interpolant import Interpolant, hermite
from ..interpolation_nodes import Nodes
from . import text_kernels
from .ck_reader import parse as parse
from .ck_writer import POLYNOMIALS, CkOptions, CkTarget, write_blocks
from .cspice import import_spiceypy

Options = CkOptions


def interpolant(options: CkOptions) -> Interpolant:
    """Constant rate from record to record in types 2 and 3, Hermite's polynomials in types 5 and 6."""
    return options.interpolant


def other_interpolants(options: CkOptions) -> dict[str, Interpolant]:
    """Hermite's polynomials of type 5 of several degrees, by the options of each."""
    degrees = [degree for degree in (7, 15) if options.type not in POLYNOMIALS or degree > options.degree]
    return {f"type=5, degree={degree}": hermite(degree, "degree") for degree in degrees}


def blocks(nodes: Nodes, options: CkOptions) -> Iterator[bytes]:
    """The CK."""
    return write_blocks(nodes, CkTarget.of(nodes, options), import_spiceypy())


def companions(nodes: Nodes, name: str, options: CkOptions) -> dict[str, bytes]:
    """Clock (.tsc), frame (.tf), leap seconds (.tls) and a meta-kernel of all (.tm) for a CK of this name."""
    target = CkTarget.of(nodes, options)
    origin = time_origin.tt_origin(nodes.segments[0].first)
    anchor = one_date(origin.time)
    body = target.frame.removesuffix("_BODY")
    texts = {
        ".tsc": text_kernels.clock(target.naif_id, int(origin.tt), anchor),
        ".tf": text_kernels.frames(target.naif_id, target.structure, target.frame, body, target.name),
        ".tls": text_kernels.leap_seconds(),
    }
    if Path(name).suffix in (*texts, ".tm"):
        raise FormatError("a text kernel beside it would have the name of the CK; .bc is usual", name)
    names = [Path(name).with_suffix(ending).name for ending in texts] + [name]
    if all(name.isascii() and name.isprintable() for name in names):  # text kernels are ASCII
        texts[".tm"] = text_kernels.meta_kernel(names)
    return {ending: text.encode("ascii") for ending, text in texts.items()}
