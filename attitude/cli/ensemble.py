"""`attitude ensemble`: many bodies, statistics of their attitudes or all of them stored."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from . import arguments, console

DESCRIPTION = (
    "Move many bodies, drawn about a scene's or read from a table. Print statistics of their attitudes at "
    "the scene's instants, or store all attitudes and rates. A run that was interrupted goes on where it "
    "ended when the same command is given once more."
)
# Flags of `attitude ensemble` that draw bodies; the same names in an ensemble's document.
DRAWING = {
    "bodies": ("N", "how many bodies are drawn about the scene's"),
    "seed": ("S", "of the random numbers (0): the same seed, the same bodies"),
    "moments": ("SPREAD", 'relative, of the principal moments, such as "2 %%" or 0.02'),
    "angular-velocity": ("SPREAD", 'of its components, such as "0.1 deg/s"'),
    "attitude": ("SPREAD", 'of a small rotation about each of the body\'s axes, such as "1 deg"'),
}


def add_arguments(parser: ArgumentParser) -> None:
    """Those of `attitude ensemble`."""
    parser.add_argument(
        "document",
        metavar="DOCUMENT",
        help=arguments.SCENE + ", or a document of an ensemble, which has a scene in it",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="DIRECTORY",
        help="NAME.zarr or NAME.parquet: store attitudes and rates there",
    )
    parser.add_argument(
        "--statistics", metavar="FILE", help='FILE.ecsv or FILE.json ("-": JSON) for statistics'
    )
    parser.add_argument(
        "--plot",
        metavar="FILE",
        help="a picture, FILE.svg or FILE.png: where an axis points at the last instant, the growth of the "
        "spread, and when free bodies flip",
    )
    parser.add_argument(
        "--axis",
        choices=("x", "y", "z", "least", "middle", "greatest"),
        help="of the body, or by its principal moment: the one in the picture (least: the long axis)",
    )
    for name, (metavar, text) in DRAWING.items():
        kind = int if name in ("bodies", "seed") else str
        parser.add_argument(f"--{name}", metavar=metavar, type=kind, help=text)
    parser.add_argument(
        "--table", metavar="FILE", help="a body for each row of this table (Parquet, ECSV, FITS), none drawn"
    )
    parser.add_argument(
        "--leave-out-bad-rows", action="store_true", help="of the table, and list them, instead of stopping"
    )
    parser.add_argument(
        "--leave-out-lost-bodies",
        action="store_true",
        help="of statistics: those that cannot be followed to the scene's tolerance, instead of stopping",
    )
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="of a running Dask cluster, such as tcp://10.0.0.1:8786"
    )
    parser.add_argument(
        "--workers", metavar="N", type=int, help="threads of this machine (as many as it has processors)"
    )
    parser.add_argument("--chunk", metavar="BODIES", type=int, help="bodies in a chunk of the store (4096)")
    parser.add_argument("--overwrite", action="store_true", help="replace an ensemble that is stored there")
    parser.add_argument(
        "-q", "--quiet", action="store_true", help="no progress on standard error, and no summary"
    )


def execute(options: Namespace) -> None:
    """Compute, and print or store."""
    from .ensemble_execution import carry_out

    console.announce_compilation(options)
    carry_out(options, *arguments.document_text(options.document))
