"""Headers that every answer has: what a browser is to make of it, and what not."""

from __future__ import annotations

from starlette.datastructures import MutableHeaders

PAGE = "text/html"
EVERYWHERE = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
}
# Pages load everything from here; scripts are files, never text in a page.  Drawings may be made in place.
PAGES = {
    "content-security-policy": "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "cross-origin-opener-policy": "same-origin",
    "x-frame-options": "DENY",
}
# What is no page is shown as none, even where a browser is led to open it as one.
OTHERS = {"content-security-policy": "default-src 'none'; frame-ancestors 'none'; sandbox"}


def secure(headers: MutableHeaders) -> None:
    """Add what a handler has not set itself."""
    is_page = headers.get("content-type", "").startswith(PAGE)
    for name, value in (EVERYWHERE | (PAGES if is_page else OTHERS)).items():
        headers.setdefault(name, value)
