"""`attitude convert`: a file of attitudes in another format or frame."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from . import arguments, console
from .run import report_interpolation


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `attitude convert`."""
    parser.description = (
        "Read a file in any of the formats, and write its ephemeris in another format or frame, at its own "
        "instants or others; between its own it is interpolated as it states, by slerp where it states "
        "nothing."
    )
    table = {
        "files FILE": "a file of attitudes; several that follow each other are joined",
        "--from F": "its format; by default from its ending",
        **arguments.OUTPUT,
        **arguments.COLUMNS,
    }
    special = {"files": {"nargs": "+"}, "--from": {"dest": "source_format"}, "--output": {"default": "-"}}
    arguments.add(parser, table, special)
    chosen = {
        "--times T,...": "these instants: dates (ISO 8601, in the file's time scale) or seconds since "
        "its epoch",
        "--step DT": 'every DT from the first instant to the last, such as "10 s" or "1 min"',
    }
    arguments.add(parser.add_mutually_exclusive_group(), chosen)
    filling = {
        "--by": "in gaps, free rotation fitted to both sides, for a body whose inertia is in the file or "
        "--body",
        "--body BODY": "three moments, such as 10,13,17 (their ratios matter), or a document",
    }
    arguments.add(parser, filling, {"--by": {"action": "store", "choices": ["dynamics"]}})


def execute(options: Namespace) -> None:
    """Read and write."""
    from .. import formats
    from ..ephemeris import Ephemeris
    from ..estimation.conversion import Conversion
    from ..estimation.fit_document import FitDocument

    source = formats.find_source(options.files[0], options.source_format)
    target, writing, reading = arguments.output_format(options, source)
    console.announce_compilation(options)
    ephemeris = Ephemeris.read(options.files, options.source_format, **reading)
    asked = (options.frame, options.ut1, options.times, options.step, options.by, options.body)
    ephemeris, gaps = Conversion(*asked, prefix="--", name_of_inertia="body").apply(
        ephemeris, lambda name: FitDocument.from_json(*arguments.document_text(name))
    )
    for gap in gaps:
        console.remark(options, str(gap))
    if (options.times or options.step) is not None and ephemeris.plan is not None:
        console.remark(options, ephemeris.plan.solver)
    ephemeris = ephemeris if options.columns is None else ephemeris.with_columns(options.columns)
    with console.progress_bar(options) as progress:
        written = formats.write(ephemeris, options.output, target.name, progress, **writing)
    report_interpolation(written, options)
