"""`attitude fit`: the motion of a free body from observations of it."""

from __future__ import annotations

import json
from argparse import ArgumentParser, Namespace
from dataclasses import replace
from pathlib import Path

from ..errors import InputError, unknown_name
from . import arguments, console

RATE = 'an angular velocity above 0, such as "0.01 deg/s" (without a unit: rad/s)'
KINDS = ("attitudes", "rates", "directions", "ranges")


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `attitude fit`."""
    parser.description = (
        "Fit the free rotation of a body to observations of it: print the estimate with its standard "
        "deviations, outliers, and what the data do not see; write the scene, to go on from with `attitude "
        "run`."
    )
    table = {
        "document DOCUMENT": "a scene document, or a built-in scene; attitude and rate, where it has them, "
        "are the start",
        "--observations FILE ...": "a table (CSV with units in the names of columns), or attitudes in any "
        "format; repeatable",
        "--sigma ANGLE": f"of attitudes of an ephemeris: {arguments.ANGLE}",
        "--rate-sigma RATE": f"with which its rates are used too: {RATE}",
        "--only KINDS": f"of these observations, such as {','.join(KINDS[:2])}",
        "--bias": "estimate constant biases of rates and ranges",
        "--estimate LIST": "by default attitude,angular_velocity,inertia",
        "--loss NAME": "linear, soft_l1, huber, cauchy or arctan",
        "--relative-sigma": "scale the covariance by the reduced chi-square, as where sigma is only relative",
        "-o --output FILE": "write the scene that was estimated",
        "--json": "the answer as JSON",
        **arguments.QUIET,
        "--plot FILE": "draw residuals and rates to FILE.svg or FILE.png",
    }
    arguments.add(parser, table)


def execute(options: Namespace) -> None:
    """Print the answer."""
    from .. import units
    from ..estimation import BodyRates, RangeOffsets
    from ..estimation.fit_document import FitDocument, read_observations
    from ..runtime import output_paths

    picture_format = options.plot and output_paths.check_picture(options.plot)
    if options.output:
        output_paths.check(options.output)
    document = FitDocument.from_json(*arguments.document_text(options.document))
    changes = {
        "estimate": options.estimate and [word.strip() for word in options.estimate.split(",")],
        "loss": options.loss,
        "absolute_sigma": False if options.relative_sigma else None,
    }
    changes = {name: value for name, value in changes.items() if value is not None}
    document = FitDocument(**{**document.model_dump(exclude_unset=True, by_alias=True), **changes})
    sigma = arguments.angle(options.sigma, "--sigma")
    rate_sigma = None
    if options.rate_sigma is not None:
        rate_sigma = units.positive_quantity(options.rate_sigma, (units.RATE, "rad/s"), "--rate-sigma", RATE)
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
        if not any(each.biases for each in sets):
            raise InputError("--bias", True, "rates or range offsets, which may have a bias")
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
