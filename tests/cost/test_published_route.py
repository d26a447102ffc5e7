"""The published formulas in doubles: right for generic bodies, and failing where they must."""

import random

import numpy as np
import pytest

from attitude import RigidBody, TorqueFreeMotion
from attitude.cost import InitialValueProblem
from attitude.cost.methods import published as route
from attitude.oracle import truth
from tests.bodies import GENERIC, Body, each, random_bodies
from tests.cost.answers import FULL_TENSOR, errors, instants, problem

(METHOD,) = route.methods()
# Beside the separatrix and an axis the formulas lose digits; Dzhanibekov is a case of its own, below.
ORDINARY = ("short axis", "plate", "long axis", "Toutatis")
ITS_OWN_ACCURACY = 1e-12  # rad, at tens of radians; measured 7e-15 ... 2.5e-13


def test_any_order_of_axes_is_right():
    for body, attitude in random_bodies(random.Random(3), 6, decades=0.5):
        motion = TorqueFreeMotion(RigidBody(body.inertia), attitude, body.omega, order="wxyz")
        q, _ = METHOD.prepare(InitialValueProblem.of_motion(motion))(np.array([0.0, 1.7]))
        expected, _ = truth.attitude_and_rate(*body, attitude, 1.7)
        assert truth.attitude_error(q[1].tolist(), expected) < ITS_OWN_ACCURACY


@pytest.mark.parametrize(
    "body", **each({name: GENERIC[name] for name in ORDINARY} | {"full tensor": FULL_TENSOR})
)
def test_generic_bodies_come_out_right(body):
    assert max(errors(METHOD, body, instants(body))) < ITS_OWN_ACCURACY


@pytest.mark.parametrize(
    ("body", "least", "most"),
    [
        (Body((3.0, 4.0, 6.0), (2.0, 0.7, 1.0 + 1e-8)), 1e-11, 1e-5),
        (Body((1.0, 2.0, 3.0), (1.0, 1e-6, -1e-6)), 1e-9, 1e-2),
    ],
    ids=["separatrix", "axis"],
)
def test_digits_are_lost_near_singular_cases(body, least, most):
    assert least < errors(METHOD, body, instants(body))[0] < most


def test_digits_are_lost_with_time():
    body = GENERIC["short axis"]
    assert errors(METHOD, body, instants(body, (1.0,)))[0] < 1e-14
    assert 1e-12 < errors(METHOD, body, instants(body, (1e6,)))[0] < 1e-7


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        (Body((3.0, 4.0, 6.0), (2.0, 0.7, 1.0)), "on the separatrix"),
        (Body((2.0, 2.0, 3.0), (0.3, -0.4, -1.2)), "two moments are equal"),
        (Body((1.0, 2.0, 2.5), (0.0, 0.0, 0.7)), "spin about a principal axis"),
        (Body((1.0, 2.0, 3.0), (1.0, 1e-9, -1e-9)), "divide by zero"),
        (GENERIC["Dzhanibekov"], "invalid value"),  # the sine of an amplitude is over one by a rounding
    ],
)
def test_where_the_formulas_fail_they_say_so(body, reason):
    with pytest.raises(ArithmeticError, match=reason):
        METHOD.prepare(problem(body))(instants(body))
