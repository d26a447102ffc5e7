"""heyoka and Orekit answer the question that ours answers, right, or say what is missing."""

import subprocess
import sys
from importlib import import_module
from importlib.util import find_spec

import numpy as np
import pytest

from attitude.cost import AbsentError
from attitude.cost.methods import heyoka, orekit
from attitude.cost.methods.euler import FreeEquations
from tests.bodies import GENERIC, Body, each
from tests.cost.answers import FULL_TENSOR, errors, instants, problem

RIGHT = 1e-11  # rad, and relative for the rate: what three generic bodies keep over ten periods
THREE = {"short axis": GENERIC["short axis"], "Toutatis": GENERIC["Toutatis"], "full tensor": FULL_TENSOR}

needs_heyoka = pytest.mark.skipif(find_spec("heyoka") is None, reason="heyoka is not installed")


def ten_periods(body):
    return np.linspace(0.0, 10.0 * problem(body).unit, 9)


# -- heyoka ---------------------------------------------------------------------------------------


@needs_heyoka
@pytest.mark.parametrize("body", **each(THREE))
def test_heyoka_is_right_over_ten_periods(body):
    assert max(errors(heyoka.methods()[-1], body, ten_periods(body))) < RIGHT


@needs_heyoka
def test_heyoka_is_more_exact_the_tighter_its_tolerance():
    body = GENERIC["short axis"]
    attitude_errors = [errors(method, body, ten_periods(body))[0] for method in heyoka.methods()]
    assert attitude_errors[0] > 1e-9
    assert attitude_errors == sorted(attitude_errors, reverse=True)


@needs_heyoka
@pytest.mark.parametrize("scale", [1e-150, 1e-5, 1e150])
def test_tolerance_means_the_same_at_any_scale_of_the_rate(scale):
    moments, omega = GENERIC["short axis"]
    body = Body(moments, tuple(scale * w for w in omega))
    assert max(errors(heyoka.methods()[-1], body, instants(body))) < RIGHT


@needs_heyoka
def test_heyoka_answers_again_as_it_did():
    body = GENERIC["Toutatis"]
    solve, t = heyoka.methods()[-1].prepare(problem(body)), ten_periods(body)
    first, second = solve(t), solve(t)
    assert (first[0] == second[0]).all()
    assert (first[1] == second[1]).all()


@needs_heyoka
def test_heyoka_that_fails_names_the_outcome():
    equations = FreeEquations.of(problem(GENERIC["Toutatis"]))
    system = heyoka.free_motion(import_module("heyoka"))
    integrator = import_module("heyoka").taylor_adaptive(
        system, equations.start.tolist(), pars=equations.k.tolist(), tol=1e-9, compact_mode=True
    )
    integrator.state[4] = 1e200  # whose square is beyond a double
    with pytest.raises(ArithmeticError, match="heyoka: err_nf_state at t = nan of 1"):
        heyoka.propagate(integrator, np.array([0.0, 1.0]))


# -- Orekit ---------------------------------------------------------------------------------------


@pytest.mark.usefixtures("java")
@pytest.mark.parametrize("body", **each(THREE))
def test_orekit_is_right_over_ten_periods(body):
    (method,) = orekit.methods()
    assert max(errors(method, body, ten_periods(body))) < RIGHT


@pytest.mark.usefixtures("java")
@pytest.mark.parametrize("scale", [1e-150, 1e150])
def test_orekit_is_right_at_any_scale(scale):
    moments, omega = GENERIC["short axis"]
    (method,) = orekit.methods()
    slow = Body(moments, tuple(scale * w for w in omega))
    assert max(errors(method, slow, instants(slow))) < RIGHT
    light = Body(tuple(scale * moment for moment in moments), omega)
    assert max(errors(method, light, instants(light))) < RIGHT


@pytest.mark.usefixtures("java")
def test_orekits_exceptions_are_arithmetic_errors():
    (method,) = orekit.methods()
    with pytest.raises(ArithmeticError, match=r"Orekit: org\.hipparchus"):
        method.prepare(problem(Body((3.0, 4.0, 6.0), (2.0, 0.7, 1.0))))


def end_of_process(program):
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=240)
    return run.returncode, run.stdout, run.stderr


@pytest.mark.usefixtures("java")
def test_virtual_machine_is_silent_serves_others_and_lets_the_process_end():
    """Started by a thread that has ended, as in a service: Java would wait for that thread."""
    program = """
import threading
from attitude.cost.methods import orekit
starting = threading.Thread(target=orekit.start)
starting.start()
starting.join()
assert orekit.start() is orekit.start()
import orekit_jpype
orekit_jpype.initVM()
from org.orekit.time import AbsoluteDate
"""
    assert end_of_process(program) == (0, "", "")


@pytest.mark.usefixtures("java")
def test_virtual_machine_that_runs_already_is_used_as_it_is():
    program = "import jpype; jpype.startJVM(); from attitude.cost.methods import orekit; orekit.start()"
    code, printed, complaints = end_of_process(program)
    assert (code, printed) == (0, ""), complaints  # of which its own starter may have chosen to see some


# -- absent ---------------------------------------------------------------------------------------


@pytest.fixture
def afresh():
    """The virtual machine that was started before is forgotten, and afterwards remembered."""
    remembered, orekit.start = orekit.start, orekit.start.__wrapped__
    yield
    orekit.start = remembered


@pytest.mark.usefixtures("afresh")
@pytest.mark.parametrize(
    ("module", "package"), [(heyoka, "heyoka"), (orekit, "jpype"), (orekit, "orekit_jpype")]
)
def test_missing_package_is_absence_and_names_the_remedy(monkeypatch, module, package):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(AbsentError, match=r"pip install 'attitude\[peers\]'"):
        module.methods()[-1].prepare(problem(GENERIC["Toutatis"]))


class NoJavaError(Exception):
    pass


class MachineWithoutJava:
    """What jpype is where it finds no Java."""

    JVMNotFoundException = JVMNotSupportedException = NoJavaError

    def isJVMStarted(self):
        return False

    def getDefaultJVMPath(self):
        raise NoJavaError("No JVM shared library file found")


@pytest.mark.usefixtures("afresh")
def test_missing_java_is_absence(monkeypatch):
    monkeypatch.setattr(orekit, "_packages", lambda: (MachineWithoutJava(), None))
    with pytest.raises(AbsentError, match=r"needs Java.*No JVM"):
        orekit.methods()[0].prepare(problem(GENERIC["Toutatis"]))


class NoCompiler:
    @staticmethod
    def getSystemJavaCompiler():
        return None


@pytest.mark.usefixtures("afresh", "java")
def test_java_without_compiler_is_absence(monkeypatch):
    monkeypatch.setattr(orekit, "_java", lambda name: NoCompiler)
    with pytest.raises(AbsentError, match="a JDK is needed"):
        orekit.methods()[0].prepare(problem(GENERIC["Toutatis"]))


def test_java_that_warns_of_native_code_has_the_flag_against_it(tmp_path):
    library = tmp_path / "lib" / "server" / "libjvm.so"
    library.parent.mkdir(parents=True)
    assert orekit.flags_of(library) == []
    for version, flags in (("17.0.15", []), ("25.0.1", [orekit.NATIVE_CODE_FLAG])):
        (tmp_path / "release").write_text(f'IMPLEMENTOR="x"\nJAVA_VERSION="{version}"\n')
        assert orekit.flags_of(library) == flags
