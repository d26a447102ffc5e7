"""What the march between plates' edges and its callers agree on (`layout` says how).  Plain numpy.

A source is a direction d(t), with a strength p(t), both independent of the body; it is given by the row of
the effect that it belongs to, without the plate.  The torque of an effect is p (K d + Q (d, d)) in components
along the body's axes: a form.  docs/torques.md, section 5.
"""

from enum import IntEnum

import numpy as np

from ..layout import BodyRow, StepState


class ShadowModel(IntEnum):
    """Shadow of the central body: `SolarRow.SHADOW`."""

    NONE, CYLINDRICAL, CONICAL = range(3)


class Light(IntEnum):
    """How much of a source's light or flow arrives between two cuts of the span."""

    DARK = 0
    PARTIAL = 1  # a fraction, which is computed
    FULL = 2


class FormRow(IntEnum):
    """Numbers of a form."""

    LINEAR = 0  # K (3, 3) row by row
    QUADRATIC = 9  # for each component the factors of xx, yy, zz, xy, xz, yz
    WIDTH = 27


class PlateRow(IntEnum):
    """Numbers of a plate.

    For a strength of 1 and n . d = c > 0 its torque is c [A x d] c + (B + C c) x n c with the centre of
    pressure x.
    """

    SOURCE, NORMAL, CENTRE = 0, 1, 4  # index; n (3); x (3)
    # A, B, C: the area times what flows along d (1 - specular), along n from scattering (2/3 diffuse), and
    # from mirroring (2 specular)
    ALONG, SCATTERED, MIRRORED = 7, 8, 9
    WIDTH = 10


class PlateFlag(IntEnum):
    """Numbers of a plate during the march."""

    LIT = 0  # 1, else -1
    COSINE = 1  # n . d
    WIDTH = 2


ARC_NODES = 8  # of an arc


class ArcRow(IntEnum):
    """Further rows of the workspace, after `NodeRow`."""

    # known beforehand: quaternion of the turn about the momentum (4); half the turn about the third axis
    PRECESSION, SPIN_COSINE, SPIN_SINE = 11, 15, 16
    # at the stages: departure of the attitude (4); matrix from the body's axes before the precession (3, 3)
    DEPARTURE, ROTATION = 17, 21
    # (3) each: momentum along the body's axes; that gained in the arc, before the precession; rate; torque.
    # GAIN and the row after it also take direction and strength of one source, for the compiler to know
    # where they are
    MOMENTUM, GAIN, RATE, TORQUE = 30, 33, 36, 39
    # unknowns: departure (4) and momentum (3); their slopes; the last change
    STAGE, SLOPE, CHANGE = 42, 49, 56
    # the scheme: nodes, weights; row j of MATRIX the weights of node j in the integrals up to each node, of
    # TO_POWERS its share of the coefficients of powers of y = 2 x - 1; AT_END the values at x = 1 of the
    # polynomials that are one at a node
    NODE, WEIGHT, MATRIX, TO_POWERS, AT_END = 57, 58, 59, 67, 75
    SOURCES = 76  # then SourceRow.ROWS for each source


class SourceRow(IntEnum):
    """Rows of a source."""

    DIRECTION, STRENGTH = 0, 3  # (3), inertial
    TURNED = 4  # (3): direction before the departure
    POWERS = 7  # (3): coefficients of the direction that the body sees
    END = 10  # ArcEnd
    ROWS = 11


class ArcEnd(IntEnum):
    """Numbers of a source at the end of the arc."""

    DIRECTION, STRENGTH = 0, 3  # (3), inertial
    RATE = 4  # (3) of the direction that the body sees, 1/s
    REACH = 7  # by how much a cosine can differ from that at the middle of the arc


# A body on the march; counts: arcs, sweeps, flips of plates, failures.  start, between: scratch.
MARCHED = np.dtype(
    [
        ("index", "i8"),
        ("body", "f8", BodyRow.WIDTH),
        ("constant", "f8", 3),  # torque that is constant in the body, N m
        ("state", "f8", StepState.WIDTH),
        ("theta", "f8"),  # rad, of the longest arc
        ("squared_rates", "f8"),  # 1/s2: torque over the least moment, and other rates squared
        ("counts", "i8", 4),
        ("edges", "f8"),  # rad/s: what missed edges may have cost
        ("start", "f8", StepState.WIDTH),
        ("between", "f8", StepState.WIDTH),
    ]
)
