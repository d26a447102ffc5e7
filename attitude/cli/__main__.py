"""`python -m attitude.cli` is the command `attitude`."""

import sys

from .command import main

sys.exit(main())
