"""Build all kernels ahead, for machines that are to have no compiler (the container image).

    python -m attitude.runtime.build

Needs numba, and `ld` (of binutils) to make libraries that any process can load.  They are of one
kind for each of prebuilt.PROCESSORS of this machine's architecture, whatever this machine's own is.
"""

from __future__ import annotations

import platform
import subprocess
import tempfile
from pathlib import Path

from ..errors import AttitudeError
from . import compiled, kernel_cache, prebuilt
from .signature import Signature

# Whatever is not found is an error here, and not at some call.
LINK = ["ld", "-shared", "-Bsymbolic", "--strip-all", "-z", "defs", "-z", "now", "-z", "relro"]
LIBRARIES = ["--as-needed", "-l:libm.so.6", "-l:libc.so.6"]

# attitude.cost's "phases in doubles": what the second parts of phases cost and buy.
MEASURED = Signature("cayley_klein", "sample", "r1.d1.n.d3.d3.i.i.i.i")


def build(library: Path, processor: str, groups: list[list[Signature]]) -> None:
    """A shared library of these kernels, compiled for this processor in a process for each group."""
    library.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as objects:
        kernel_cache.run_compilers(Path(objects), groups, "--processor", processor)
        link(sorted(Path(objects).iterdir()), library)


def link(objects: list[Path], library: Path) -> None:
    try:
        run = subprocess.run([*LINK, "-o", library, *objects, *LIBRARIES], capture_output=True, text=True)
    except FileNotFoundError:
        raise AttitudeError("kernels cannot be linked: ld is not installed (of binutils)") from None
    if run.returncode != 0:
        raise AttitudeError(f"kernels cannot be linked: {run.stderr.strip()}")


def signatures() -> list[list[Signature]]:
    """What the library calls, in the groups it is compiled in, and what is only measured."""
    return [*(group for wing in compiled.WINGS for group in wing), [MEASURED]]


def main() -> None:
    processors = prebuilt.PROCESSORS.get(platform.machine(), {})
    if not processors:
        raise AttitudeError(f"kernels are not built ahead for {platform.machine()}")
    for processor in processors:
        build(prebuilt.PLACE / f"{processor}.so", processor, signatures())
    print(sum(map(len, signatures())), "kernels built for each of", ", ".join(processors))


if __name__ == "__main__":
    main()
