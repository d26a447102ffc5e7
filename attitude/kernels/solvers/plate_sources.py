"""Directions and strengths of the effects' sources at the nodes of an arc, and the torques of their forms.

docs/torques.md, section 5: equation (T7), shadow and density.
"""

import math

from ..intrinsics import fma, inlined, routine
from ..layout import AIR_DEGREE, AirPiece, DipoleRow, DragRow, EffectCode, EffectRow, NodeRow, SolarRow
from ..rotation import rotated_back
from ..vectors import add_scaled, cross, dot, pair_at, scaled, three
from .node_rows import accessors
from .plate_layout import ARC_NODES, ArcRow, FormRow, Light, PlateFlag, PlateRow, ShadowModel, SourceRow
from .torque import ASTRONOMICAL_UNIT, dipole_field

two_at, three_at, four_at, put_two, put_three, put_four = accessors(ARC_NODES)


@inlined
def source_row(k, row):
    """A row of source k."""
    return ArcRow.SOURCES + k * SourceRow.ROWS + row


@routine
def evaluate_sources(sources, lights, air, work):
    """Direction and strength of every source at the nodes, whose times and places are there already.

    In rows whose place the compiler knows, and copied from there.  That there are as many nodes as there are
    is kept from it: it makes vectors of loops, but writes out those of eight rounds before.
    """
    nodes = min(ARC_NODES, work.shape[0])
    for k in range(sources.shape[0]):
        row, code = sources[k], sources[k, EffectRow.CODE]
        if code == EffectCode.GRAVITY_GRADIENT:
            for i in range(nodes):
                r = three_at(work, NodeRow.POSITION, i)
                distance2 = dot(r, r)
                inverse = 1.0 / math.sqrt(distance2)
                _put_source(work, i, scaled(inverse, r), 3.0 * row[EffectRow.VALUE] * inverse / distance2)
        elif code == EffectCode.DRAG_PLATE:
            turning, density = three(row, DragRow.ROTATION), row[DragRow.DENSITY]
            reference, height = row[DragRow.REFERENCE_RADIUS], row[DragRow.SCALE_HEIGHT]
            for i in range(nodes):
                r = three_at(work, NodeRow.POSITION, i)
                wind = add_scaled(three_at(work, NodeRow.VELOCITY, i), -1.0, cross(turning, r))
                speed2 = dot(wind, wind)
                direction = scaled(1.0 / math.sqrt(max(speed2, 1e-300)), wind)
                _put_source(work, i, direction, (reference - math.sqrt(dot(r, r))) / height)
                work[ArcRow.CHANGE * ARC_NODES + i] = -0.5 * density * speed2
            if row[DragRow.AIR_COUNT] > 0.0:
                _write_log_density(row, air, work, nodes)
            for i in range(nodes):
                relative = math.exp(work[ArcRow.RATE * ARC_NODES + i])
                work[ArcRow.RATE * ARC_NODES + i] = work[ArcRow.CHANGE * ARC_NODES + i] * relative
        elif code == EffectCode.SOLAR_PLATE:
            _evaluate_sunlight(row, lights[k], work, nodes)
        elif code == EffectCode.CONSTANT_INERTIAL:
            fixed = three(row, EffectRow.VALUE)
            size = math.sqrt(dot(fixed, fixed))
            direction = scaled(1.0 / max(size, 1e-300), fixed)
            for i in range(nodes):
                _put_source(work, i, direction, size)
        else:
            _evaluate_field(row, work, nodes)
        _keep_source(k, work, nodes)


@inlined
def _write_log_density(row, air, work, nodes):
    """Logarithm of the density at the nodes."""
    first, count = int(row[DragRow.AIR_FIRST]), int(row[DragRow.AIR_COUNT])
    for i in range(nodes):
        now, now_low = two_at(work, NodeRow.TIME, i)
        work[ArcRow.RATE * ARC_NODES + i] = log_density(air, first, count, now, now_low)


@routine
def log_density(air, first, count, t, t_low):
    """Logarithm of the density on the piece that t is in; before and after all pieces, on the outermost."""
    low, high = first, first + count
    while high - low > 1:
        middle = (low + high) // 2
        if air[middle, AirPiece.START] <= t:
            low = middle
        else:
            high = middle
    x = fma((t - air[low, AirPiece.START]) + t_low, air[low, AirPiece.SCALE], -1.0)
    value = air[low, AirPiece.POWERS + AIR_DEGREE]
    for power in range(AIR_DEGREE - 1, -1, -1):
        value = fma(value, x, air[low, AirPiece.POWERS + power])
    return value


@inlined
def _keep_source(k, work, nodes):
    """Copy direction and strength, and the direction before the departure."""
    for i in range(nodes):
        direction = rotated_back(four_at(work, ArcRow.PRECESSION, i), three_at(work, ArcRow.GAIN, i))
        put_three(work, ArcRow.TORQUE, i, direction)
    target = source_row(k, SourceRow.DIRECTION) * ARC_NODES
    for i in range(4 * ARC_NODES):  # GAIN and, after it, RATE
        work[target + i] = work[ArcRow.GAIN * ARC_NODES + i]
    target = source_row(k, SourceRow.TURNED) * ARC_NODES
    for i in range(3 * ARC_NODES):
        work[target + i] = work[ArcRow.TORQUE * ARC_NODES + i]


@inlined
def _put_source(work, i, direction, strength):
    put_three(work, ArcRow.GAIN, i, direction)
    work[ArcRow.RATE * ARC_NODES + i] = strength


@inlined
def _evaluate_sunlight(row, light, work, nodes):
    strength = -row[SolarRow.PRESSURE] * (ASTRONOMICAL_UNIT * ASTRONOMICAL_UNIT)
    strength = 0.0 if light == Light.DARK else strength
    for i in range(nodes):
        to_sun = add_scaled(three_at(work, NodeRow.SUN, i), -1.0, three_at(work, NodeRow.POSITION, i))
        distance2 = dot(to_sun, to_sun)
        _put_source(work, i, scaled(1.0 / math.sqrt(distance2), to_sun), strength / distance2)
    if light == Light.PARTIAL and row[SolarRow.SHADOW] == ShadowModel.CONICAL:
        radii = row[SolarRow.SHADOW_RADIUS], row[SolarRow.SUN_RADIUS]
        for i in range(nodes):
            r, sun = three_at(work, NodeRow.POSITION, i), three_at(work, NodeRow.SUN, i)
            work[ArcRow.RATE * ARC_NODES + i] *= lit_fraction(r, sun, *radii)


@inlined
def _evaluate_field(row, work, nodes):
    """The field of a dipole fixed in the turning central body: `torque.dipole_field`."""
    fixed, cosines = three(row, DipoleRow.AXIS), three(row, DipoleRow.AXIS_COSINE)
    axis, turn_rate = (fixed, cosines, three(row, DipoleRow.AXIS_SINE)), pair_at(row, DipoleRow.TURN_RATE)
    for i in range(nodes):
        t = two_at(work, NodeRow.TIME, i)
        field = dipole_field(row[DipoleRow.STRENGTH], axis, turn_rate, t, three_at(work, NodeRow.POSITION, i))
        size = math.sqrt(dot(field, field))
        _put_source(work, i, scaled(1.0 / max(size, 1e-300), field), size)


@routine
def lit_fraction(r, sun, radius, sun_radius):
    """Part of the Sun's disc that the central body leaves free, seen from r; vectors from its centre, m.

    Source: Montenbruck & Gill, Satellite Orbits (2000), section 3.4.2; angles by two-argument arctangents,
    which keep their digits where discs touch.
    """
    to_sun = add_scaled(sun, -1.0, r)
    distance, height = math.sqrt(dot(to_sun, to_sun)), math.sqrt(dot(r, r))
    normal = cross(to_sun, r)
    c = math.atan2(math.sqrt(dot(normal, normal)), -dot(to_sun, r))
    a, b = math.asin(min(1.0, sun_radius / distance)), math.asin(min(1.0, radius / height))
    if c >= a + b:
        return 1.0
    if c <= b - a:
        return 0.0
    if c <= a - b:
        return 1.0 - (b / a) * (b / a)
    x = 0.5 * (c + (a - b) * (a + b) / c)
    y = math.sqrt(max((a - x) * (a + x), 0.0))
    own, other = math.atan2(y, x), math.atan2(y, c - x)
    covered = a * a * _segment(own) + b * b * _segment(other)
    return max(0.0, 1.0 - covered / (math.pi * a * a))


@inlined
def _segment(angle):
    """angle - sin(angle) cos(angle): twice the area of a segment of the unit circle."""
    if abs(angle) > 0.1:
        return angle - math.sin(angle) * math.cos(angle)
    x = 4.0 * angle * angle  # (2a - sin 2a) / 2 by its series
    series = fma(x, -1.0 / 39916800.0, 1.0 / 362880.0)
    series = fma(x, fma(x, -series, 1.0 / 5040.0), -1.0 / 120.0)
    return x * angle * fma(x, series, 1.0 / 6.0)


@inlined
def add_torques(forms, work):
    """Torques of the sources at the nodes, added to TORQUE."""
    for k in range(forms.shape[0]):
        form = forms[k]
        K1, K2, K3 = three(form, 0), three(form, 3), three(form, 6)
        q = FormRow.QUADRATIC
        Q1, Q2, Q3 = _six(form, q), _six(form, q + 6), _six(form, q + 12)
        turned, strengths = source_row(k, SourceRow.TURNED), source_row(k, SourceRow.STRENGTH) * ARC_NODES
        for i in range(ARC_NODES):
            d, strength = seen(work, turned, i), work[strengths + i]
            torque = three_at(work, ArcRow.TORQUE, i)
            torque = (
                fma(strength, _form(K1, Q1, d), torque[0]),
                fma(strength, _form(K2, Q2, d), torque[1]),
                fma(strength, _form(K3, Q3, d), torque[2]),
            )
            put_three(work, ArcRow.TORQUE, i, torque)


@inlined
def seen(work, turned, i):
    """The direction that the body sees at node i."""
    d = three_at(work, turned, i)
    return _along(work, 0, i, d), _along(work, 1, i, d), _along(work, 2, i, d)


@inlined
def _six(form, first):
    return form[first], form[first + 1], form[first + 2], form[first + 3], form[first + 4], form[first + 5]


@inlined
def _along(work, column, i, d):
    """Component along a body axis: a column of the rotation's matrix."""
    first = (ArcRow.ROTATION + column) * ARC_NODES + i
    z = fma(work[first], d[0], work[first + 3 * ARC_NODES] * d[1])
    return fma(work[first + 6 * ARC_NODES], d[2], z)


@inlined
def _form(K, Q, d):
    x, y, z = d
    first = fma(Q[0], x, fma(Q[3], y, fma(Q[4], z, K[0])))
    second = fma(Q[1], y, fma(Q[5], z, K[1]))
    return fma(first, x, fma(second, y, fma(fma(Q[2], z, K[2]), z, 0.0)))


@routine
def add_plate(form, plate, sign):
    """Add the torque of a plate to the form of its source, or take it away (sign -1)."""
    n, c = three(plate, PlateRow.NORMAL), three(plate, PlateRow.CENTRE)
    arm = cross(c, n)
    # c x d, row by row
    rows = (0.0, -c[2], c[1]), (c[2], 0.0, -c[0]), (-c[1], c[0], 0.0)
    for j in range(3):
        for i in range(3):
            form[3 * j + i] += sign * plate[PlateRow.SCATTERED] * arm[j] * n[i]
        add_product(form, j, n, rows[j], sign * plate[PlateRow.ALONG])
        add_product(form, j, n, n, sign * plate[PlateRow.MIRRORED] * arm[j])


@routine
def add_product(form, j, u, v, factor):
    """Add factor (u . d) (v . d) to component j of a form."""
    first = FormRow.QUADRATIC + 6 * j
    form[first] += factor * (u[0] * v[0])
    form[first + 1] += factor * (u[1] * v[1])
    form[first + 2] += factor * (u[2] * v[2])
    form[first + 3] += factor * (u[0] * v[1] + u[1] * v[0])
    form[first + 4] += factor * (u[0] * v[2] + u[2] * v[0])
    form[first + 5] += factor * (u[1] * v[2] + u[2] * v[1])


@routine
def sum_forms(base, plates, flags, forms):
    """The forms of the sources: what they always have, and their lit plates."""
    for k in range(forms.shape[0]):
        for j in range(FormRow.WIDTH):
            forms[k, j] = base[k, j]
    for p in range(plates.shape[0]):
        if flags[p, PlateFlag.LIT] > 0.0:
            add_plate(forms[int(plates[p, PlateRow.SOURCE])], plates[p], 1.0)
