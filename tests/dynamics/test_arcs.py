"""The span cut where something changes: which arc an instant belongs to, which impulses are met."""

import numpy as np
import pytest

from attitude import RigidBody
from attitude.dynamics.arcs import arcs, instants_within
from attitude.problem.initial_state import InitialState
from attitude.problem.torque_model import AppliedImpulse

STATE = InitialState(RigidBody((1, 2, 2.5)), np.array([1.0, 0, 0, 0]), np.zeros(3), -20.0, 20.0)


class During:
    """A torque that acts in spans."""

    def __init__(self, *spans):
        self.spans = list(spans) or None

    def intervals(self, initial_state):
        return self.spans


def impulse(seconds):
    return AppliedImpulse(seconds, np.ones(3), np.zeros(3), True)


def cut(stop, torques=(), impulses=()):
    return arcs(STATE, torques, impulses, stop)


def edges(found):
    return [(arc.start, arc.stop) for arc in found]


def test_nothing_that_changes_is_one_arc():
    always = During()
    (arc,) = cut(20.0, [always])
    assert (arc.start, arc.stop, arc.torques, arc.impulses) == (0.0, 20.0, (always,), ())


def test_spans_of_a_torque_cut_and_say_where_it_acts():
    now_and_then, always = During((2.0, 4.0), (6.0, 30.0)), During()
    found = cut(20.0, [now_and_then, always])
    assert edges(found) == [(0.0, 2.0), (2.0, 4.0), (4.0, 6.0), (6.0, 20.0)]
    assert [now_and_then in arc.torques for arc in found] == [False, True, False, True]
    assert all(always in arc.torques for arc in found)


def test_backwards_arcs_descend():
    now_and_then = During((-4.0, -2.0), (1.0, 2.0))
    found = cut(-20.0, [now_and_then], [impulse(-10.0), impulse(5.0)])
    assert edges(found) == [(0.0, -2.0), (-2.0, -4.0), (-4.0, -10.0), (-10.0, -20.0)]
    assert [bool(arc.torques) for arc in found] == [False, True, False, False]
    assert [len(arc.impulses) for arc in found] == [0, 0, 0, 1]


@pytest.mark.parametrize(
    ("stop", "seconds", "met"),
    [(20.0, 0.0, True), (20.0, 20.0, True), (20.0, 20.5, False), (-20.0, 0.0, False), (-20.0, -20.0, False)],
)
def test_impulses_at_the_ends(stop, seconds, met):
    """The state at an instant is the one after its impulse; a document gives the one before."""
    assert any(arc.impulses for arc in cut(stop, impulses=[impulse(seconds)])) is met


def test_impulses_of_one_instant_keep_their_order():
    first, second = impulse(5.0), impulse(5.0)
    found = cut(20.0, impulses=[first, second])
    assert found[1].impulses[0] is first
    assert found[1].impulses[1] is second


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_each_instant_belongs_to_one_arc(sign):
    found = cut(sign * 20.0, impulses=[impulse(sign * 5.0), impulse(sign * 10.0)])
    seconds = sign * np.array([20.0, 3.0, 5.0, 7.0, 10.0, 0.0, 5.0])
    places = instants_within(found, seconds, np.zeros(7))
    assert sorted(np.concatenate(places).tolist()) == list(range(7))
    later = [[5, 1], [2, 6, 3], [4, 0]] if sign > 0 else [[5, 1, 2, 6], [3, 4], [0]]
    assert [place.tolist() for place in places] == later


def test_second_part_of_an_instant_orders_within_a_double():
    (arc,) = cut(20.0)
    (place,) = instants_within([arc], np.array([1.0, 1.0]), np.array([1e-20, -1e-20]))
    assert place.tolist() == [1, 0]
