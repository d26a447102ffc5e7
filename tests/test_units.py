"""Units of documents: those of astropy, and those in which spinners and older mass properties are stated."""

import math

import pytest

from attitude import InputError, Scene, units

POUND, FOOT, INCH, GRAVITY = 0.45359237, 0.3048, 0.0254, 9.80665  # kg, m, m, m/s2, by definition
SLUG = POUND * GRAVITY / FOOT
KNOWN = {
    "rpm": (units.RATE, 2 * math.pi / 60),
    "RPM": (units.RATE, 2 * math.pi / 60),
    "rev/min": (units.RATE, 2 * math.pi / 60),
    "rev/s": (units.RATE, 2 * math.pi),
    "rev/day": (units.RATE, 2 * math.pi / 86400),
    "cycle/min": (units.RATE, 2 * math.pi / 60),
    "deg/min": (units.RATE, math.pi / 180 / 60),
    "deg/sec": (units.RATE, math.pi / 180),
    "deg / h": (units.RATE, math.pi / 180 / 3600),
    "slug ft2": (units.MOMENT, SLUG * FOOT**2),
    "slug·ft²": (units.MOMENT, SLUG * FOOT**2),
    "slug-ft2": (units.MOMENT, SLUG * FOOT**2),
    "kg·m²": (units.MOMENT, 1.0),
    "kg-m^2": (units.MOMENT, 1.0),
    "N⋅m": (units.TORQUE, 1.0),
    "deg s⁻¹": (units.RATE, math.pi / 180),
    "rps": (units.RATE, 2 * math.pi),
    "turn/min": (units.RATE, 2 * math.pi / 60),
    "slug.ft2": (units.MOMENT, SLUG * FOOT**2),
    "slug*ft^2": (units.MOMENT, SLUG * FOOT**2),
    "lb ft2": (units.MOMENT, POUND * FOOT**2),
    "lbm ft**2": (units.MOMENT, POUND * FOOT**2),
    "lb in2": (units.MOMENT, POUND * INCH**2),
    "oz in2": (units.MOMENT, POUND / 16 * INCH**2),
    "lbf ft s2": (units.MOMENT, POUND * GRAVITY * FOOT),
    "lbf in s2": (units.MOMENT, POUND * GRAVITY * INCH),
    "kg cm2": (units.MOMENT, 1e-4),
    "lb": (units.MASS, POUND),
    "slug": (units.MASS, SLUG),
    "ft": (units.LENGTH, FOOT),
    "in": (units.LENGTH, INCH),
    "ft/s": (units.SPEED, FOOT),
    "ft/s/s": (units.ACCELERATION, FOOT),
    "m/s/s": (units.ACCELERATION, 1.0),
    "lbf ft": (units.TORQUE, POUND * GRAVITY * FOOT),
    "lb/ft3": (units.DENSITY, POUND / FOOT**3),
}


@pytest.mark.parametrize(("name", "like", "size"), [(name, *row) for name, row in KNOWN.items()], ids=KNOWN)
def test_unit_has_its_size_by_definition(name, like, size):
    assert units.parse_unit(name, like, "unit") == pytest.approx(size, rel=1e-15, abs=0)


@pytest.mark.parametrize(
    ("name", "like"),
    [
        ("lb in2", units.RATE),
        ("rpm", units.MOMENT),
        ("ft1000000", units.LENGTH),
        ("lb / ft s", units.DENSITY),
        ("slug  ft", units.MOMENT),
        ("furlong", units.LENGTH),
        ("", units.LENGTH),
    ],
)
def test_other_units_are_refused_with_what_is_expected(name, like):
    with pytest.raises(InputError, match=r"unit: a unit of .*, such as "):
        units.parse_unit(name, like, "unit")


@pytest.mark.parametrize(
    ("name", "like", "near"),
    [
        ("rpn", units.RATE, "rpm"),
        ("degs/s", units.RATE, "deg/s"),
        ("degrees/sec", units.RATE, "deg/s"),
        ("slugs ft2", units.MOMENT, "slug ft2"),
        ("lbs in2", units.MOMENT, "lb in2"),
        ("KG M2", units.MOMENT, "kg m2"),
        ("Nm", units.TORQUE, "N m"),
    ],
)
def test_unit_that_is_like_another_names_it(name, like, near):
    with pytest.raises(InputError, match=rf"such as .*; did you mean '{near}'\?; got '{name}'"):
        units.parse_unit(name, like, "unit")


def test_scene_in_rpm_and_slug_ft2_is_that_in_si():
    document = Scene.builtin("toutatis").document()
    document["body"] = {"moments": [1, 2, 2.5], "unit": "slug ft2"}
    document["angular_velocity"] = {"value": [0, 0, 60], "unit": "rpm"}
    motion = Scene.model_validate(document).motion()
    assert motion.body.moments.tolist() == pytest.approx(
        [1.3558179483, 2.7116358966, 3.3895448708], rel=1e-10
    )
    assert motion.at(0.0).angular_velocity.tolist() == pytest.approx([0, 0, 2 * math.pi], rel=1e-15)
