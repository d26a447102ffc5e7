"""Spacing of nodes: what readers of other tools interpolate stays within what was asked for."""

import numpy as np
import pytest
from astropy import units as u
from scipy.interpolate import BarycentricInterpolator
from scipy.spatial.transform import Rotation, Slerp

from attitude import Ephemeris, FormatError, InputError, RegimeError, RigidBody, Scene, TorqueFreeMotion
from attitude.formats.nodes import Interpolant, chosen
from attitude.formats.samples import Samples

SLERP, LAGRANGE = Interpolant("slerp"), Interpolant("lagrange", 7)
each_interpolant = pytest.mark.parametrize(
    "interpolant", [SLERP, LAGRANGE, Interpolant("lagrange", 3)], ids=str
)
BODY = RigidBody([1.0, 1.6, 2.1])
MOTION = TorqueFreeMotion(BODY, [1, 0, 0, 0], (0.3, -0.5, 0.9), order="wxyz")
SCENES = ["dzhanibekov", "thruster-plan", "drop", "gyrostat"]


def between(interpolant, t, q, at):
    """What a reader finds at instants that lie between nodes; by scipy."""
    if interpolant.kind == "slerp":
        return Slerp(t, Rotation.from_quat(q, scalar_first=True))(at).as_quat(scalar_first=True)
    found, width = [], min(interpolant.degree, len(t) - 1)
    for instant in at:
        interval = min(max(int(np.searchsorted(t, instant, side="right")) - 1, 0), len(t) - 2)
        first = min(max(interval - (width - 1) // 2, 0), len(t) - 1 - width)
        window = slice(first, first + width + 1)
        value = BarycentricInterpolator(t[window] - t[first], q[window])(instant - t[first])
        found.append(value / np.linalg.norm(value))
    return np.array(found)


def angle(p, q):
    """Between attitudes, rad, with digits for small ones: scipy's own product and arcsine."""
    p, q = (Rotation.from_quat(each, scalar_first=True) for each in (p, q))
    return 2 * np.arcsin(np.minimum(np.linalg.norm((p.inv() * q).as_quat()[:, :3], axis=1), 1))


def errors(nodes, ephemeris, places):
    """Of each segment, at these fractions of some of its intervals."""
    for segment in nodes.segments:
        part = segment.whole()
        if len(part) < 2:
            continue
        t, q = part.elapsed, part.quaternion("wxyz")
        picked = np.unique(np.concatenate([np.arange(len(t) - 1)[:20], np.arange(len(t) - 1)[-20:]]))
        for place in places:
            at = t[picked] + place * (t[picked + 1] - t[picked])
            true = ephemeris.resampled(at).quaternion("wxyz")
            yield angle(between(interpolant=nodes.interpolant, t=t, q=q, at=at), true).max()


@each_interpolant
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_interpolation_between_chosen_nodes_keeps_the_tolerance(name, interpolant, tolerance):
    ephemeris = Scene.builtin(name).run()
    nodes = chosen(Samples.of(ephemeris), interpolant, tolerance)
    assert 0.02 * tolerance < nodes.worst <= tolerance  # and is not won by needless nodes
    assert max(errors(nodes, ephemeris, [0.5])) <= nodes.worst * (1 + 1e-6)
    # Errors of slerp are greatest at midpoints, but for the change of the rate within the interval.
    assert max(errors(nodes, ephemeris, [0.1, 0.4, 0.45, 0.6, 0.9])) <= 1.1 * tolerance


@each_interpolant
def test_chosen_nodes_cover_the_span_and_no_more(interpolant):
    ephemeris = Scene.builtin("toutatis").run()
    (segment,) = chosen(Samples.of(ephemeris), interpolant, 1e-5).segments
    t = segment.whole().elapsed
    assert (t[0], t[-1]) == (ephemeris.elapsed[0], ephemeris.elapsed[-1])
    assert (np.diff(t) > 0).all()
    step = t[1] - t[0]
    assert np.allclose(np.diff(t)[:-1], step, rtol=1e-12)
    assert float(f"{step:.2e}") == step  # a number that people can read


@pytest.mark.parametrize("block", [1, 10, 1000])
def test_nodes_do_not_depend_on_the_pieces_they_come_in(block, monkeypatch):
    from attitude.formats import nodes, samples

    ephemeris = MOTION.at(np.linspace(0.0, 20.0, 50))
    whole = [chosen(Samples.of(ephemeris), each, 1e-4) for each in (SLERP, LAGRANGE)]
    monkeypatch.setattr(samples, "BLOCK", block)
    monkeypatch.setattr(nodes, "CHECKED", block)
    for expected in whole:
        found = chosen(Samples.of(ephemeris), expected.interpolant, 1e-4)
        assert found.worst == expected.worst
        pieces = [piece.elapsed for piece in found.segments[0].pieces()]
        assert max(map(len, pieces)) <= block
        assert np.array_equal(np.concatenate(pieces), expected.segments[0].whole().elapsed)


@each_interpolant
def test_of_given_instants_the_worst_midpoint_is_told(interpolant):
    t = np.sort(np.random.default_rng(3).uniform(0.0, 30.0, 200))
    ephemeris = MOTION.at(t)
    nodes = chosen(Samples.of(ephemeris), interpolant)
    assert [segment.whole().elapsed.tolist() for segment in nodes.segments] == [t.tolist()]
    middle = t[:-1] + 0.5 * np.diff(t)
    true = ephemeris.resampled(middle).quaternion("wxyz")
    expected = angle(between(interpolant, t, ephemeris.quaternion("wxyz"), middle), true).max()
    assert nodes.worst == pytest.approx(expected, rel=1e-6, abs=1e-15)
    assert f"{nodes.worst:.1e} rad" in nodes.remark
    assert nodes.written == (200, nodes.worst)


def test_nobody_interpolates_across_an_impulse():
    ephemeris = Scene.builtin("thruster-plan").run()
    firings = [event.seconds for event in ephemeris.events]
    for tolerance in (None, 1e-5):
        nodes = chosen(Samples.of(ephemeris), LAGRANGE, tolerance)
        starts = [float(segment.head.elapsed[0]) for segment in nodes.segments]
        ends = [float(segment.tail.elapsed[0]) for segment in nodes.segments]
        assert len(starts) == len(firings) + 1
        assert all(
            end < firing <= start for end, firing, start in zip(ends, firings, starts[1:], strict=False)
        )
    for segment, firing in zip(nodes.segments, firings, strict=False):  # chosen: up to the impulse itself
        assert firing - float(segment.tail.elapsed[0]) < 1e-9
    for segment in nodes.segments:  # and the rate is the one of this side
        energy = segment.whole().kinetic_energy
        assert np.ptp(energy) <= 1e-9 * energy[0]


def test_one_instant_has_nothing_between():
    nodes = chosen(Samples.of(MOTION.at([3.0])), LAGRANGE)
    assert nodes.written == (1, 0.0)
    nodes = chosen(Samples.of(MOTION.at([3.0])), SLERP, 1e-6)
    assert nodes.written == (1, 0.0)
    assert nodes.segments[0].whole().elapsed.tolist() == [3.0]


def test_spin_at_a_constant_rate_needs_two_nodes_of_slerp():
    spin = TorqueFreeMotion(BODY, [1, 0, 0, 0], (0.0, 0.0, 0.1), order="wxyz")
    nodes = chosen(Samples.of(spin.at(np.linspace(0.0, 30.0, 7))), SLERP, 1e-9)
    assert nodes.written.nodes == 2
    assert nodes.worst < 1e-14


def test_what_was_read_from_a_file_has_no_motion_behind_it(tmp_path):
    MOTION.at(np.arange(9.0)).write(tmp_path / "a.csv")
    back = Ephemeris.read(tmp_path / "a.csv")
    nodes = chosen(Samples.of(back), SLERP)
    assert nodes.worst is None
    assert "not known" in nodes.remark
    with pytest.raises(InputError, match="interpolation_error: none for an ephemeris read from a file"):
        chosen(Samples.of(back), SLERP, 1e-6)
    with pytest.raises(RegimeError, match="only these samples"):
        back.resampled([1.0])


def test_resampled_is_the_motion_itself():
    ephemeris = MOTION.at(np.arange(9.0))
    assert np.array_equal(
        ephemeris[2:5].resampled([0.5, 7.25]).quaternion("wxyz"), MOTION.at([0.5, 7.25]).quaternion("wxyz")
    )
    scene = Scene.builtin("gravity-gradient-capture")
    run = scene.run()
    some = run.elapsed[3:90:7]
    off = angle(run.resampled(some).quaternion("wxyz"), run.quaternion("wxyz")[3:90:7])
    assert off.max() < 2 * run.plan.error_bound  # a solver may take other steps for other instants


def test_tolerance_is_an_angle_within_reason():
    samples = Samples.of(MOTION.at(np.arange(9.0)))
    assert chosen(samples, SLERP, 1 * u.arcmin).worst <= np.deg2rad(1 / 60)
    for wrong in (0.0, -1.0, np.nan, 1e-14, 10.0, "a", 1 * u.m):
        with pytest.raises(InputError, match="interpolation_error"):
            chosen(samples, SLERP, wrong)


@pytest.mark.parametrize("most", [1, 2, 1000])
def test_more_nodes_than_a_file_should_have_are_refused(most):
    with pytest.raises(InputError, match=f"interpolation_error: an angle that no more than {most} nodes"):
        chosen(Samples.of(MOTION.at(np.arange(100.0))), SLERP, 1e-9, most)


def test_disorder_and_batches_are_refused():
    with pytest.raises(FormatError, match=r"instants\[2\] \(1.0 s\) is not after the one before"):
        chosen(Samples.of(MOTION.at([0.0, 2.0, 1.0])), SLERP)
    many = TorqueFreeMotion(
        RigidBody.from_moments([[1.0, 1.6, 2.1]] * 2), [1, 0, 0, 0], (0, 0, 1), order="wxyz"
    )
    with pytest.raises(FormatError, match=r"not shape \(2, 3\)"):
        chosen(Samples.of(many.at([0.0, 1.0, 2.0])), SLERP)
