"""Orekit's TorqueFree (org.orekit.attitudes), with the loop over instants inside the JVM.

A small class, TorqueFreeLoop.java, is compiled in the process by the JDK's own compiler and holds the
loop; one call takes all instants in one array and returns all samples in another.  The virtual machine
starts once in a process, in `start`; one that runs already is used as it is.

No orekit-data is needed: dates count from ARBITRARY_EPOCH, attitudes refer to GCRF.  Orekit's dates resolve
an attosecond and no less, so time is counted in a power of two of seconds such that the body turns by about a
radian in one, and the moments in a power of two near the greatest.  No digit changes.
"""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ..initial_value_problem import InitialValueProblem
from ..method import AbsentError, Method, Solve
from .principal_frame import exponent, principal_axes

SOURCE = Path(__file__).with_name("TorqueFreeLoop.java")
NATIVE_CODE_FLAG = "--enable-native-access=ALL-UNNAMED"


def methods() -> list[Method]:
    """One method: Orekit has no accuracy to choose."""
    return [Method("Orekit TorqueFree", "", prepare, steps=False)]


def prepare(problem: InitialValueProblem) -> Solve:
    """Orekit's model of the motion, which integrates one angle over a period when it is made.

    Raises
    ------
    AbsentError : no package, no Java, or a Java without compiler.
    ArithmeticError : an exception of Orekit, here or when the solution is evaluated.
    """
    loop_class = start()
    second = exponent(problem.angular_velocity)
    moments, axes = principal_axes(problem)
    arguments = (
        np.ldexp(moments, -exponent(moments)),
        axes.T.ravel(),
        problem.attitude,
        np.ldexp(problem.angular_velocity, -second),  # 2^second units of time in a second
    )
    with _java_errors_named():
        loop = loop_class(*map(_java_array, arguments))

    def solve(instants: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        with _java_errors_named():
            samples = loop.evaluate(_java_array(np.ldexp(instants, second)))
        rows = np.array(memoryview(samples), dtype=float).reshape(-1, 7)  # copied as a block
        return rows[:, :4], np.ldexp(rows[:, 4:], second)

    return solve


# -- the virtual machine ----------------------------------------------------------------------


@cache
def start() -> Any:
    """TorqueFreeLoop, the Java class, in a virtual machine that runs and has compiled it to machine code.

    Raises
    ------
    AbsentError : no package, no Java, or a Java without compiler.
    """
    jpype, package = _packages()
    if not jpype.isJVMStarted():
        start_machine(jpype, package)
    jars = sorted(Path(package.__file__).parent.glob("jars/*.jar"))
    with tempfile.TemporaryDirectory(prefix="attitude-orekit-") as folder:
        _compile(jars, Path(folder))
        # in a class loader of its own with Orekit: the class path does not change
        urls = [_java("java.io.File")(str(path)).toURI().toURL() for path in (Path(folder), *jars)]
        parent = _java("java.lang.ClassLoader").getSystemClassLoader()
        loader = _java("java.net.URLClassLoader")(urls, parent)
        loop_class = jpype.JClass("TorqueFreeLoop", loader=loader)
    # evaluated until the JVM has compiled it and all that it calls
    arguments = ([1.0, 1.6, 2.1], np.eye(3).ravel(), [1.0, 0.0, 0.0, 0.0], [0.3, 0.4, 0.5])
    loop_class(*map(_java_array, arguments)).evaluate(_java_array(np.linspace(0.0, 100.0, 200_000)))
    return loop_class


def _packages() -> tuple[Any, Any]:
    try:
        return import_module("jpype"), import_module("orekit_jpype")
    except ImportError as error:
        raise AbsentError("Orekit is not installed: pip install 'attitude[peers]'") from error


def start_machine(jpype: Any, package: Any) -> None:
    """Start the JVM by Orekit's own package, so that later users in the process find it initialised."""
    try:
        library = Path(jpype.getDefaultJVMPath())
        # Python keeps its own handling of ctrl-C; no warnings are printed; JPype's requests for full
        # collections (a tenth of a second each, in somebody else's timing) are ignored
        flags = ["-Xrs", "-Xlog:disable", "-XX:+DisableExplicitGC", *flags_of(library)]
        package.initVM(vmargs=",".join(flags))
    except (jpype.JVMNotFoundException, jpype.JVMNotSupportedException, OSError) as error:
        raise AbsentError(f"Orekit needs Java, such as a JDK in JAVA_HOME: {error}") from error
    # otherwise Java waits, at the end of Python, for the thread that started it, which may have ended
    config: Any = import_module("jpype.config")
    config.onexit = False


def flags_of(library: Path) -> list[str]:
    """Flags by the version of Java, which its home, two or three levels above its library, records."""
    for home in library.parents[1:4]:
        if (home / "release").is_file():
            version = re.search(r'JAVA_VERSION="(\d+)', (home / "release").read_text())
            # from version 22 on, Java warns of native code; 11 does not know the flag
            return [NATIVE_CODE_FLAG] if version and int(version[1]) >= 22 else []
    return []


def _compile(jars: list[Path], folder: Path) -> None:
    compiler = _java("javax.tools.ToolProvider").getSystemJavaCompiler()
    if compiler is None:
        raise AbsentError(
            "Orekit's loop is compiled at first use, and this Java has no compiler: a JDK is needed"
        )
    messages = _java("java.io.ByteArrayOutputStream")()
    path = os.pathsep.join(map(str, jars))
    arguments = ["-nowarn", "-proc:none", "-classpath", path, "-d", str(folder), str(SOURCE)]
    if compiler.run(None, messages, messages, arguments) != 0:
        raise RuntimeError(f"{SOURCE.name} does not compile: {messages}")


def _java(name: str) -> Any:
    return import_module("jpype").JClass(name)


# -- to Java -------------------------------------------------------------------------


@contextmanager
def _java_errors_named() -> Iterator[None]:
    try:
        yield
    except import_module("jpype").JException as error:
        raise ArithmeticError(f"Orekit: {error}") from error


def _java_array(values: Any) -> Any:
    """double[], copied as a block."""
    jpype = import_module("jpype")
    return jpype.JArray(jpype.JDouble)(np.ascontiguousarray(values, dtype=float))
