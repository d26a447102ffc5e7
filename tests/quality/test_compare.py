"""Two ephemerides compared: rotations and rates known beforehand, frames, instants, the command."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from attitude import Ephemeris, InputError, RegimeError, RigidBody, TorqueFreeMotion
from attitude.cli import main
from attitude.quality.compare import compare
from tests.formats.test_aem import EPOCH
from tests.quality.test_check import T, motion, rebuilt


def turned(data, vector):
    q = (data.rotation * Rotation.from_rotvec(vector)).as_quat(scalar_first=True)
    return rebuilt(data, q=q)


def test_rotation_is_a_vector_along_the_first_body_axes():
    data = motion().at(T)
    vector = np.array([1e-3, -2e-3, 3e-3])
    comparison = compare(data, turned(data, vector))
    assert np.abs(comparison.rotation - vector).max() <= 1e-15
    table = comparison.to_dict()
    assert table["angle_rad"]["rms_axes"] == pytest.approx(np.abs(vector).tolist(), abs=1e-15)
    assert table["angle_rad"]["greatest"] == pytest.approx(np.linalg.norm(vector), abs=1e-15)
    assert table["rate_rad_s"]["greatest"] == 0.0


def test_sign_of_quaternions_does_not_matter():
    data = motion().at(T)
    assert compare(data, rebuilt(data, q=-data.quaternion("wxyz"))).angle.max() == 0.0


def test_rates_are_subtracted():
    data = motion().at(T)
    other = rebuilt(data, rate=data.angular_velocity + np.array([0.0, 1e-4, 0.0]))
    assert np.abs(compare(data, other).rate_difference - [0.0, 1e-4, 0.0]).max() <= 1e-15


def test_where_the_greatest_difference_is():
    data = motion().at(T)
    q = data.quaternion("wxyz").copy()
    q[37] = (Rotation.from_quat(q[37], scalar_first=True) * Rotation.from_rotvec([0.1, 0, 0])).as_quat(
        scalar_first=True
    )
    table = compare(data, rebuilt(data, q=q)).to_dict()
    assert table["angle_rad"]["at_s"] == T[37]


def test_frames_and_instants_are_brought_together(tmp_path):
    """The same motion, in another frame and format, from another epoch and at other instants."""
    whole = motion().at(T)
    whole.in_frame("ICRF").write(tmp_path / "a.czml", interpolation_error=1e-7)
    whole.write(tmp_path / "b.aem", interpolation_error=1e-7)
    comparison = compare(Ephemeris.read(tmp_path / "a.czml"), Ephemeris.read(tmp_path / "b.aem"))
    assert comparison.angle.max() <= 3e-7
    assert comparison.frame == "GCRF"
    exact = compare(Ephemeris.read(tmp_path / "b.aem"), whole)
    assert exact.note == "the second by its own motion"
    assert exact.angle.max() <= 1e-8  # dates of the file are rounded to 1 ns


def test_only_common_instants_are_compared(tmp_path):
    motion().at(T[50:]).write(tmp_path / "b.npz")
    comparison = compare(motion().at(T), Ephemeris.read(tmp_path / "b.npz"))
    assert (len(comparison.angle), comparison.left_out) == (150, 50)
    assert "50 instants of the first are not covered by the second" in str(comparison)
    motion().at(T + 100.0).write(tmp_path / "c.npz")
    with pytest.raises(InputError, match="ephemerides that overlap in time"):
        compare(motion().at(T), Ephemeris.read(tmp_path / "c.npz"))


def test_what_cannot_be_compared_is_refused():
    bodies = TorqueFreeMotion(
        RigidBody([(1.0, 1.6, 2.1)] * 2), [1.0, 0, 0, 0], (0.3, -0.5, 0.9), EPOCH, order="wxyz"
    )
    with pytest.raises(RegimeError, match="compare: one body"):
        compare(motion().at(T), bodies.at(T))
    with pytest.raises(RegimeError, match="compare: one body"):
        compare(motion().at(T), motion().at([]))
    undated = TorqueFreeMotion(RigidBody((1.0, 1.6, 2.1)), [1.0, 0, 0, 0], (0.3, -0.5, 0.9), order="wxyz")
    with pytest.raises(InputError, match="dates in both"):
        compare(motion().at(T), undated.at(T))


def test_command_prints_draws_and_judges(tmp_path, capsys):
    data = motion().at(T)
    data.write(tmp_path / "a.aem")
    turned(data, np.array([1e-3, 0.0, 0.0])).write(tmp_path / "b.npz")
    files = [str(tmp_path / "a.aem"), str(tmp_path / "b.npz")]
    assert main(["compare", *files]) == 0
    assert "angle: at most 1.000e-03 rad" in capsys.readouterr().out
    assert main(["compare", *files, "--tolerance", "1e-4", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["instants"] == 200
    assert main(["compare", *files, "--tolerance", "0.1 deg", "--plot", str(tmp_path / "d.svg")]) == 0
    assert (tmp_path / "d.svg").read_text().count("<svg") == 1
    assert main(["compare", files[0], str(tmp_path / "none.npz")]) == 2


def test_convert_takes_a_step_or_instants(tmp_path, capsys):
    motion().at(T).write(tmp_path / "a.aem", interpolation_error=1e-7)
    source, target = str(tmp_path / "a.aem"), str(tmp_path / "b.npz")
    assert main(["convert", source, "-o", target, "--step", "500 ms"]) == 0
    back = Ephemeris.read(target)
    assert back.elapsed.tolist() == [0.5 * k for k in range(40)]
    assert compare(back, motion().at(T)).angle.max() <= 1.1e-7
    assert main(["convert", source, "-o", target, "--times", "0.25, 3"]) == 0
    assert Ephemeris.read(target).elapsed.tolist() == [0.25, 3.0]
    dates = "2016-12-31T23:59:55.123456789,2017-01-01T00:00:00.123456789"
    assert main(["convert", source, "-o", target, "--times", dates]) == 0
    assert Ephemeris.read(target).elapsed == pytest.approx([5.0, 11.0], abs=1e-9)  # a leap second between
    for wrong in (
        ["--times", "x"],
        ["--step", "-1 s"],
        ["--step", "1 m"],
        ["--times", "1e9"],
        ["--step", "1e-30"],
    ):
        assert main(["convert", source, "-o", target, *wrong]) == 2
        assert capsys.readouterr().err.count("\n") == 1
