"""Bodies that cannot be integrated to the scene's tolerance stop an ensemble, or are left out and listed."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from attitude import InputError, RegimeError, Scene, ToleranceError
from attitude.cli import main
from attitude.ensemble import Ensemble
from attitude.ensemble.block_motion import motion_of, solver_choice

# between bodies within the tolerance and those refused are some whose error outgrows it
pytestmark = pytest.mark.filterwarnings("ignore:bodies:attitude.AttitudeWarning")


def hopeless():
    """Of 12 bodies some turn so far that rounding alone is more than this tolerance."""
    document = Scene.builtin("envisat").document()
    document |= {
        "times": {"elapsed": [0.0, 6.0, 24.0], "unit": "h"},
        "tolerance": {"value": 2e-11, "unit": "rad"},
    }
    return Ensemble.sample(Scene.model_validate(document), 12, 7, angular_velocity="2 deg/s")


def test_body_that_cannot_be_integrated_stops_an_ensemble_by_its_name():
    with pytest.raises(ToleranceError, match=r"^bodies\[\d+\]: tolerance: 2.0e-11 rad cannot be reached"):
        hopeless().statistics()


def test_steps_are_not_shortened_for_what_is_rounding():
    """A few radians each, at a tolerance below what rounding grows to: formerly 0.2 rad."""
    ensemble = hopeless()
    candidate = solver_choice(ensemble.scene, ensemble.source, ensemble.instants()).candidate
    turned = np.abs(np.asarray(ensemble.states().angular_velocity)).max() * candidate.step
    assert 1.0 < turned < 8.0


def test_bodies_that_cannot_be_integrated_are_left_out_and_listed():
    ensemble = hopeless()
    actual = ensemble.statistics(lost_bodies="leave out")
    assert 0 < len(actual.lost) < 12
    assert actual.count == 12 - len(actual.lost)
    assert actual.to_table().meta["lost"] == actual.lost.tolist()
    density = ensemble.density(lost_bodies="leave out")
    assert (density.lost == actual.lost).all()
    assert (density.counts.sum(axis=(1, 2)) == actual.count).all()
    # of the others, the mean is that of an ensemble which has no others
    remaining = [i for i in range(12) if i not in actual.lost]
    quaternions = np.array([simulated_alone(ensemble, i) for i in remaining])
    mean = np.array(
        [
            Rotation.from_quat(q, scalar_first=True).mean().as_quat(scalar_first=True)
            for q in quaternions.transpose(1, 0, 2)
        ]
    )
    assert np.abs(np.abs((mean * actual.mean).sum(axis=1)) - 1.0).max() < 1e-12


def simulated_alone(ensemble, i):
    instants = ensemble.instants()
    choice = solver_choice(ensemble.scene, ensemble.source, instants)
    return motion_of(ensemble.scene, ensemble.states(i, i + 1), instants, i, choice=choice).quaternion[0]


def test_no_statistics_where_no_body_can_be_integrated():
    document = Scene.builtin("drop").document() | {"times": {"elapsed": [1e3], "unit": "s"}}
    ensemble = Ensemble.sample(Scene.model_validate(document), 3, 7, attitude="1 deg")
    with pytest.raises(RegimeError, match=r"^bodies\[0\]: times: the body comes to rest"):
        ensemble.statistics()
    with pytest.raises(RegimeError, match="none of the 3 bodies can be integrated"):
        ensemble.statistics(lost_bodies="leave out")


def test_lost_bodies_is_one_of_two_words():
    with pytest.raises(InputError, match="lost_bodies: one of stop, leave out"):
        hopeless().statistics(lost_bodies="keep")


def test_command_leaves_them_out_by_its_flag(capfd, tmp_path):
    path = tmp_path / "a.json"
    ensemble = hopeless()
    path.write_text(ensemble.scene.to_json())
    arguments = ["ensemble", str(path), "--bodies", "12", "--seed", "7", "--angular-velocity", "2 deg/s"]
    assert main(arguments) == 2
    assert capfd.readouterr().err.startswith("attitude: bodies[")
    assert main([*arguments, "--leave-out-lost-bodies"]) == 0
    out, err = capfd.readouterr()
    lost = ensemble.statistics(lost_bodies="leave out").lost.tolist()
    names = ", ".join(map(str, lost[:10])) + (" ..." if len(lost) > 10 else "")
    last = err.splitlines()[-1]
    assert last == f"attitude: left out, for they cannot be followed: {len(lost)} bodies ({names})"
    assert out.startswith(f"# {12 - len(lost)} bodies in GCRF")


def test_store_has_all_bodies(capfd):
    assert main(["ensemble", "envisat", "--bodies", "2", "-o", "a.zarr", "--leave-out-lost-bodies"]) == 2
    assert "no --output beside it" in capfd.readouterr().err
