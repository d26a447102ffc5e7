"""The torques of a scene's effects at an instant; rows of numbers as `layout` has them.

All in components along the body's axes that the solver steps, and SI.
"""

import math

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from ..intrinsics import bits_of, fma, inlined, routine
from ..layout import (
    CONSTANT_BODY,
    CONSTANT_INERTIAL,
    DRAG_PLATE,
    EDDIES,
    FULL,
    GRAVITY_GRADIENT,
    INVERSES,
    MAGNETIC,
    MOMENTS,
    NODES,
    PLACE,
    RATE,
    ROTORS,
    SOLAR_PLATE,
    SPEED,
    SUN,
    TIME,
    TIME_LOW,
    TO_AXES,
    TORQUE,
)
from ..phase import phase, sine_cosine
from ..rotation import product, rotated, rotated_back
from ..vectors import add_scaled, cross, dot, scaled
from .orbit_path import along_pieces, position_and_velocity

ASTRONOMICAL_UNIT = 149597870700.0


@inlined
def three(row, first):
    """Three numbers of a row, from `first` on."""
    return row[first], row[first + 1], row[first + 2]


@routine
def torque(world, body, t, t_low, q, rate):
    """Sum of the torques, but for eddies, whose torque is linear in the rate.

    world : effects (n, EFFECT_WIDTH), orbit, pieces, sun (start, length, whether there is one), sun_pieces
    body : (STEPPED_BODY,); q : attitude of the axes; rate : of the body
    """
    effects, orbit, pieces, sun, sun_pieces = world
    r, v = position_and_velocity(orbit, pieces, t, t_low)
    total = 0.0, 0.0, 0.0
    for k in range(effects.shape[0]):
        row = effects[k]
        code = row[0]
        if code == GRAVITY_GRADIENT:
            one = gravity_gradient(row[1], three(body, MOMENTS), q, r)
        elif code == CONSTANT_BODY:
            one = three(row, 1)
        elif code == CONSTANT_INERTIAL:
            one = rotated_back(q, three(row, 1))
        elif code == MAGNETIC:
            one = magnetic(_dipole(row), (row[14], row[15]), t, t_low, q, r)
        elif code == SOLAR_PLATE:
            place, _ = along_pieces(sun_pieces, sun[0], sun[1], t, t_low)
            one = solar_plate(_plate(row), q, add_scaled(place, -1.0, r))
        elif code == DRAG_PLATE:
            one = drag_plate(_plate(row), three(row, 11), q, r, v)
        else:
            one = users(row[1], _to_axes(body), t + t_low, q, rate)
        total = add_scaled(total, 1.0, one)
    return total


@inlined
def torques(world, body, work):
    """`torque` at all nodes of a step side by side, from rows of the workspace `work` into its row TORQUE.

    What depends on the time alone (places and speeds on the orbit, places of the sun) is there already.
    What does not depend on the node is read beforehand: a loop that reads no other array becomes vectors.
    """
    effects = world[0]
    for i in range(NODES):
        put_three(work, TORQUE, i, (0.0, 0.0, 0.0))
    for k in range(effects.shape[0]):
        row = effects[k]
        code = row[0]
        if code == GRAVITY_GRADIENT:
            mu, moments = row[1], three(body, MOMENTS)
            for i in range(NODES):
                q, r = four_at(work, FULL, i), three_at(work, PLACE, i)
                _add_at(work, TORQUE, i, gravity_gradient(mu, moments, q, r))
        elif code == CONSTANT_BODY:
            fixed = three(row, 1)
            for i in range(NODES):
                _add_at(work, TORQUE, i, fixed)
        elif code == CONSTANT_INERTIAL:
            fixed = three(row, 1)
            for i in range(NODES):
                _add_at(work, TORQUE, i, rotated_back(four_at(work, FULL, i), fixed))
        elif code == MAGNETIC:
            dipole, pace = _dipole(row), (row[14], row[15])
            for i in range(NODES):
                q, r = four_at(work, FULL, i), three_at(work, PLACE, i)
                t, t_low = work[TIME * NODES + i], work[TIME_LOW * NODES + i]
                _add_at(work, TORQUE, i, magnetic(dipole, pace, t, t_low, q, r))
        elif code == SOLAR_PLATE:
            plate = _plate(row)
            for i in range(NODES):
                to_sun = add_scaled(three_at(work, SUN, i), -1.0, three_at(work, PLACE, i))
                _add_at(work, TORQUE, i, solar_plate(plate, four_at(work, FULL, i), to_sun))
        elif code == DRAG_PLATE:
            plate, turning = _plate(row), three(row, 11)
            for i in range(NODES):
                q, r = four_at(work, FULL, i), three_at(work, PLACE, i)
                _add_at(work, TORQUE, i, drag_plate(plate, turning, q, r, three_at(work, SPEED, i)))
        else:
            address, to_axes = row[1], _to_axes(body)
            for i in range(NODES):
                q, rate = four_at(work, FULL, i), three_at(work, RATE, i)
                t = work[TIME * NODES + i] + work[TIME_LOW * NODES + i]
                _add_at(work, TORQUE, i, users(address, to_axes, t, q, rate))


@inlined
def three_at(work, row, i):
    """Three numbers of node i, from `row` on."""
    return work[row * NODES + i], work[(row + 1) * NODES + i], work[(row + 2) * NODES + i]


@inlined
def four_at(work, row, i):
    """Four numbers of node i, from `row` on."""
    x, y, z = three_at(work, row + 1, i)
    return work[row * NODES + i], x, y, z


@inlined
def put_three(work, row, i, vector):
    """Write three numbers of node i."""
    work[row * NODES + i] = vector[0]
    work[(row + 1) * NODES + i] = vector[1]
    work[(row + 2) * NODES + i] = vector[2]


@inlined
def put_four(work, row, i, q):
    """Write four numbers of node i."""
    work[row * NODES + i] = q[0]
    put_three(work, row + 1, i, (q[1], q[2], q[3]))


@inlined
def _add_at(work, row, i, vector):
    work[row * NODES + i] += vector[0]
    work[(row + 1) * NODES + i] += vector[1]
    work[(row + 2) * NODES + i] += vector[2]


@inlined
def _to_axes(body):
    return body[TO_AXES], body[TO_AXES + 1], body[TO_AXES + 2], body[TO_AXES + 3]


@inlined
def _dipole(row):
    """(dipole of the body, strength, the three vectors of the field's axis)."""
    return three(row, 1), row[4], three(row, 5), three(row, 8), three(row, 11)


@inlined
def _plate(row):
    """(normal, centre of pressure, four numbers)."""
    return three(row, 1), three(row, 4), (row[7], row[8], row[9], row[10])


@inlined
def gravity_gradient(mu, moments, q, r):
    """3 mu / r^3 e x I e, e the direction of the centre of the central body (or away from it)."""
    distance2 = dot(r, r)
    inverse = 1.0 / math.sqrt(distance2)
    e = rotated_back(q, scaled(inverse, r))
    size = 3.0 * mu * inverse / distance2
    I1, I2, I3 = moments
    x = size * (I3 - I2) * e[1] * e[2]
    y = size * (I1 - I3) * e[2] * e[0]
    z = size * (I2 - I1) * e[0] * e[1]
    return x, y, z


@inlined
def magnetic(dipole, pace, t, t_low, q, r):
    """Dipole x B, B that of a dipole fixed in the turning central body."""
    own, strength, still, cosines, sines = dipole
    turns, rest = phase(pace[0], pace[1], t, t_low)
    sine, cosine = sine_cosine(turns, rest)
    d = add_scaled(add_scaled(still, cosine, cosines), sine, sines)
    distance2 = dot(r, r)
    inverse = 1.0 / math.sqrt(distance2)
    e = scaled(inverse, r)
    field = add_scaled(scaled(3.0 * dot(d, e), e), -1.0, d)
    return cross(own, rotated_back(q, scaled(strength * inverse / distance2, field)))


@inlined
def solar_plate(plate, q, to_sun):
    """Pressure of sunlight on a plate: what is absorbed, mirrored and scattered.

    F = -P A cos [(1 - specular) s + 2 (specular cos + diffuse / 3) n] on the lit side.
    Source: Wertz, Spacecraft Attitude Determination and Control (1978), section 17.2.2.
    """
    n, centre, (area, specular, diffuse, pressure) = plate
    distance2 = dot(to_sun, to_sun)
    s = rotated_back(q, scaled(1.0 / math.sqrt(distance2), to_sun))
    cosine = max(dot(n, s), 0.0)
    pressure *= ASTRONOMICAL_UNIT * ASTRONOMICAL_UNIT / distance2
    along_n = 2.0 * fma(specular, cosine, diffuse / 3.0)
    force = scaled(-pressure * area * cosine, add_scaled(scaled(1.0 - specular, s), along_n, n))
    return cross(centre, force)


@inlined
def drag_plate(plate, turning, q, r, v):
    """Drag of the air that meets a plate: F = -1/2 rho Cd A cos v^2 along the air's motion."""
    n, centre, (area, density, reference, height) = plate
    wind = add_scaled(v, -1.0, cross(turning, r))
    speed2 = dot(wind, wind)
    inverse = 1.0 / math.sqrt(max(speed2, 1e-300))
    ahead = rotated_back(q, scaled(inverse, wind))
    cosine = max(dot(n, ahead), 0.0)
    density *= math.exp((reference - math.sqrt(dot(r, r))) / height)
    return cross(centre, scaled(-0.5 * density * area * cosine * speed2, ahead))


@inlined
def users(address, to_axes, t, q, rate):
    """The torque of a function of the user's, asked in the frame of the user's body."""
    attitude = product(q, to_axes)
    omega = rotated_back(to_axes, rate)
    return rotated(to_axes, called(bits_of(address), t, attitude, omega))


@intrinsic
def called(typingctx, address, t, q, rate):
    """The three numbers that the C function at an address writes."""
    double = ir.DoubleType()
    signature = types.UniTuple(types.float64, 3)(address, t, q, rate)

    def codegen(context, builder, signature, args):
        pointer = double.as_pointer()
        arrays = []
        for values, size in ((args[2], 4), (args[3], 3), (None, 3)):
            with builder.goto_entry_block():  # once, whatever loop this stands in
                array = builder.alloca(double, size=size)
            for i in range(size if values is not None else 0):
                value = builder.extract_value(values, i)
                builder.store(value, builder.gep(array, [ir.Constant(ir.IntType(32), i)]))
            arrays.append(array)
        kind = ir.FunctionType(ir.VoidType(), [double, pointer, pointer, pointer])
        function = builder.inttoptr(args[0], kind.as_pointer())
        builder.call(function, [args[1], *arrays])
        out = [builder.load(builder.gep(arrays[2], [ir.Constant(ir.IntType(32), i)])) for i in range(3)]
        return context.make_tuple(builder, signature.return_type, out)

    return signature, codegen


@inlined
def body_rate(body, m):
    """Rate of the body whose momentum, rotors included, is m in body components."""
    return rate_of(three(body, INVERSES), three(body, ROTORS), m)


@inlined
def rate_of(inverses, rotors, m):
    """Body rate of a momentum, along the principal axes."""
    x = inverses[0] * (m[0] - rotors[0])
    y = inverses[1] * (m[1] - rotors[1])
    z = inverses[2] * (m[2] - rotors[2])
    return x, y, z


@inlined
def eddies_of(body):
    """C, row by row."""
    return three(body, EDDIES), three(body, EDDIES + 3), three(body, EDDIES + 6)


@inlined
def taken_by_eddies(C, rate):
    """C omega."""
    return dot(C[0], rate), dot(C[1], rate), dot(C[2], rate)
