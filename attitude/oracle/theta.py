"""Route 2: the attitude as quotients of theta functions, by `mpmath.jtheta` at raised precision.

In the frame with z along the momentum, with alpha = q0 + i q3 and beta = q1 + i q2,

    alpha = c_a exp(i lambda t) theta4(v - i h | Q2),    beta = c_b exp(i lambda t) theta1(v - i h | Q2),

Q2 = exp(-2 pi K'/K), v = pi u / 2K, h = s pi eta / 2K, then normalised. One rate serves both, because
conj(alpha) beta = (gamma1 + i gamma2) / 2i is periodic. It is taken from the kinematic equation at t = 0,

    i lambda = i Im[(i omega3 - conj(omega1 + i omega2) beta/alpha) / 2 - v' theta4'/theta4]

(the real part is the decay of the norm), never from a closed sum, and c_b / c_a from the momentum direction.
Moments and rates are exact fractions; extra working digits make up for cancellation.
"""

from functools import lru_cache

from mpmath import mp, mpc, mpf

from .exact import (
    circulation,
    conjugate,
    constant_rotation,
    decades,
    elapsed,
    fractions,
    half_turn,
    multiply,
    norm,
    normalised,
    quaternion_of_matrix,
    real,
    reals,
    rotate,
)

GUARD_DIGITS = 25
DIGITS_STEP = 16  # working digits are multiples of it: instants near and far share a motion's constants


def attitude_and_rate(moments, omega, q0, t, digits=50):
    """Attitude and body rate of a torque-free body after time t.

    Parameters
    ----------
    moments, omega : 3 numbers each; principal moments in any order, body rate, rad/s; exact as given
    q0 : 4 numbers, wxyz, body to inertial; normalised at the working precision
    t : number or tuple (hi, lo) of numbers, s; either sign
    digits : correct digits of the result

    Returns
    -------
    q : 4 mpf, wxyz, continuous in t with q(0) = q0
    omega : 3 mpf, body frame, rad/s
    """
    return motion(fractions(moments), fractions(omega), digits).at(t, q0)


@lru_cache(maxsize=4096)
def motion(moments, omega, digits=50):
    """The motion of a body, as an object with `at(t, q0)`, from Fractions."""
    kind = {"constant_rate": ConstantRate, "symmetric": Symmetric, "separatrix": Separatrix}
    invariants = circulation(moments, omega)
    return kind.get(invariants.regime, Theta)(moments, omega, invariants, digits)


class Motion:
    """Base of all regimes: exact inputs, working digits, q(t) = q0 * turn(t) with turn(0) = 1."""

    def __init__(self, moments, omega, invariants, digits):
        self.moments, self.omega, self.circulation = moments, omega, invariants
        self.regime, self.digits, self.cached_constants = invariants.regime, digits, {}
        self.base_digits = digits + GUARD_DIGITS + self.lost_digits()

    def lost_digits(self):
        """Digits lost to cancellation in the constants."""
        return 0

    def working_digits(self, t):
        """Working digits for `digits` correct ones in phases of |t| times the rate."""
        fastest = max(abs(component) for component in self.omega)
        phase = abs(t) * fastest * max(self.moments) / min(self.moments) + 1
        return self.base_digits + decades(1 / phase)

    def at(self, t, q0):
        """Attitude and rate at t, as in `attitude_and_rate`."""
        t = elapsed(t)
        with mp.workdps(-(-self.working_digits(t) // DIGITS_STEP) * DIGITS_STEP):
            turn, omega = self.turn_and_rate(t)
            return multiply(normalised(q0), turn), omega


class ConstantRate(Motion):
    """Rest, sphere, spin about a principal axis: q = q0 exp(omega t / 2)."""

    def turn_and_rate(self, t):
        """turn(t) and the body rate, at the working precision."""
        omega = tuple(reals(self.omega))
        return constant_rotation(omega, real(t)), omega


class Symmetric(Motion):
    """I1 = I2: q = q0 exp(Lb a1 t / 2) exp(k (omega3 - Lb3 a1) t / 2), elementary."""

    def turn_and_rate(self, t):
        """turn(t) and the body rate, at the working precision."""
        body_axis = self.circulation.axes[2]
        inverse = self.circulation.inverse[0]
        momentum = [moment * component for moment, component in zip(self.moments, self.omega, strict=True)]
        L = mp.sqrt(real(sum(component * component for component in momentum)))
        axis = [real(component) / L for component in momentum]
        spin = real(self.omega[body_axis] - inverse * momentum[body_axis]) * real(t)
        symmetry_axis = [mpf(int(k == body_axis)) for k in range(3)]
        spin_turn = half_turn(symmetry_axis, spin / 2)
        turn = multiply(half_turn(axis, L * real(inverse) * real(t) / 2), spin_turn)
        return turn, rotate(conjugate(spin_turn), reals(self.omega))


class CayleyKlein(Motion):
    """Motions given by alpha and beta in the frame of axes 1, 2, 3 with z along the momentum."""

    def constants(self):
        """Constants of the motion at the working precision, cached."""
        if mp.dps not in self.cached_constants:
            self.cached_constants[mp.dps] = self.initial_constants()
        return self.cached_constants[mp.dps]

    def initial_constants(self):
        """Constants of the motion at the working precision."""
        invariants = self.circulation
        a = [real(inverse) for inverse in invariants.inverse]
        momentum = [real(self.moments[k] * self.omega[k]) for k in range(3)]
        L = norm(momentum)
        gamma = [component / L for component in invariants.along_axes(momentum)]
        A = [mp.sqrt(real(square)) for square in invariants.amplitude_squared]
        s = 1 if invariants.inverse[0] > invariants.inverse[1] else -1
        signed_axes = list(zip(invariants.signs, invariants.axes, strict=True))
        frame = quaternion_of_matrix(
            [[mpf(sign * int(axis == k)) for sign, axis in signed_axes] for k in range(3)]
        )
        common = {"a": a, "L": L, "gamma": gamma, "A": A, "s": s, "frame": frame}
        common["ratio"] = -1j * mpc(gamma[0], gamma[1]) / (1 + gamma[2])
        return common | self.phase_constants(common)

    def initial_log_rate(self, common):
        """(d/dt log alpha) at t = 0 from q' = q omega / 2."""
        w1, w2, w3 = (common["L"] * a * gamma for a, gamma in zip(common["a"], common["gamma"], strict=True))
        return (mpc(0, w3) - mpc(w1, -w2) * common["ratio"]) / 2

    def turn_and_rate(self, t):
        """turn(t) and the body rate, at the working precision."""
        constants = self.constants()
        alpha, beta = self.alpha_beta(constants, real(t))
        norm = mp.sqrt(abs(alpha) ** 2 + abs(beta) ** 2)
        alpha, beta = alpha / norm, beta / norm
        start = self.start(constants)
        now = (alpha.real, beta.real, beta.imag, alpha.imag)
        turn = multiply(
            multiply(constants["frame"], multiply(conjugate(start), now)), conjugate(constants["frame"])
        )
        transverse = 2j * mp.conj(alpha) * beta
        gamma = (transverse.real, transverse.imag, abs(alpha) ** 2 - abs(beta) ** 2)
        rate = [mpf(0)] * 3
        for k, (sign, axis) in enumerate(zip(self.circulation.signs, self.circulation.axes, strict=True)):
            rate[axis] = sign * constants["L"] * constants["a"][k] * gamma[k]
        return turn, tuple(rate)

    def start(self, constants):
        """Quaternion at t = 0 with alpha > 0: |alpha|^2 = (1 + gamma3) / 2, beta = ratio * alpha."""
        alpha = mp.sqrt((1 + constants["gamma"][2]) / 2)
        beta = constants["ratio"] * alpha
        return (alpha, beta.real, beta.imag, mpf(0))


class Theta(CayleyKlein):
    """Short and long axis modes."""

    def lost_digits(self):
        """Digits lost to cancellation in the constants."""
        return decades(self.circulation.m) + decades(self.circulation.m1)

    def phase_constants(self, common):
        """K, K', eta, u0, nome, lambda; `log_rate` is i lambda less the logarithmic rate of the norm."""
        invariants, gamma, A, s = self.circulation, common["gamma"], common["A"], common["s"]
        a1, a2, a3 = invariants.inverse
        m, m1 = real(invariants.m), real(invariants.m1)
        K, K_prime = mp.ellipk(m), mp.pi / (2 * mp.agm(1, mp.sqrt(m)))
        eta = mp.ellipf(mp.atan(mp.sqrt(real((a3 - a2) / (a2 - a1)))), m1)
        u0 = mp.ellipf(mp.atan2(s * gamma[1] / A[1], gamma[0] / A[0]), m)
        u_rate = mp.sqrt(real(invariants.u_rate_squared))
        v_rate, v0, h = mp.pi * u_rate / (2 * K), mp.pi * u0 / (2 * K), s * mp.pi * eta / (2 * K)
        nome2 = mp.exp(-2 * mp.pi * K_prime / K)
        z0 = mpc(v0, -h)
        theta4, theta1 = mp.jtheta(4, z0, nome2), mp.jtheta(1, z0, nome2)
        log_rate = self.initial_log_rate(common) - v_rate * mp.jtheta(4, z0, nome2, 1) / theta4
        return {
            "m": m, "m1": m1, "K": K, "K_prime": K_prime, "eta": eta, "u0": u0, "u_rate": u_rate,
            "v0": v0, "v_rate": v_rate, "h": h, "nome2": nome2,
            "lambda": log_rate.imag, "log_rate": log_rate,
            "c_a": 1 / theta4, "c_b": common["ratio"] / theta1,
        }  # fmt: skip

    def alpha_beta(self, constants, t):
        """alpha and beta at time t, before normalisation."""
        v = constants["v0"] + constants["v_rate"] * t
        turns = mp.nint(v / mp.pi)
        z = mpc(v - turns * mp.pi, -constants["h"])
        phase = mp.expj(constants["lambda"] * t)
        flip = -1 if int(turns) % 2 else 1
        alpha = constants["c_a"] * phase * mp.jtheta(4, z, constants["nome2"])
        return alpha, flip * constants["c_b"] * phase * mp.jtheta(1, z, constants["nome2"])


class Separatrix(CayleyKlein):
    """D = 0: the nome is 1, the thetas become alpha ~ cos(x + i u/2), beta ~ sin(x + i u/2); elementary.

    tan 2x = s sqrt((a3 - a2) / (a2 - a1)), sinh u0 = s gamma2 A1 / gamma1.
    """

    def working_digits(self, t):
        """gamma1 and gamma3 decay as 1/cosh u: keep their digits too, up to a thousand."""
        with mp.workdps(15):
            decay = mp.sqrt(real(self.circulation.u_rate_squared)) * abs(real(t)) / mp.log(10)
        return super().working_digits(t) + int(min(decay, 1000))

    def phase_constants(self, common):
        """Constants of alpha and beta."""
        gamma, A, s = common["gamma"], common["A"], common["s"]
        a1, a2, a3 = self.circulation.inverse
        x = s * mp.atan(mp.sqrt(real((a3 - a2) / (a2 - a1)))) / 2
        u_rate = mp.sqrt(real(self.circulation.u_rate_squared))
        u0 = mp.asinh(s * gamma[1] * A[0] / (A[1] * gamma[0]))
        z0 = mpc(x, u0 / 2)
        log_rate = self.initial_log_rate(common) + 1j * u_rate / 2 * mp.tan(z0)
        return {
            "x": x, "u0": u0, "u_rate": u_rate, "lambda": log_rate.imag, "log_rate": log_rate,
            "c_a": 1 / mp.cos(z0), "c_b": common["ratio"] / mp.sin(z0),
        }  # fmt: skip

    def alpha_beta(self, constants, t):
        """alpha and beta at time t, before normalisation."""
        z = mpc(constants["x"], (constants["u0"] + constants["u_rate"] * t) / 2)
        phase = mp.expj(constants["lambda"] * t)
        scale = mp.cosh(z.imag)
        return constants["c_a"] * phase * mp.cos(z) / scale, constants["c_b"] * phase * mp.sin(z) / scale
