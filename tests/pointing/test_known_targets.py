"""The targets that a plan says are known are those that the ephemeris answers about."""

import pytest

from attitude import Scene
from attitude.errors import InputError, RegimeError
from attitude.pointing import targets
from attitude.scene.builtin_scenes import builtin_names

EPOCH = {"epoch": {"time": "2024-01-01T00:00:00", "scale": "utc"}}
LOW = {"altitude": {"value": 600, "unit": "km"}}
TLE = [
    "1 25544U 98067A   24001.00000000  .00016717  00000-0  10270-3 0  9004",
    "2 25544  51.6400 208.9163 0006703 130.5360 325.0288 15.49815573432398",
]
MARS = {
    "semi_major_axis": {"value": 4000, "unit": "km"},
    "mu": {"value": 42828.37, "unit": "km3/s2"},
    "radius": {"value": 3389.5, "unit": "km"},
}
CASES = {
    **{name: {"scene": name} for name in builtin_names()},
    "undated": {"orbit": LOW, "frame": "GCRF"},
    "inertial": {"orbit": LOW, "frame": "INERTIAL", **EPOCH},
    "dated": {"orbit": LOW, "frame": "GCRF", **EPOCH},
    "teme": {"orbit": LOW, "frame": "TEME", **EPOCH},
    "ecliptic": {"frame": "ECLIPJ2000", **EPOCH},
    "tle": {"orbit": {"tle": TLE}, "frame": "GCRF", **EPOCH},
    "mars": {"orbit": MARS, "frame": "ICRF", **EPOCH},
    "mu of the Earth": {"orbit": {**MARS, "central_body": "earth"}, "frame": "ICRF", **EPOCH},
}
SPINNER = {
    "body": {"moments": [1, 2, 3], "unit": "kg m2"},
    "attitude": {"quaternion": [1, 0, 0, 0], "order": "wxyz"},
    "angular_velocity": {"value": [0.1, 0.2, 0.3], "unit": "rad/s"},
    "times": {"elapsed": [0, 1], "unit": "s"},
}


def is_known(data, name):
    """Whether its vector is known, which may be zero, as the momentum before the first thruster fires."""
    try:
        targets.target_vector(data, name)
    except (InputError, RegimeError):
        return False
    return True


@pytest.mark.parametrize("case", CASES)
def test_plan_names_the_targets_that_the_ephemeris_answers_about(case):
    document = CASES[case]
    scene = Scene.model_validate(document if "scene" in document else {**SPINNER, **document})
    plan = scene.plan()
    data = scene.run()
    assert plan.targets == tuple(name for name in targets.TARGETS if is_known(data, name))
    assert plan.to_dict()["targets"] == list(plan.targets)
    orbit = scene.ephemeris_orbit()
    assert (plan.central_body is None) is (orbit is None)
    if orbit is not None:
        assert plan.to_dict()["central_body"]["radius_m"] == orbit.central_radius
        assert plan.central_body.is_earth is orbit.is_about_the_earth
