"""The registry of formats: names, file endings and media types; no format's module is imported here."""

from __future__ import annotations

from typing import NamedTuple


class Format(NamedTuple):
    """The names of a format: in commands, at the end of a file's name, and over HTTP.

    module : of `attitude.formats`
    has_companions : whether its readers need other files besides
    syntax : which, where the module writes several
    """

    name: str
    module: str
    endings: tuple[str, ...]
    media: str
    has_companions: bool = False
    syntax: str = ""


FORMATS = {
    entry.name: entry
    for entry in (
        Format("ecsv", "tables.ecsv", (".ecsv",), "text/x-ecsv"),
        Format("csv", "tables.csv", (".csv",), "text/csv"),
        Format("json", "tables.json", (".json",), "application/json"),
        Format("ndjson", "tables.ndjson", (".ndjson", ".jsonl"), "application/x-ndjson"),
        Format("arrow", "arrow.file", (".arrow", ".feather"), "application/vnd.apache.arrow.file"),
        Format("arrows", "arrow.stream", (".arrows",), "application/vnd.apache.arrow.stream"),
        Format("parquet", "arrow.parquet", (".parquet",), "application/vnd.apache.parquet"),
        Format("fits", "tables.fits", (".fits",), "application/fits"),
        Format("npz", "npz", (".npz",), "application/x-npz"),
        Format("aem", "ccsds.aem", (".aem",), "text/x-ccsds-aem", syntax="kvn"),
        Format("aem-xml", "ccsds.aem", (".xml",), "application/xml", syntax="xml"),
        Format("acm", "ccsds.acm_writer", (".acm",), "text/x-ccsds-acm", syntax="kvn"),
        Format("acm-xml", "ccsds.acm_writer", (".acm.xml",), "application/x-ccsds-acm+xml", syntax="xml"),
        Format("stk", "stk", (".a", ".stk"), "text/x-stk-attitude"),
        Format("czml", "czml", (".czml",), "application/vnd.czml+json"),
        Format("ck", "spice.ck", (".bc", ".ck"), "application/x-spice-ck", True),
    )
}
BY_ENDING = {ending: entry for entry in FORMATS.values() for ending in entry.endings}
# Formats of other tools that are read, and not written.
READ_ONLY = {"defatt": Format("defatt", "defatt", (".defatt",), "text/x-mms-defatt")}
