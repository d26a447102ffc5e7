"""What `check` says of files that are good, and of each usual fault."""

import json

import numpy as np
import pytest

from attitude import Ephemeris, RegimeError, RigidBody, TorqueFreeMotion
from attitude.cli import main
from attitude.quality.check import check, check_file
from attitude.times.instants import as_instants
from tests.formats.test_aem import EPOCH

T = np.arange(200) * 0.1
BODY = RigidBody((1.0, 1.6, 2.1))


def motion(rate=(0.3, -0.5, 0.9)):
    return TorqueFreeMotion(BODY, [1.0, 0.0, 0.0, 0.0], rate, EPOCH, order="wxyz", frame="EME2000")


def rebuilt(data, q=None, t=None, rate=None):
    instants = data.instants if t is None else as_instants(t, data.epoch)
    attitude = data.quaternion("wxyz") if q is None else q
    return Ephemeris(
        attitude.copy(), instants, data.frame, None, data.angular_velocity if rate is None else rate
    )


def faults(tmp_path, data, name="a.aem", **options):
    data.write(tmp_path / name, **options)
    report = check_file(tmp_path / name)
    return {finding.subject: finding.text for finding in report.findings if finding.is_fault}


def test_good_file_has_no_fault(tmp_path):
    assert faults(tmp_path, motion().at(T)) == {}
    report = check_file(tmp_path / "a.aem")
    subjects = [finding.subject for finding in report.findings]
    assert subjects == [
        "coverage",
        "gaps",
        "spacing",
        "signs",
        "unit length",
        "rotation",
        "rates",
        "interpolation",
    ]
    assert report.is_good
    assert "nothing is off" in str(report)


def test_gap_is_named(tmp_path):
    t = np.concatenate([T[:50], T[80:]])
    assert faults(tmp_path, rebuilt(motion().at(t)))["gaps"].startswith("1: 4.9 to 8 s; 1 segment")


def test_changes_of_sign_are_counted(tmp_path):
    data = motion().at(T)
    data.write(tmp_path / "a.aem")
    lines = (tmp_path / "a.aem").read_text().splitlines()
    first = lines.index("DATA_START") + 1
    for i in (30, 31, 60):
        epoch, *q = lines[first + i].split()
        flipped = [f"-{x}".replace("--", "") for x in q[:4]]
        lines[first + i] = " ".join([epoch, *flipped, *q[4:]])
    (tmp_path / "a.aem").write_text("\n".join(lines) + "\n")
    report = check_file(tmp_path / "a.aem")
    (signs,) = [finding for finding in report.findings if finding.is_fault]
    assert signs.subject == "signs"
    assert signs.values["sign_changes"] == 4


def test_spinner_sampled_too_slowly_is_seen_from_its_rates(tmp_path):
    spinner = motion((0.0, 0.0, 2.0 * np.pi))  # a turn a second
    found = faults(tmp_path, spinner.at(np.arange(40) * 1.05), "a.npz")
    assert found["rates"] == "by its rates the body turns 1.05 times between attitudes: sampled too slowly"
    slower = faults(tmp_path, spinner.at(np.arange(40) * 0.3), "b.npz")
    assert "beyond 90 deg the direction of the rotation becomes ambiguous" in slower["rotation"]


WRONG_RATES = {
    "they have the opposite sign": lambda data: -data.angular_velocity,
    "they are in rad/s instead of deg/s": lambda data: np.deg2rad(data.angular_velocity),
    "their components are along the axes of the external frame": lambda data: data.rotation.apply(
        data.angular_velocity
    ),
}


@pytest.mark.parametrize(("reason", "rate"), WRONG_RATES.items(), ids=WRONG_RATES)
def test_wrong_rates_are_explained(reason, rate, tmp_path):
    data = motion().at(T)
    assert faults(tmp_path, rebuilt(data, rate=rate(data)))["rates"].endswith(f"%: {reason}")


def test_rates_in_degrees_are_recognised(tmp_path):
    data = motion((0.003, -0.005, 0.009)).at(T)
    found = faults(tmp_path, rebuilt(data, rate=np.rad2deg(data.angular_velocity)))
    assert found["rates"].endswith("they are in deg/s instead of rad/s")


def test_spacing_too_wide_for_the_stated_method_is_a_fault(tmp_path):
    found = faults(tmp_path, motion().at(np.arange(30) * 1.0), degree=1)
    assert found["interpolation"].startswith(
        "interpolation between the attitudes of a file: Lagrange, degree 1"
    )
    assert faults(tmp_path, motion().at(np.arange(60) * 0.3), degree=7) == {}


def test_estimated_error_of_interpolation_is_near_the_true_one(tmp_path):
    """On files that state their error, which the writer knows from the motion."""
    for degree, name in ((1, "a"), (3, "b"), (5, "c")):
        written = motion().at(T).write(tmp_path / f"{name}.aem", degree=degree)
        (finding,) = [
            f for f in check_file(tmp_path / f"{name}.aem").findings if f.subject == "interpolation"
        ]
        assert 0.2 < finding.values["estimate_rad"] / written.interpolation_error < 5.0


def test_quaternions_of_few_digits_are_said(tmp_path):
    motion().at(T).write(tmp_path / "a.csv")
    text = (tmp_path / "a.csv").read_text().splitlines()
    words = text[3].split(",")
    words[3] = str(float(words[3]) + 1e-4)
    (tmp_path / "a.csv").write_text("\n".join([*text[:3], ",".join(words), *text[4:]]) + "\n")
    report = check_file(tmp_path / "a.csv")
    (reading,) = [finding for finding in report.findings if finding.subject == "reading"]
    assert "length" in reading.text
    assert not report.is_good


def test_instants_in_no_order_are_the_only_finding():
    data = motion().at(T)
    (finding,) = check(rebuilt(data, t=T[::-1].copy()))
    assert finding.text.startswith("instant 1 (19.8 s) is not after the one before it")


def test_batch_and_no_instants_are_refused():
    bodies = TorqueFreeMotion(
        RigidBody([(1.0, 1.6, 2.1)] * 2), [1.0, 0, 0, 0], (0.3, -0.5, 0.9), order="wxyz"
    )
    for data in (bodies.at(T), motion().at([])):
        with pytest.raises(RegimeError, match="check: one body at a list of instants"):
            check(data)


def test_command_prints_one_screen_and_its_exit_code_tells(tmp_path, capsys):
    motion().at(T).write(tmp_path / "a.aem")
    assert main(["check", str(tmp_path / "a.aem")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) <= 24
    assert main(["check", str(tmp_path / "a.aem"), "--interpolation-error", "1e-12"]) == 1
    assert "! interpolation:" in capsys.readouterr().out
    assert main(["check", str(tmp_path / "a.aem"), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["good"] is True
    assert {"subject", "off", "text"} <= report["findings"][0].keys()
    assert main(["check", str(tmp_path / "none.aem")]) == 2
