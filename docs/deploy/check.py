"""What an image has on board, made use of once: run when it is built, which fails if anything is missing.

The service's warm-up: no kernel is left to compile, and a known case comes out right.  Then an answer
in every format: written, and read back the same.
"""

from __future__ import annotations

import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

from attitude import Ephemeris, Scene
from attitude.formats.registry import FORMATS
from attitude.runtime import kernel_cache
from service import readiness

COMPILERS = ("numba", "llvmlite")
ABSENT = ("ck",)  # SPICE's own format and library: attitude[spice] is not part of the image


def check() -> None:
    present = [name for name in COMPILERS if find_spec(name)]
    assert not present, f"no compiler belongs into the image: {present}"
    kernel_cache.on_compilation.append(_refuse)
    print(readiness.warm_up())
    ephemeris = Scene.builtin("toutatis").run()
    with tempfile.TemporaryDirectory() as folder:
        for known in FORMATS.values():
            if known.name not in ABSENT:
                check_format(ephemeris, Path(folder) / f"answer{known.endings[0]}")
    print(f"an answer in {len(FORMATS) - len(ABSENT)} formats")


def check_format(ephemeris: Ephemeris, path: Path) -> None:
    ephemeris.write(path)
    read = Ephemeris.read(path)
    assert len(read.quaternion("wxyz")) >= len(ephemeris.quaternion("wxyz")), path


def _refuse(count: int) -> None:
    sys.exit(f"{count} kernels were not built ahead")


if __name__ == "__main__":
    check()
