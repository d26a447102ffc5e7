"""Quaternions that were printed with few digits, in files of every format, documents, arrays and tables."""

import warnings

import numpy as np
import pytest
from astropy import units as u
from astropy.table import QTable
from astropy.time import Time

from attitude import AttitudeWarning, Ephemeris, FormatError, InputError, RigidBody, Scene, TorqueFreeMotion
from attitude.ensemble import Ensemble
from attitude.formats.registry import FORMATS
from attitude.frames import rotations
from attitude.samples.ephemeris_data import EphemerisData
from attitude.times.instants import Instants

EPOCH = Time("2024-01-01T00:00:00", scale="utc")
EXACT = np.array([[30.0, 25.0, 16.0, 10.0], [1.0, 2.0, 3.0, 4.0], [7.0, -1.0, 2.0, 5.0]])
EXACT /= np.linalg.norm(EXACT, axis=1)[:, None]
OTHERS = ("aem", "aem-xml", "stk", "czml", "ck")
BODY = RigidBody((1.0, 1.6, 2.1))


def ephemeris(q):
    return Ephemeris.of(EphemerisData(np.array(q), Instants(np.arange(3.0), None, EPOCH), "ITRF"))


def written(q, format, tmp_path):
    """A file with these quaternions, whatever their length; CZML in ITRF, the others in GCRF."""
    path = tmp_path / f"a{FORMATS[format].endings[0]}"
    source = ephemeris(q)
    if format != "czml":
        source = Ephemeris.of(EphemerisData(source.attitude, source.instants, "GCRF"))
    source.write(path, **({"rates": False} if format in ("aem", "aem-xml", "stk", "ck") else {}))
    return path


def read(path, format):
    return Ephemeris.read(path, **({"frame": "ITRF"} if format == "czml" else {}))


@pytest.mark.parametrize("decimals", [3, 5])
@pytest.mark.parametrize("format", FORMATS)
def test_quaternions_of_few_decimals_are_brought_to_unit_length_with_a_warning(format, decimals, tmp_path):
    rounded = np.round(EXACT, decimals)
    off = np.abs(np.linalg.norm(rounded, axis=1) - 1.0).max()
    assert off > 1e-6
    path = written(rounded, format, tmp_path)
    with pytest.warns(
        AttitudeWarning, match=rf"{path.name}: (unitQ|q)uaternion: .* by up to {off:.2g}; each"
    ):
        q = read(path, format).quaternion("wxyz")
    assert np.abs(np.linalg.norm(q, axis=1) - 1.0).max() < (1e-15 if format in OTHERS else 1e-6)
    assert rotations.angle_between(q, EXACT).max() < 2.0 * 10.0**-decimals


@pytest.mark.parametrize("format", OTHERS)
def test_seven_decimals_of_other_tools_are_brought_to_unit_length_without_a_warning(format, tmp_path):
    rounded = np.round(EXACT, 7)
    q = read(written(rounded, format, tmp_path), format).quaternion("wxyz")
    assert np.abs(np.linalg.norm(q, axis=1) - 1.0).max() < 4e-16
    assert rotations.angle_between(q, rounded / np.linalg.norm(rounded, axis=1)[:, None]).max() < 1e-15


@pytest.mark.parametrize("format", FORMATS)
def test_quaternions_off_unit_by_more_than_a_hundredth_are_refused(format, tmp_path):
    wrong = EXACT * np.array([[1.0], [1.011], [1.0]])
    path = written(wrong, format, tmp_path)
    with pytest.raises(
        FormatError, match=r"a unit quaternion, within 0\.01 of length 1; got.* 1\.011"
    ) as caught:
        read(path, format)
    assert caught.value.source == str(path)


def test_array_within_a_thousandth_of_unit_length_is_taken_with_a_warning():
    rounded = np.round(EXACT[0], 3)
    with pytest.warns(AttitudeWarning, match="^attitude: lengths of quaternions differ from 1 by up to"):
        motion = TorqueFreeMotion(BODY, rounded, (0.3, -0.5, 0.9), order="wxyz")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        same = TorqueFreeMotion(BODY, rounded / np.linalg.norm(rounded), (0.3, -0.5, 0.9), order="wxyz")
    t = np.linspace(0.0, 100.0, 7)
    assert (
        rotations.angle_between(motion.at(t).quaternion("wxyz"), same.at(t).quaternion("wxyz")).max() < 4e-15
    )
    with pytest.raises(
        InputError, match=r"attitude: a unit quaternion, within 0\.001 of length 1; got 1\.002"
    ):
        TorqueFreeMotion(BODY, EXACT[0] * 1.002, (0.3, -0.5, 0.9), order="wxyz")


@pytest.mark.parametrize(
    "attitude",
    [
        {"quaternion": [0.7303, 0.1826, 0.3651, 0.5477], "order": "wxyz"},
        {"matrix": [[0.1333, -0.6667, 0.7333], [0.9333, 0.3333, 0.1333], [-0.3333, 0.6667, 0.6667]]},
    ],
    ids=["quaternion", "matrix"],
)
@pytest.mark.parametrize("effects", [[], [{"type": "gravity_gradient"}]], ids=["free", "effects"])
def test_document_with_four_decimals_is_run_with_a_warning(attitude, effects):
    document = {
        "body": {"moments": [1, 2, 2.5], "unit": "kg m2"},
        "attitude": attitude,
        "angular_velocity": {"value": [1, 2, 3], "unit": "deg/s"},
        "times": {"start": 0, "stop": 60, "count": 7, "unit": "s"},
        "effects": effects,
        "orbit": {"altitude": {"value": 700, "unit": "km"}},
    }
    form = next(iter(attitude))
    with pytest.warns(AttitudeWarning, match=rf"^attitude\.{form}: "):
        ran = Scene.model_validate(document).run()
    assert np.abs(np.linalg.norm(ran.quaternion("wxyz"), axis=1) - 1.0).max() < 1e-14


def test_table_of_bodies_with_four_decimals_warns_once_and_is_of_unit_length():
    table = QTable({"moments": [[1.0, 1.6, 2.1]] * 3 * u.kg * u.m**2, "quaternion": np.round(EXACT, 4)})
    table.meta["quaternion_order"] = "wxyz"
    table["angular_velocity"] = [[0.1, 0.2, 0.3]] * 3 * u.rad / u.s
    with pytest.warns(AttitudeWarning, match=r"^table\.quaternion: lengths"):
        ensemble = Ensemble.from_table(table)
    q = ensemble.states(0, 3).attitude
    assert np.abs(np.linalg.norm(q, axis=1) - 1.0).max() < 1e-6
    assert rotations.angle_between(q, EXACT).max() < 2e-4  # half a unit of the last place in each of four
