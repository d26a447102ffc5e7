"""UTC taken for UT1, beyond the tables of the Earth's rotation: by argument, document, command and HTTP."""

import json
import re
import warnings

import erfa
import numpy as np
import pytest
from astropy.time import Time

from attitude import Ephemeris, InputError, Scene
from attitude.cli.command import main
from attitude.frames.earth_fixed import itrf
from attitude.times.instants import Instants

pytestmark = pytest.mark.filterwarnings("ignore:ERFA function:erfa.ErfaWarning")
BEYOND = 'which astropy\'s tables of UT1 cover; ut1="utc" takes UTC for UT1 beyond them'


def document(year=2028, **more):
    return {
        "body": {"moments": [1, 2, 2.5], "unit": "kg m2"},
        "epoch": {"time": f"{year}-06-01T00:00:00", "scale": "utc"},
        "frame": "EME2000",
        "attitude": {"quaternion": [1, 0, 0, 0], "order": "wxyz"},
        "angular_velocity": {"value": [1, 2, 3], "unit": "deg/s"},
        "times": {"start": 0, "stop": 60, "count": 7, "unit": "s"},
        **more,
    }


@pytest.mark.parametrize("year", [1957, 1973, 2020, 2028, 2045])
def test_rotation_with_utc_for_ut1_is_that_of_erfa(year):
    epoch = Time(f"{year}-06-01T03:04:05", scale="utc")
    instants = Instants(np.array([0.0, 5000.0, 90000.0]), None, epoch)
    found = itrf(instants, "utc").quaternion
    for q, time in zip(found, instants.time, strict=True):
        expected = erfa.c2t06a(time.tt.jd1, time.tt.jd2, time.utc.jd1, time.utc.jd2, 0.0, 0.0)
        w, x, y, z = q
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        assert np.abs(np.eye(3) + 2.0 * (w * cross + cross @ cross) - expected).max() < 1e-11
    assert itrf(instants, "utc").rate[0, 2] == pytest.approx(7.292115e-5, rel=1e-7)


def test_it_is_within_that_second_of_the_tables():
    instants = Instants(np.arange(5.0) * 86400, None, Time("2020-01-01", scale="utc"))
    one, other = itrf(instants).quaternion, itrf(instants, "utc").quaternion
    angle = 2 * np.arccos(np.minimum(np.abs((one * other).sum(axis=1)), 1.0))
    # UT1 - UTC was -0.177 s, 1.3e-5 rad; the pole 0.3 arcseconds off, 1.5e-6 rad
    assert np.allclose(angle, 0.177 * 7.292e-5, rtol=0.05)


def test_ephemeris_keeps_the_choice_and_says_so(tmp_path):
    ephemeris = Scene.model_validate(document()).run()
    with pytest.raises(InputError, match=re.escape(BEYOND)):
        ephemeris.in_frame("ITRF")
    fixed = ephemeris.in_frame("ITRF", ut1="utc")
    same = Scene.model_validate(document(ut1="utc")).run().in_frame("ITRF")
    assert np.array_equal(fixed.quaternion("wxyz"), same.quaternion("wxyz"))
    back = fixed.in_frame("EME2000")
    assert np.abs(back.quaternion("wxyz") - ephemeris.quaternion("wxyz")).max() < 1e-15
    assert np.array_equal(fixed.resampled([10.0, 20.0]).quaternion("wxyz"), fixed.quaternion("wxyz")[1:3])
    for ending in ("csv", "ecsv", "npz", "parquet"):
        fixed.write(tmp_path / f"a.{ending}")
        read = Ephemeris.read(tmp_path / f"a.{ending}")
        assert (read.frame, read.ut1) == ("ITRF", "utc")
    assert "UTC is taken for UT1" in (tmp_path / "a.csv").read_text()
    fixed.write(tmp_path / "a.a")
    assert "UTC is taken for UT1" in (tmp_path / "a.a").read_text()


@pytest.mark.parametrize("ut1", ["UTC", "ut1", 1, None])
def test_other_sources_are_refused(ut1):
    if ut1 is not None:
        with pytest.raises(InputError, match='ut1: "tables", those that come with astropy, or "utc"'):
            Scene.model_validate(document()).run().in_frame("ITRF", ut1=ut1)
    with pytest.raises(InputError, match="ut1: one of 'tables' or 'utc'"):
        Scene.model_validate(document(ut1=ut1))


def test_czml_is_written_and_read_with_it(tmp_path):
    scene = Scene.model_validate(document())
    ephemeris = scene.run()
    ephemeris.write(tmp_path / "a.czml", ut1="utc")
    assert "UTC taken for UT1, off by at most 0.9 s, and no polar motion" in (tmp_path / "a.czml").read_text()
    back = Ephemeris.read(tmp_path / "a.czml", ut1="utc", frame="EME2000")
    assert np.abs(back.quaternion("wxyz") - ephemeris.quaternion("wxyz")).max() < 1e-14
    Scene.model_validate(document(ut1="utc")).write(tmp_path / "b.czml")
    assert (tmp_path / "b.czml").read_bytes() == (tmp_path / "a.czml").read_bytes()
    with pytest.raises(InputError, match="ut1: "):
        ephemeris.write(tmp_path / "a.czml", ut1="UT1")


@pytest.mark.parametrize("year", [1957, 2028, 2045])
def test_command_takes_it_for_any_format_and_prints_no_warning_of_erfa(year, tmp_path, capsys):
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(document(year)))
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        assert main(["run", str(path), "-q", "-o", str(tmp_path / "a.czml")]) == 2
        assert BEYOND in capsys.readouterr().err
        for name, more in (("a.czml", []), ("a.csv", ["--frame", "ITRF"])):
            assert main(["run", str(path), "-q", "--set", "ut1=utc", "-o", str(tmp_path / name), *more]) == 0
        assert (
            main(
                ["convert", str(tmp_path / "a.czml"), "-q", "--set", "ut1=utc", "-o", str(tmp_path / "b.csv")]
            )
            == 0
        )
        err = capsys.readouterr().err
    assert "ErfaWarning" not in err
    assert err.count("\n") <= 3
    assert Ephemeris.read(tmp_path / "a.csv").frame == "ITRF"
    assert main(["run", str(path), "--set", "ut1=no"]) == 2
    assert '--set ut1: "tables", those that come with astropy, or "utc"' in capsys.readouterr().err
