"""`attitude check`: what is off in a file of attitudes."""

from __future__ import annotations

import json
from argparse import ArgumentParser, Namespace

from . import arguments


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `attitude check`."""
    parser.description = (
        "Read a file of attitudes and judge it: coverage, gaps, spacing, signs, unit length, rates against "
        "differences of attitudes, and the error of its own interpolation.  Exit code 1 where something is "
        "off."
    )
    table = {
        "file FILE": "a file of attitudes",
        "--from F": "its format; by default from its ending",
        "--interpolation-error TOL": "an estimated error of its interpolation above TOL is off: "
        f"{arguments.ANGLE}; 1e-3 by default",
        arguments.SET: "an option of the format's reader; repeatable",
        "--json": "the report as JSON",
    }
    defaults = {"--from": {"dest": "source_format"}, "--interpolation-error": {"default": "1e-3 rad"}}
    arguments.add(parser, table, defaults)


def execute(options: Namespace) -> int:
    """Print the report."""
    from ..quality.check import check_file

    most = arguments.angle(options.interpolation_error, "--interpolation-error")
    reading = arguments.reading_options(options, options.file, options.source_format)
    report = check_file(options.file, options.source_format, most or 0.0, **reading)
    print(json.dumps(report.to_dict(), indent=2) if options.json else report)
    return 0 if report.is_good else 1
