"""Pictures of ephemerides: what is in them, by the text and the marks of an SVG."""

import re
from pathlib import Path

import numpy as np
import pytest

from attitude import AttitudeError, Ephemeris, FormatError, InputError, RigidBody, Scene, TorqueFreeMotion
from attitude.cli import command
from attitude.plot import choices, curves, timeline
from attitude.plot.drop import LABEL_WIDTH, apart
from attitude.plot.drop import picture as drop_picture
from attitude.plot.style import AXIS_COLOURS
from attitude.scene.simulation import compared
from tests.effects.scenes import effect, quantity, scene


def words(svg):
    return re.findall(r">([^<>]+)</text>", svg.decode())


def free(times, rate=(0.3, -0.5, 0.9)):
    return TorqueFreeMotion(RigidBody((1.0, 1.6, 2.1)), (1, 0, 0, 0), rate, order="wxyz").at(times)


def test_picture_of_a_free_body_names_its_lines_and_frame():
    actual = words(timeline.picture(free(np.linspace(0, 60, 400)), "svg"))
    for name in ("q_w", "q_x", "q_y", "q_z", "omega_x", "omega_y", "omega_z", "attitude", "body rate, rad/s"):
        assert name in actual
    assert "A scene: attitude, body to ICRF" in actual
    assert "time, s" in actual
    # energy and momentum stay as they are, and the centre of mass is not followed
    assert not {"energy", "momentum", "position, m"} & set(actual)


def test_picture_shows_what_effects_change_and_when_they_acted():
    actual = words(timeline.picture(Scene.builtin("thruster-plan").run(), "svg"))
    assert {"energy", "momentum", "impulse (4)"} <= set(actual)
    assert "time, min" in actual


def test_picture_of_a_sink_shows_energy_but_not_the_momentum_that_stays():
    actual = words(timeline.picture(Scene.builtin("explorer-1").run(), "svg"))
    assert "energy" in actual
    assert "momentum" not in actual
    assert "time since 1958-02-01T03:55:00.000 tt, min" in actual


def test_picture_of_a_fall_shows_where_the_centre_of_mass_is():
    fall = scene(
        effect("uniform_gravity"), position=quantity([0, 0, 9], "m"), velocity=quantity([1, 0, 0], "m/s")
    )
    assert {"position, m", "x", "y", "z"} <= set(words(timeline.picture(fall.run(), "svg")))


def test_every_event_is_a_line_through_every_panel():
    ephemeris = Scene.builtin("thruster-plan").run()
    colour = timeline.EVENTS["impulse"][0]
    lines = re.findall(rf"stroke: {colour}", timeline.picture(ephemeris, "svg").decode())
    panels, in_legend = 3, 1
    assert len(lines) == len(ephemeris.events) * panels + in_legend


def test_samples_too_far_apart_are_dots_and_others_lines():
    """Between samples a turn apart a line would show a motion that is none."""

    def has_dots(step):
        return b"<use" in re.sub(rb'<g id="(xtick|ytick).*?</g>\n *</g>', b"", near(step), flags=re.DOTALL)

    def near(step):
        svg = timeline.picture(free(np.arange(40) * step), "svg")
        return svg[: svg.index(b"legend_1")]

    rate = np.linalg.norm((0.3, -0.5, 0.9))
    assert not has_dots(0.9 * curves.MAX_JOINED_ANGLE / rate)
    assert has_dots(1.6 * curves.MAX_JOINED_ANGLE / rate)


def test_order_of_instants_does_not_matter():
    seconds = np.linspace(0, 20, 60)
    assert timeline.picture(free(seconds[::-1]), "svg") == timeline.picture(free(seconds), "svg")


@pytest.mark.parametrize(
    ("span", "unit"), [(3.0, "s"), (239.0, "s"), (241.0, "min"), (4 * 3600.0, "h"), (4 * 86400.0, "d")]
)
def test_unit_of_the_time_axis_fits_the_span(span, unit):
    assert f"time, {unit}" in words(timeline.picture(free(np.linspace(0.0, span, 9)), "svg"))


def test_picture_does_not_change_from_one_time_to_the_next():
    ephemeris = free(np.linspace(0, 9, 30))
    assert timeline.picture(ephemeris, "svg") == timeline.picture(ephemeris, "svg")
    assert timeline.picture(ephemeris, "png").startswith(b"\x89PNG")


def test_attitudes_alone_are_drawn_alone():
    whole = free(np.linspace(0, 9, 30))
    alone = Ephemeris(whole.quaternion("wxyz").copy(), whole.instants, "GCRF")
    actual = words(timeline.picture(alone, "svg"))
    assert "q_z" in actual
    assert "omega_x" not in actual


@pytest.mark.parametrize("times", [3.0, [3.0], [[1.0, 2.0]]], ids=["instant", "one", "two dimensions"])
def test_one_instant_or_two_dimensions_are_not_drawn(times):
    with pytest.raises(InputError, match="one body at two instants or more"):
        timeline.picture(free(times), "svg")


# -- of a drop -----------------------------------------------------------------------------------


def drop(**changes):
    return Scene.model_validate(Scene.builtin("drop").document() | changes)


def test_drop_is_compared_and_other_scenes_are_not():
    actual = compared(drop())
    assert actual.falling.contacts == [event.seconds for event in drop().run().events]
    assert compared(Scene.builtin("gyrostat")) is None
    assert compared(Scene.builtin("toutatis")) is None
    assert compared(drop(times={"start": 0, "stop": 1, "step": 0.1, "unit": "s"})) is None
    kicked = [*drop().document()["effects"], effect("impulse", time=quantity(1, "s"))]
    assert compared(drop(effects=kicked)) is None


def test_picture_of_a_body_that_comes_to_rest_ends_there():
    actual = compared(drop(times={"start": 0, "stop": 20, "step": 0.01, "unit": "s"}))
    assert actual.model.seconds[-1] == 20.0
    rest = actual.falling.seconds[-1]
    assert 2.8 < rest < 2.9
    labels = words(drop_picture(actual, "svg"))
    assert "20.0" not in labels
    assert "2.5" in labels
    assert (
        sum(label.endswith(" s") and label[0] in "c0123" for label in labels) == 3
    )  # of 15 contacts and more


def test_labels_of_contacts_keep_their_distance():
    assert apart([1.0, 1.01, 1.2, 1.3, 1.31], 0.1) == [1.0, 1.2, 1.3]
    assert apart([], LABEL_WIDTH) == []


# -- what is named ----------------------------------------------------------------------------------


def test_named_panels_are_drawn_in_their_order_and_no_others():
    envisat = Scene.builtin("envisat").run()
    actual = words(timeline.picture(envisat, "svg", choices.parse("angle:z:earth,euler:ZYX,rates")))
    titles = [text for text in actual if text.endswith((" deg", "rad/s"))]
    assert titles == ["angle z earth, deg", "euler zyx, deg", "angular velocity, rad/s"]
    assert "attitude" not in actual


@pytest.mark.parametrize("name", ["polhode", "momentum-sphere", "ground-track"])
def test_curves_are_drawn_beside_panels_and_alone(name):
    envisat = Scene.builtin("envisat").run()
    alone, beside = (
        timeline.picture(envisat, "svg", choices.parse(text)) for text in (name, f"energy,{name}")
    )
    title = {
        "polhode": "polhode",
        "momentum-sphere": "direction in the body",
        "ground-track": "meets the ground",
    }
    assert any(title[name] in text for text in words(alone))
    assert any(title[name] in text for text in words(beside))
    assert "kinetic energy, J" in words(beside)
    assert "kinetic energy, J" not in words(alone)


def test_angles_are_those_that_the_ephemeris_knows():
    actual = words(timeline.picture(Scene.builtin("toutatis").run(), "svg", choices.parse("angles")))
    assert {"angle z sun, deg", "angle z momentum, deg"} <= set(actual)
    assert not any("earth" in text for text in actual)


def test_plotted_polhode_is_the_body_rate():
    figure = free(np.linspace(0, 20, 200)).plot("polhode")
    (line, *_) = figure.subfigs[0].axes[0].lines
    assert np.array_equal(
        np.stack(line.get_data_3d(), axis=1), free(np.linspace(0, 20, 200)).angular_velocity
    )


def test_every_column_of_a_request_is_a_line():
    document = Scene.builtin("toutatis").document() | {
        "uncertainty": {"attitude": quantity([1, 1, 1], "deg")}
    }
    (panel,) = Scene.model_validate(document).run().plot("attitude_covariance").subfigs[0].axes
    assert len(panel.get_lines()) == 6
    assert len({line.get_color() for line in panel.get_lines()}) == 6


def test_components_have_the_colours_of_their_axes():
    attitude, rate = Scene.builtin("toutatis").run().plot().subfigs[0].axes
    colours = [[line.get_color() for line in axes.get_lines()] for axes in (attitude, rate)]
    assert colours[0][1:] == colours[1] == list(AXIS_COLOURS.values())


def test_short_axis_of_a_polhode_has_one_tick():
    (axes,) = Scene.builtin("toutatis").run().plot("polhode").subfigs[0].axes
    assert len(axes.zaxis.get_ticklocs()) == 1
    assert len(axes.xaxis.get_ticklocs()) > 2


def test_file_of_attitudes_beside_one_of_an_orbit_is_drawn_as_their_scene(tmp_path, monkeypatch):
    path = str(Path(__file__).parents[1] / "docs" / "examples" / "satellite.oem")
    scene = Scene.load(Scene.load("envisat").document() | {"orbit": {"file": path}, "effects": []})
    monkeypatch.chdir(tmp_path)
    what = "ground-track,angle:z:nadir"
    scene.run().write("envisat.csv")
    command.main(["plot", "envisat.csv", "--orbit", path, "--what", what, "-o", "file.svg"])
    expected = timeline.picture(scene.run(), "svg", what.split(","))
    assert Path("file.svg").read_bytes() == expected


def test_unknown_name_and_missing_orbit_are_refused_by_name():
    with pytest.raises(InputError, match="did you mean 'polhode'"):
        free(np.linspace(0, 20, 9)).plot("polhod")
    with pytest.raises(AttitudeError, match="orbit"):
        Scene.builtin("toutatis").run().plot("ground-track")


# -- films ------------------------------------------------------------------------------------------


def test_film_shows_the_attitudes_of_the_samples():
    ephemeris = free(np.linspace(0, 20, 30))
    shown = ephemeris.animate(seconds=1.0)
    shown._func(7)  # as the writer of a film draws one of its frames
    space, polhode = shown._fig.axes
    for line, axis in zip(space.lines[-3:], "xyz", strict=True):
        assert np.stack(line.get_data_3d())[:, 1] == pytest.approx(0.95 * ephemeris.direction(axis)[7])
    assert np.ravel(polhode.lines[-1].get_data_3d()) == pytest.approx(ephemeris.angular_velocity[7])
    shown._draw_was_started = True  # matplotlib warns of an animation that was never shown


@pytest.mark.parametrize(("name", "start"), [("a.gif", b"GIF8"), ("a.html", b"\n<link")])
def test_film_is_a_file(name, start, tmp_path):
    free(np.linspace(0, 20, 5)).animate(tmp_path / name, seconds=0.2)
    assert (tmp_path / name).read_bytes().startswith(start)


def test_film_of_another_ending_is_refused():
    with pytest.raises(FormatError, match="gif, mp4 or html"):
        free(np.linspace(0, 20, 5)).animate("a.avi")
    with pytest.raises(InputError, match="seconds"):
        free(np.linspace(0, 20, 5)).animate(seconds=0.0)
