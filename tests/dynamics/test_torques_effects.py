"""Each torque by itself: its size by hand at one instant, its motion by SciPy, and what it keeps or loses."""

import numpy as np
import pytest

from attitude import InputError
from tests.dynamics.motions import angle, initial_state, integrated, matrix
from tests.dynamics.scenes import MOMENTS, TIGHT, orbit, plate, quantity, scene

MU, RADIUS = 3.986004e14, 6378100.0  # nominal Earth (IAU 2015)
C, SOLAR_CONSTANT, AU, SUN_RADIUS = 299792458.0, 1361.0, 149597870700.0, 6.957e8
# rad: how far SciPy's answer at rtol 1e-12 may be from a solver's after tens of radians.
AGREEMENT = 1e-10


def instant_torque(effect, **more):
    """(3,) N m, inertial, on the body at rest at the epoch: its momentum a moment after and before.

    What the difference leaves is (n dt)^2, 1e-10 of it.
    """
    dt = 0.01
    run = scene(effect, elapsed=(-dt, dt), tolerance=1e-9, **more).run()
    return (run.angular_momentum[1] - run.angular_momentum[0]) / (2.0 * dt)


def place(t, a=7e6, e=0.0):
    """(r, v) on the orbit in the plane z = 0 from its pericentre at x, by Newton's iteration."""
    n = np.sqrt(MU / a**3)
    E = n * t
    for _ in range(30):
        E -= (E - e * np.sin(E) - n * t) / (1.0 - e * np.cos(E))
    across, slow = np.sqrt(1.0 - e * e), 1.0 - e * np.cos(E)
    r = a * np.array([np.cos(E) - e, across * np.sin(E), 0.0])
    return r, a * n / slow * np.array([-np.sin(E), across * np.cos(E), 0.0])


def agrees(run, torque, within=AGREEMENT, rtol=1e-12, **more):
    """Attitudes and rates of a run are those of SciPy's DOP853 of Euler's equations with the torque."""
    start = run_situation(run)
    q, w = integrated(start, torque, run.elapsed, rtol=rtol, **more)
    assert angle(run.quaternion("wxyz").T, q) < within
    assert np.abs(run.angular_velocity.T - w).max() < within * np.abs(w).max()


def run_situation(run):
    """Body and state that `integrated` starts from: those of the first instant, which is the epoch."""
    assert run.elapsed[0] == 0.0
    return initial_state(run.body.tensor, run.angular_velocity[0], run.quaternion("wxyz")[0])


# Gravity gradient


def test_gravity_gradient_at_45_degrees_by_hand():
    """(3/2) n^2 (I_2 - I_1) where the centre is 45 degrees from both axes: n^2 = mu / r^3."""
    turned = {"euler": [45, 0, 0], "sequence": "ZXZ", "unit": "deg"}
    torque = instant_torque({"type": "gravity_gradient"}, orbit=orbit(), attitude=turned)
    # n^2 = 3.986004e14 / 3.43e20 = 1.162100292e-6; times 1.5 and 14 - 10: 6.97260175e-6 N m; the axis of
    # the lesser moment, ahead of the vertical by 45 degrees, is pulled back to it
    assert torque == pytest.approx([0.0, 0.0, -6.97260175e-6], rel=1e-8, abs=1e-14)


# Damping


def test_eddies_stop_a_spin_about_a_principal_axis_exponentially():
    """omega = omega0 exp(-C t / I), turned by omega0 I / C (1 - exp(-C t / I)); 0.05 N m s over 17 kg m2."""
    t = np.array([0.0, 50.0, 340.0, 1000.0])
    run = scene(
        {"type": "eddy_damping", "coefficient": 0.05, "unit": "N m s"}, rate=(0, 0, 0.4), elapsed=t
    ).run()
    left = np.exp(-0.05 * t / 17.0)
    assert left[2] == pytest.approx(1.0 / np.e)
    assert run.angular_velocity[:, 2] == pytest.approx(0.4 * left, rel=1e-11)
    turned = 0.4 * 17.0 / 0.05 * (1.0 - left)
    expected = np.stack([np.cos(0.5 * turned), 0.0 * t, 0.0 * t, np.sin(0.5 * turned)])
    assert angle(run.quaternion("wxyz").T, expected) < TIGHT


def test_eddies_of_a_tensor_agree_with_scipy_and_take_energy_and_momentum():
    tensor = [[0.05, 0.01, 0.005], [0.01, 0.04, 0.002], [0.005, 0.002, 0.03]]
    t = np.linspace(0.0, 300.0, 40)
    effect = {"type": "eddy_damping", "tensor": tensor, "unit": "N m s"}
    run = scene(effect, rate=(0.3, -0.5, 0.4), elapsed=t).run()
    agrees(run, lambda t, R, w: -np.array(tensor) @ w)
    assert (np.diff(run.kinetic_energy) < 0.0).all()
    assert (np.diff(np.linalg.norm(run.angular_momentum, axis=1)) < 0.0).all()


# Magnetic dipole


FIELD = {"strength": quantity(3e-5, "T"), "radius": quantity(6371.2, "km"), "rotation": quantity(0, "rad/s")}


def test_magnetic_torque_over_the_equator_and_over_the_pole_by_hand():
    """B = 3e-5 T (6371.2 / 7000)^3 = 2.262000e-5 T to the north over the equator, twice that, down, over
    the north pole; m x B for 2 A m2 along x."""
    effect = {"type": "magnetic_dipole", "dipole": quantity([2, 0, 0], "A m2"), "field": FIELD}
    B = 3e-5 * (6371.2 / 7000.0) ** 3
    assert pytest.approx(2.2620e-5, rel=1e-4) == B
    assert instant_torque(effect, orbit=orbit()) == pytest.approx([0.0, -2.0 * B, 0.0], rel=1e-8, abs=1e-13)
    polar = orbit(inclination=quantity(90, "deg"), true_anomaly=quantity(90, "deg"))
    assert instant_torque(effect, orbit=polar) == pytest.approx([0.0, 4.0 * B, 0.0], rel=1e-7, abs=1e-10)


def test_tilted_dipole_that_turns_with_the_earth_agrees_with_scipy():
    tilt, longitude, turning = np.radians(11.0), np.radians(-70.0), 7.292115e-5
    field = {
        **FIELD,
        "tilt": quantity(11, "deg"),
        "longitude": quantity(-70, "deg"),
        "rotation": quantity(turning, "rad/s"),
    }
    effect = {"type": "magnetic_dipole", "dipole": quantity([30, -20, 50], "A m2"), "field": field}
    t = np.linspace(0.0, 6000.0, 13)
    run = scene(effect, rate=(0.01, -0.005, 0.004), elapsed=t, orbit=orbit()).run()

    def torque(t, R, w):
        r, _ = place(t)
        d, east = np.linalg.norm(r), longitude + turning * t
        # of the pole where the field points inwards, in the north; the moment is opposite
        pole = np.array([np.sin(tilt) * np.cos(east), np.sin(tilt) * np.sin(east), np.cos(tilt)])
        B = 3e-5 * 6371.2e3**3 / d**3 * (pole - 3.0 * (pole @ r) * r / d**2)
        return np.cross([30.0, -20.0, 50.0], R.T @ B)

    agrees(run, torque)


# Sunlight


def sunlight(*plates, **more):
    return {"type": "solar_pressure", "plates": list(plates), "sun": {"direction": [1, 0, 0]}, **more}


@pytest.mark.parametrize(
    ("degrees", "force"),
    [
        # P A [(1 - 0.3) + 2 (0.3 + 0.2 / 3)] towards -x; P = 1361 / 299792458 = 4.53980733e-6 N/m2, A = 2
        (0, (-1.301411435e-5, 0.0)),
        # cos = 1/2: P A / 2 [0.7 s + 2 (0.15 + 0.2 / 3) n], n = (1/2, sqrt(3)/2):
        # P (0.7 + 0.433333 / 2, 0.433333 * 0.8660254)
        (60, (-4.161490053e-6, -1.703688342e-6)),
        (95, (0.0, 0.0)),
    ],
)
def test_light_on_a_plate_by_hand(degrees, force):
    """At the arm (0, 1.5, 0.4) m: r x F."""
    normal = [np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0]
    lit = plate(2.0, normal, [0.0, 1.5, 0.4], specular=0.3, diffuse=0.2)
    other = plate(2.0, [-1, 0, 0], [0.3, 0.0, 0.2])  # shows its back: nothing
    torque = instant_torque(sunlight(lit, other, shadow=False))
    Fx, Fy = force
    assert torque == pytest.approx([-0.4 * Fy, 0.4 * Fx, -1.5 * Fx], rel=1e-8, abs=1e-15)


def test_sunlight_agrees_with_scipy_and_ends_at_the_shadow():
    """A body that keeps its lit side to the Sun: entry and exit where the orbit crosses the cylinder."""
    lit = plate(3.0, [1, 0.2, 0], [0.1, 0.6, -0.5], specular=0.4, diffuse=0.1)
    period = 2.0 * np.pi * np.sqrt(7e6**3 / MU)
    half = np.arcsin(RADIUS / 7e6) / (2.0 * np.pi) * period
    entry, end = 0.5 * period - half, 0.5 * period + half
    t = np.array([0.0, 1000.0, entry - 1.0, entry + 200.0, end - 200.0, end + 1.0, 5500.0])
    moments, rate = (100.0, 140.0, 170.0), (6e-5, 4e-5, -5e-5)
    light = sunlight(lit, shadow="cylindrical")
    run = scene(light, moments=moments, rate=rate, elapsed=t, orbit=orbit()).run()
    assert [(event.kind, event.seconds) for event in run.events] == [
        ("shadow entry", pytest.approx(entry, abs=1e-6)),
        ("shadow exit", pytest.approx(end, abs=1e-6)),
    ]
    L = run.angular_momentum
    assert np.abs(L[4] - L[3]).max() < 1e-14 * np.linalg.norm(L[3])
    assert np.abs(L[3] - L[2]).max() > 1e-9 * np.linalg.norm(L[3])

    def torque(t, R, w):
        r, _ = place(t)
        if r[0] < 0.0 and abs(r[1]) < RADIUS:
            return np.zeros(3)
        n = np.array([1.0, 0.2, 0.0]) / np.sqrt(1.04)
        sun = np.array([AU, 0.0, 0.0]) - r
        d = np.linalg.norm(sun)
        s = R.T @ sun / d
        c = n @ s
        assert c > 0.1
        force = -SOLAR_CONSTANT / C * (AU / d) ** 2 * 3.0 * c * (0.6 * s + 2.0 * (0.4 * c + 0.1 / 3.0) * n)
        return np.cross([0.1, 0.6, -0.5], force)

    agrees_in_pieces(run, torque, (entry, end))


def agrees_in_pieces(run, torque, cuts, within=AGREEMENT):
    """`agrees`, SciPy restarted where the torque is broken: no instant is at a cut but the last."""
    q, w, before = run.quaternion("wxyz")[0], run.angular_velocity[0], 0.0
    for cut in (*cuts, run.elapsed[-1]):
        inside = (run.elapsed > before) & (run.elapsed < cut)
        t = np.append(run.elapsed[inside], cut) - before
        at = before + 1e-9  # on this side of the edge
        found, rates = integrated(
            initial_state(run.body.tensor, w, q), lambda s, R, w, at=at: torque(at + s, R, w), t, rtol=1e-12
        )
        if inside.any():
            assert angle(run.quaternion("wxyz")[inside].T, found[:, :-1]) < within
        q, w, before = found[:, -1], rates[:, -1], cut
    assert angle(run.quaternion("wxyz")[-1:].T, q[:, None]) < within


def free_part(a, behind):
    """Part of the Sun's disc that is free, seen an angle from the point behind the Earth; by quadrature."""
    r = a * np.array([-np.cos(behind), np.sin(behind), 0.0])
    sun = np.array([AU, 0.0, 0.0]) - r
    own, other = np.arcsin(SUN_RADIUS / np.linalg.norm(sun)), np.arcsin(RADIUS / a)
    between = np.arctan2(np.linalg.norm(np.cross(sun, -r)), -(sun @ r))
    # strips of the Sun's disc across the line of centres: their length, less what the other disc covers
    angles = np.linspace(0.0, np.pi, 200_001)
    x, half = own * np.cos(angles), own * np.sin(angles)
    covered = np.minimum(half, np.sqrt(np.maximum(other**2 - (between - x) ** 2, 0.0)))
    return np.trapezoid((half - covered) * half, angles) / np.trapezoid(half * half, angles)


@pytest.mark.parametrize(("a", "into"), [(7e6, 0.3), (7e6, 0.8), (4.2e7, 0.5), (2e9, 0.5), (2e9, 1.5)])
def test_light_in_a_penumbra_is_that_of_the_part_of_the_disc_that_is_free(a, into):
    """`into`: of the way from the first touch of the discs to the second; beyond, the Sun is a ring."""
    own, other = SUN_RADIUS / (AU + a), np.arcsin(RADIUS / a)
    behind = own + other - 2.0 * into * min(own, other)
    part = free_part(a, behind)
    lit = plate(2.0, [1, 0, 0], [0.0, 0.5, 0.0])
    place = orbit(a, true_anomaly=quantity(180.0 - np.degrees(behind), "deg"))
    torque = {
        shadow: instant_torque(sunlight(lit, shadow=shadow), orbit=place) for shadow in ("conical", False)
    }
    assert 0.0 < part < 1.0
    assert torque["conical"] == pytest.approx(part * torque[False], rel=1e-5)


@pytest.mark.parametrize("a", [7e6, 4.2164e7], ids=["low orbit", "geostationary"])
@pytest.mark.parametrize("shadow", [True, False])
@pytest.mark.parametrize("sun", ["astropy", {"direction": [0.1, -0.9, -0.4]}], ids=["astropy", "fixed"])
def test_light_comes_from_the_sun_to_the_body_with_and_without_a_shadow(a, shadow, sun):
    """r x F on a plate that absorbs all, at the body's distance from the Sun; a fixed Sun is 1 au away."""
    from astropy.coordinates import get_body_barycentric
    from astropy.time import Time

    arm, area = np.array([0.3, -0.7, 0.5]), 2.0
    if sun == "astropy":
        when = Time("2026-03-20T12:00:00", scale="utc")
        place_of = {name: get_body_barycentric(name, when).xyz.to_value("m") for name in ("sun", "earth")}
        towards = place_of["sun"] - place_of["earth"]
    else:
        towards = AU * np.array(sun["direction"]) / np.linalg.norm(sun["direction"])
    # on the side of the orbit that has the Sun abeam, where the parallax is greatest, and never in the shadow
    abeam = np.degrees(np.arctan2(towards[1], towards[0])) + 90.0
    around = orbit(a, true_anomaly=quantity(abeam, "deg"))
    to_sun = towards - a * np.array([np.cos(np.radians(abeam)), np.sin(np.radians(abeam)), 0.0])
    d = np.linalg.norm(to_sun)
    normal = towards / np.linalg.norm(towards)
    lit = plate(area, normal.tolist(), arm.tolist())
    effect = {"type": "solar_pressure", "plates": [lit], "sun": sun, "shadow": shadow}
    epoch = {"time": "2026-03-20T12:00:00", "scale": "utc"}
    torque = instant_torque(effect, orbit=around, epoch=epoch, frame="GCRF")
    force = -SOLAR_CONSTANT / C * (AU / d) ** 2 * area * (normal @ to_sun / d) * to_sun / d
    assert np.abs(torque - np.cross(arm, force)).max() < 1e-7 * np.linalg.norm(np.cross(arm, force))


# Drag


def test_drag_on_a_plate_by_hand():
    """rho v^2 / 2 Cd A = 0.5 1e-12 (3.986004e14 / 7e6) 2.2 3 = 1.87911617e-4 N against the motion along y."""
    facing = plate(3.0, [0, 1, 0], [0.0, 0.0, 0.5], coefficient=2.2)
    drag = {"type": "drag", "plates": [facing], "density": quantity(1e-12, "kg/m3"), "corotating": False}
    torque = instant_torque(drag, orbit=orbit())
    assert torque == pytest.approx([0.5 * 1.87911617e-4, 0.0, 0.0], rel=1e-8, abs=1e-14)
    # air that turns with the Earth, 7.2921151467e-5 rad/s 7e6 m = 510.448060 m/s, meets it more slowly, and
    # at one and a half scale heights more is thinner by exp(-1.5)
    thin = {
        "type": "drag",
        "plates": [facing],
        "density": quantity(1e-12, "kg/m3"),
        "reference_altitude": quantity(7e6 - RADIUS - 75e3, "m"),
        "scale_height": quantity(50, "km"),
    }
    slower = (1.0 - 510.448060 / np.sqrt(MU / 7e6)) ** 2
    assert instant_torque(thin, orbit=orbit())[0] == pytest.approx(
        0.5 * 1.87911617e-4 * slower * np.exp(-1.5), rel=1e-7
    )


def test_drag_on_an_eccentric_orbit_agrees_with_scipy():
    """A weather vane in exponential air that turns with the planet, for a part of the orbit in which the
    flow keeps to one side."""
    plates = [
        plate(2.0, [0, 1, 0.1], [0.1, -0.4, 0.2]),
        plate(1.0, [0.3, 1, 0], [0, -0.9, 0], coefficient=1.8),
    ]
    effect = {
        "type": "drag",
        "plates": plates,
        "density": quantity(4e-11, "kg/m3"),
        "reference_altitude": quantity(300, "km"),
        "scale_height": quantity(45, "km"),
    }
    t = np.linspace(0.0, 900.0, 10)
    rate = (2e-4, -3e-4, 9e-4)
    run = scene(effect, rate=rate, elapsed=t, orbit=orbit(6.9e6, eccentricity=0.03)).run()
    turning = np.array([0.0, 0.0, 7.2921151467e-5])

    def torque(t, R, w):
        r, v = place(t, 6.9e6, 0.03)
        flow = R.T @ (v - np.cross(turning, r))
        density = 4e-11 * np.exp(-(np.linalg.norm(r) - RADIUS - 300e3) / 45e3)
        total = np.zeros(3)
        for n, centre, area in (([0, 1, 0.1], [0.1, -0.4, 0.2], 4.0), ([0.3, 1, 0], [0, -0.9, 0], 1.8)):
            c = np.array(n) @ flow / np.linalg.norm(n) / np.linalg.norm(flow)
            assert c > 0.05
            total += np.cross(centre, -0.5 * density * np.linalg.norm(flow) * area * c * flow)
        return total

    agrees(run, torque)


# Several effects of one kind

FACING = plate(3.0, [0, 1, 0], [0.0, 0.0, 0.5])
THIN = {"type": "drag", "plates": [FACING], "density": quantity(1e-12, "kg/m3")}
TABLE = {"altitudes": quantity([300, 900], "km"), "densities": quantity([1e-11, 1e-14], "kg/m3")}
LIT = sunlight(plate(2.0, [1, 0, 0], [0.0, 1.5, 0.4]), shadow=False)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (THIN, THIN | {"density": TABLE}),
        (
            THIN | {"density": TABLE},
            THIN
            | {
                "density": {"altitudes": TABLE["altitudes"]}
                | {"densities": quantity([3e-11, 1e-12], "kg/m3")}
            },
        ),
        (LIT, LIT | {"shadow": "conical", "plates": [plate(1.0, [2, 1, 0], [0.3, 0.0, 0.2], specular=0.5)]}),
        (
            {"type": "magnetic_dipole", "dipole": quantity([2, 0, 0], "A m2"), "field": FIELD},
            {"type": "magnetic_dipole", "dipole": quantity([1, 0, 3], "A m2")},
        ),
    ],
    ids=["constant and table", "tables", "light", "fields"],
)
def test_torques_of_two_effects_of_one_kind_add(one, other):
    torque = [instant_torque(effect, orbit=orbit()) for effect in (one, other)]
    document = scene(one, other, elapsed=(-0.01, 0.01), tolerance=1e-9, orbit=orbit())
    momentum = document.run().angular_momentum
    assert min(np.abs(each).max() for each in torque) > 0.0
    assert (momentum[1] - momentum[0]) / 0.02 == pytest.approx(sum(torque), rel=1e-6, abs=1e-13)


# Constant torque


@pytest.mark.parametrize("frame", ["body", "inertial"])
def test_constant_torque_for_a_while_agrees_with_scipy(frame):
    """By a solver before, during and after; the momentum changes by torque times time while it acts."""
    T = np.array([0.02, -0.01, 0.015])
    effect = {"type": "constant_torque", "torque": quantity(T.tolist(), "N m"), "frame": frame}
    effect |= {"start": quantity(10, "s"), "stop": quantity(35, "s")}
    t = np.array([0.0, 5.0, 9.0, 12.0, 30.0, 36.0, 50.0])
    run = scene(effect, rate=(0.3, -0.5, 0.4), elapsed=t).run()
    assert [(event.kind, event.seconds) for event in run.events] == [
        ("torque on", 10.0),
        ("torque off", 35.0),
    ]

    def torque(t, R, w):
        return np.zeros(3) if not 10.0 < t < 35.0 else T if frame == "body" else R.T @ T

    agrees_in_pieces(run, torque, (10.0, 35.0))
    L = run.angular_momentum
    if frame == "inertial":
        assert L[-1] - L[0] == pytest.approx(25.0 * T, rel=1e-12)
    assert np.abs(L[2] - L[0]).max() < 1e-14 * np.linalg.norm(L[0])


# Dissipation


def falling_energy(run):
    """(n,) J: m.I^-1 m / 2, m the momentum in the body, which is what the sink lowers."""
    m = np.array([matrix(q).T @ L for q, L in zip(run.quaternion("wxyz"), run.angular_momentum, strict=True)])
    return 0.5 * (m * m / np.array(np.diag(run.body.tensor))).sum(axis=1), m


SINK = {"type": "dissipation", "coefficient": quantity(1e-4, "1/(N m s)")}


@pytest.mark.parametrize("moments", [(10.0, 14.0, 17.0), (17.0, 10.0, 14.0), (40.0, 40.0, 9.0)])
def test_dissipation_keeps_momentum_and_takes_energy_down_to_flat_spin(moments):
    rate = np.full(3, 0.1)
    rate[np.argmin(moments)] = 2.0
    t = np.linspace(0.0, 60000.0, 400)
    run = scene(SINK, moments=moments, rate=rate.tolist(), elapsed=t, tolerance=1e-6).run()
    L = run.angular_momentum
    assert np.abs(L - L[0]).max() <= 1e-13 * np.linalg.norm(L[0])
    energy, m = falling_energy(run)
    least = 0.5 * (L[0] @ L[0]) / max(moments)
    assert (np.diff(energy) <= 1e-14 * energy[0]).all()
    assert (np.diff(energy[energy > least * (1.0 + 1e-9)]) < 0.0).all()
    assert energy[0] > 1.4 * least
    assert energy[-1] == pytest.approx(least, rel=1e-12)
    # about the axis of the greatest moment, or about some axis across the third
    hi = np.isclose(moments, max(moments))
    assert np.linalg.norm(m[-1][hi]) == pytest.approx(np.linalg.norm(L[0]), rel=1e-12)


def test_prolate_spinner_ends_in_flat_spin():
    """As Explorer 1: a rod spun about its axis, a thousandth of a radian off, lies across L in the end."""
    moments, t = (3.0, 3.02, 0.04), np.array([0.0, 4000.0])
    sink = {"type": "dissipation", "coefficient": quantity(3e-2, "1/(N m s)")}
    run = scene(sink, moments=moments, rate=(0, 1e-4, 5.0), elapsed=t, tolerance=1e-4).run()
    _, m = falling_energy(run)
    L = np.linalg.norm(m[0])
    assert np.linalg.norm(m[0][:2]) < 2e-3 * L
    assert abs(m[1][1]) == pytest.approx(L, rel=1e-9)
    assert abs(run.angular_velocity[1][1]) == pytest.approx(L / 3.02, rel=1e-9)


def test_sink_stronger_than_the_spin_is_refused():
    """m x w many times alpha is more than w: no rate of the body gives the rate that is asked for."""
    sink = {"type": "dissipation", "coefficient": quantity(10, "1/(N m s)")}
    with pytest.raises(InputError, match=r"dissipation.*over more than a turn"):
        scene(sink, moments=(3.0, 3.02, 0.04), rate=(0.5, 1e-4, 5.0), elapsed=[0.0, 10.0]).run()


# Wheels


@pytest.mark.parametrize("moments", [MOMENTS, (20.0, 20.0, 9.0)])
def test_wheels_that_stand_still_change_no_bit(moments):
    t = np.linspace(-500.0, 3000.0, 50)
    still = scene(
        {"type": "wheels", "momentum": quantity([0, 0, 0], "N m s")},
        moments=moments,
        rate=(0.3, -0.5, 0.4),
        elapsed=t,
    ).run()
    free = scene(moments=moments, rate=(0.3, -0.5, 0.4), elapsed=t).run()
    assert still.quaternion("wxyz").tobytes() == free.quaternion("wxyz").tobytes()
    assert still.angular_velocity.tobytes() == free.angular_velocity.tobytes()
