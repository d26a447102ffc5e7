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
    cayley_klein   time -> phases -> alpha, beta -> quaternion and body rate
    vectors        threes of numbers, and their turning
    surface        how high the lowest point of a body is over a plane, and for how long it cannot touch it
    rubbing        one point that touches, with friction
    impact         what a contact does to velocity and body rate
    contact        flight after flight between contacts, in closed form
    compiler       all of this into machine code, in a process of its own
"""
