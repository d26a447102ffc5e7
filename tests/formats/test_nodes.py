"""Spacing of nodes: what readers of other tools interpolate stays within what was asked for."""

from itertools import pairwise

import numpy as np
import pytest
from astropy import units as u
from scipy.interpolate import BarycentricInterpolator
from scipy.spatial.transform import Rotation, Slerp

from attitude import Ephemeris, FormatError, InputError, RegimeError, RigidBody, Scene, TorqueFreeMotion
from attitude.formats.interpolant import HERMITE_FRACTIONS
from attitude.formats.interpolation_nodes import ERROR_MARGIN, FRACTIONS, Interpolant, chosen, upwards
from attitude.samples.chunks import Samples

SLERP, LAGRANGE = Interpolant("slerp"), Interpolant("lagrange", 7)
each_interpolant = pytest.mark.parametrize(
    "interpolant", [SLERP, LAGRANGE, Interpolant("lagrange", 3)], ids=str
)
BODY = RigidBody([1.0, 1.6, 2.1])
MOTION = TorqueFreeMotion(BODY, [1, 0, 0, 0], (0.3, -0.5, 0.9), order="wxyz")
SCENES = ["dzhanibekov", "thruster-plan", "drop", "gyrostat"]


def between(interpolant, t, q, at):
    """What a reader finds at instants that lie between nodes: scipy's slerp, or Lagrange's formula."""
    if interpolant.kind == "slerp":
        return Slerp(t, Rotation.from_quat(q, scalar_first=True))(at).as_quat(scalar_first=True)
    width = min(interpolant.degree, len(t) - 1)
    interval = np.clip(np.searchsorted(t, at, side="right") - 1, 0, len(t) - 2)
    window = np.clip(interval - (width - 1) // 2, 0, len(t) - 1 - width)[:, None] + np.arange(width + 1)
    weights = np.ones(window.shape)
    for j in range(width + 1):
        for k in set(range(width + 1)) - {j}:
            weights[:, j] *= (at - t[window[:, k]]) / (t[window[:, j]] - t[window[:, k]])
    interpolated = (weights[:, :, None] * q[window]).sum(axis=1)
    return interpolated / np.linalg.norm(interpolated, axis=1, keepdims=True)


def angle(p, q):
    """Between attitudes, rad, with digits for small ones: scipy's own product and arcsine."""
    p, q = (Rotation.from_quat(each, scalar_first=True) for each in (p, q))
    return 2 * np.arcsin(np.minimum(np.linalg.norm((p.inv() * q).as_quat()[:, :3], axis=1), 1))


def true_error(nodes, ephemeris, count=2000, seed=1):
    """rad; the greatest of what readers find, at so many random instants of the whole span."""
    segments = [part for part in (segment.ephemeris() for segment in nodes.segments) if len(part) > 1]
    spans = np.array([np.ptp(part.elapsed) for part in segments])
    worst = 0.0
    for part, span in zip(segments, spans, strict=True):
        t, q = part.elapsed, part.quaternion("wxyz")
        selected = max(2, int(count * span / spans.sum()))
        at = np.sort(np.random.default_rng(seed).uniform(t[0], t[-1], selected))
        true = ephemeris.resampled(at).quaternion("wxyz")
        worst = max(worst, float(angle(between(nodes.interpolant, t, q, at), true).max()))
    return worst


def most_turned(nodes, ephemeris):
    """rad; how far the body turns from one node to the next at its greatest rate."""
    steps = [np.diff(segment.ephemeris().elapsed).max() for segment in nodes.segments if segment.count > 1]
    at = np.linspace(ephemeris.elapsed[0], ephemeris.elapsed[-1], 3000)
    return max(steps) * np.linalg.norm(ephemeris.resampled(at).angular_velocity, axis=1).max()


@pytest.mark.parametrize("degree", range(1, 9))
def test_reader_of_these_tests_is_scipys(degree):
    generator = np.random.default_rng(degree)
    t, q = np.cumsum(generator.uniform(0.5, 1.5, 20)), generator.normal(size=(20, 4))
    at = np.sort(generator.uniform(t[0], t[-1], 50))
    for instant, interpolated in zip(at, between(Interpolant("lagrange", degree), t, q, at), strict=True):
        interval = min(int(np.searchsorted(t, instant, side="right")) - 1, 18)
        first = min(max(interval - (degree - 1) // 2, 0), 19 - degree)
        value = BarycentricInterpolator(t[first : first + degree + 1], q[first : first + degree + 1])(instant)
        assert interpolated == pytest.approx(value / np.linalg.norm(value), abs=1e-10)


@each_interpolant
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_interpolation_between_chosen_nodes_keeps_the_tolerance(name, interpolant, tolerance):
    ephemeris = Scene.builtin(name).run()
    nodes = chosen(Samples.of(ephemeris), interpolant, tolerance)
    assert 0.3 * tolerance < nodes.max_error <= tolerance  # and is not won by needless nodes
    assert true_error(nodes, ephemeris) <= nodes.max_error


def spinning(moments, rate):
    return TorqueFreeMotion(RigidBody(np.diag(moments)), [1, 0, 0, 0], rate, order="wxyz")


# Moments, rate (rad/s), and how many turns.
BODIES = {
    "sphere": ([1, 1, 1], (0.01, 0.02, 0.05), 15.7),
    "sphere, whole turns": ([1, 1, 1], (0.0, 0.0, np.deg2rad(6.0)), 60.0),
    "about the first axis": ([1, 2, 2.5], (1.0, 0, 0), 14.0),
    "about the second axis": ([1, 2, 2.5], (0, 0.3, 0), 2.0),
    "about the third axis": ([1, 2, 2.5], (0, 0, np.deg2rad(6.0)), 60.0),
    "near an axis": ([1, 2, 2.5], (1e-5, 0, 0.1), 14.3),
    "near the separatrix": ([1.0, 1.6, 2.1], (1e-7, 0.3, 1e-7), 40.0),
    "needle": ([0.01, 1.0, 1.003], (3.0, 0.2, -0.4), 20.0),
    "disc": ([1.0, 1.0, 1.99], (0.3, 0.0, 2.0), 25.0),
    "tumbling": ([1.0, 1.6, 2.1], (0.3, -0.5, 0.9), 10.0),
    "at rest": ([1, 2, 2.5], (0, 0, 0), 0.0),
    "a hundredth of a turn": ([1, 2, 2.5], (0.1, 0.3, 1.0), 0.01),
}
INTERPOLANTS = [SLERP, *(Interpolant("lagrange", degree) for degree in (1, 2, 4, 5, 7, 15))]
each_body = pytest.mark.parametrize("name", BODIES)


def span(name):
    moments, rate, turns = BODIES[name]
    size = np.linalg.norm(rate)
    return spinning(moments, rate), 2 * np.pi * turns / size if turns else 100.0


@each_body
@pytest.mark.parametrize("interpolant", INTERPOLANTS, ids=str)
def test_promise_holds_at_every_instant_of_every_motion(name, interpolant):
    motion, seconds = span(name)
    for tolerance in (1e-2, 1e-6 if interpolant.degree > 1 else 1e-4):
        ephemeris = motion.at([0.0, seconds])
        nodes = chosen(Samples.of(ephemeris), interpolant, tolerance)
        turned = most_turned(nodes, ephemeris)
        assert true_error(nodes, ephemeris) <= nodes.max_error <= tolerance
        assert turned <= np.pi / 2 * 1.001
        # Else a quarter of a turn, or a few windows for all of the span, are what limits the spacing.
        if turned < 0.99 * np.pi / 2 and nodes.written.nodes > 10 * interpolant.degree:
            assert nodes.max_error >= 0.4 * tolerance


@each_body
@pytest.mark.parametrize("interpolant", INTERPOLANTS, ids=str)
def test_of_given_instants_no_error_is_greater_than_the_stated_one(name, interpolant):
    motion, seconds = span(name)
    for in_a_turn in (0.25, 3.0, 20.0):
        count = 2 + int(in_a_turn * BODIES[name][2])
        uneven = np.sort(np.random.default_rng(3).uniform(0.0, seconds, count + interpolant.degree))
        for t in (np.linspace(0.0, seconds, count), uneven):
            ephemeris = motion.at(t)
            nodes = chosen(Samples.of(ephemeris), interpolant)
            assert true_error(nodes, ephemeris, 700) <= nodes.max_error


@each_interpolant
def test_stated_error_is_the_greatest_and_little_more(interpolant):
    for t in (np.linspace(0, 30, 200), np.sort(np.random.default_rng(3).uniform(0.0, 30.0, 200))):
        ephemeris = MOTION.at(t)
        nodes = chosen(Samples.of(ephemeris), interpolant)
        assert [segment.ephemeris().elapsed.tolist() for segment in nodes.segments] == [t.tolist()]
        at = np.sort((t[:-1, None] + np.diff(t)[:, None] * np.linspace(0, 1, 60)).ravel())
        true = ephemeris.resampled(at).quaternion("wxyz")
        greatest = angle(between(interpolant, t, ephemeris.quaternion("wxyz"), at), true).max()
        assert greatest <= nodes.max_error < 1.08 * greatest
        assert nodes.written == (200, nodes.max_error, None)


@pytest.mark.parametrize("interpolant", INTERPOLANTS, ids=str)
def test_readers_of_nodes_whole_turns_apart_are_half_a_turn_off(interpolant):
    spin = spinning([1, 2, 2.5], (0, 0, np.deg2rad(6.0)))
    nodes = chosen(Samples.of(spin.at(np.arange(0.0, 3601.0, 120.0))), interpolant)
    assert nodes.max_error == pytest.approx(np.pi, abs=1e-6)
    assert nodes.max_error >= np.pi * (1 - 1e-15)


def test_greatest_error_between_the_places_is_within_the_margin():
    """Nodal polynomials of all intervals of even windows, times factors linear in time."""
    zero, aside = np.meshgrid(np.linspace(-1.0, 2.0, 31), [0.0, 0.1, 1.0, 100.0])

    def greatest(degree, interval, at):
        nodal = np.prod([interval + at - j for j in range(degree + 1)], axis=0)
        return (np.abs(nodal) * np.hypot(aside[..., None], at - zero[..., None])).max(axis=-1)

    for degree in range(1, 16):
        for interval in range(degree):
            true = greatest(degree, interval, np.linspace(0.0, 1.0, 401))
            assert (true <= ERROR_MARGIN * greatest(degree, interval, FRACTIONS)).all()


def test_figure_for_people_is_rounded_upwards():
    assert [upwards(angle) for angle in (7.01e-7, 7e-7, 9.91e-7, 0.0)] == [
        "7.1e-07",
        "7.0e-07",
        "1.0e-06",
        "0.0e+00",
    ]


@each_interpolant
def test_chosen_nodes_cover_the_span_and_no_more(interpolant):
    ephemeris = Scene.builtin("toutatis").run()
    (segment,) = chosen(Samples.of(ephemeris), interpolant, 1e-5).segments
    t = segment.ephemeris().elapsed
    assert (t[0], t[-1]) == (ephemeris.elapsed[0], ephemeris.elapsed[-1])
    assert (np.diff(t) > 0).all()
    step = t[1] - t[0]
    assert np.allclose(np.diff(t)[:-2], step, rtol=1e-12)
    assert (np.diff(t)[-2:] > 0.49 * step).all()  # for none to be so close that rounding matters
    assert (np.diff(t)[-2:] < 1.01 * step).all()
    assert float(f"{step:.2e}") == step  # a number that people can read


@pytest.mark.parametrize("block", [1, 10, 1000])
def test_nodes_do_not_depend_on_the_pieces_they_come_in(block, monkeypatch):
    from attitude.formats import interpolation_nodes
    from attitude.samples import chunks

    ephemeris = MOTION.at(np.linspace(0.0, 20.0, 50))
    whole = [chosen(Samples.of(ephemeris), each, 1e-4) for each in (SLERP, LAGRANGE)]
    monkeypatch.setattr(chunks, "CHUNK_INSTANTS", block)
    monkeypatch.setattr(interpolation_nodes, "INTERVALS_PER_CHECK", block)
    for expected in whole:
        interpolated = chosen(Samples.of(ephemeris), expected.interpolant, 1e-4)
        assert interpolated.max_error == expected.max_error
        pieces = [piece.elapsed for piece in interpolated.segments[0].chunks()]
        assert max(map(len, pieces)) <= block
        assert np.array_equal(np.concatenate(pieces), expected.segments[0].ephemeris().elapsed)


def test_nobody_interpolates_across_an_impulse():
    ephemeris = Scene.builtin("thruster-plan").run()
    firings = [event.seconds for event in ephemeris.events]
    for tolerance in (None, 1e-5):
        nodes = chosen(Samples.of(ephemeris), LAGRANGE, tolerance)
        starts = [float(segment.first.elapsed[0]) for segment in nodes.segments]
        ends = [float(segment.last.elapsed[0]) for segment in nodes.segments]
        assert len(starts) == len(firings) + 1
        assert all(
            end < firing <= start for end, firing, start in zip(ends, firings, starts[1:], strict=False)
        )
    for segment, firing in zip(nodes.segments, firings, strict=False):  # chosen: up to the impulse itself
        assert 0.0 < firing - float(segment.last.elapsed[0]) < 1e-9
    for segment in nodes.segments:  # and the rate is the one of this side
        energy = segment.ephemeris().kinetic_energy
        assert np.ptp(energy) <= 1e-9 * energy[0]


def test_an_impulse_at_the_last_instant_adds_no_node():
    """Hermite's polynomials would have the rate after it at the last node."""
    impulse = KICKED | {"time": {"value": 360.0, "unit": "s"}}
    hermite = Interpolant("hermite", 7)
    plain, kicked = (chosen(Samples.of(flight(effects)), hermite, 1e-6) for effects in ([], [impulse]))
    assert kicked.written.nodes < 1.1 * plain.written.nodes < 100
    assert 360.0 - 1e-12 < float(kicked.segments[-1].last.elapsed[0]) < 360.0


def test_one_instant_has_nothing_between():
    nodes = chosen(Samples.of(MOTION.at([3.0])), LAGRANGE)
    assert nodes.written == (1, 0.0, None)
    nodes = chosen(Samples.of(MOTION.at([3.0])), SLERP, 1e-6)
    assert nodes.written == (1, 0.0, None)
    assert nodes.segments[0].ephemeris().elapsed.tolist() == [3.0]


def test_spin_at_a_constant_rate_needs_two_nodes_of_slerp_for_a_quarter_of_a_turn():
    spin = spinning([1.0, 1.6, 2.1], (0.0, 0.0, 0.1))
    nodes = chosen(Samples.of(spin.at(np.linspace(0.0, 15.0, 7))), SLERP, 1e-9)
    assert nodes.written.nodes == 2
    assert nodes.max_error < 1e-14
    assert chosen(Samples.of(spin.at(np.linspace(0.0, 200 * np.pi, 7))), SLERP, 1e-9).written.nodes < 45


def test_what_was_read_from_a_file_has_no_motion_behind_it(tmp_path):
    MOTION.at(np.arange(9.0)).write(tmp_path / "a.csv")
    back = Ephemeris.read(tmp_path / "a.csv")
    nodes = chosen(Samples.of(back), SLERP)
    assert nodes.max_error is None
    assert "not known" in nodes.remark
    with pytest.raises(InputError, match="interpolation_error: none for an ephemeris read from a file"):
        chosen(Samples.of(back), SLERP, 1e-6)
    with pytest.raises(RegimeError, match=r"9\.0 s is outside the file"):
        back.resampled([9.0])


def test_resampled_is_the_motion_itself():
    ephemeris = MOTION.at(np.arange(9.0))
    assert np.array_equal(
        ephemeris[2:5].resampled([0.5, 7.25]).quaternion("wxyz"), MOTION.at([0.5, 7.25]).quaternion("wxyz")
    )
    scene = Scene.builtin("gravity-gradient-capture")
    run = scene.run()
    selected = run.elapsed[3:90:7]
    off = angle(run.resampled(selected).quaternion("wxyz"), run.quaternion("wxyz")[3:90:7])
    assert off.max() < 2 * run.plan.error_bound  # a solver may take other steps for other instants


def test_tolerance_is_an_angle_within_reason():
    samples = Samples.of(MOTION.at(np.arange(9.0)))
    assert chosen(samples, SLERP, 1 * u.arcmin).max_error <= np.deg2rad(1 / 60)
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


# -- files, as their readers interpolate them -----------------------------------------------------

FILES = {
    "ck.bc": (SLERP, {}),
    "a.czml": (SLERP, {}),
    **{f"{order}.a": (Interpolant("lagrange", order), {"interpolation_order": order}) for order in (1, 2, 7)},
    **{f"{degree}.aem": (Interpolant("lagrange", degree), {"degree": degree}) for degree in (1, 4, 7)},
    "b.xml": (Interpolant("lagrange", 5), {"degree": 5}),
}
SPUN_UP = {"type": "constant_torque", "torque": {"value": [1e-3, 0, 0], "unit": "N m"}, "frame": "body"}
KICKED = {"type": "impulse", "time": {"value": 101.3, "unit": "s"}, "frame": "body"} | {
    "angular_impulse": {"value": [0.02, 0.0, 0.1], "unit": "N m s"}
}
FLIGHTS = {
    "spinner": ([1.0, 2.0, 2.5], [0, 0, np.deg2rad(6)], []),
    "sphere": ([1.0, 1.0, 1.0], [0.01, 0.02, 0.05], []),
    "near an axis": ([1.0, 2.0, 2.5], [1e-5, 0, 0.1], []),
    "spun up": ([1.0, 2.0, 2.5], [0.001, 0, 0], [SPUN_UP]),
    "kicked": ([1.0, 2.0, 2.5], [0.01, 0.0, 0.1], [KICKED]),
}


def flight(name, step=1.0):
    """A flight of the table, or the kicked one under other effects."""
    moments, rate, effects = FLIGHTS[name] if isinstance(name, str) else (*FLIGHTS["kicked"][:2], name)
    document = {
        "body": {"moments": moments, "unit": "kg m2"},
        "epoch": {"time": "2020-01-01T00:00:00", "scale": "utc"},
        "frame": "EME2000",
        "attitude": {"quaternion": [1, 0, 0, 0], "order": "wxyz"},
        "angular_velocity": {"value": rate, "unit": "rad/s"},
        "times": {"start": 0, "stop": 360, "step": step, "unit": "s"},
        "effects": effects,
    }
    return Scene.model_validate(document).run()


@pytest.mark.parametrize("name", FLIGHTS)
@pytest.mark.parametrize("file", FILES)
@pytest.mark.parametrize("tolerance", [None, 1e-5])
def test_file_keeps_what_is_promised_of_it(file, name, tolerance, tmp_path):
    if file.endswith(".bc"):
        pytest.importorskip("spiceypy")
    interpolant, options = FILES[file]
    ephemeris = flight(name, 12.0)
    if name == "kicked" and file in ("2.a", "7.a"):
        with pytest.raises(FormatError, match="have no segments"):
            ephemeris.write(tmp_path / file, None, None, tolerance, **options)
        return
    written = ephemeris.write(tmp_path / file, None, None, tolerance, **options)
    back = Ephemeris.read(tmp_path / file)
    q, true = back.quaternion("wxyz"), ephemeris.in_frame(back.frame)
    instants = (back.time - ephemeris.epoch).to_value("s")
    cuts = [event.seconds for event in back.events if event.kind == "segment"]  # STK's readers know none
    for first, last in pairwise([0, *np.searchsorted(back.elapsed, cuts), len(back)]):
        t = instants[first:last]
        at = np.sort(np.random.default_rng(1).uniform(t[0], t[-1], 1000))
        interpolated = angle(
            between(interpolant, t, q[first:last], at), true.resampled(at).quaternion("wxyz")
        )
        assert (
            interpolated.max() <= written.interpolation_error + 1e-9
        )  # dates to the nanosecond, at 0.6 rad/s
    assert tolerance is None or written.interpolation_error <= tolerance
    assert (name == "kicked" and not file.endswith(".a")) == (len(cuts) == 1)


@pytest.mark.parametrize("degree", [3, 7, 11, 15])
def test_errors_of_hermites_polynomials_are_greatest_near_the_fractions(degree):
    """Of the squared nodal polynomial times a factor linear in time, in every window that SPICE takes."""
    x, half = np.linspace(0.0, 1.0, 2001), (degree + 1) // 4
    for left in range(half):
        for right in range(half):
            nodes = np.arange(-left, right + 2)
            for zero in np.append(np.linspace(-3.0, 4.0, 71), 1e9):
                dense, few = (
                    np.abs(np.prod([(at - node) ** 2 for node in nodes], axis=0) * (at - zero))
                    for at in (x, HERMITE_FRACTIONS)
                )
                assert dense.max() <= 1.05 * few.max()
