"""Take out of an image's packages what the service never opens: `python trim.py SITE_PACKAGES`.

Half of what is installed, by size: other packages' tests, what compilers would read, and the parts
of pyarrow that talk to other people's servers.  check.py, beside it, is run on what is left.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

UNUSED = [
    # tests, but for those that their package imports itself
    "*/*/**/tests",
    "pyarrow/tests",
    # for compilers: headers, declarations, static libraries
    "**/*.a",
    "**/*.pxd",
    "**/*.pyx",
    "**/*.h",
    "**/*.hpp",
    "pyarrow/include",
    "pyarrow/src",
    # clients of Flight, S3, Google, Azure and Hadoop; second copies under the name that linkers look for
    "pyarrow/*flight*",
    "pyarrow/*s3*",
    "pyarrow/_gcsfs*",
    "pyarrow/_azurefs*",
    "pyarrow/_hdfs*",
    "pyarrow/_pyarrow_cpp_tests*",
    "pyarrow/libarrow_python*.so",
    "pyarrow/libarrow_python*.so.*.*",
]


def trim(packages: Path) -> None:
    for pattern in UNUSED:
        found = list(packages.glob(pattern))
        if not found:
            print(f"trim: {pattern} is no longer there", file=sys.stderr)
        for path in found:
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink(missing_ok=True)


if __name__ == "__main__":
    trim(Path(sys.argv[1]))
