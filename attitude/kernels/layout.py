"""What kernels and their callers agree on: the record of a body's constants, and the codes in it.

Plain numpy: who only calls kernels needs no compiler.
"""

import numpy as np

CONSTANT_RATE, SHORT_AXIS, LONG_AXIS, SEPARATRIX = range(4)
REGIMES = ("constant_rate", "short_axis", "long_axis", "separatrix")
THETA, TRANSFORMED = range(2)


# An effect is a row of numbers, or several; the first is its code, vectors of the body are components
# along its principal axes, all is SI.  Rows are padded with zeros to EFFECT_WIDTH.
#   CONSTANT_BODY      torque (3)
#   CONSTANT_INERTIAL  torque (3), inertial components
#   GRAVITY_GRADIENT   gravitational parameter of the central body, m3/s2
#   EDDY               C (3, 3) row by row: torque -C omega, N m s
#   DISSIPATION        alpha, 1/(N m s): dm/dt = m x w + alpha m x (m x w), m the momentum, w = I^-1 m
#   WHEELS             momentum of the rotors relative to the body (3), N m s
#   MAGNETIC           dipole of the body (3), A m2; field strength k, T m3; axis of the central body's
#                      dipole as a + b cos(2 pi x) + c sin(2 pi x): a (3), b (3), c (3) inertial;
#                      x in turns/s in two parts: B = k / r^3 (3 (d . r) r - d), r here a unit vector
#   SOLAR_PLATE        normal (3), centre of pressure (3) from the centre of mass, area, specular and
#                      diffuse coefficient, pressure at 1 au, N/m2
#   DRAG_PLATE         normal (3), centre of pressure (3), area times drag coefficient, density, kg/m3,
#                      at reference radius, m, and scale height, m (infinite: constant density), rotation
#                      of the atmosphere (3), inertial, rad/s; first piece of the density by time (AIR), and
#                      their number: if there are any, they stand in place of the exponential
#   USER               address of a C function void(double t, double *q, double *w, double *torque)
#                      as the bits of a double; body frame of the document
(
    CONSTANT_BODY,
    CONSTANT_INERTIAL,
    GRAVITY_GRADIENT,
    EDDY,
    DISSIPATION,
    WHEELS,
    MAGNETIC,
    SOLAR_PLATE,
    DRAG_PLATE,
    USER,
) = range(1, 11)
EFFECT_WIDTH = 20
# Where the numbers of a row are vectors of the body: the place of each one's first.  EDDY's are a tensor.
BODY_VECTORS = {CONSTANT_BODY: (1,), WHEELS: (1,), MAGNETIC: (1,), SOLAR_PLATE: (1, 4), DRAG_PLATE: (1, 4)}

# The density along the orbit as a function of time: a row a piece, ascending, with its start, s, twice the
# inverse of its length, and the coefficients of ln(density), kg/m3, in powers of the time from its middle
# over half of its length.  AIR_FIRST, AIR_COUNT: its first piece and their number, in a row of DRAG_PLATE.
AIR_START, AIR_SCALE, AIR_POWERS = 0, 1, 2
AIR_DEGREE = 9
AIR_WIDTH = AIR_POWERS + AIR_DEGREE + 1
AIR_FIRST, AIR_COUNT = 14, 15

# Where the centre of mass is on its orbit, about the central body: code, then
#   KEPLER  semi-major axis a, eccentricity e, mean anomaly at t = 0 in turns, mean motion in turns/s in two
#           parts, mean motion in rad/s, unit vectors to the pericentre P (3) and along the motion there Q (3)
#   TABLE   start and length, s, of the pieces; position is a polynomial in each: coefficients
#           (pieces, 3, degree + 1) of x, y, z in powers of the time from the middle of the piece over half of
#           its length, from -1 to 1
NO_ORBIT, KEPLER, TABLE = range(3)
ORBIT_WIDTH = 16

# The body that solvers step: moments (3) and their inverses (3) along axes of the solver's choice, the
# turn q_PB from the document's body frame to these axes (4, v_P = R(q_PB) v_B); then the sums of the rows
# that act without a torque of their own or linearly: momentum of the rotors (3), alpha of the dissipation,
# C of the eddies (3, 3).  The effects handed to solvers are the other rows.
MOMENTS, INVERSES, TO_AXES, ROTORS, ALPHA, EDDIES = 0, 3, 6, 10, 13, 14
STEPPED_BODY = 23

# The state that solvers step: attitude of the axes (4, to inertial) and what its rounding left (4), momentum
# (3, inertial) and the rest (3); of a body symmetric about its third axis also the momentum along that axis
# and the rest, and the turn about it that is not in the attitude, in turns, and the rest.
ATTITUDE, ATTITUDE_LOW, MOMENTUM, MOMENTUM_LOW = 0, 4, 8, 11
AXIAL, AXIAL_LOW, SPIN, SPIN_LOW = 14, 15, 16, 17
STATE = 18

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
        ("body", "f8", STEPPED_BODY),
        ("symmetric", "i8"),
        ("state", "f8", STATE),
        ("steps", "i8"),
        ("decay", "f8"),
        ("max_steps", "f8"),
        ("dense", "i8"),
        ("aim", "f8"),
        ("after", "i8"),
        ("reach", "f8"),
        ("counts", "f8", 3),
        ("scratch", "f8", 2 * STATE),
    ]
)

# Nodes of a step: two of the widest vectors, the second half mirrors of the first.  A workspace has rows of
# so many numbers, one after the other; in one dimension, for the compiler to see that rows are apart.
NODES, HALF = 16, 8

# Rows of the collocation's workspace.  Known before the sweeps: time, place, speed and Sun (along the axes of
# the step), cosine and sine of the turns about the momentum and about the third axis, and both in turns.
TIME, TIME_LOW, PLACE, SPEED, SUN, COSINE, SINE, SPIN_COSINE, SPIN_SINE = 0, 1, 2, 5, 8, 11, 12, 13, 14
TURNED, SPUN = 15, 16
# Changed by the sweeps: momentum and torque along the body's axes, the unknowns, their slopes, the last
# change; and the Legendre coefficients of the slopes.
MOMENT, TORQUE, STAGE, SLOPE, CHANGE, COEFFICIENT = 17, 20, 23, 31, 39, 40
# The scheme: nodes, weights; row j of the matrix the weights in the integrals up to each node of the first
# half, of sums and of differences; weights of node j in the Legendre coefficients.
AT, WEIGHTS, MATRIX, LEGENDRE = 48, 49, 50, 58
# For each effect: its direction along the axes of the step turned about the momentum, and its strength;
# before them, those of one effect, where the compiler sees them apart from the other rows.
DIRECTION, STRENGTH, KNOWN = 74, 77, 78
KNOWN_ROWS = 4
# Rows of STAGE and SLOPE: departure of the attitude (4), momentum (3), momentum along the third axis.
UNKNOWNS = 8

# A body that flies over a plane, as kernels take it: numbers (WORLD_WIDTH) and the corners of its shape
# (n, 3), from the centre of mass, body frame.  Corners alone are a polyhedron; BALL puts a ball of the radius
# about each, RIM a disc across the axis: a cylinder is two corners on its axis, each with a rim.
#   mass, kg; gravity (3), m/s2; unit normal of the plane (3), away from the ground; height of the plane along
#   it, m; restitution; friction; kind of corner, its radius, m, and unit axis (3), body frame; greatest
#   distance of a corner's lowest point (or of a ball's centre) and of any point from the centre of mass, m
SHARP, RIM, BALL = range(3)
WORLD_WIDTH = 17
# A flight between two contacts: its start, s in two parts, and the state there: attitude (4), body rate (3),
# position (3), velocity (3).
FLIGHT_WIDTH = 15
# A contact: how many points, approaching speed of the fastest, impulse (3), where it acts (3), body rate (3)
# and velocity (3) before; inertial but for the body rate.
CONTACT_WIDTH = 14
# A point that touches: place (3) from the centre of mass; impulse along the normal, and across it (3); what
# a unit impulse changes of its own speed, along the normal, and at most across it; all body frame.
TOUCH_WIDTH = 9
# What ends a run of flights; the last two are no end: numbers beyond a double, or more steps than is sane.
TIME_IS_UP, AT_REST, NO_ROOM, OUT_OF_RANGE, TOO_LONG = range(5)
# Points of a rim that stand for all of it where it lies flat.
RIM_POINTS = 8

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

# Whole turns are dropped in one step; up to this many, what is left lies where the polynomials hold.
MAX_TURNS = 2.0**42


# Rows, and numbers in each, of the scratch array for a gyrostat's exact sums.
EXACT_SUM_ROWS, EXACT_SUM_LENGTH = 20, 512


def workspace():
    """Scratch for exact sums: the sum, two generations of a product, its factors; a tensor over a rate.

    Kernels allocate nothing: each call is handed its own.
    """
    return np.empty(512), np.empty((2, 256)), np.empty((5, 2)), np.empty((4, 3))


INVARIANTS = np.dtype(
    [
        # what the samples need
        ("route", "i8"),  # THETA or TRANSFORMED
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
        ("regime", "i8"),
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

# How partial derivatives are computed: beside a constant rate, by the functions that make the samples, or by
# these with the changes for needles spun about themselves (docs/partial-derivatives.md).
CONSTANT_PARTIALS, LONG_ARCS, NEEDLE = range(3)
# Whether they may leave the range of a double, and so near the middle axis at t = 0 that they do at once.
MAY_GROW, LOST = 1, 2

# What partial derivatives need besides INVARIANTS.  Axes 1, 2, 3 are those of INVARIANTS; beside a constant
# rate axis 3 is along the momentum.  Moments are over `size`, time is L t: no unit of time is left.
PARTIALS = np.dtype(
    [
        ("kind", "i8"),
        ("elements", "i8"),  # how many of the elements 11, 22, 33, 12, 13, 23 are computed
        ("grows", "i8"),  # 0, MAY_GROW, LOST
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

# Bodies whose constants are computed together in vector lanes, and the rows of that kernel's workspace: those
# of a record, then whether the body is served; q, E and E'; two-part moments; rate, attitude; axes.  From row
# to row an odd number of cache lines: no two rows share a set.
LANE_BLOCK, LANE_PITCH = 64, 72
LANE_SERVED = INVARIANTS.itemsize // 8
LANE_NOMES, LANE_MOMENTS, LANE_RATE, LANE_ATTITUDE, LANE_AXES = (LANE_SERVED + n for n in (1, 4, 10, 13, 17))
LANE_ROWS = LANE_AXES + 18

# How a gyrostat's samples are computed, and what motion it is (docs/gyrostats.md).
CIRCLING_SERIES, SWINGING_SERIES, TRANSFORMED_SERIES = range(3)
CONSTANT, TWO_TURNS, CIRCLING_PATH, SWINGING_PATH, SEPARATRIX_PATH = range(5)

GYROSTAT = np.dtype(
    [
        ("route", "i8"),
        ("precession", "f8", 2),  # lambda, turns/s, two parts
        ("argument", "f8", 2),  # v' turns/s, or y' rad/s, two parts
        ("argument0", "f8", 2),  # its value at t = 0
        (
            "step",
            "f8",
            2,
        ),  # of y, after which the series repeat but for a constant factor; infinite on a separatrix
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
        ("regime", "i8"),
        ("period", "f8"),  # s, after which gamma3 returns; infinite on a separatrix and for a constant rate
        ("any_rotor", "i8"),  # whether the rotor is along no principal axis
        ("boost", "f8"),  # condition number of `frame`, which is 1 for a rotor along a principal axis
    ]
)
