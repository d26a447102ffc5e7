"""`attitude ensemble`: many bodies, statistics of their attitudes or all of them stored."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from . import arguments, console


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `attitude ensemble`."""
    parser.description = (
        "Move many bodies, drawn about a scene's or read from a table. Print statistics of their attitudes "
        "at the scene's instants, or store all attitudes and rates. A run that was interrupted goes on "
        "where it ended when the same command is given once more."
    )
    table = {
        "document DOCUMENT": arguments.SCENE + ", or a document of an ensemble, which has a scene in it",
        "-o --output DIRECTORY": "NAME.zarr or NAME.parquet: store attitudes and rates there",
        "--statistics FILE": 'FILE.ecsv or FILE.json ("-": JSON) for statistics',
        "--plot FILE": "a picture, FILE.svg or FILE.png: where an axis points at the last instant, the "
        "growth of the spread, and when free bodies flip",
        "--axis": "of the body, or by its principal moment: the one in the picture (least: the long axis)",
        # what draws bodies; the same names in an ensemble's document
        "--bodies N": "how many bodies are drawn about the scene's",
        "--seed S": "of the random numbers (0): the same seed, the same bodies",
        "--moments SPREAD": 'relative, of the principal moments, such as "2 %%" or 0.02',
        "--angular-velocity SPREAD": 'of its components, such as "0.1 deg/s"',
        "--attitude SPREAD": 'of a small rotation about each of the body\'s axes, such as "1 deg"',
        "--table FILE": "a body for each row of this table (Parquet, ECSV, FITS), none drawn",
        "--leave-out-bad-rows": "of the table, and list them, instead of stopping",
        "--leave-out-lost-bodies": "of statistics: those that cannot be followed to the scene's tolerance, "
        "instead of stopping",
        "--scheduler ADDRESS": "of a running Dask cluster, such as tcp://10.0.0.1:8786",
        "--workers N": "threads of this machine (as many as it has processors)",
        "--chunk BODIES": "bodies in a chunk of the store (4096)",
        "--overwrite": "replace an ensemble that is stored there",
        "-q --quiet": "no progress on standard error, and no summary",
    }
    numbers = {f"--{name}": {"type": int} for name in ("bodies", "seed", "workers", "chunk")}
    axes = {"action": "store", "choices": ("x", "y", "z", "least", "middle", "greatest")}
    arguments.add(parser, table, {**numbers, "--axis": axes})


def execute(options: Namespace) -> None:
    """Compute, and print or store."""
    from .ensemble_execution import carry_out

    console.announce_compilation(options)
    carry_out(options, *arguments.document_text(options.document))
