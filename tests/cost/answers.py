"""Errors of a method on the named bodies."""

import numpy as np

from attitude.cost import InitialValueProblem
from attitude.oracle import truth
from tests.bodies import ATTITUDE, TRUTH_DIGITS, Body, motion, speed

RADIANS = (0.0, 0.3, 1.7, 11.0, 53.0)

_turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
_tensor = _turn @ np.diag([1.0, 1.7, 2.3]) @ _turn.T
FULL_TENSOR = Body(tuple(map(tuple, (0.5 * (_tensor + _tensor.T)).tolist())), (0.3, -0.7, 0.9))


def problem(body):
    return InitialValueProblem.of_motion(motion(body))


def instants(body, radians=RADIANS):
    return np.array(radians) / speed(body)


def errors(method, body, t):
    """Largest attitude error, rad, and relative rate error of a method at instants t."""
    attitudes, rates = method.prepare(problem(body))(t)
    assert attitudes.shape == (len(t), 4)
    assert rates.shape == (len(t), 3)
    exact = truth.attitude_and_rate_of_tensor if np.ndim(body.inertia) == 2 else truth.attitude_and_rate
    worst = [0.0, 0.0]
    for instant, q, rate in zip(t.tolist(), attitudes.tolist(), rates.tolist(), strict=True):
        true_q, true_rate = exact(*body, ATTITUDE, instant, TRUTH_DIGITS)
        worst[0] = max(worst[0], truth.attitude_error(q, true_q))
        worst[1] = max(worst[1], truth.rate_error(rate, true_rate))
    return worst
