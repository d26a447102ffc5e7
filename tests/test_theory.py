"""Equations of docs/theory.md and docs/gyrostats.md, evaluated by mpmath, solve the equations of motion."""

from types import SimpleNamespace

import mpmath as mp
import pytest

DIGITS = 40
EQUAL = mp.mpf(10) ** -30
EULER = mp.mpf(10) ** -15  # of derivatives, which are differences
SERIES = range(1, 40)
# Moments in an order of their own, and rates: both regimes, m below and above 0.97.
BODIES = {
    "short axis": (("1", "2", "3"), ("0.3", "0.4", "1.1")),
    "long axis": (("3", "1", "2"), ("0.2", "1.3", "0.3")),
    "short axis, beside the separatrix": (("1", "2", "3"), ("0.57", "1.0", "0.34")),
    "long axis, beside the separatrix": (("2", "3", "1"), ("1.0", "0.30", "0.56")),
    "disc": (("1", "1.2", "2.1"), ("0.5", "0.2", "0.3")),
}


@pytest.fixture(autouse=True)
def _digits():
    with mp.workdps(DIGITS):
        yield


def assert_equal(x, y):
    assert abs(x - y) < EQUAL * abs(y)


def rf(x, y, z):
    return mp.elliprf(x, y, z)


def free(name):
    """The quantities of sections 2 to 5, by the names there."""
    moments, rates = ([mp.mpf(text) for text in texts] for texts in BODIES[name])
    lo, mid, hi = sorted(range(3), key=lambda i: moments[i])
    difference = [moments[i] * (moments[i] - moments[mid]) * rates[i] ** 2 for i in (lo, hi)]
    D = sum(difference)  # (6)
    order = (lo, mid, hi) if D > 0 else (hi, mid, lo)
    moment, rate = [moments[i] for i in order], [abs(rates[i]) for i in order]
    a = [1 / each for each in moment]
    L = mp.sqrt(sum((i * w) ** 2 for i, w in zip(moment, rate, strict=True)))
    energy = sum(i * w**2 for i, w in zip(moment, rate, strict=True)) / 2
    gamma = [i * w / L for i, w in zip(moment, rate, strict=True)]
    s = 1 if D > 0 else -1
    r = {(i, j): mp.sqrt(abs(a[i - 1] - a[j - 1])) for i in (1, 2, 3) for j in (1, 2, 3)}
    c = 2 * energy / L**2
    S1, S2, S3 = (mp.sqrt(abs(c - each)) for each in a)
    assert_equal(c - a[0], (a[1] - a[0]) * gamma[1] ** 2 + (a[2] - a[0]) * gamma[2] ** 2)  # (7)
    assert_equal(c - a[1], -D / (moments[mid] * L**2))
    A = (S3 / r[3, 1], S3 / r[3, 2], S1 / r[3, 1])  # (9)
    k, k1 = S3 * r[2, 1] / (r[3, 2] * S1), r[3, 1] * S2 / (r[3, 2] * S1)  # (10)
    m, m1 = k**2, k1**2
    assert_equal(m + m1, 1)
    assert_equal(A[0] ** 2 + A[2] ** 2, 1)
    u_rate = L * r[3, 2] * S1  # (11)
    sine, cosine = s * gamma[1] / A[1], gamma[0] / A[0]
    u0 = sine * rf(cosine**2, cosine**2 + m1 * sine**2, 1)  # (12)
    K, K1 = mp.ellipk(m), mp.ellipk(m1)
    eta = (
        r[3, 2] / r[3, 1] * rf((r[2, 1] / r[3, 1]) ** 2, (r[2, 1] ** 2 + m * r[3, 2] ** 2) / r[3, 1] ** 2, 1)
    )
    assert_equal(eta, mp.ellipf(mp.atan(r[3, 2] / r[2, 1]), m1))  # (14)
    assert_equal(K1 - eta, A[2] * rf(A[0] ** 2, A[0] ** 2 + m * A[2] ** 2, 1))  # (15)
    q = mp.exp(-mp.pi * K1 / K)
    E, E1 = mp.exp(-mp.pi * eta / K), mp.exp(-mp.pi * (K1 - eta) / K)
    v_rate = mp.pi * u_rate / (2 * K)  # (13)
    mean = L / 2 * (a[0] + (a[2] - a[0]) * A[2])
    assert_equal(mean, (L * a[0] * A[0] ** 2 / (1 + A[2]) + L * a[2] * A[2]) / 2)
    total = sum((q**n * E1**n - q ** (2 * n) * E**n) / (1 - q ** (4 * n)) for n in SERIES)
    rate_of_phase = mean + 2 * s * v_rate * total  # (20)
    return SimpleNamespace(**{key: value for key, value in locals().items() if key != "self"})


def pair(b, t):
    """alpha and beta of (21), with the coefficients (17) to (19)."""
    v = mp.pi * (b.u0 + b.u_rate * t) / (2 * b.K)
    q, E, E1, s = b.q, b.E, b.E1, b.s

    def even(n, sign):
        return (-1) ** n * (q ** (2 * n * n - n) * E1**n + sign * q ** (2 * n * n) * E**n)

    def odd(n, sign):
        return (-1) ** n * (q ** (2 * n * n + n) * E1**n + sign * q ** (2 * n * (n + 1)) * E ** (n + 1))

    few = range(12)
    a = [mp.mpf(1), *(even(n, 1) for n in few[1:])]
    b_ = [mp.mpf(0), *(even(n, -1) for n in few[1:])]
    c, d = ([odd(n, sign) for n in few] for sign in (1, -1))
    rho = mp.sqrt((1 + b.A[2]) / 2)
    ga, gb = rho / sum(a), b.A[0] / (2 * rho) / sum(d)  # (19)
    alpha = sum(ga * a[n] * mp.cos(2 * n * v) + 1j * s * ga * b_[n] * mp.sin(2 * n * v) for n in few)
    beta = sum(
        s * gb * c[n] * mp.sin((2 * n + 1) * v) - 1j * gb * d[n] * mp.cos((2 * n + 1) * v) for n in few
    )
    turn = mp.exp(1j * b.rate_of_phase * t) / mp.sqrt(abs(alpha) ** 2 + abs(beta) ** 2)
    return alpha * turn, beta * turn


def momentum_direction(alpha, beta):
    across = 2j * mp.conj(alpha) * beta  # (4)
    return across.real, across.imag, abs(alpha) ** 2 - abs(beta) ** 2


def assert_solves_kinematics(solution, rate, t):
    """(3), by differences."""
    alpha, beta = solution(t)
    w1, w2, w3 = rate(t)
    slopes = (mp.diff(lambda x, i=i: solution(x)[i], t) for i in (0, 1))
    alpha_rate, beta_rate = slopes
    assert abs(alpha_rate - (1j * w3 * alpha - (w1 - 1j * w2) * beta) / 2) < EULER
    assert abs(beta_rate - ((w1 + 1j * w2) * alpha - 1j * w3 * beta) / 2) < EULER


@pytest.mark.parametrize("name", BODIES)
def test_theta_series_solve_the_equations_of_motion(name):
    b = free(name)
    for t in (mp.mpf("0.7"), mp.mpf("-13.1")):
        direction = momentum_direction(*pair(b, t))
        u = b.u0 + b.u_rate * t
        sn, cn, dn = (mp.ellipfun(kind, u, m=b.m) for kind in ("sn", "cn", "dn"))
        expected = (b.A[0] * cn, b.s * b.A[1] * sn, b.A[2] * dn)  # (8)
        assert max(abs(x - y) for x, y in zip(direction, expected, strict=True)) < EQUAL
        assert_solves_kinematics(
            lambda x: pair(b, x),
            lambda x: [b.L * a * g for a, g in zip(b.a, momentum_direction(*pair(b, x)), strict=True)],
            t,
        )
    start = momentum_direction(*pair(b, 0))
    assert max(abs(x - y) for x, y in zip(start, b.gamma, strict=True)) < EQUAL


@pytest.mark.parametrize("name", BODIES)
def test_published_rates_agree_and_the_transformed_series_is_the_same_motion(name):
    b = free(name)
    h = mp.pi * b.eta / (2 * b.K)
    total = sum(b.q ** (2 * n) * mp.sinh(2 * n * h) / (1 + b.q ** (2 * n)) for n in SERIES)
    left = b.L * (b.a[2] - b.a[0]) * b.A[2]
    assert_equal(left, -b.s * b.v_rate * (mp.coth(h) + 4 * total))  # section 4.2
    Q, x = mp.exp(-mp.pi * b.K / (2 * b.K1)), mp.pi * b.eta / (4 * b.K1)
    y_rate = mp.pi * b.u_rate / (4 * b.K1)
    terms = ((-1) ** n * Q ** (2 * n) / (1 - Q ** (2 * n)) * mp.sin(2 * n * x) for n in range(1, 400))
    within = b.mean + b.s * y_rate * (mp.tan(x) - 4 * sum(terms))  # (26)
    assert_equal(b.rate_of_phase, within - b.s * x * b.u_rate / b.K)  # (27)
    rho = mp.sqrt((1 + b.A[2]) / 2)
    for t in (mp.mpf("0.2"), mp.mpf("2.5")):
        u = b.u0 + b.u_rate * t
        argument = b.s * x + 1j * mp.pi * u / (4 * b.K1)
        turn = mp.exp(1j * (b.rate_of_phase * t + b.s * x * u / b.K))
        alpha, beta = (  # (23), whose factors are the values at u = 0
            turn * scale * mp.jtheta(kind, argument, Q) / mp.jtheta(kind, b.s * x, Q)
            for kind, scale in ((2, rho), (1, -1j * b.A[0] / (2 * rho)))
        )
        size = mp.sqrt(abs(alpha) ** 2 + abs(beta) ** 2)
        both = zip((alpha / size, beta / size), pair(b, t), strict=True)
        assert max(abs(one - other) for one, other in both) < EQUAL


@pytest.mark.parametrize("name", BODIES)
def test_rates_are_quotients_of_theta_functions(name):
    b = free(name)
    u = b.u0 + b.u_rate * mp.mpf("0.9")
    v, theta = mp.pi * u / (2 * b.K), mp.jtheta
    expected = [
        amplitude * mp.ellipfun(kind, u, m=b.m)
        for kind, amplitude in zip(("cn", "sn", "dn"), (b.A[0], b.s * b.A[1], b.A[2]), strict=True)
    ]
    zero = {n: theta(n, 0, b.q) for n in (2, 3, 4)}
    quotients = (  # (31)
        b.A[0] * zero[4] / zero[2] * theta(2, v, b.q) / theta(4, v, b.q),
        b.s * b.A[1] * zero[3] / zero[2] * theta(1, v, b.q) / theta(4, v, b.q),
        b.A[2] * zero[4] / zero[3] * theta(3, v, b.q) / theta(4, v, b.q),
    )
    assert max(abs(x - y) for x, y in zip(quotients, expected, strict=True)) < EQUAL
    H = mp.pi * b.K / (2 * b.K1)
    Q, y = mp.exp(-H), mp.pi * u / (4 * b.K1)
    n = mp.nint(y / H)

    def hyperbolic(y):
        """e N-, M-, e N+ over M+ of (32)."""
        e = mp.exp(-2 * abs(y))
        z = Q / e
        square, fourth = z**2 + Q**2 * e**2, Q**4 * (z**4 + Q**4 * e**4)
        M = [1 + i * e**2 + i * (Q**2 * z**2 + i * Q**4 * e**4) + Q**8 * z**4 for i in (1, -1)]
        return e * (1 - square + fourth) / M[0], M[1] / M[0], e * (1 + square + fourth) / M[0]

    middle = hyperbolic(H / 2)[1]
    signs = (-1) ** n, (-1) ** n * mp.sign(y - n * H), 1
    scales = b.A[0] / hyperbolic(mp.mpf(0))[0], b.s * b.A[1] / middle, b.A[2] / hyperbolic(mp.mpf(0))[2]
    if b.m1 < mp.mpf("0.03"):  # elsewhere the terms that (32) has are too few
        found = [a * c * x for a, c, x in zip(signs, scales, hyperbolic(y - n * H), strict=True)]
        assert max(abs(x - y) for x, y in zip(found, expected, strict=True)) < mp.mpf(10) ** -17


PUBLISHED = [  # moments; rates in deg/s, deg/d; (13) and (29) in s, d
    (
        ("0.001894220", "0.006211019", "0.007194665"),
        ("10", "20", "30"),
        "17.3844892719394",
        "10.0764922502932",
    ),
    (("3.0836", "3.235", "1"), ("14.51", "33.529", "-98.709"), "5.36853031352291", "7.41165226793735"),
]


@pytest.mark.parametrize(("moments", "rates", "period", "around"), PUBLISHED, ids=["brick", "Toutatis"])
def test_periods_of_published_bodies(moments, rates, period, around, monkeypatch):
    degrees = [str(mp.radians(mp.mpf(rate))) for rate in rates]
    monkeypatch.setitem(BODIES, "published", (moments, degrees))
    b = free("published")
    turn = 2 * b.rate_of_phase - (b.v_rate if b.s < 0 else 0)  # (29)
    assert mp.almosteq(4 * b.K / b.u_rate, mp.mpf(period), rel_eps=mp.mpf(10) ** -14)  # (13)
    assert mp.almosteq(2 * mp.pi / abs(turn), mp.mpf(around), rel_eps=mp.mpf(10) ** -14)


# -- gyrostats: docs/gyrostats.md ------------------------------------------------------------------

# Inverse moments, a3 that of the rotor's axis; k = a3 h / L; the greater end of gamma3.
GYROSTATS = {
    "circling, p > 0": ("0.3", "0.447", "0.937", "0.141", "0.92"),
    "circling, p < 0": ("0.711", "0.429", "0.658", "0.189", "0.629"),
    "swinging, p > 0": ("0.576", "0.898", "0.749", "0.0301", "0.933"),
    "swinging, p < 0": ("0.98", "0.862", "0.513", "0.265", "-0.273"),
}


@pytest.mark.parametrize("name", GYROSTATS)
def test_theta_functions_of_gyrostats_solve_the_equations_of_motion(name):
    """At L = 1, from the upper end: gamma2 = 0 and gamma1 > 0."""
    a1, a2, a3, k, e2 = (mp.mpf(text) for text in GYROSTATS[name])
    a12, a13, a23 = a1 - a2, a1 - a3, a2 - a3
    g1, s, is_circling = mp.sqrt(1 - e2**2), mp.sign(a12), name.startswith("circling")
    b1, b2 = a23 * e2 + k, a13 * e2 + k  # (39)
    d1, d2 = b1**2 - a23 * a12 * g1**2, b2**2
    above, below = (a13 * g1**2 + sign * 2 * k * (1 - sign * e2) for sign in (1, -1))
    J, U = a12 * a13 * g1**2 - 2 * b1 * b2, 2 * a12 - a13 * (1 + e2**2) - 2 * k * e2
    assert abs(J**2 - 4 * d1 * d2 - a12**2 * above * below) < EQUAL  # (40)
    assert abs(U**2 - above * below - 4 * d1) < EQUAL
    if is_circling:
        root = mp.sqrt(d1 * d2)
        M, N, nu = mp.sqrt(abs(J - 2 * root)), 2 * mp.sqrt(root), mp.sqrt(abs(J + 2 * root))
        mu, rate = (J + 2 * root) / (J - 2 * root), mp.mpf(1) / 2
    else:
        ratio, span = abs(a13 / a12), 2 * mp.sqrt(d2) / abs(a13)
        n = mp.sqrt(above * below) / abs(a13)
        S = (n + mp.sqrt(n**2 + span**2)) / 2
        S1, A, B = span**2 / (4 * S), (U / a12 - ratio * n) / 2, (U / a12 + ratio * n) / 2
        M, N, nu, mu = mp.sqrt(S * B), mp.sqrt(n), mp.sqrt(S1 * abs(A)), S1 * A / (S * B)
        rate = mp.sqrt(abs(a12 * a13)) / 2
    v_rate = rate * mp.agm(M, N)  # (42)
    R = mp.agm(1, N / M) / mp.agm(1, nu / M) if mu > 0 else mp.agm(1, M / N) / mp.agm(1, nu / N)
    p = mp.sign(mu) * mp.exp(-mp.pi * R)
    assert p > 0 if "p > 0" in name else p < 0

    def slope(x):  # (40a), from the upper end
        return (a12 * g1**2 + 2 * b1 * x + a23 * x**2) * (-2 * b2 * x - a13 * x**2)

    def integrand(u):  # x = (1 - e2) u^2, as the slope has a root at the end
        return 2 * u * (1 - e2) / mp.sqrt(abs(slope((1 - e2) * u**2)))

    h = v_rate * mp.quad(integrand, [0, 0.5, 1], method="gauss-legendre")  # (42a)
    if not is_circling:
        assert abs(h - mp.agm(M, N) * rf(S, S1, ratio * S * S1) / 2) < EULER
    mean = (a3 * e2 - k + a1 * (1 - e2)) / 2
    E, sign = mp.exp(-2 * h), mp.sign(p)
    E2 = abs(p) / E
    if is_circling:  # (43)
        total = sum(((sign * E2) ** n - (p * E) ** n) / (1 - p ** (2 * n)) for n in SERIES)
        precession = mean + 2 * s * v_rate * total
    else:
        total = sum((-1) ** n * p**n * mp.sinh(2 * n * h) / (1 - p**n) for n in SERIES)
        precession = mean - s * v_rate * (mp.tanh(h) - 4 * total)
    kind, nome = (4, p) if is_circling else (2, mp.sqrt(mp.mpc(p)))
    scales = (kind, mp.sqrt((1 + e2) / 2)), (1, -1j * mp.sqrt((1 - e2) / 2))

    def solution(t):  # (41)
        alpha, beta = (
            scale
            * mp.exp(1j * precession * t)
            * mp.jtheta(i, v_rate * t - 1j * s * h, nome)
            / mp.jtheta(i, -1j * s * h, nome)
            for i, scale in scales
        )
        size = mp.sqrt(abs(alpha) ** 2 + abs(beta) ** 2)
        return alpha / size, beta / size

    def rates(t):  # (37)
        gamma = momentum_direction(*solution(t))
        return a1 * gamma[0], a2 * gamma[1], a3 * gamma[2] - k

    assert_solves_kinematics(solution, rates, mp.mpf("1.3"))
