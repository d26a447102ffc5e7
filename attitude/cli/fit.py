"""`attitude fit`: the motion of a free body from observations of it."""

from __future__ import annotations

import json
from argparse import ArgumentParser, Namespace
from dataclasses import replace
from pathlib import Path

from ..errors import unknown_name
from . import arguments, console

DESCRIPTION = (
    "Fit the free rotation of a body to observations of it: print the estimate with its standard deviations, "
    "outliers, and what the data do not see; write the scene, to go on from with `attitude run`."
)
KINDS = ("attitudes", "rates", "directions", "ranges")


def add_arguments(parser: ArgumentParser) -> None:
    """Those of `attitude fit`."""
    parser.add_argument(
        "document",
        metavar="DOCUMENT",
        help="a scene document, or a built-in scene; attitude and rate, where it has them, are the start",
    )
    parser.add_argument(
        "--observations",
        metavar="FILE",
        action="append",
        default=[],
        help="a table (CSV with units in the names of columns), or attitudes in any format; repeatable",
    )
    parser.add_argument("--sigma", metavar="ANGLE", help=f"of attitudes of an ephemeris: {arguments.ANGLE}")
    parser.add_argument(
        "--rate-sigma", metavar="RATE", help=f"with which its rates are used too: {arguments.RATE}"
    )
    parser.add_argument(
        "--only", metavar="KINDS", help=f"of these observations, such as {','.join(KINDS[:2])}"
    )
    parser.add_argument("--bias", action="store_true", help="estimate constant biases of rates and ranges")
    parser.add_argument("--estimate", metavar="LIST", help="by default attitude,angular_velocity,inertia")
    parser.add_argument("--loss", metavar="NAME", help="linear, soft_l1, huber, cauchy or arctan")
    parser.add_argument(
        "--relative-sigma",
        action="store_true",
        help="scale the covariance by the reduced chi-square, as where sigma is only relative",
    )
    parser.add_argument("-o", "--output", metavar="FILE", help="write the scene that was estimated")
    parser.add_argument("--json", action="store_true", help="the answer as JSON")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress on standard error")
    parser.add_argument("--plot", metavar="FILE", help="draw residuals and rates to FILE.svg or FILE.png")


def execute(options: Namespace) -> None:
    """Print the answer."""
    from ..estimation import BodyRates, RangeOffsets
    from ..estimation.fit_document import FitDocument, read_observations
    from ..runtime import output_paths

    picture_format = options.plot and output_paths.check_picture(options.plot)
    if options.output:
        output_paths.check(options.output)
    document = FitDocument.from_json(*arguments.document_text(options.document))
    changes = {
        "estimate": options.estimate and options.estimate.split(","),
        "loss": options.loss,
        "absolute_sigma": False if options.relative_sigma else None,
    }
    changes = {name: value for name, value in changes.items() if value is not None}
    document = FitDocument(**{**document.model_dump(exclude_unset=True, by_alias=True), **changes})
    sigma = arguments.angle(options.sigma, "--sigma")
    rate_sigma = arguments.rate(options.rate_sigma, "--rate-sigma")
    sets = [
        each
        for path in options.observations
        for each in read_observations(path, sigma, rate_sigma, document.frame or "ICRF")
    ]
    console.announce_compilation(options)
    if options.only is not None:
        kinds = [kind.strip() for kind in options.only.split(",")]
        for kind in kinds:
            if kind not in KINDS:
                raise unknown_name("--only", "kind", kind, KINDS)
        sets = [each for each in sets if each.KIND in kinds]
    if options.bias:
        sets = [
            replace(each, has_bias=True) if isinstance(each, (BodyRates, RangeOffsets)) else each
            for each in sets
        ]
    with console.progress_bar(options) as progress:
        result = document.fit(sets, progress)
    scene = document.scene(result)
    answer = {**result.to_dict(), "scene": scene.document()}
    print(json.dumps(answer, indent=2) if options.json else result)
    if options.output:
        output_paths.write(options.output, (scene.to_json() + "\n").encode())
    if picture_format:
        result.plot(Path(options.plot))
        console.remark(options, f"drawn: {options.plot}")
