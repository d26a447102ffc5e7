"""The published formulas, vectorised: as good as their scalar form, and no better."""

import random

import numpy as np
import pytest

from attitude import RigidBody, TorqueFreeMotion
from attitude.cost import Problem
from attitude.cost.methods import published as route
from attitude.oracle import truth
from tests.bodies import ATTITUDE, GENERIC, Body, each, random_bodies
from tests.cost.answers import FULL_TENSOR, errors, instants, problem
from tests.oracles import published

(METHOD,) = route.ladder()
# Beside the separatrix and an axis the formulas lose digits; Dzhanibekov is a case of its own, below.
ORDINARY = ("short axis", "plate", "long axis", "Toutatis")
SAME_FORMULAS = 3e-13  # rad: the order of sums differs, and the formulas amplify that
ITS_OWN_ACCURACY = 1e-12  # rad, at tens of radians; measured 7e-15 ... 2.5e-13


@pytest.mark.parametrize("name", [name for name in GENERIC if name != "Dzhanibekov"])
def test_vectorised_and_scalar_form_are_the_same_formulas(name):
    body = GENERIC[name]
    t = instants(body)
    for instant, q, rate in zip(t.tolist(), *METHOD.prepare(problem(body))(t), strict=True):
        scalar_q, scalar_rate = published.attitude_and_rate(*body, ATTITUDE, instant)
        assert truth.attitude_error(q.tolist(), scalar_q) < SAME_FORMULAS
        assert truth.rate_error(rate.tolist(), scalar_rate) < SAME_FORMULAS


def test_vectorised_and_scalar_form_agree_in_every_order_of_axes():
    for body, attitude in random_bodies(random.Random(3), 6, decades=0.5):
        motion = TorqueFreeMotion(RigidBody(body.inertia), attitude, body.omega, order="wxyz")
        q, _ = METHOD.prepare(Problem.of_motion(motion))(np.array([0.0, 1.7]))
        scalar_q, _ = published.attitude_and_rate(*body, attitude, 1.7)
        assert truth.attitude_error(q[1].tolist(), scalar_q) < SAME_FORMULAS


@pytest.mark.parametrize(
    "body", **each({name: GENERIC[name] for name in ORDINARY} | {"full tensor": FULL_TENSOR})
)
def test_generic_bodies_come_out_right(body):
    assert max(errors(METHOD, body, instants(body))) < ITS_OWN_ACCURACY


def test_digits_go_beside_the_separatrix():
    worst, _ = errors(METHOD, body := Body((3.0, 4.0, 6.0), (2.0, 0.7, 1.0 + 1e-8)), instants(body))
    assert 1e-11 < worst < 1e-5


def test_digits_go_beside_an_axis():
    worst, _ = errors(METHOD, body := Body((1.0, 2.0, 3.0), (1.0, 1e-6, -1e-6)), instants(body))
    assert 1e-9 < worst < 1e-2


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
