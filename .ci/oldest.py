"""The oldest releases that pyproject.toml allows, as constraints for pip.

    python .ci/oldest.py [EXTRA...]     dependencies, and those of the extras; without any, of `all`

`numpy>=2.0` becomes `numpy==2.0`, which is the release 2.0.0.
"""

import re
import sys
import tomllib
from pathlib import Path

PROJECT = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
REQUIREMENT = re.compile(r"([\w.-]+)(?:\[[\w,-]+\])?>=([\d.]+)(?:,<[\d.]+)?")


def oldest(requirements):
    for requirement in requirements:
        match = REQUIREMENT.fullmatch(requirement)
        if match is None:
            sys.exit(f"{requirement}: NAME>=VERSION[,<VERSION] is what this script reads")
        yield f"{match[1]}=={match[2]}"


extras = PROJECT["optional-dependencies"]
names = sys.argv[1:] or [name for name in extras if name not in ("all", "docs", "peers", "test")]
print(
    *sorted({*oldest([*PROJECT["dependencies"], *(each for name in names for each in extras[name])])}),
    sep="\n",
)
