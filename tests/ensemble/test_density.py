"""Where body axes point: cells of equal area, and bodies counted in them."""

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

from attitude import InputError, Scene, TorqueFreeMotion
from attitude.ensemble import Ensemble
from attitude.ensemble.density import COLUMNS, ROWS, CellCounter, axis_of, cell_of

TOUTATIS = Scene.builtin("toutatis")
TIMES = [0.0, 3e5, 1e6]


def spread_ensemble(size=3000):
    return Ensemble.sample(TOUTATIS, size, 5, moments="5 %", angular_velocity="5 deg/d", attitude="10 deg")


def test_cells_have_equal_areas():
    vectors = np.random.default_rng(1).normal(size=(720_000, 3))
    cells = cell_of(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))
    counts = np.bincount(cells, minlength=ROWS * COLUMNS)
    assert stats.chisquare(counts).pvalue > 1e-3


@pytest.mark.parametrize(
    ("direction", "row", "column"),
    [
        ((0, 0, 1), ROWS - 1, None),
        ((0, 0, -1), 0, None),
        ((1, 0, 1e-9), ROWS // 2, COLUMNS // 2),
        ((0, 1, -1e-9), ROWS // 2 - 1, 3 * COLUMNS // 4),
        ((-1, -1e-9, 1e-9), ROWS // 2, 0),
        ((-1, 1e-9, 1e-9), ROWS // 2, COLUMNS - 1),
    ],
)
def test_cell_of_known_directions(direction, row, column):
    cell = int(cell_of(np.array(direction, dtype=float)))
    assert cell // COLUMNS == row
    assert column is None or cell % COLUMNS == column


def test_counts_are_those_of_each_body_by_itself():
    ensemble = spread_ensemble()
    states = ensemble.states()
    motion = TorqueFreeMotion(states.body, states.attitude, states.angular_velocity, order="wxyz")
    density = ensemble.density(TIMES, axis=(1.0, -2.0, 0.5))
    axis = np.array([1.0, -2.0, 0.5]) / np.linalg.norm([1.0, -2.0, 0.5])
    for t, counts in zip(TIMES, density.counts, strict=True):
        quaternions = motion.at(t).quaternion("xyzw")
        x, y, z = Rotation.from_quat(quaternions).apply(axis).T
        edges = np.linspace(-1, 1, ROWS + 1), np.linspace(-np.pi, np.pi, COLUMNS + 1)
        expected = np.histogram2d(z, np.arctan2(y, x), edges)[0]
        assert np.abs(counts - expected).sum() <= 2  # one body may stand on an edge
        assert counts.sum() == ensemble.size


def test_counts_do_not_depend_on_how_bodies_are_shared_out():
    ensemble = spread_ensemble()
    work = CellCounter(ensemble.source, TOUTATIS, None, ensemble.instants(TIMES), np.array([0.0, 0.0, 1.0]))
    parts = [(0, 1), (1, 1000), (1000, 3000)]
    assert (
        sum(work(part)[0] for part in parts).reshape(3, ROWS, COLUMNS) == ensemble.density(TIMES).counts
    ).all()


def test_density_is_over_that_of_any_direction_and_covers_what_it_says():
    density = spread_ensemble().density(TIMES)
    assert density.relative.mean(axis=(1, 2)) == pytest.approx(1.0)
    cells = np.sort(density.counts[0].ravel())[::-1]
    needed = round(density.covered[0] * ROWS * COLUMNS)
    assert cells[:needed].sum() >= 0.95 * density.count > cells[: needed - 1].sum()


def test_axes_by_name():
    # moments 3.08, 3.24, 1
    assert (axis_of("least", TOUTATIS) == [0, 0, 1]).all()
    assert (axis_of("middle", TOUTATIS) == [1, 0, 0]).all()
    assert (axis_of("greatest", TOUTATIS) == [0, 1, 0]).all()
    assert (axis_of("y", None) == [0, 1, 0]).all()
    envisat = Scene.builtin("envisat")
    axis, tensor = axis_of("least", envisat), envisat.body.build().tensor
    assert tensor @ axis == pytest.approx((axis @ tensor @ axis) * axis, abs=1e-9 * tensor.max())
    assert axis @ tensor @ axis == pytest.approx(envisat.body.build().moments.min())


@pytest.mark.parametrize("axis", ["w", "long", [0, 0, 0], [1, 2], [np.nan, 0, 1], None, "least"])
def test_what_is_no_axis_is_refused(axis):
    with pytest.raises(InputError, match=r"^axis: "):
        axis_of(axis, None)
