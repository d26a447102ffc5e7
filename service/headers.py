"""Headers that every answer has: what a browser is to make of it, and what not."""

from __future__ import annotations

from http import HTTPStatus

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

RawHeaders = list[tuple[bytes, bytes]]


def _raw(headers: dict[str, str]) -> RawHeaders:
    return [(name.encode(), value.encode()) for name, value in headers.items()]


def policy(media: str) -> dict[str, str]:
    """Of an answer of this media type, and of a 304 in its place, whose headers replace those kept."""
    return PAGES if media.startswith(PAGE) else OTHERS


_ALWAYS, _OF_PAGES, _OF_OTHERS = _raw(EVERYWHERE), _raw(PAGES), _raw(OTHERS)


def secured(given: RawHeaders, status: int) -> RawHeaders:
    """With what a handler has not set itself; a 304 is of no media type, and is given no policy here."""
    names = dict(given)
    is_page = names.get(b"content-type", b"").startswith(PAGE.encode())
    ours = _ALWAYS if status == HTTPStatus.NOT_MODIFIED else _ALWAYS + (_OF_PAGES if is_page else _OF_OTHERS)
    return given + [pair for pair in ours if pair[0] not in names]
