"""Build all kernels ahead, for machines that are to have no compiler (the container image).

    python -m attitude.build_kernels

Needs numba, and `ld` (of binutils) to make libraries that any process can load.  They are of one
kind for each of built.PROCESSORS of this machine's architecture, whatever this machine's own is.
"""

from __future__ import annotations

import platform
import subprocess
import tempfile
from pathlib import Path

from . import built, compiled
from .errors import AttitudeError
from .kernels.layout import CompiledName

# Whatever is not found is an error here, and not at some call.
LINK = ["ld", "-shared", "-Bsymbolic", "--strip-all", "-z", "defs", "-z", "now", "-z", "relro"]
LIBRARIES = ["--as-needed", "-l:libm.so.6", "-l:libc.so.6"]

# attitude.cost's "phases in doubles": what the second parts of phases cost and buy.
MEASURED = [("cayley_klein", "sample", "r1.d1.n.d3.d3.i.i.i.i")]


def build(place: Path, processors: tuple[str, ...], groups: list[list[CompiledName]]) -> int:
    """Libraries of these kernels, in a directory for each processor; returns how many that were."""
    for processor in processors:
        (place / processor).mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as objects:
            _compile(Path(objects), processor, groups)
            for name in (name for group in groups for name in group):
                _link(Path(objects) / str(name), place / processor / built.library_name(name))
    return len(processors) * sum(map(len, groups))


def names() -> list[list[CompiledName]]:
    """What the library calls, in the groups it is compiled in, and what is only measured."""
    digest, groups = built.digest(), [group for groups in compiled.SETS for group in groups]
    return [
        [CompiledName(module, kernel, tuple(kinds.split(".")), digest) for module, kernel, kinds in group]
        for group in [*groups, MEASURED]
    ]


def _compile(place: Path, processor: str, groups: list[list[CompiledName]]) -> None:
    # no features but those that come with the processor's name: this machine may have more
    told = {"NUMBA_CPU_NAME": processor, "NUMBA_CPU_FEATURES": ""}
    compiled.run_compilers(place, groups, "--to-link", **told)


def _link(code: Path, library: Path) -> None:
    try:
        run = subprocess.run([*LINK, "-o", library, code, *LIBRARIES], capture_output=True, text=True)
    except FileNotFoundError:
        raise AttitudeError("kernels cannot be linked: ld is not installed (of binutils)") from None
    if run.returncode != 0:
        raise AttitudeError(f"kernels cannot be linked: {run.stderr.strip()}")


def main() -> None:
    processors = tuple(built.PROCESSORS.get(platform.machine(), ()))
    if not processors:
        raise AttitudeError(f"kernels are not built ahead for {platform.machine()}")
    print(build(built.PLACE, processors, names()), "kernels built for", ", ".join(processors))


if __name__ == "__main__":
    main()
