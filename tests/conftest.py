"""Scenes by physical name, one set for all tests; and a kernel cache that cannot be stale.

numba notices an edit in the file of the function it cached, not in those that function calls;
so the cache used by the tests is named after the text of all kernels together.
"""

import hashlib
import os
import tempfile
from pathlib import Path

_package = Path(__file__).parents[1] / "attitude"
_kernels = [*sorted((_package / "kernels").glob("*.py")), _package / "cost" / "methods" / "euler.py"]
_digest = hashlib.sha256(b"".join(path.read_bytes() for path in _kernels)).hexdigest()[:16]
os.environ["NUMBA_CACHE_DIR"] = str(Path(tempfile.gettempdir()) / f"attitude-kernels-{_digest}")
