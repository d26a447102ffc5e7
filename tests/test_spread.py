"""Pictures of an uncertainty: bands and ellipses against exact bodies drawn at random, and their legends."""

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from attitude import RigidBody, Scene, TorqueFreeMotion
from attitude.plot import spread, timeline
from attitude.plot.choices import panels

BODIES = 4000
MOMENTS, RATE, SIGMA = np.array([10.0, 13.0, 17.0]), np.array([0.02, -0.03, 0.05]), 0.01
DOCUMENT = {
    "body": {"moments": MOMENTS.tolist(), "unit": "kg m2"},
    "attitude": {"euler": [20, 40, 60], "sequence": "ZXZ", "unit": "deg"},
    "angular_velocity": {"value": RATE.tolist(), "unit": "rad/s"},
    "times": {"start": -40, "stop": 60, "step": 5, "unit": "s"},
    "uncertainty": {
        "attitude": {"value": [SIGMA, 2 * SIGMA, SIGMA], "unit": "rad"},
        "angular_velocity": {"value": [1e-4, 2e-4, 1e-4], "unit": "rad/s"},
        "moments": {"value": [0.05, 0.1, 0.1], "unit": "kg m2"},
    },
}


def document(**changes):
    return {**DOCUMENT, **changes}


@pytest.fixture(scope="module")
def ephemeris():
    return Scene.load(DOCUMENT).run()


@pytest.fixture(scope="module")
def exact(ephemeris):
    """Bodies drawn from the uncertainty, moved exactly: attitudes (n, m), rates (n, m, 3), moments (n, 3)."""
    random = np.random.default_rng(7)
    sigma = np.sqrt(np.diagonal(ephemeris.uncertainty.covariance))
    draws = random.normal(size=(BODIES, 12)) * sigma
    at_zero = Rotation.from_euler("ZXZ", [20, 40, 60], degrees=True) * Rotation.from_rotvec(draws[:, :3])
    moments = MOMENTS + draws[:, 6:9]
    motion = TorqueFreeMotion(
        RigidBody.from_moments(moments),
        at_zero.as_quat(scalar_first=True),
        RATE + draws[:, 3:6],
        order="wxyz",
    )
    moved = motion.at(ephemeris.elapsed)
    return moved.rotation, moved.angular_velocity, moments


def drawn_values(name, exact):
    """What is plotted under a name, by SciPy and the definitions."""
    rotation, rate, moments = exact
    shape = rate.shape[:2]
    body_momentum = moments[:, None] * rate
    momentum = Rotation.from_matrix(rotation.as_matrix().reshape(-1, 3, 3)).apply(
        body_momentum.reshape(-1, 3)
    )
    momentum = momentum.reshape(*shape, 3)
    axis = rotation.as_matrix()[..., 2].reshape(*shape, 3)
    if name == "euler:ZYX":
        angles = Rotation.from_matrix(rotation.as_matrix().reshape(-1, 3, 3)).as_euler("ZYX", degrees=True)
        return angles.reshape(*shape, 3)
    if name == "angle:z:momentum":
        size = np.linalg.norm(momentum, axis=-1)
        return np.degrees(np.arccos((momentum * axis).sum(axis=-1) / size))[..., None]
    return {
        "rates": rate,
        "momentum": momentum,
        "energy": 0.5 * (body_momentum * rate).sum(axis=-1)[..., None],
        "direction:z": axis,
    }[name]


@pytest.mark.parametrize(
    "name", ["euler:ZYX", "rates", "momentum", "energy", "direction:z", "angle:z:momentum"]
)
def test_band_is_the_standard_deviation_of_exact_bodies(ephemeris, exact, name):
    (panel,) = timeline.with_sigma(ephemeris, list(panels(ephemeris, [name])), [name])
    values = drawn_values(name, exact)
    off = values - panel.values
    if name.startswith("euler"):
        off = (off + 180.0) % 360.0 - 180.0
    spread_of_bodies = np.sqrt((off**2).mean(axis=0))
    # 4,000 bodies: 1.1 % of chance, four times that for the worst of 63 numbers
    np.testing.assert_allclose(panel.sigma, spread_of_bodies, rtol=0.045, atol=0.01 * panel.sigma.max())


def test_momentum_and_energy_of_a_free_body_are_as_unsure_at_all_times(ephemeris):
    for name in ("momentum", "energy"):
        (panel,) = timeline.with_sigma(ephemeris, list(panels(ephemeris, [name])), [name])
        assert np.ptp(panel.sigma, axis=0).max() <= 1e-6 * panel.sigma.max()


def test_four_in_ten_exact_bodies_point_into_the_ellipse(ephemeris, exact):
    """1 - exp(-1/2) of a normal distribution in the plane; the ellipse as the picture draws it."""
    angles = np.linspace(0.0, 2.0 * np.pi, 9)[:-1]
    edge = spread.around(ephemeris, np.array([0.0, 0.0, 1.0]), angles)
    edge = edge.rotation.as_matrix()[..., 2].reshape(len(ephemeris), len(angles), 3)
    middle = ephemeris.rotation.as_matrix()[..., 2]
    axes = exact[0].as_matrix()[..., 2].reshape(BODIES, -1, 3)
    for k in (0, 8, 20):
        plane = np.linalg.svd(middle[k : k + 1])[2][1:]
        border = (edge[k] - middle[k]) @ plane.T
        # the quadratic form that is 1 on the border
        form = np.linalg.lstsq(
            np.stack([border[:, 0] ** 2, border[:, 1] ** 2, border[:, 0] * border[:, 1]], axis=1), np.ones(8)
        )[0]
        x, y = ((axes[:, k] - middle[k]) @ plane.T).T
        inside = form[0] * x * x + form[1] * y * y + form[2] * x * y <= 1.0
        assert inside.mean() == pytest.approx(1.0 - np.exp(-0.5), abs=4 * 0.0077)


def words(svg):
    return re.findall(r">([^<>]+)</text>", svg.decode())


def test_picture_says_what_its_bands_are_and_from_when_on_they_do_not_hold():
    times = {"start": 0, "stop": 4000, "step": 4, "unit": "s"}
    ephemeris = Scene.load(document(times=times)).run()
    limit = ephemeris.uncertainty.linear_until
    assert 0.0 < limit < 4000.0
    actual = words(timeline.picture(ephemeris, "svg"))
    assert "band: 1 sigma to either side" in actual
    assert f"from {limit / 60:.4g} min on the first order is off by &gt; 10 % at 3 sigma" in actual
    figure = timeline.figure(ephemeris)
    starts = [patch.get_x() for axes in figure.axes for patch in axes.patches]
    assert starts == pytest.approx([limit / 60.0] * len(figure.axes))


@pytest.mark.parametrize(
    "changes", [{"uncertainty": None}, {"frame": "ITRF"}], ids=["exact", "in a turning frame"]
)
def test_picture_without_an_uncertainty_has_no_band(changes):
    scene = Scene.load(
        {key: value for key, value in document(**changes).items() if value is not None and key != "frame"}
    )
    ephemeris = scene.run()
    if "frame" in changes:
        dated = document(epoch={"time": "2024-01-01T00:00:00", "scale": "utc"})
        ephemeris = Scene.load(dated).run().in_frame("ITRF")
    assert not any("sigma" in word for word in words(timeline.picture(ephemeris, "svg")))


@pytest.mark.parametrize(
    ("step", "kind"),
    [(5, "PolyCollection"), (100, "LineCollection")],
    ids=["bands", "bars where samples are dots"],
)
def test_every_line_has_its_band_on_both_sides_of_the_epoch(step, kind):
    times = {"start": -8 * step, "stop": 12 * step, "step": step, "unit": "s"}
    figure = timeline.figure(Scene.load(document(times=times)).run())
    for axes in figure.axes:
        drawn = [each for each in axes.collections if kind in type(each).__name__ or kind == "PolyCollection"]
        assert len(drawn) == len(axes.get_lines())
        low, high = axes.get_ylim()
        assert all(
            low <= line.get_ydata().min() and line.get_ydata().max() <= high for line in axes.get_lines()
        )


def test_ground_track_has_ellipses_of_the_axis():
    orbit = {"altitude": {"value": 600, "unit": "km"}, "inclination": {"value": 60, "unit": "deg"}}
    down = {"euler": [0, -90, 0], "sequence": "ZYX", "unit": "deg"}
    dated = {"orbit": orbit, "epoch": {"time": "2024-01-01T00:00:00", "scale": "utc"}, "attitude": down}
    ephemeris = Scene.load(document(**dated)).run()
    figure = timeline.figure(ephemeris, ["ground-track"])
    assert "ellipse of 1 sigma" in [text.get_text() for text in figure.axes[0].get_legend().get_texts()]


def test_first_order_holds_as_long_whatever_the_unit_of_the_moments():
    """Variances of an asteroid's moments are 1e40 times those of its attitude."""
    sigma = np.array([0.01] * 3 + [1e-4] * 3 + [0.1] * 3)
    correlation = np.eye(9) + 0.3 * (np.eye(9, k=3) + np.eye(9, k=-3))
    limits = []
    for scale in (1.0, 1e20):
        of_inputs = np.outer(sigma, sigma) * correlation * np.outer(*[[1.0] * 6 + [scale] * 3] * 2)
        body = {"moments": (scale * MOMENTS).tolist(), "unit": "kg m2"}
        times = {"start": 0, "stop": 4000, "step": 40, "unit": "s"}
        scene = document(body=body, times=times, uncertainty={"covariance": of_inputs.tolist()})
        limits.append(Scene.load(scene).run().uncertainty.linear_until)
    assert limits[0] == pytest.approx(limits[1])
    assert 0.0 < limits[0] < 4000.0
