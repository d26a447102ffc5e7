"""`attitude compare`: how two files of attitudes differ."""

from __future__ import annotations

import json
from argparse import ArgumentParser, Namespace

from . import arguments, console


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `attitude compare`."""
    parser.description = (
        "Bring two files of attitudes to one frame and to the instants of the first, and tell the greatest "
        "and the rms rotation between them, and of rates.  Exit code 1 where the rotation exceeds "
        "--tolerance."
    )
    table = {
        "first A": "a file of attitudes",
        "second B": "another, of any format",
        "--frame FRAME": "compare in this frame; by default in that of A",
        "--tolerance TOL": f"exit code 1 above it: {arguments.ANGLE}",
        "--json": "the differences as JSON",
        "--plot FILE": "draw them in time to FILE.svg or FILE.png",
    }
    arguments.add(parser, table)


def execute(options: Namespace) -> int:
    """Print the differences."""
    from ..ephemeris import Ephemeris
    from ..quality.compare import compare
    from ..runtime import output_paths

    tolerance = arguments.angle(options.tolerance, "--tolerance")
    picture_format = options.plot and output_paths.check_picture(options.plot)
    comparison = compare(Ephemeris.read(options.first), Ephemeris.read(options.second), options.frame)
    print(json.dumps(comparison.to_dict(), indent=2) if options.json else comparison)
    if picture_format:
        from ..quality import difference_plot

        output_paths.write(options.plot, difference_plot.picture(comparison, picture_format))
        console.warn(f"drawn: {options.plot}")
    return int(tolerance is not None and comparison.angle.max() > tolerance)
