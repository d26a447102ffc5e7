"""Builds all kernels ahead, for machines without a compiler (the container image).

    python -m attitude.runtime.build

Requires numba, and `ld` (of binutils) to link libraries that any process can load: one for each of
prebuilt.PROCESSORS of this machine's architecture.
"""

from __future__ import annotations

import platform
import subprocess
import tempfile
from pathlib import Path

from ..errors import AttitudeError
from . import compiled, kernel_cache, prebuilt
from .signature import Signature


def build(library: Path, processor: str, groups: list[list[Signature]]) -> None:
    """Builds a shared library of these kernels for a processor, with a compiler process for each group."""
    library.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as objects:
        kernel_cache.run_compilers(Path(objects), groups, "--processor", processor)
        link(sorted(Path(objects).iterdir()), library)


def link(objects: list[Path], library: Path) -> None:
    """Links object files to a shared library; AttitudeError where that fails."""
    # undefined symbols are an error of the linker, not of the first call
    options = ["-shared", "-Bsymbolic", "--strip-all", "-z", "defs", "-z", "now", "-z", "relro"]
    libraries = ["--as-needed", "-l:libm.so.6", "-l:libc.so.6"]
    command = ["ld", *options, "-o", str(library), *map(str, objects), *libraries]
    try:
        run = subprocess.run(command, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        raise AttitudeError("kernels cannot be linked: ld is not installed (of binutils)") from None
    if run.returncode != 0:
        raise AttitudeError(f"kernels cannot be linked: {run.stderr.strip()}")


def signatures() -> list[list[Signature]]:
    """The signatures that the library calls, in their groups."""
    return [group for wing in compiled.WINGS for group in wing]


def main() -> None:
    """Builds the libraries for this machine's architecture."""
    processors = prebuilt.PROCESSORS.get(platform.machine(), {})
    if not processors:
        raise AttitudeError(f"kernels are not built ahead for {platform.machine()}")
    for processor in processors:
        build(prebuilt.DIRECTORY / f"{processor}.so", processor, signatures())
    print(sum(map(len, signatures())), "kernels built for each of", ", ".join(processors))


if __name__ == "__main__":
    main()
