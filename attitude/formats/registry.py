"""Which formats there are: their names, endings and media types; nothing of them is loaded here."""

from __future__ import annotations

from typing import NamedTuple


class Format(NamedTuple):
    """What a format is called, in commands, at the end of a file's name, and over HTTP."""

    name: str
    module: str
    endings: tuple[str, ...]
    media: str
    has_companions: bool = False  # other files that its readers need besides


KNOWN = (
    Format("ecsv", "tables.ecsv", (".ecsv",), "text/x-ecsv"),
    Format("csv", "tables.csv", (".csv",), "text/csv"),
    Format("json", "tables.json", (".json",), "application/json"),
    Format("ndjson", "tables.ndjson", (".ndjson", ".jsonl"), "application/x-ndjson"),
    Format("arrow", "arrow.file", (".arrow", ".feather"), "application/vnd.apache.arrow.file"),
    Format("arrows", "arrow.stream", (".arrows",), "application/vnd.apache.arrow.stream"),
    Format("parquet", "arrow.parquet", (".parquet",), "application/vnd.apache.parquet"),
    Format("fits", "tables.fits", (".fits",), "application/fits"),
    Format("npz", "npz", (".npz",), "application/x-npz"),
    Format("aem", "ccsds.kvn", (".aem",), "text/x-ccsds-aem"),
    Format("aem-xml", "ccsds.xml", (".xml",), "application/xml"),
    Format("stk", "stk", (".a",), "text/x-stk-attitude"),
    Format("czml", "czml", (".czml",), "application/vnd.czml+json"),
    Format("ck", "spice.ck", (".bc",), "application/x-spice-ck", True),
)
FORMATS = {known.name: known for known in KNOWN}
BY_ENDING = {ending: known for known in KNOWN for ending in known.endings}
