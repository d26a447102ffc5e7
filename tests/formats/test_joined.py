"""Several files of one body, read as one ephemeris."""

import numpy as np
import pytest

from attitude import Ephemeris, InputError, RegimeError
from attitude.cli import main
from tests.formats.test_aem import T, motion


def parts(tmp_path, ending="aem"):
    whole = motion(frame="EME2000").at(T)
    paths = [tmp_path / f"{k}.{ending}" for k in range(3)]
    for path, (first, last) in zip(paths, ((0, 15), (15, 25), (25, 40)), strict=True):
        whole[first:last].write(path)
    return whole, paths


@pytest.mark.parametrize("ending", ["aem", "xml", "csv", "parquet", "npz", "czml"])
def test_files_are_joined_in_the_order_of_time(ending, tmp_path):
    whole, paths = parts(tmp_path, ending)
    back = Ephemeris.read([paths[1], paths[2], paths[0]])
    assert len(back) == 40
    expected = whole.in_frame(back.frame)
    assert (back.rotation * expected.rotation.inv()).magnitude().max() <= 1e-14
    assert np.abs((back.time - whole.time).to_value("s")).max() <= 1e-9
    assert [event.text for event in back.events] == [f"{path} begins" for path in paths[1:]]


def test_joined_files_are_interpolated_within_each_and_never_across(tmp_path):
    _, paths = parts(tmp_path)
    back = Ephemeris.read(paths)
    alone = Ephemeris.read(paths[1])
    t = np.linspace(0.0, alone.elapsed[-1], 7)
    shift = (alone.epoch - back.epoch).to_value("s")
    asked = back.resampled(t + shift)
    assert np.abs(asked.quaternion("wxyz") - alone.resampled(t).quaternion("wxyz")).max() <= 1e-9
    with pytest.raises(RegimeError, match="in the gap of the file"):
        back.resampled(0.5 * (T[14] + T[15]))


@pytest.mark.parametrize("count", [1, 2, 3])
def test_files_in_a_rotating_frame_are_interpolated_in_the_frame_they_are_read_into(count, tmp_path):
    """CZML, whose attitudes are relative to the Earth-fixed frame."""
    whole, paths = parts(tmp_path, "czml")
    back = Ephemeris.read(paths[:count])
    asked = back.resampled(back.elapsed).rotation * back.rotation.inv()
    assert asked.magnitude().max() < 1e-14
    between = whole.resampled(T[:14] + 0.5 * np.diff(T[:15])).in_frame(back.frame).rotation
    shift = (whole.epoch - back.epoch).to_value("s")
    interpolated = back.resampled(T[:14] + 0.5 * np.diff(T[:15]) + shift).rotation
    alone = Ephemeris.read(paths[0]).resampled(T[:14] + 0.5 * np.diff(T[:15]) + shift).rotation
    assert (interpolated * alone.inv()).magnitude().max() < 1e-6
    assert (interpolated * between.inv()).magnitude().max() < 0.1


@pytest.mark.parametrize("ending", [".aem", ".csv", ".bc", ".a", ".acm", ".fits"])
def test_files_that_share_an_epoch_are_joined_with_both_attitudes(ending, tmp_path):
    """As ground systems cut them, at midnight for one."""
    whole, _ = parts(tmp_path)
    paths = [tmp_path / f"{name}{ending}" for name in "ab"]
    whole[:21].write(paths[0])
    whole[20:].write(paths[1])
    back = Ephemeris.read(paths)
    shared = float((whole.time[20] - back.epoch).to_value("s"))
    assert len(back) == 41
    assert back.elapsed[19:22] == pytest.approx([back.elapsed[19], shared, shared], abs=2e-9)
    assert (np.diff(back.elapsed) > 0.0).all()
    assert [event.seconds for event in back.events] == [back.elapsed[21]]
    assert any("is read twice" in note for note in back.plan.notes)
    for t in (shared - 0.01, shared, shared + 0.01):
        assert (
            back.resampled(t).rotation * whole.resampled(t + (back.epoch - whole.epoch).sec).rotation.inv()
        ).magnitude() < 1e-3
    back.write(tmp_path / "c.aem")
    assert len(Ephemeris.read(tmp_path / "c.aem")) == 41


def test_files_that_do_not_follow_each_other_are_refused(tmp_path):
    whole, paths = parts(tmp_path)
    whole[10:20].write(tmp_path / "o.aem")
    with pytest.raises(InputError, match=r"o\.aem: instants not before 2\.0 s"):
        Ephemeris.read([paths[0], tmp_path / "o.aem"])
    whole.in_frame("ICRF")[15:].write(tmp_path / "f.aem")
    with pytest.raises(InputError, match="attitudes relative to EME2000, as in"):
        Ephemeris.read([paths[0], tmp_path / "f.aem"])
    with pytest.raises(InputError, match="path: a file, or several"):
        Ephemeris.read([])


def test_command_joins_files(tmp_path):
    _, paths = parts(tmp_path)
    assert main(["convert", *map(str, paths), "-o", str(tmp_path / "all.aem")]) == 0
    assert (tmp_path / "all.aem").read_text().count("META_START") == 3
    assert len(Ephemeris.read(tmp_path / "all.aem")) == 40
