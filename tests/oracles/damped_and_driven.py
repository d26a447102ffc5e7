"""Closed forms under torques: a symmetric body spun up along its axis; eddies in it, and in a sphere."""

from mpmath import mp, mpc, mpf


def spun_up(transverse, axial, rate, torque, t):
    """Attitude (wxyz, from the identity) and rate of a symmetric body under a constant torque along its axis.

    With theta = integral of omega3, mu = axial / transverse and w0 = omega1 + i omega2 at t = 0, the
    Cayley-Klein parameters alpha = a exp(i theta/2), beta = b exp(-i theta/2) follow
    a' = -conj(w0) exp(-i mu theta) b / 2 and b' = w0 exp(i mu theta) a / 2.  With theta' = e tau,
    e = torque / axial, a = exp(-i mu e tau^2 / 4) y is

        y'' + [|w0|^2/4 - i mu e/2 + mu^2 e^2 tau^2/4] y = 0:   y = D_nu(+-kappa tau),   kappa^2 = i mu e,

    nu = -1 - i |w0|^2 / (4 mu e): parabolic cylinder functions (DLMF 12.2).
    """
    A, C, torque, t = (mpf(x) for x in (transverse, axial, torque, t))
    w1, w2, w3 = (mpf(x) for x in rate)
    mu, e, w0 = C / A, torque / C, mpc(w1, w2)
    kappa, nu = mp.sqrt(mpc(0, mu * e)), -1 - mpc(0, abs(w0) ** 2 / (4 * mu * e))
    phase = mpc(0, mu * e)

    def solutions(tau):
        """Values of both a, and their derivatives."""
        out = []
        for sign in (1, -1):
            z = sign * kappa * tau
            D, after = mp.pcfd(nu, z), mp.pcfd(nu + 1, z)
            factor = mp.exp(-phase * tau * tau / 4)
            slope = sign * kappa * (z / 2 * D - after)
            out.append((factor * D, factor * (slope - phase * tau / 2 * D)))
        return out

    (p, dp), (q, dq) = solutions(w3 / e)
    wronskian = p * dq - q * dp
    first, second = dq / wronskian, -dp / wronskian  # a = 1 and a' = 0 at the start
    (p, dp), (q, dq) = solutions(w3 / e + t)
    theta = w3 * t + e * t * t / 2
    a, change = first * p + second * q, first * dp + second * dq
    b = -2 * mp.expj(mu * theta) * change / mp.conj(w0)
    alpha, beta = a * mp.expj(theta / 2), b * mp.expj(-theta / 2)
    w = w0 * mp.expj((mu - 1) * theta)
    return (alpha.real, beta.real, beta.imag, alpha.imag), (w.real, w.imag, w3 + e * t)


def damped_sphere(moment, damping, rate, t):
    """Attitude and rate of a sphere under the torque -damping omega: the axis stands still."""
    moment, damping, t = mpf(moment), mpf(damping), mpf(t)
    rate = [mpf(x) for x in rate]
    speed = mp.sqrt(sum(x * x for x in rate))
    half = speed * moment / damping * -mp.expm1(-damping * t / moment) / 2
    turn = [mp.sin(half) * x / speed for x in rate]
    return (mp.cos(half), *turn), tuple(x * mp.exp(-damping * t / moment) for x in rate)


def damped_rate(transverse, axial, across, along, rate, t):
    """Rate of a symmetric body under the torque -(across omega1, across omega2, along omega3)."""
    A, C, c1, c3, t = (mpf(x) for x in (transverse, axial, across, along, t))
    w1, w2, w3 = (mpf(x) for x in rate)
    theta = w3 * C / c3 * -mp.expm1(-c3 * t / C)
    w = mpc(w1, w2) * mp.exp(mpc(-c1 * t / A, (C / A - 1) * theta))
    return w.real, w.imag, w3 * mp.exp(-c3 * t / C)
