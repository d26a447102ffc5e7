"""Compiled mathematics on plain float64 arrays.

Kernels know no units, `Time`, frames, files or HTTP, and import nothing from the modules above them.  The
closed form is at the root, in the order of the calculation:

    layout         records and codes that kernels and their callers share
    intrinsics     fused multiply-add, the bits of a double
    vectors        vectors of three numbers, and their rotation
    doubledouble   two-part arithmetic
    expansion      sums of products without rounding
    phase          a rate times a time in two parts; sine and cosine of turns
    clock          days and seconds in two parts
    elliptic       K, K', R_F in two parts
    principal      a tensor's principal moments and axes, in two parts
    regime         D, whose sign decides the regime
    quaternion     the convention of order and direction, in two parts
    polhode        the path of the momentum in the body
    theta_coefficients  coefficients of the theta functions, for one body or a vector of them
    lanes          body, rate, attitude -> constants of the motion: many bodies in vector lanes
    invariants     the same for the bodies that lanes leave: with branches and exact sums
    cayley_klein   time -> phases -> alpha, beta -> quaternion and body rate
    rotation       quaternions in plain doubles, for solvers
    interpolation  polynomials through attitudes, compared with the motion between the nodes

    gauss_legendre nodes, weights and integrals of Gauss's quadrature

and in packages what other parts of the library need:

    partials.integrals     time -> attitude and the integrals of squares of Jacobi's functions
    partials.partial_record body, rate, constants of the motion -> constants of its partial derivatives
    partials.long_arcs     derivatives along axes 1, 2, 3
    partials.blocks        numbers of a body in a loop over a block of instants, and its columns
    partials.long_blocks   the same at many instants, along the body's axes, in vectors
    partials.short_arcs    the same over short arcs, by quadrature
    partials.constant_spin the same beside a constant rate
    partials.assembly      derivatives along the body's axes
    gyrostat.conserved     conserved numbers of a rotor along axis 3, by exact sums
    gyrostat.path          labels, ends and moduli of the momentum's path
    gyrostat.coefficients  the two theta functions and the rates of their phases
    gyrostat.boost         any rotor's problem -> one with its rotor along axis 3
    gyrostat.base          which of these problems a body poses
    gyrostat.record        body, rotors, rate, attitude -> constants of the motion
    gyrostat.attitudes     time -> phases -> alpha, beta -> quaternion and body rate
    solvers.orbit_path     position and velocity of the centre of mass on its orbit
    solvers.node_vectors   half rows of nodes as vectors of the processor: integrals of slopes, copies
    solvers.node_rows      numbers at the nodes of a step
    solvers.torque         effects, time, attitude, rate -> torque, at all nodes of a step
    solvers.dense_output   states at instants, also within a step
    solvers.collocation    Gauss's collocation, order 32
    solvers.plate_layout   sources, plates and the workspace of the march between their edges
    solvers.plate_sources  directions and strengths of sources at nodes -> torques, by forms of 27 numbers
    solvers.edge_search    the first edge of a plate within an arc; plates that change sides
    solvers.plate_march    arcs of collocation, order 16, that end at the edges of plates
    contact.clearance      height of a body's lowest point over a plane, and a bound on the time to contact
    contact.friction       impulse at one point of contact with friction
    contact.impact         change of velocity and body rate at a contact
    contact.flight         flights between contacts, in closed form
    statistics.philox      random words by number (counter-based)
    statistics.normal      random words to normal deviates
    statistics.dispersion  states of bodies drawn about a nominal one
    statistics.moment_sums sums over bodies that statistics are computed from, the same in any order
"""
