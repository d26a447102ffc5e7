"""The torques of a scene's effects at all nodes of a step of the collocation (docs/torques.md, section 1).

What depends on the time alone, the direction of the central body or of its field and the strength, is
computed once a step, along axes that turn with the step (`directions_and_strengths`); what depends on the
attitude, in every sweep (`torques`).  Torques are along the body's axes that the solver steps.
"""

import math

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from ..intrinsics import bits_of, fma, inlined, routine
from ..layout import NODES, ROWS_PER_EFFECT, BodyRow, DipoleRow, EffectCode, EffectRow, NodeRow, StepRow
from ..phase import phase, sine_cosine
from ..rotation import product, rotated, rotated_back
from ..vectors import add_scaled, cross, dot, four, pair_at, scaled, three
from .node_rows import accessors
from .node_vectors import copy_effect

ASTRONOMICAL_UNIT = 149597870700.0
two_at, three_at, four_at, put_two, put_three, put_four = accessors(NODES)


@inlined
def turned_by(cosine, sine, v):
    """A vector after a turn about the third axis."""
    return fma(cosine, v[0], -sine * v[1]), fma(sine, v[0], cosine * v[1]), v[2]


@inlined
def departure_at(work, i, start):
    """The departure of the attitude at node i."""
    stage = four_at(work, StepRow.STAGE, i)
    return start[0] + stage[0], start[1] + stage[1], start[2] + stage[2], start[3] + stage[3]


# -- once a step ------------------------------------------------------------------------------------------


@routine
def directions_and_strengths(effects, frame, work):
    """Direction and strength of every effect at the nodes, from the positions in the workspace.

    frame : quaternion from the axes of the step to inertial ones
    """
    for k in range(effects.shape[0]):
        row = effects[k]
        code = row[EffectRow.CODE]
        if code == EffectCode.GRAVITY_GRADIENT:
            for i in range(NODES):
                r = three_at(work, NodeRow.POSITION, i)
                distance2 = dot(r, r)
                inverse = 1.0 / math.sqrt(distance2)
                _write_source(work, i, scaled(inverse, r), 3.0 * row[EffectRow.VALUE] * inverse / distance2)
        elif code == EffectCode.CONSTANT_INERTIAL:
            fixed = rotated_back(frame, three(row, EffectRow.VALUE))
            for i in range(NODES):
                _write_source(work, i, fixed, 1.0)
        elif code == EffectCode.MAGNETIC:
            fixed = rotated_back(frame, three(row, DipoleRow.AXIS))
            cosines = rotated_back(frame, three(row, DipoleRow.AXIS_COSINE))
            axis = fixed, cosines, rotated_back(frame, three(row, DipoleRow.AXIS_SINE))
            strength, turn_rate = row[DipoleRow.STRENGTH], pair_at(row, DipoleRow.TURN_RATE)
            for i in range(NODES):
                t = two_at(work, NodeRow.TIME, i)
                field = dipole_field(strength, axis, turn_rate, t, three_at(work, NodeRow.POSITION, i))
                _write_source(work, i, field, 1.0)
        copy_effect(work, StepRow.DIRECTION * NODES, (StepRow.EFFECTS + ROWS_PER_EFFECT * k) * NODES)


@inlined
def _write_source(work, i, direction, strength):
    """Keep a direction, turned with the step about the momentum, and a strength."""
    cosine, sine = two_at(work, StepRow.COSINE, i)
    put_three(work, StepRow.DIRECTION, i, turned_by(cosine, -sine, direction))
    work[StepRow.STRENGTH * NODES + i] = strength


@inlined
def dipole_field(strength, axis, turn_rate, t, r):
    """k / r^3 (3 (d . e) e - d): the field of a dipole d fixed in the turning central body.

    axis : a, b, c of d = a + b cos + c sin; turn_rate : turns/s in two parts; t in two parts
    """
    turns, rest = phase(turn_rate, t[0], t[1])
    sine, cosine = sine_cosine(turns, rest)
    d = add_scaled(add_scaled(axis[0], cosine, axis[1]), sine, axis[2])
    distance2 = dot(r, r)
    inverse = 1.0 / math.sqrt(distance2)
    e = scaled(inverse, r)
    return scaled(strength * inverse / distance2, add_scaled(scaled(3.0 * dot(d, e), e), -1.0, d))


# -- in every sweep ---------------------------------------------------------------------------------------


@inlined
def needs_rates(effects):
    """Whether a torque depends on the rate of the body."""
    asks = False
    for k in range(effects.shape[0]):
        asks |= effects[k, EffectRow.CODE] == EffectCode.USER
    return asks


@inlined
def torques(effects, body, start, frame, work):
    """Sum of the torques at all nodes, but for eddies, into the row TORQUE of the workspace.

    What does not depend on the node is read beforehand: a loop that reads no other array becomes vectors.

    start : the departure at the start of the step; frame : as in `directions_and_strengths`
    """
    for i in range(NODES):
        put_three(work, StepRow.TORQUE, i, (0.0, 0.0, 0.0))
    for k in range(effects.shape[0]):
        row = effects[k]
        code = row[EffectRow.CODE]
        copy_effect(work, (StepRow.EFFECTS + ROWS_PER_EFFECT * k) * NODES, StepRow.DIRECTION * NODES)
        if code == EffectCode.GRAVITY_GRADIENT:
            moments = three(body, BodyRow.MOMENTS)
            for i in range(NODES):
                strength = work[StepRow.STRENGTH * NODES + i]
                _add(work, i, gravity_gradient(strength, moments, _direction_seen(work, i, start)))
        elif code == EffectCode.CONSTANT_BODY:
            fixed = three(row, EffectRow.VALUE)
            for i in range(NODES):
                _add(work, i, fixed)
        elif code == EffectCode.CONSTANT_INERTIAL:
            for i in range(NODES):
                _add(work, i, _direction_seen(work, i, start))
        elif code == EffectCode.MAGNETIC:
            own = three(row, DipoleRow.DIPOLE)
            for i in range(NODES):
                _add(work, i, cross(own, _direction_seen(work, i, start)))
        elif code == EffectCode.USER:
            inverses, rotors = three(body, BodyRow.INVERSES), three(body, BodyRow.ROTORS)
            address, to_axes = row[EffectRow.VALUE], four(body, BodyRow.TO_AXES)
            for i in range(NODES):
                rate = rate_of(inverses, rotors, three_at(work, StepRow.MOMENTUM, i))
                t, t_low = two_at(work, NodeRow.TIME, i)
                q = attitude_at(work, i, start, frame)
                _add(work, i, user_torque(address, to_axes, t + t_low, q, rate))


@inlined
def _direction_seen(work, i, start):
    """The direction along the body's axes at node i."""
    v = rotated_back(departure_at(work, i, start), three_at(work, StepRow.DIRECTION, i))
    cosine, sine = two_at(work, StepRow.SPIN_COSINE, i)
    return turned_by(cosine, -sine, v)


@inlined
def attitude_at(work, i, start, frame):
    """The whole attitude at node i."""
    sine, cosine = sine_cosine(0.5 * work[StepRow.PRECESSION * NODES + i], 0.0)
    q = product(product(frame, (cosine, 0.0, 0.0, sine)), departure_at(work, i, start))
    sine, cosine = sine_cosine(0.5 * work[StepRow.SPIN * NODES + i], 0.0)
    return product(q, (cosine, 0.0, 0.0, sine))


@inlined
def _add(work, i, vector):
    work[StepRow.TORQUE * NODES + i] += vector[0]
    work[(StepRow.TORQUE + 1) * NODES + i] += vector[1]
    work[(StepRow.TORQUE + 2) * NODES + i] += vector[2]


@inlined
def gravity_gradient(strength, moments, e):
    """3 mu / r^3 e x I e, e the direction of the centre of the central body (or away from it)."""
    x = strength * (moments[2] - moments[1]) * e[1] * e[2]
    y = strength * (moments[0] - moments[2]) * e[2] * e[0]
    z = strength * (moments[1] - moments[0]) * e[0] * e[1]
    return x, y, z


@inlined
def user_torque(address, to_axes, t, q, rate):
    """The torque of a function of the user's, asked in the frame of the user's body."""
    attitude = product(q, to_axes)
    omega = rotated_back(to_axes, rate)
    return rotated(to_axes, call_function(bits_of(address), t, attitude, omega))


@intrinsic
def call_function(typingctx, address, t, q, rate):
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
def rate_of(inverses, rotors, m):
    """Body rate of a momentum, rotors included, along the principal axes."""
    x = inverses[0] * (m[0] - rotors[0])
    y = inverses[1] * (m[1] - rotors[1])
    z = inverses[2] * (m[2] - rotors[2])
    return x, y, z


@inlined
def eddies_of(body):
    """C, row by row."""
    return three(body, BodyRow.EDDIES), three(body, BodyRow.EDDIES + 3), three(body, BodyRow.EDDIES + 6)


@inlined
def eddy_damping(C, rate):
    """C omega."""
    return dot(C[0], rate), dot(C[1], rate), dot(C[2], rate)
