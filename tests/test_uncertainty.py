"""Uncertainty of a scene: covariances against exact bodies, where they cease to be linear, and documents."""

import csv
import json

import numpy as np
import pandas
import pyarrow.ipc
import pytest
from astropy.table import Table

from attitude import Ephemeris, InputError, RegimeError, RigidBody, Scene, TorqueFreeMotion
from attitude.frames import rotations
from attitude.plot import spread

COUNT = 6000  # bodies drawn; a standard deviation of them is off by 1/sqrt(2 COUNT), five times is the limit
LIMIT = 5.0 / np.sqrt(2.0 * COUNT)
SIGMA = {
    "attitude": {"value": [1.2, 0.6, 1.8], "unit": "arcmin"},
    "angular_velocity": {"value": [2e-3, 1e-3, 2e-3], "unit": "deg/s"},
    "moments": {"value": [4e-4, 3e-4, 5e-4], "unit": "kg m2"},
    "axes": {"value": [0.6, 1.2, 0.6], "unit": "arcmin"},
}
RATES = {
    "short axis": (3.0, -5.0, 20.0),
    "long axis": (20.0, 4.0, -3.0),
    "beside the middle axis": (2.0, 15.0, 1.0),
    "spin about the greatest": (0.0, 0.0, 12.0),
}


def scene(rate=(3.0, -5.0, 20.0), stop=100.0, uncertainty=SIGMA, **members):
    return Scene.model_validate(
        {
            "body": {"moments": [1.0, 1.6, 2.1], "unit": "kg m2"},
            "attitude": {"quaternion": [0.1, -0.7, 0.5, 0.5], "order": "wxyz"},
            "angular_velocity": {"value": list(rate), "unit": "deg/s"},
            "times": {"start": 0.0, "stop": stop, "count": 5, "unit": "s"},
            "uncertainty": uncertainty,
            **members,
        }
    )


def drawn(ephemeris, covariance, seed=3):
    """Small rotations and changes of rate, (COUNT, m, 6), of exact bodies."""
    rng = np.random.default_rng(seed)
    changes = rng.multivariate_normal(np.zeros(12), covariance, COUNT, method="eigh")
    axes = rotation(changes[:, 9:])
    tensors = axes * (np.array([1.0, 1.6, 2.1]) + changes[:, None, 6:9]) @ np.swapaxes(axes, 1, 2)
    tensors = 0.5 * (tensors + np.swapaxes(tensors, 1, 2))
    start = ephemeris[0]
    attitudes = rotations.product(start.quaternion("wxyz"), rotations.from_matrix(rotation(changes[:, :3])))
    rates = start.angular_velocity + changes[:, 3:6]
    exact = TorqueFreeMotion(RigidBody(tensors), attitudes, rates, order="wxyz").at(ephemeris.elapsed)
    turns = rotations.rotation_vectors(ephemeris.quaternion("wxyz"), exact.quaternion("wxyz"))
    return np.concatenate([turns, exact.angular_velocity - ephemeris.angular_velocity], axis=-1)


def rotation(vectors):
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(vectors).as_matrix()


@pytest.mark.parametrize("rate", RATES.values(), ids=list(RATES))
def test_covariance_is_that_of_exact_bodies(rate):
    ephemeris = scene(rate).run()
    sample = drawn(ephemeris, ephemeris.uncertainty.covariance)
    spread = np.sqrt((sample**2).mean(axis=0))
    sigma = np.sqrt(np.diagonal(ephemeris.covariance, axis1=-2, axis2=-1))
    sizes = np.sqrt((spread.reshape(-1, 2, 3) ** 2).mean(axis=-1)).repeat(3, axis=-1)
    assert (np.abs(sigma - spread) <= LIMIT * sizes).all()
    mixed = np.einsum("nmi,nmj->mij", sample, sample) / COUNT
    limits = LIMIT * sizes[:, :, None] * sizes[:, None, :] * np.sqrt(2.0)
    assert (np.abs(mixed - ephemeris.covariance) <= limits).all()


def test_sigma_of_a_direction_is_that_of_exact_directions():
    ephemeris = scene().run()
    turns = drawn(ephemeris, ephemeris.uncertainty.covariance)[..., :3]
    for axis in np.eye(3):
        moved = np.cross(turns, axis)
        greatest = np.linalg.eigvalsh(np.einsum("nmi,nmj->mij", moved, moved) / COUNT)[:, 2] ** 0.5
        assert np.abs(ephemeris.direction_sigma(axis) / greatest - 1.0).max() <= LIMIT


def test_linear_until_is_where_exact_bodies_at_three_sigma_leave_the_first_order():
    wide = {"angular_velocity": {"value": [0.0, 0.0, 0.2], "unit": "deg/s"}}
    ephemeris = scene(stop=400.0, uncertainty=wide).run()
    limit = ephemeris.uncertainty.linear_until
    assert 20.0 < limit < 400.0
    (note,) = ephemeris.notes
    assert f"from {limit:.6g} s on" in note
    assert "Ensemble" in note
    for instant, beyond in ((0.5 * limit, False), (2.0 * limit, True)):
        here = scene(uncertainty=wide, times={"elapsed": [0.0, instant], "unit": "s"}).run()
        linear = here.partials().matrix[1][:, 5] * np.deg2rad(0.6)
        changes = []
        for sign in (1.0, -1.0):
            moved = scene((3.0, -5.0, 20.0 + 0.6 * sign), times={"elapsed": [instant], "unit": "s"}).run()
            vector = rotations.rotation_vectors(here.quaternion("wxyz")[1], moved.quaternion("wxyz")[0])
            rate = moved.angular_velocity[0] - here.angular_velocity[1]
            changes.append(sign * np.concatenate([vector, rate]) - linear)
        both = np.array(changes).reshape(2, 2, 3)
        off = (np.sqrt((both**2).sum(axis=(0, 2)) / 2) / np.linalg.norm(linear.reshape(2, 3), axis=1)).max()
        assert (off > 0.1) == beyond


def test_small_uncertainty_is_linear_over_the_whole_span():
    ephemeris = scene().run()
    assert ephemeris.uncertainty.linear_until == np.inf
    assert ephemeris.notes == ()


def test_a_covariance_says_the_same_as_its_standard_deviations():
    stated = scene().run()
    rows = stated.uncertainty.covariance.tolist()
    assert np.allclose(
        scene(uncertainty={"covariance": rows}).run().covariance, stated.covariance, rtol=1e-12
    )
    six = [row[:6] for row in rows[:6]]
    fewer = {name: SIGMA[name] for name in ("attitude", "angular_velocity")}
    with_six, with_sigma = (scene(uncertainty=u).run().covariance for u in ({"covariance": six}, fewer))
    assert np.allclose(with_six, with_sigma, rtol=1e-12)


def test_effects_carry_the_uncertainty_too():
    """A torque too weak to matter: the closed form's covariance, by differences of integrated bodies."""
    weak = {"type": "constant_torque", "torque": {"value": [1e-9, 0.0, 0.0], "unit": "N m"}, "frame": "body"}
    free, forced = scene(stop=20.0).run(), scene(stop=20.0, effects=[weak]).run()
    assert forced.plan.solver.startswith("gauss")
    size = np.abs(free.covariance).max()
    assert np.abs(forced.covariance - free.covariance).max() < 1e-6 * size


@pytest.mark.parametrize("ending", ["csv", "ecsv", "parquet", "fits", "ndjson", "json", "arrow", "npz"])
def test_every_columnar_format_holds_the_covariance_and_can_be_read(tmp_path, ending):
    ephemeris, path = scene().run(), tmp_path / f"motion.{ending}"
    ephemeris.write(path)
    read = Ephemeris.read(path)
    assert (read.quaternion("wxyz") == ephemeris.quaternion("wxyz")).all()
    with pytest.raises(RegimeError, match="uncertainty"):
        _ = read.covariance
    check_columns(ephemeris, read_columns(path))


ROWS, COLUMNS = (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)


def read_columns(path):
    """Numbers by name, by readers that are not ours; vectors as (n, k)."""
    if path.suffix == ".csv":
        rows = list(
            csv.DictReader(line for line in path.read_text().splitlines() if not line.startswith("#"))
        )
        return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
    if path.suffix in (".ecsv", ".fits"):
        table = Table.read(path)
        return {name: table[name].value for name in table.colnames}
    if path.suffix == ".parquet":
        return {name: np.array(values.tolist()) for name, values in pandas.read_parquet(path).items()}
    if path.suffix == ".ndjson":
        return pandas.DataFrame(list(map(json.loads, path.read_text().splitlines()))[1:]).to_dict("series")
    if path.suffix == ".arrow":
        return pyarrow.ipc.open_file(path).read_all().to_pandas().to_dict("series")
    return json.loads(path.read_text())["columns"] if path.suffix == ".json" else dict(np.load(path))


def check_columns(ephemeris, columns):
    """Covariances and sigma of directions are those of the ephemeris, to the last digit."""
    for label, covariance, unit in (
        ("attitude_covariance", ephemeris.attitude_covariance, "rad2"),
        ("angular_velocity_covariance", ephemeris.rate_covariance, "rad2_s2"),
    ):
        names = [f"{label}_{element}_{unit}" for element in ("xx", "yy", "zz", "xy", "xz", "yz")]
        values = columns[label] if label in columns else np.array([columns[name] for name in names]).T
        assert (np.asarray(values) == covariance[:, ROWS, COLUMNS]).all()
    for name, axis in zip("xyz", np.eye(3), strict=True):
        label = f"direction_sigma_{name}"
        values = columns[label] if label in columns else columns[f"{label}_deg"]
        assert (np.asarray(values) == np.rad2deg(ephemeris.direction_sigma(axis))).all()


def test_tables_in_memory_hold_the_covariance():
    ephemeris = scene().run()
    table, dataset = ephemeris.to_table(), ephemeris.to_xarray()
    check_columns(ephemeris, {name: table[name].value for name in table.colnames})
    check_columns(ephemeris, ephemeris.to_pandas())
    check_columns(ephemeris, {name: dataset[name].values for name in dataset})
    assert dataset["attitude_covariance"].sel(element="xy").values[1] == ephemeris.covariance[1, 0, 1]
    assert dataset["attitude_covariance"].attrs == {"units": "rad2", "axes": "body axes"}
    angles = ephemeris.with_columns("elapsed,euler:ZYX,euler:ZXZ,attitude_sigma,angle:z:momentum").to_xarray()
    assert angles["euler_zyx"].dims == ("time", "euler_angle")
    assert "axes" not in angles["euler_zyx"].attrs
    assert angles["attitude_sigma"].attrs == {"units": "deg", "axes": "body axes"}
    assert angles["angle_z_momentum"].attrs == {"units": "deg"}


def test_chosen_columns_are_those_of_the_covariance():
    ephemeris = scene().run()
    chosen = ephemeris.with_columns("elapsed,attitude_sigma,angular_velocity_sigma,direction_sigma:-x")
    table = chosen.to_table()
    assert table["attitude_sigma"].unit == "deg"
    assert np.allclose(
        np.deg2rad(table["attitude_sigma"].value) ** 2,
        np.diagonal(ephemeris.attitude_covariance, axis1=1, axis2=2),
    )
    assert np.allclose(
        table["direction_sigma_minus_x"].value, np.rad2deg(ephemeris.direction_sigma([-1, 0, 0]))
    )


@pytest.mark.parametrize("sequence", ["ZYX", "ZXZ", "XYX"])
def test_sigmas_of_euler_angles_are_those_of_differences(sequence):
    ephemeris = scene().run()
    column = ephemeris.with_columns(f"elapsed,euler_sigma:{sequence}").to_table()
    label = f"euler_sigma_{sequence.lower()}"
    assert column[label].unit == "deg"

    def angles(data):
        yield "angles", "deg", data.euler(sequence, "deg")

    expected = spread.sigmas(ephemeris, angles)["angles"]
    assert np.abs(column[label].value / expected - 1.0).max() < 1e-5  # of the differences


def test_undetermined_euler_angles_have_no_sigma():
    upright = {"quaternion": [1.0, 0.0, 0.0, 0.0], "order": "wxyz"}
    still = scene(attitude=upright).run()
    with pytest.raises(RegimeError, match="euler_sigma:ZXZ: where the second angle leaves the others"):
        still.with_columns("elapsed,euler_sigma:ZXZ").to_table()


def test_another_frame_leaves_it_and_an_index_selects_it():
    ephemeris = scene(frame="GCRF").run()
    assert (ephemeris.in_frame("ECLIPJ2000").covariance == ephemeris.covariance).all()
    assert (ephemeris[2:4].covariance == ephemeris.covariance[2:4]).all()
    assert (ephemeris.resampled([50.0]).covariance == ephemeris.covariance[2:3]).all()


def test_a_frame_that_turns_has_no_covariance_and_says_so():
    dated = scene(frame="GCRF", epoch={"time": "2020-01-01T00:00:00", "scale": "utc"}).run()
    turning = dated.in_frame("ITRF")
    assert "attitude_covariance" not in turning.to_table().colnames
    with pytest.raises(RegimeError, match="ITRF is a rotating frame"):
        _ = turning.covariance


def row(k, size=6):
    return [float(i == k) for i in range(size)]


REFUSED = {
    "nothing": ({}, "at least one of attitude"),
    "negative": (
        {"attitude": {"value": [1, -1, 1], "unit": "deg"}},
        r"uncertainty.attitude.value.*zero or greater",
    ),
    "unit": ({"attitude": {"value": [1, 1, 1], "unit": "kg"}}, "uncertainty.attitude.unit"),
    "twice": ({**SIGMA, "covariance": [row(k) for k in range(6)]}, "said twice"),
    "size": ({"covariance": [row(k, 5) for k in range(5)]}, "6, 9 or 12 rows"),
    "asymmetric": ({"covariance": [[1, 0.5, 0, 0, 0, 0], *(row(k) for k in range(1, 6))]}, "mirrored"),
    "indefinite": (
        {"covariance": [[1, 2, 0, 0, 0, 0], [2, 1, 0, 0, 0, 0], *(row(k) for k in range(2, 6))]},
        "positive semidefinite",
    ),
    "variance": ({"covariance": [[-1, 0, 0, 0, 0, 0], *(row(k) for k in range(1, 6))]}, "zero or greater"),
    "moments": ({"moments": {"value": [0.5, 0, 0], "unit": "kg m2"}}, "quarter of the principal moments"),
}


@pytest.mark.parametrize(("uncertainty", "message"), REFUSED.values(), ids=list(REFUSED))
def test_an_uncertainty_that_cannot_be_is_refused_by_its_field(uncertainty, message):
    with pytest.raises(InputError, match=message):
        scene(uncertainty=uncertainty).run()


def test_the_document_keeps_its_uncertainty():
    document = scene().to_json()
    assert json.loads(document)["uncertainty"] == SIGMA
    assert Scene.from_json(document).to_json() == document
