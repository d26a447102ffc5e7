"""Moments that no body has are drawn again: how often, and where that leaves their mean."""

import json

import numpy as np
import pytest
from astropy.table import QTable
from scipy.special import ndtri

from attitude import InputError
from attitude.cli import main
from attitude.ensemble import Ensemble, redraws, storage
from tests.ensemble.fake_source import Stop, stop_at
from tests.ensemble.scenes import PLATE, TENSOR, scene

TIMES = [0.0, 10.0]
NOMINAL = np.array([1.0, 1.0, 2.0])


def disc(n=1000, seed=4, moments="1 %", **spreads):
    return Ensemble.sample(scene(body=PLATE), n, seed, moments=moments, **spreads)


def by_numpy(n, seed, spread):
    """(bodies drawn again, draws rejected, mean deviates (3,)), of numpy's words and scipy's quantiles."""
    actual, attempts = [], []
    for body in range(n):
        for attempt in range(1000):
            words = np.random.Philox(key=seed, counter=3 * body + attempt * 2**192).random_raw(3)
            deviates = ndtri(((words >> np.uint64(11)).astype(float) + 0.5) * 2.0**-53)
            moments = NOMINAL * (1.0 + spread * deviates)
            if (moments > 0.0).all() and (2.0 * moments <= moments.sum()).all():
                break
        actual.append(deviates)
        attempts.append(attempt)
    return np.count_nonzero(attempts), sum(attempts), np.mean(actual, axis=0)


# -- what it says -----------------------------------------------------------------------------------


@pytest.mark.parametrize("spread", [0.01, 0.3])
def test_redraws_are_those_of_a_rejection_by_numpy(spread):
    actual = disc(400, 11, spread).redraws()
    redrawn, rejected, mean = by_numpy(400, 11, spread)
    assert (actual.bodies, actual.redrawn, actual.rejected) == (400, redrawn, rejected)
    assert 100 < redrawn < rejected
    # deviates are (I / I0 - 1) / s of rounded moments, in units of 2^-36
    assert np.abs(actual.shift - mean).max() <= 1e-10
    assert np.abs(actual.mean / (NOMINAL * (1.0 + spread * mean)) - 1.0).max() <= 1e-11
    assert actual.nominal == (1.0, 1.0, 2.0)


def test_mean_of_a_disc_moves_by_that_of_half_a_normal_distribution():
    """I1 + I2 - I3 of a disc is s (n1 + n2 - 2 n3), whose negative half is drawn again.

    n . (1, 1, -2) / sqrt(6) becomes half-normal, of mean sqrt(2 / pi); n3 moves by -2 / sqrt(6) of that.
    """
    n = 200_000
    actual = disc(n).redraws()
    expected = np.sqrt(2.0 / np.pi) * np.array([1.0, 1.0, -2.0]) / np.sqrt(6.0)
    assert expected[2] == pytest.approx(-0.6515, abs=1e-4)
    assert np.abs(actual.shift - expected).max() <= 4.0 / np.sqrt(n)  # of deviates no wider than one
    assert actual.redrawn / n == pytest.approx(0.5, abs=4 * 0.5 / np.sqrt(n))
    assert actual.rejected / n == pytest.approx(1.0, abs=4 * np.sqrt(2.0 / n))


def test_mean_is_that_of_the_states():
    ensemble = disc(moments=["1 %", "0 %", "3 %"])
    actual, moments = ensemble.redraws(100, 900), ensemble.states(100, 900).body.moments
    np.testing.assert_allclose(actual.mean, moments.mean(axis=0), rtol=1e-12)
    assert actual.bodies == 800
    assert (actual.shift[1], actual.mean[1]) == (0.0, 1.0)


def test_body_by_its_tensor_is_counted_too():
    ensemble = Ensemble.sample(scene(body=TENSOR), 2000, 4, moments="10 %")
    actual, tensors = ensemble.redraws(), ensemble.states().body.tensor
    assert actual.redrawn > 100
    axes = ensemble.source.body.axes
    along = np.einsum("ij,njk,ik->ni", axes, tensors, axes)
    np.testing.assert_allclose(actual.mean, along.mean(axis=0), rtol=1e-12)


def test_nothing_is_said_where_nothing_is_drawn_again():
    ensemble = Ensemble.sample(scene(), 500, 4, moments="2 %")
    actual = ensemble.statistics(TIMES)
    assert (actual.redraws.redrawn, actual.redraws.rejected) == (0, 0)
    for text in (str(actual), repr(actual), repr(ensemble)):
        assert "drawn again" not in text


def test_bodies_whose_moments_are_not_drawn_have_no_redraws():
    assert disc(moments=None, attitude="1 deg").redraws() is None
    table = Ensemble.from_table(disc(10).to_table())
    assert table.redraws() is None
    assert table.statistics(TIMES).redraws is None
    assert "redraws" not in table.statistics(TIMES).to_table().meta


@pytest.mark.parametrize(("first", "last"), [(5, 5), (0, 1001), (-1, 3)])
def test_redraws_of_bodies_that_there_are_not_are_refused(first, last):
    with pytest.raises(InputError, match=r"bodies: first and last of 1000 bodies"):
        disc().redraws(first, last)


def test_moments_that_find_no_value_do_not_spoil_a_name():
    thin = scene(body={"moments": [1e-9, 1.0, 1.0], "unit": "kg m2"})
    ensemble = Ensemble.sample(thin, 100, 1, moments="10 %")
    assert "found none in 1000 attempts" in repr(ensemble)
    with pytest.raises(InputError, match="found none in 1000 attempts"):
        ensemble.redraws()


# -- where it is reported ---------------------------------------------------------------------------


def test_it_is_printed_with_everything_that_comes_of_the_bodies(tmp_path):
    ensemble = disc()
    text = str(ensemble.redraws())
    assert text.startswith(
        f"moments drawn again for {ensemble.redraws().redrawn} of 1000 bodies (rejected draws"
    )
    assert " kg m2, +0." in text
    assert text.endswith(" standard deviations from the scene's")
    statistics, density = ensemble.statistics(TIMES), ensemble.density(TIMES)
    result = ensemble.run(TIMES, tmp_path / "out.zarr")
    texts = repr(ensemble), repr(statistics), str(statistics), repr(density), str(result)
    for shown in (*texts, repr(storage.read(tmp_path / "out.zarr"))):
        assert text in shown


def test_it_is_in_the_tables_of_statistics(tmp_path):
    actual = disc().statistics(TIMES)
    actual.to_table().write(tmp_path / "a.ecsv")
    meta = QTable.read(tmp_path / "a.ecsv").meta["redraws"]
    assert redraws.Redraws.of_document(meta) == actual.redraws
    assert meta["shift"][2] == pytest.approx(-0.65, abs=0.1)


@pytest.fixture
def document(tmp_path):
    path = tmp_path / "disc.json"
    plain = {"scene": disc().scene.document(), "bodies": 1000, "seed": 4, "moments": "1 %"}
    path.write_text(json.dumps(plain))
    return str(path)


def test_command_says_it(document, capfd, tmp_path):
    text = str(disc().redraws())
    assert main(["ensemble", document]) == 0
    out, err = capfd.readouterr()
    assert err == f"attitude: {text}\n"
    assert out.splitlines()[1] == f"# {text}"
    assert main(["ensemble", document, "--statistics", "-"]) == 0
    out, err = capfd.readouterr()
    assert redraws.Redraws.of_document(json.loads(out)["redraws"]) == disc().redraws()
    assert err == f"attitude: {text}\n"
    assert main(["ensemble", document, "-q", "-o", str(tmp_path / "a.parquet")]) == 0
    assert capfd.readouterr() == ("", f"attitude: {text}\n")


# -- the same bits ----------------------------------------------------------------------------------


@pytest.mark.parametrize("part", [1, 7, 999, 1000, 2**20])
@pytest.mark.parametrize("workers", [1, 2])
def test_they_do_not_depend_on_parts_and_workers(monkeypatch, part, workers):
    whole = disc().redraws()
    monkeypatch.setattr(redraws, "BODIES_PER_TASK", part)
    monkeypatch.setattr("attitude.ensemble.sources.dispersion.TALLIED_BODIES", 13)
    assert disc().redraws(workers=workers) == whole
    assert disc().statistics(TIMES, workers=workers).redraws == whole


def test_they_do_not_depend_on_what_is_spread_besides():
    assert disc(angular_velocity="0.1 deg/s", attitude="1 deg").redraws() == disc().redraws()


def test_name_of_many_bodies_has_those_of_the_first(monkeypatch):
    monkeypatch.setattr("attitude.ensemble.ensemble.BODIES_PER_TASK", 100)
    assert repr(disc()).endswith(f"of the first 100; {disc().redraws(0, 100)}>")


@pytest.mark.parametrize("ending", ["zarr", "parquet"])
def test_a_store_has_those_of_all_bodies_also_when_it_was_gone_on_with(tmp_path, ending):
    to, whole = tmp_path / f"out.{ending}", disc().redraws()
    with pytest.raises(Stop):
        disc().run(TIMES, to, workers=1, chunk=100, progress=stop_at(0.6))
    result = disc().run(TIMES, to, workers=2)
    assert result.resumed
    assert (result.redraws, storage.read(to).redraws) == (whole, whole)
    one = disc().run(TIMES, tmp_path / f"one.{ending}", chunk=1000)
    assert storage.read(one.path).head["redraws"] == storage.read(to).head["redraws"] == whole.document()
    disc(moments=None).run(TIMES, to, overwrite=True)
    assert storage.read(to).redraws is None
