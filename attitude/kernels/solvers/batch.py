"""The solvers for body after body: one call a block, in which nobody asks for the interpreter.

Every body is stepped as if it were alone, by the solvers' own loops: its bits do not depend on its company.
All arrays of one body are rows of those here, in the order of the bodies; places on the orbit, the Sun and
the instants are the same for all.
"""

from ..intrinsics import kernel
from .collocation import collocate
from .runge_kutta import runge_kutta
from .splitting import split


@kernel
def collocate_each(
    which,
    states,
    start,
    stop,
    steps,
    bodies,
    symmetric,
    effects,
    orbit,
    pieces,
    sun,
    sun_pieces,
    seconds,
    rest,
    out,
    spare,
    work,
    counts,
    halted,
):
    """`collocation.collocate` for some bodies.

    Parameters
    ----------
    which : (k,), the bodies to march; the others' rows stay as they are
    states : (n, STATE), at the start; at the end when this returns
    start : (2,), s, two-part time; stop : s; steps : (n,), equal ones from start to stop
    bodies : (n, STEPPED_BODY); symmetric : (n,); effects : (n, m, EFFECT_WIDTH)
    out : (n, 10, instants), counts : (n, 2), as the solver has them; spare, work : scratch of one body
    halted : as the solver has it; the rest of the bodies are not marched then
    """
    for i in which:
        if halted[0] != 0.0:
            return
        h = (stop - start[0]) / steps[i]
        collocate(
            states[i],
            start,
            h,
            steps[i],
            bodies[i],
            symmetric[i],
            effects[i],
            orbit,
            pieces,
            sun,
            sun_pieces,
            seconds,
            rest,
            out[i],
            spare,
            work,
            counts[i],
            halted,
        )


@kernel
def split_each(
    which,
    states,
    start,
    stop,
    steps,
    drifts,
    kicks,
    bodies,
    symmetric,
    effects,
    orbit,
    pieces,
    sun,
    sun_pieces,
    seconds,
    rest,
    out,
    spare,
    work,
    halted,
):
    """`splitting.split` for some bodies; arguments as in `collocate_each`, drifts and kicks as there."""
    for i in which:
        if halted[0] != 0.0:
            return
        h = (stop - start[0]) / steps[i]
        split(
            states[i],
            start,
            h,
            steps[i],
            drifts,
            kicks,
            bodies[i],
            symmetric[i],
            effects[i],
            orbit,
            pieces,
            sun,
            sun_pieces,
            seconds,
            rest,
            out[i],
            spare,
            work,
            halted,
        )


@kernel
def runge_kutta_each(
    which,
    states,
    start,
    stop,
    first,
    tolerance,
    table,
    bodies,
    effects,
    orbit,
    pieces,
    sun,
    sun_pieces,
    seconds,
    rest,
    out,
    spare,
    work,
    counts,
    most,
    halted,
):
    """`runge_kutta.runge_kutta` for some bodies; arguments as in `collocate_each`.

    stop : (2,), s, two-part time; first : (n,), s, the first steps; tolerance : (n,), of a step, rad
    counts : (n, 3), zeros, written as the solver does; most : of each body
    """
    for i in which:
        if halted[0] != 0.0:
            return
        runge_kutta(
            states[i],
            start,
            stop,
            first[i],
            tolerance[i],
            table,
            bodies[i],
            effects[i],
            orbit,
            pieces,
            sun,
            sun_pieces,
            seconds,
            rest,
            out[i],
            spare,
            work,
            counts[i],
            most,
            halted,
        )
