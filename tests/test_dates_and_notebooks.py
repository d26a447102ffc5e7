"""Instants as dates of any kind; scenes by name, path or data; how notebooks show objects."""

import re
from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest
from astropy.time import Time

from attitude import Ephemeris, FormatError, InputError, RigidBody, Scene, TorqueFreeMotion, fit
from attitude.ensemble import Ensemble
from attitude.estimation import Attitudes

ISO = "2024-03-01T12:00:00"
EPOCH = Time(ISO, scale="utc")


def motion(epoch=EPOCH):
    return TorqueFreeMotion(RigidBody([1.0, 1.6, 2.1]), [1, 0, 0, 0], [0.1, -0.2, 0.3], epoch, "wxyz")


DATES = {
    "text": ISO.replace("12:", "13:"),
    "text with Z": ISO.replace("12:", "13:") + "Z",
    "datetime": datetime(2024, 3, 1, 13),
    "datetime of a zone": datetime(2024, 3, 1, 15, tzinfo=timezone(timedelta(hours=2))),
    "datetime in UTC": datetime(2024, 3, 1, 13, tzinfo=UTC),
    "datetime64": np.datetime64("2024-03-01T13:00:00"),
    "Time": Time("2024-03-01T13:00:00", scale="utc"),
    "Time in TAI": Time("2024-03-01T13:00:37", scale="tai"),
}


@pytest.mark.parametrize("date", DATES.values(), ids=DATES)
def test_an_instant_is_a_date_of_any_kind(date):
    expected = motion().at(3600.0)
    found = motion().at(date)
    assert found.shape == ()
    # a Time is good to 1e-11 s
    np.testing.assert_allclose(found.attitude, expected.attitude, rtol=0, atol=1e-11)
    several = motion().at([date, date] if not isinstance(date, Time) else Time([date, date]))
    np.testing.assert_allclose(several.elapsed, 3600.0, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.resampled(date).elapsed, 3600.0, rtol=0, atol=1e-9)


@pytest.mark.parametrize("epoch", [ISO, ISO + "Z", datetime(2024, 3, 1, 12), np.datetime64(ISO)], ids=str)
def test_an_epoch_is_a_date_of_any_kind(epoch):
    assert motion(epoch).epoch == EPOCH
    assert motion(epoch).epoch.scale == "utc"


def test_text_is_in_the_time_scale_of_the_epoch_unless_it_ends_in_z():
    tai = motion(Time(ISO, scale="tai"))
    assert tai.at("2024-03-01T12:00:10").elapsed == pytest.approx(10.0, abs=1e-9)
    assert tai.at("2024-03-01T12:00:10Z").elapsed == pytest.approx(47.0, abs=1e-9)


def test_windows_take_dates():
    condition = {"axis": "z", "to": [0, 0, 1], "below": {"value": 30, "unit": "deg"}}
    one = motion().crossings(condition, ISO, datetime(2024, 3, 1, 13))
    assert len(one) == len(motion().crossings(condition, 0.0, 3600.0)) > 0


# -- scenes ------------------------------------------------------------------------------------------


def test_a_scene_is_loaded_by_name_path_or_data(tmp_path, monkeypatch):
    scene = Scene.builtin("toutatis")
    (tmp_path / "toutatis.json").write_text(scene.to_json())
    monkeypatch.chdir(tmp_path)
    named = {"scene": "toutatis"}
    for source in ("toutatis", "toutatis.json", tmp_path / "toutatis.json", scene.document(), scene, named):
        assert Scene.load(source).document() == scene.document()


@pytest.mark.parametrize(
    ("source", "error", "message"),
    [
        ("toutatiss", InputError, "did you mean 'toutatis'"),
        ("nowhere.json", FormatError, "nowhere.json: cannot be read"),
        ("a/toutatis", FormatError, "a/toutatis: cannot be read"),
        (5, InputError, "source: a path, the name of a built-in scene, or plain data; got 5"),
        ({"body": {}}, InputError, "body.unit"),
    ],
)
def test_what_is_no_scene_is_named(source, error, message):
    with pytest.raises(error, match=message):
        Scene.load(source)


# -- notebooks ---------------------------------------------------------------------------------------


def test_notebooks_show_tables_and_a_picture():
    scene = Scene.builtin("envisat")
    of_motion = scene.motion()._repr_html_()
    assert "<th style='text-align:left'>regime</th>" in of_motion
    assert f"{float(scene.motion().polhode_period):.9g}" in of_motion
    assert "instants" in scene._repr_html_()
    assert "predicted error, rad" in scene.plan()._repr_html_()
    assert "data:image/png;base64,iVBOR" in scene.run()._repr_html_()
    assert "<img" not in scene.run()[0]._repr_html_()
    assert (
        "bodies"
        in TorqueFreeMotion(
            RigidBody([[1, 2, 2.5], [1, 2, 2]]), [1, 0, 0, 0], [0, 0, 1], order="wxyz"
        )._repr_html_()
    )


def test_notebooks_show_fits_and_ensembles_briefly():
    seconds = np.arange(0.0, 60.0, 5.0)
    observed = Attitudes.of(motion().at(seconds), 1e-4)
    found = fit(observed, RigidBody([1.0, 1.6, 2.1]), estimate=["attitude", "angular_velocity"])
    assert f"{found.sigma[0]:.2e}" in found._repr_html_()
    assert len(repr(found)) < 300
    bodies = Ensemble.sample(Scene.builtin("toutatis"), n=1234, seed=1, moments="2 %")
    assert "1234" in bodies._repr_html_()
    assert len(repr(motion().partials([0.0, 1.0]))) < 100


def test_names_are_escaped():
    document = Scene.builtin("toutatis").document() | {"name": "<script>alert(1)</script>"}
    for text in (Scene.load(document)._repr_html_(), Scene.load(document).run()._repr_html_()):
        assert "<script" not in text
        assert re.search("&lt;script&gt;", text)


def test_notebooks_show_an_ephemeris_of_a_file(tmp_path):
    motion().at([0.0, 1.0, 2.0]).write(tmp_path / "a.csv")
    assert (
        "none is known: these are the attitudes of the file"
        in Ephemeris.read(tmp_path / "a.csv")._repr_html_()
    )


def test_notebooks_without_matplotlib_show_the_table_alone(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    text = motion().at([0.0, 1.0])._repr_html_()
    assert text.startswith("<table>")
    assert "<img" not in text
