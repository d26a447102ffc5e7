"""`attitude check`: what is off in a file of attitudes."""

from __future__ import annotations

import json
from argparse import ArgumentParser, Namespace

from . import arguments

DESCRIPTION = (
    "Read a file of attitudes and judge it: coverage, gaps, spacing, signs, unit length, rates against "
    "differences of attitudes, and the error of its own interpolation.  Exit code 1 where something is off."
)


def add_arguments(parser: ArgumentParser) -> None:
    """Those of `attitude check`."""
    parser.add_argument("file", metavar="FILE", help="a file of attitudes")
    parser.add_argument(
        "--from", dest="source_format", metavar="F", help="its format; by default from its ending"
    )
    parser.add_argument(
        "--interpolation-error",
        metavar="TOL",
        default="1e-3 rad",
        help=f"an estimated error of its interpolation above TOL is off: {arguments.ANGLE}; 1e-3 by default",
    )
    parser.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        help="an option of the format's reader; repeatable",
    )
    parser.add_argument("--json", action="store_true", help="the report as JSON")


def execute(options: Namespace) -> int:
    """Print the report."""
    from ..quality.check import check_file

    most = arguments.angle(options.interpolation_error, "--interpolation-error")
    reading = arguments.reading_options(options, options.file, options.source_format)
    report = check_file(options.file, options.source_format, most or 0.0, **reading)
    print(json.dumps(report.to_dict(), indent=2) if options.json else report)
    return 0 if report.is_good else 1
