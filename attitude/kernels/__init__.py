"""Compiled mathematics: plain float64 arrays in and out.

Nothing in this room knows units, `Time`, frames, files or HTTP, and nothing here
imports from the modules above it.  Read downwards it is the calculation:

    layout         what kernels and their callers agree on
    intrinsics     the processor's fused multiply-add and the bits of a double
    doubledouble   two-part arithmetic
    expansion      sums of products without any rounding
    clock          days and seconds in two parts
    elliptic       K, K', R_F in two parts
    principal      a tensor's principal moments and axes, in two parts
    discriminant   D, whose sign is the regime
    quaternion     the one statement of order and direction
    invariants     body, momentum, attitude -> everything the samples need: decided once
    phase          a rate times a time in two parts; sine and cosine of turns
    cayley_klein   time -> phases -> alpha, beta -> quaternion and body rate
    vectors        threes of numbers, and their turning
    rotation       quaternions in plain doubles, for steps
    course         where the centre of mass is on its orbit
    torque         effects, time, attitude, rate -> torque
    free_rotation  the exact motion over one step, in plain doubles
    stepping       what solvers share: state, time of a step, samples
    splitting      kicks by the torque around exact free rotation
    collocation    Gauss's collocation, order 16
    runge_kutta    Dormand and Prince, order 8, with steps of its own choice
    many           these solvers for body after body, one call a block
    surface        how high the lowest point of a body is over a plane, and for how long it cannot touch it
    rubbing        one point that touches, with friction
    impact         what a contact does to velocity and body rate
    contact        flight after flight between contacts, in closed form
    interpolation  polynomials through attitudes, half-way between them, against the attitudes there
    philox         random words by number
    normal         random words to normal deviates
    dispersion     states of bodies drawn about a nominal one
    gathering      sums over bodies of what statistics are made of, the same in any order
"""
