"""The figure of a drop: with gravity, without, and by the closed form, through a collision."""

import re

import numpy as np
import pytest

from attitude import RegimeError, RigidBody
from attitude.dynamics.contact import GroundPlane, box
from attitude.dynamics.drop_comparison import compare
from attitude.plot.drop import picture
from attitude.problem.initial_state import InitialState
from attitude.samples.translation import parabola

GROUND = GroundPlane(np.array([0.0, 0.0, 1.0]), 0.0, box((1, 0.6, 0.3)), 0.5, 0.2)
FALLING = np.array([0.0, 0.0, -9.81])
SECONDS = np.arange(241) * 0.01


def thrown(up=6.0):
    state = (np.array([1.0, 0, 0, 0]), np.array([3.0, 0.5, 1.0]), 0.0, 2.4)
    position, velocity = np.array([0.0, 0, 3]), np.array([1.0, 0, up])
    return InitialState(
        RigidBody((0.45, 1.09, 1.36)), *state, mass=12.0, position=position, velocity=velocity
    )


@pytest.fixture(scope="module")
def drop():
    return compare(thrown(), GROUND, FALLING, SECONDS)


def test_gravity_makes_no_difference_to_the_attitude_through_the_collision(drop):
    assert drop.falling.contacts == pytest.approx(drop.weightless.contacts, abs=1e-12)
    assert len(drop.falling.contacts) == 1
    # the attitude at the collision is the same to a few roundings, and so is what follows from it
    assert np.abs(drop.falling.quaternion - drop.weightless.quaternion).max() <= 5e-14


def test_the_model_is_left_at_the_collision_and_not_before(drop):
    difference = np.abs(drop.falling.quaternion - drop.model.quaternion).max(axis=1)
    (moment,) = drop.falling.contacts
    assert (difference[drop.falling.seconds < moment] == 0.0).all()
    assert difference[-1] > 0.5


def test_a_body_that_stays_in_the_air_has_nothing_to_compare():
    with pytest.raises(RegimeError, match="does not touch the ground"):
        compare(thrown(up=30.0), GROUND, FALLING, SECONDS)


def test_picture_shows_three_curves_and_the_collision(drop):
    svg = picture(drop, "svg", "Brick").decode()
    text = " ".join(re.findall(r">([^<>]+)</text>", svg))
    for words in (
        "Brick",
        "with gravity",
        "without gravity",
        "closed form",
        "contact, 1.542 s",
        "q_w",
        "q_z",
    ):
        assert words in text
    assert picture(drop, "svg", "Brick").decode() == svg
    assert picture(drop, "png").startswith(b"\x89PNG")


def test_translation_is_the_parabola():
    """Thrown up at 9.81 m/s, it is back after 2 s at the speed it left with."""
    start, velocity = np.array([1.0, 2.0, 3.0]), np.array([0.5, 0.0, 9.81])
    position, speed = parabola(start, velocity, FALLING, np.array([0.0, 1.0, 2.0]))
    assert np.allclose(position, [[1, 2, 3], [1.5, 2, 3 + 4.905], [2, 2, 3]], atol=1e-14)
    assert np.allclose(speed[:, 2], [9.81, 0.0, -9.81], atol=1e-14)
