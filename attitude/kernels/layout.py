"""What kernels and their callers agree on: records of a body's constants, and names of numbers in arrays.

An `IntEnum` names the numbers of an array: `state[StepState.MOMENTUM]` is the first of three.  What a comment
gives no size is one number; WIDTH is how many numbers there are in all, ROWS how many rows.  Units are SI.
Plain numpy: who only calls kernels needs no compiler.
"""

from enum import IntEnum

import numpy as np

# -- torque-free motion (docs/theory.md) --------------------------------------------------------------------


class Regime(IntEnum):
    """Regime of a motion: `regime` of INVARIANTS."""

    CONSTANT_RATE, SHORT_AXIS, LONG_AXIS, SEPARATRIX = range(4)


REGIMES = tuple(regime.name.lower() for regime in Regime)


class Route(IntEnum):
    """Series that samples are summed from: `route` of INVARIANTS (sections 4 and 5)."""

    THETA, TRANSFORMED = range(2)


# Whole turns are dropped in one step; up to this many, what is left lies where the polynomials hold.
MAX_TURNS = 2.0**42

INVARIANTS = np.dtype(
    [
        # what the samples need
        ("route", "i8"),  # Route
        ("precession", "f8", 2),  # lambda, turns/s, two parts
        ("argument", "f8", 2),  # v' turns/s, or y' rad/s, two parts
        ("argument0", "f8", 2),  # its value at t = 0
        ("half_turn", "f8", 2),  # y for half a polhode period; infinite on the separatrix
        ("per_half_turn", "f8"),
        ("slip", "f8"),  # turns of precession for each unit of y
        ("nome", "f8"),  # q, or Q of the transformed series
        ("alpha_re", "f8", 4),
        ("alpha_im", "f8", 4),
        ("beta_re", "f8", 4),
        ("beta_im", "f8", 4),
        ("direction", "f8", (4, 5)),  # gamma1, gamma2, gamma3 over the last row; or three factors
        ("frame", "f8", (4, 4)),  # q_IM * . * q_PB
        ("rate", "f8", (3, 3)),  # gamma -> body rate, rad/s
        # what users ask about
        ("regime", "i8"),  # Regime
        ("amplitude", "f8", 3),  # A1, A2, A3
        ("modulus", "f8"),  # k
        ("complementary_modulus", "f8"),  # k1
        ("K", "f8"),
        ("K_prime", "f8"),
        ("eta", "f8"),
        ("u_rate", "f8"),  # u', rad/s
        ("u0", "f8"),
    ]
)


def workspace():
    """Scratch for exact sums: the sum, two generations of a product, its factors; a tensor over a rate.

    Kernels allocate nothing: each call is handed its own.
    """
    return np.empty(512), np.empty((2, 256)), np.empty((5, 2)), np.empty((4, 3))


# Bodies whose constants are computed together in vector lanes, and numbers from row to row of the workspace:
# an odd number of cache lines, so that no two rows share a set.
LANE_BLOCK, LANE_PITCH = 64, 72


class LaneRow(IntEnum):
    """Rows of the workspace of `lanes`, one number of each body in a row, after those of a record."""

    SERVED = INVARIANTS.itemsize // 8  # whether the body is served
    NOMES = SERVED + 1  # q, E and E'
    MOMENTS = NOMES + 3  # three, in two parts
    RATE = MOMENTS + 6  # (3)
    ATTITUDE = RATE + 3  # (4)
    AXES = ATTITUDE + 4  # (3, 3), in two parts
    ROWS = AXES + 18


# -- partial derivatives (docs/partial-derivatives.md) ------------------------------------------------------


class PartialsKind(IntEnum):
    """How partial derivatives are computed: `kind` of PARTIALS."""

    CONSTANT_RATE = 0  # beside a constant rate
    LONG_ARCS = 1  # by the functions that make the samples
    NEEDLE = 2  # by these, with the changes for needles spun about themselves


class PartialsGrowth(IntEnum):
    """Whether partial derivatives may leave the range of a double: `grows` of PARTIALS."""

    BOUNDED, POSSIBLE = 0, 1
    LOST = 2  # so near the middle axis at t = 0 that they do at once


# What partial derivatives need besides INVARIANTS.  Axes 1, 2, 3 are those of INVARIANTS; beside a constant
# rate axis 3 is along the momentum.  Moments are over `size`, time is L t: no unit of time is left.
PARTIALS = np.dtype(
    [
        ("kind", "i8"),  # PartialsKind
        ("elements", "i8"),  # how many of the elements 11, 22, 33, 12, 13, 23 are computed
        ("grows", "i8"),  # PartialsGrowth
        ("momentum", "f8"),  # L, rad/s
        ("size", "f8"),  # unit of the moments
        ("axes", "f8", (3, 3)),  # axes 1, 2, 3 in rows, body components
        ("inverse", "f8", 3),  # a1, a2, a3
        ("differences", "f8", 3),  # a21, a31, a32
        ("initial", "f8", 3),  # gamma at t = 0
        ("start", "f8", 3),  # gamma1/A1, gamma2/A1, gamma3 at t = 0
        ("b2", "f8"),
        ("u_rate", "f8"),
        ("quaternion", "f8", 4),  # q_MP at t = 0
        ("direction", "f8", (4, 5)),  # of INVARIANTS, over A1
        ("weight", "f8", 2),  # D/K and B/K, or D'/K' and B'/K'
        ("series", "f8", 4),  # of Jacobi's zeta in w; or p = Q^2, 4p/m1 of the transformed series
        ("quotient", "f8"),  # s A1 A3/A2
        ("integral0", "f8", 3),  # Z, S, 0; or T2, T3 and half turns, at t = 0
        ("turns", "f8", (2, 2)),  # turns/s, two parts: half the sum and half the difference of both turns
        ("nomes", "f8", 2),  # E, E' of a needle
        ("mix", "f8", (6, 6)),  # elements of the tensor along axes 1, 2, 3 in each column of inertia
    ]
)


# -- gyrostats (docs/gyrostats.md) --------------------------------------------------------------------------


class GyrostatRoute(IntEnum):
    """Series that samples of a gyrostat are summed from: `route` of GYROSTAT (sections 3 and 4)."""

    CIRCLING, SWINGING, TRANSFORMED = range(3)


class GyrostatRegime(IntEnum):
    """Motion of a gyrostat: `regime` of GYROSTAT."""

    CONSTANT = 0  # rate
    TWO_TURNS = 1  # at constant rates
    CIRCLING, SWINGING, SEPARATRIX = 2, 3, 4  # families of paths (section 2), and what parts them


class Sum(IntEnum):
    """Rows of the scratch array for a gyrostat's exact sums: expansions (section 2)."""

    M1, M2, M3, A12, A13, A23, K = range(7)  # input: W M, W (a_i - a_j) and W L k of a rotor along axis 3
    B1, B2, M11, M22, M33, LL, X = range(7, 14)  # sums that others are made of
    PRODUCT, PART, TOTAL = 14, 15, 16  # scratch
    PRINCIPAL = 17  # (3): the momentum along the body's principal axes
    ROWS = 20


EXACT_SUM_LENGTH = 512  # numbers in each row

GYROSTAT = np.dtype(
    [
        ("route", "i8"),  # GyrostatRoute
        ("precession", "f8", 2),  # lambda, turns/s, two parts
        ("argument", "f8", 2),  # v' turns/s, or y' rad/s, two parts
        ("argument0", "f8", 2),  # its value at t = 0
        # of y, after which the series repeat but for a constant factor; infinite on a separatrix
        ("step", "f8", 2),
        ("per_step", "f8"),
        ("first_step", "i8"),  # number of the step in which y starts
        ("turns_per_step", "f8"),  # of the common phase
        ("slip", "f8"),  # turns of the common phase for each unit of y
        ("nome", "f8"),  # of the transformed series: exp(-step)
        ("even", "f8"),  # 1 where alpha has even multiples of the argument, else 0
        ("flips", "i8"),  # whether beta changes its sign at each step
        ("swaps", "i8"),  # whether alpha and beta change places at each step
        ("swap_ratio", "f8"),
        ("alpha_re", "f8", 5),
        ("alpha_im", "f8", 5),
        ("beta_re", "f8", 5),
        ("beta_im", "f8", 5),
        ("frame", "f8", (4, 4)),  # to the attitude before its normalisation
        ("momentum", "f8", 3),  # unit vector, inertial
        ("to_rate", "f8", (3, 3)),  # L I^-1, body: of the momentum's direction
        ("rotor_rate", "f8", 3),  # I^-1 h, body, rad/s
        ("regime", "i8"),  # GyrostatRegime
        ("period", "f8"),  # s, after which gamma3 returns; infinite on a separatrix and for a constant rate
        ("any_rotor", "i8"),  # whether the rotor is along no principal axis
        ("boost", "f8"),  # condition number of `frame`, which is 1 for a rotor along a principal axis
    ]
)


# -- effects, and the orbit (docs/torques.md) ---------------------------------------------------------------


class EffectCode(IntEnum):
    """First number of an effect's row; vectors of the body are components along its principal axes."""

    CONSTANT_BODY = 1  # torque (3), N m
    CONSTANT_INERTIAL = 2  # torque (3), N m, inertial components
    GRAVITY_GRADIENT = 3  # gravitational parameter of the central body, m3/s2
    EDDY = 4  # C (3, 3) row by row, N m s: torque -C omega
    DISSIPATION = 5  # alpha, 1/(N m s): dm/dt = m x w + alpha m x (m x w), m the momentum, w = I^-1 m
    WHEELS = 6  # momentum of the rotors relative to the body (3), N m s
    MAGNETIC = 7  # DipoleRow
    SOLAR_PLATE = 8  # SolarRow
    DRAG_PLATE = 9  # DragRow
    # address of a C function void(double t, double *q, double *w, double *torque) as the bits of a double;
    # body frame of the document
    USER = 10


class EffectRow(IntEnum):
    """Numbers of an effect's row, padded with zeros."""

    CODE = 0  # EffectCode
    VALUE = 1  # what the code says begins here
    WIDTH = 20


class DipoleRow(IntEnum):
    """Numbers of a row of MAGNETIC: B = k / r^3 (3 (d . r) r - d), r the unit vector to the body."""

    DIPOLE = 1  # (3) of the body, A m2
    STRENGTH = 4  # k, T m3
    AXIS, AXIS_COSINE, AXIS_SINE = 5, 8, 11  # a, b, c (3) of d = a + b cos(2 pi x) + c sin(2 pi x), inertial
    TURN_RATE = 14  # of x, turns/s, in two parts


class SolarRow(IntEnum):
    """Numbers of a row of SOLAR_PLATE."""

    NORMAL = 1  # (3)
    CENTRE = 4  # (3) of pressure, from the centre of mass, m
    AREA, SPECULAR, DIFFUSE = 7, 8, 9  # m2, and coefficients of reflection
    PRESSURE = 10  # at 1 au, N/m2
    SHADOW, SHADOW_RADIUS, SUN_RADIUS = 11, 12, 13  # ShadowModel; of the central body and of the Sun, m


class DragRow(IntEnum):
    """Numbers of a row of DRAG_PLATE."""

    NORMAL = 1  # (3)
    CENTRE = 4  # (3) of pressure, from the centre of mass, m
    AREA = 7  # times drag coefficient, m2
    DENSITY, REFERENCE_RADIUS = 8, 9  # kg/m3, at this radius, m
    SCALE_HEIGHT = 10  # m; infinite: constant density
    ROTATION = 11  # (3) of the atmosphere, inertial, rad/s
    # of the AirPieces, which stand in place of the exponential if there are any
    AIR_FIRST, AIR_COUNT = 14, 15


# Where the numbers of a row are vectors of the body: the place of each one's first.  EDDY's are a tensor.
BODY_VECTORS: dict[int, tuple[int, ...]] = {
    EffectCode.CONSTANT_BODY: (EffectRow.VALUE,),
    EffectCode.WHEELS: (EffectRow.VALUE,),
    EffectCode.MAGNETIC: (DipoleRow.DIPOLE,),
    EffectCode.SOLAR_PLATE: (SolarRow.NORMAL, SolarRow.CENTRE),
    EffectCode.DRAG_PLATE: (DragRow.NORMAL, DragRow.CENTRE),
}

AIR_DEGREE = 9


class AirPiece(IntEnum):
    """Numbers of a piece of the density along the orbit; pieces ascend in time."""

    START = 0  # s
    SCALE = 1  # twice the inverse of its length, 1/s
    POWERS = 2  # of the time from its middle over half of its length: coefficients of ln(density), kg/m3
    WIDTH = POWERS + AIR_DEGREE + 1


class OrbitCode(IntEnum):
    """First number of the centre of mass's orbit about the central body."""

    NONE = 0
    KEPLER = 1  # Ellipse
    TABLE = 2  # TableOrbit


ORBIT_WIDTH = 16  # numbers of an orbit


class Ellipse(IntEnum):
    """Numbers of an orbit of KEPLER."""

    SEMI_MAJOR_AXIS, ECCENTRICITY = 1, 2  # m
    MEAN_ANOMALY = 3  # at t = 0, turns
    TURN_RATE = 4  # mean motion, turns/s, in two parts
    MEAN_MOTION = 6  # rad/s
    P, Q = 7, 10  # unit vectors (3) to the pericentre and along the motion there, inertial


class TableOrbit(IntEnum):
    """Numbers of an orbit of TABLE, whose position is a polynomial in each of its pieces.

    Coefficients (pieces, 3, degree + 1) of x, y, z are in powers of the time from the middle of the piece
    over half of its length, from -1 to 1.
    """

    START, LENGTH = 1, 2  # of the pieces, s


# -- solvers under torques (docs/torques.md, section 3) -----------------------------------------------------


class BodyRow(IntEnum):
    """Numbers of the body that solvers step, along axes of the solver's choice: `body` of STEPPED.

    The effects handed to solvers are the other rows than those that are summed here.
    """

    MOMENTS, INVERSES = 0, 3  # (3) each, kg m2 and 1/(kg m2)
    TO_AXES = 6  # q_PB (4) from the document's body frame to these axes, v_P = R(q_PB) v_B
    ROTORS = 10  # sum of their momenta (3), N m s
    ALPHA = 13  # of the dissipation, 1/(N m s)
    EDDIES = 14  # C (3, 3), N m s
    WIDTH = 23


class StepState(IntEnum):
    """Numbers of the state that solvers step; LOW: what the rounding of the others left."""

    ATTITUDE, ATTITUDE_LOW = 0, 4  # (4) of the axes, to inertial
    MOMENTUM, MOMENTUM_LOW = 8, 11  # (3), inertial, N m s
    # of a body symmetric about its third axis: the momentum along it, N m s, and the turn about it that is
    # not in the attitude, in turns
    AXIAL, AXIAL_LOW, SPIN, SPIN_LOW = 14, 15, 16, 17
    WIDTH = 18


# A body and how it is stepped: its index in the arrays of effects and of results; numbers as above, and
# whether it is symmetric about the third axis; state, at the start and, when a solver returns, at the end.
# Steps : equal ones, so many; halved where they are too long, by `decay` (relative size of the last Legendre
# coefficients of a step; infinite: any) and `reach` (length times momentum; infinite: any), no more than
# max_steps pieces.  Dense : whether instants within a step are read off its polynomial.  Aim : of the
# attitude's departure, what the last sweep of a step may leave; after : sweeps made beyond it.
# Counts : sweeps, failures, pieces; scratch : of two states.
STEPPED = np.dtype(
    [
        ("index", "i8"),
        ("body", "f8", BodyRow.WIDTH),
        ("symmetric", "i8"),
        ("state", "f8", StepState.WIDTH),
        ("steps", "i8"),
        ("decay", "f8"),
        ("max_steps", "f8"),
        ("dense", "i8"),
        ("aim", "f8"),
        ("after", "i8"),
        ("reach", "f8"),
        ("counts", "f8", 3),
        ("scratch", "f8", 2 * StepState.WIDTH),
    ]
)

# Nodes of a step: two of the widest vectors, the second half mirrors of the first.
NODES, HALF = 16, 8
UNKNOWNS = 8  # departure of the attitude (4), momentum (3), momentum along the third axis


class NodeRow(IntEnum):
    """First rows of the workspaces of both solvers.

    Rows of so many numbers as a step has nodes stand one after the other, in one dimension, for the compiler
    to see that they are apart.
    """

    TIME, TIME_LOW = 0, 1  # s
    POSITION, VELOCITY = 2, 5  # (3) each, m and m/s, along the axes of the step
    SUN = 8  # (3), its position, m


class StepRow(IntEnum):
    """Further rows of the collocation's workspace."""

    # known before the sweeps: turns about the momentum (precession) and about the third axis (spin), by
    # cosine and sine, and in turns
    COSINE, SINE, SPIN_COSINE, SPIN_SINE, PRECESSION, SPIN = range(11, 17)
    # changed by the sweeps
    MOMENTUM, TORQUE = 17, 20  # (3) each, along the body's axes
    STAGE, SLOPE, CHANGE = 23, 31, 39  # the UNKNOWNS, their slopes, the last change
    COEFFICIENT = 40  # UNKNOWNS rows: Legendre coefficients of the slopes
    # the scheme: nodes in a step of length 1; HALF rows of weights of node j in the integrals up to each node
    # of the first half, of sums and of differences; NODES rows of those in the Legendre coefficients
    NODE, WEIGHT, MATRIX, LEGENDRE = 48, 49, 50, 58
    # of one effect, where the compiler sees them apart from the other rows
    DIRECTION, STRENGTH = 74, 77
    # then ROWS_PER_EFFECT for each effect: direction (3), along the axes of the step turned about the
    # momentum, and strength
    EFFECTS = 78


ROWS_PER_EFFECT = 4


# -- flight and contact with a plane (docs/torques.md, section 7) -------------------------------------------


class CornerKind(IntEnum):
    """What is about the corners of a body's shape."""

    SHARP = 0  # nothing: a polyhedron
    RIM = 1  # a disc across the axis: a cylinder is two corners on its axis, each with a rim
    BALL = 2  # a ball of the radius


class GroundRow(IntEnum):
    """Numbers of a body that flies over a plane, beside the corners (n, 3) of its shape.

    Corners are from the centre of mass, body frame.
    """

    MASS = 0  # kg
    GRAVITY = 1  # (3), m/s2
    NORMAL, HEIGHT = 4, 7  # unit vector (3) away from the ground; of the plane along it, m
    RESTITUTION, FRICTION = 8, 9
    CORNER_KIND, CORNER_RADIUS = 10, 11  # CornerKind; m
    AXIS = 12  # unit vector (3), body frame
    # greatest distance of a corner's lowest point (or of a ball's centre), and of any point, m
    REACH, SIZE = 15, 16
    WIDTH = 17


class FlightRow(IntEnum):
    """Numbers of a flight between two contacts, at its start."""

    TIME, TIME_LOW = 0, 1  # s
    ATTITUDE, RATE, POSITION, VELOCITY = 2, 6, 9, 12  # (4), (3) body frame, (3), (3)
    WIDTH = 15


class ContactRow(IntEnum):
    """Numbers of a contact; inertial but for the body rate."""

    POINTS, SPEED = 0, 1  # how many; at which the fastest approaches, m/s
    IMPULSE, CENTRE = 2, 5  # (3), N s; where it acts (3), m
    RATE, VELOCITY = 8, 11  # (3) each, before
    WIDTH = 14


class TouchRow(IntEnum):
    """Numbers of a point that touches, body frame."""

    POSITION = 0  # (3), from the centre of mass, m
    NORMAL, TANGENTIAL = 3, 4  # impulse along the normal, and across it (3), N s
    # what a unit impulse changes of the point's own speed: along the normal, and at most across it
    NORMAL_RESPONSE, TANGENTIAL_RESPONSE = 7, 8
    WIDTH = 9


class BounceState(IntEnum):
    """Numbers that carry a run of flights from call to call."""

    SPEED, QUICK_CONTACTS = 0, 1  # greatest of the surface, m/s; in quick succession: so far, zeros at first
    END, CONTACTS, TIME = 2, 3, 4  # written: FlightEnd, number of contacts, when it ended, s, in two parts
    UNTIL = 6  # read: the time until which to go on, s, in two parts
    WIDTH = 8


class FlightEnd(IntEnum):
    """What ends a run of flights."""

    TIME_IS_UP, AT_REST, NO_ROOM = range(3)
    OUT_OF_RANGE, TOO_LONG = 3, 4  # no end: numbers beyond a double, or more steps than is sane


# Points of a rim that stand for all of it where it lies flat.
RIM_POINTS = 8

# -- ensembles ----------------------------------------------------------------------------------------------

# Random words of a body, a multiple of the four of one counter; and how often its moments are drawn, each
# time from words of another range, until they are physical.
WORDS_PER_BODY = 12
MAX_DRAWS = 1000

# Sums of products of unit quaternions over a block of bodies, as whole numbers: three limbs, the first in
# units of 2^-30, the last of 2^-114.  A block has no more than 2^42 of any, so that 64 bits hold the sum of
# two million blocks, and of the first limb that of 2^33 bodies.
BODIES_PER_BLOCK = 256
LIMB_FIRST, LIMB_BITS = 30, 42
# From row to row of these sums: instants at a time, in an odd number of cache lines: no two rows share a set.
ROW_STRIDE = 1032
