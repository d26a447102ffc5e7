"""Scenes of one body under torques, in an inertial frame of its own."""

from attitude import Scene
from tests.effects.scenes import quantity

MOMENTS = (10.0, 14.0, 17.0)
TIGHT = 1e-11  # rad, a solver's own tolerance


def document(
    *effects, moments=MOMENTS, rate=(0.0, 0.0, 0.0), elapsed=(0.0,), tolerance=TIGHT, q=(1, 0, 0, 0), **more
):
    """A body with its attitude q, wxyz, and its rate at the epoch; times elapsed in s."""
    return {
        "body": {"moments": list(moments), "unit": "kg m2"},
        "frame": "INERTIAL",
        "attitude": {"quaternion": list(q), "order": "wxyz"},
        "angular_velocity": quantity(list(rate), "rad/s"),
        "times": {"elapsed": [float(t) for t in elapsed], "unit": "s"},
        "effects": list(effects),
        "tolerance": tolerance if tolerance == "best" else quantity(tolerance, "rad"),
    } | more


def scene(*effects, **more):
    return Scene.model_validate(document(*effects, **more))


def orbit(a=7e6, **more):
    """About the Earth, in the plane z = 0 and at x, towards y, at the epoch, if not said otherwise."""
    return {"semi_major_axis": quantity(a, "m"), **more}


def plate(area, normal, centre, **more):
    return {"area": quantity(area, "m2"), "normal": normal, "centre": quantity(centre, "m"), **more}
