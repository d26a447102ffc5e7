"""What the march between plates' edges and its callers agree on.  Plain numpy.

A source is a direction d(t), with a strength p(t), both independent of the body.  The torque of an effect is
p (K d + Q (d, d)) in components along the body's axes: a form of 27 numbers, K (3, 3) row by row, then for
each component the factors of xx, yy, zz, xy, xz, yz.  docs/torques.md, section 5.
"""

import numpy as np

from ..layout import EFFECT_WIDTH, STATE, STEPPED_BODY

FORM_WIDTH, QUADRATIC = 27, 9
# A source is a row of the effect it belongs to (`layout`), without the plate; of sunlight, after the
# pressure, the shadow, the radius of the central body and that of the Sun, m.
SOLAR_PRESSURE, SHADOW, SHADOW_RADIUS, SUN_RADIUS = 10, 11, 12, 13
NO_SHADOW, CYLINDRICAL, CONICAL = range(3)
SOURCE_WIDTH = EFFECT_WIDTH
# How much of a source's light or flow arrives between two cuts of the span: its fraction is computed.
DARK, PARTIAL, FULL_STRENGTH = range(3)

# A plate: its source, unit normal (3), centre of pressure (3); for a strength of 1 and n . d = c > 0 its
# torque is c [A x d] c + (B + C c) x n c with the centre of pressure x: A, B, C are the areas times what
# flows along d (1 - specular), along n from scattering (2/3 diffuse), and from mirroring (2 specular).
SOURCE, NORMAL, CENTRE, ALONG, SCATTERED, MIRRORED = 0, 1, 4, 7, 8, 9
PLATE_WIDTH = 10
# Of a plate during the march: whether it is lit (1, else -1), and n . d.
LIT, COSINE_NOW = 0, 1

# Nodes of an arc, and rows of so many numbers in the workspace: first time, place and speed as in `layout`.
ARC_NODES = 8
TIME, TIME_LOW, PLACE, SPEED, SUN, ABOUT, COSINE, SINE = 0, 1, 2, 5, 8, 11, 15, 16
DEPARTED, ROTATION, MOMENT, OUTER, RATE, TORQUE, STAGE, SLOPE, CHANGE = 17, 21, 30, 33, 36, 39, 42, 49, 56
# The scheme: nodes, weights; row j of MATRIX the weights of node j in the integrals up to each node, of
# TO_POWERS its share of the coefficients of powers of y = 2 x - 1; AT_END the values at x = 1 of the
# polynomials that are one at a node.
AT, WEIGHTS, MATRIX, TO_POWERS, AT_END = 57, 58, 59, 67, 75
SCHEME_ROWS = 76
UNKNOWNS = 7
# After them for each source: direction (3, inertial), strength, direction before the departure (3),
# coefficients of the direction that the body sees (3); and at the end of the arc (one row): direction (3,
# inertial), strength, rate of the direction that the body sees (3), 1/s; by how much a cosine can differ from
# that at the middle.
DIRECTION, STRENGTH, TURNED, POWERS, AT_ARC_END = 0, 3, 4, 7, 10
ROWS_PER_SOURCE = 11

# A body on the march; counts: arcs, sweeps, flips of plates, failures.  start, between: scratch.
MARCHED = np.dtype(
    [
        ("index", "i8"),
        ("body", "f8", STEPPED_BODY),
        ("constant", "f8", 3),  # torque that is constant in the body, N m
        ("state", "f8", STATE),
        ("theta", "f8"),  # rad, of the longest arc
        ("pace", "f8"),  # 1/s2: torque over the least moment, and other rates squared
        ("counts", "i8", 4),
        ("edges", "f8"),  # rad/s: what missed edges may have cost
        ("start", "f8", STATE),
        ("between", "f8", STATE),
    ]
)
