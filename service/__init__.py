"""The library over HTTP: a document in, one library call, the answer out.

    settings   ATTITUDE_* variables, read once into a frozen object
    limits     what is refused for its size, before anything is computed
    errors     the one table from what can go wrong to an HTTP status
    readiness  the warm-up that /readyz waits for
    openapi    what /openapi.json says beyond what FastAPI finds by itself
    routes     the handlers
    pages      the viewer at /
    app        create_app and serve: wiring only

No mathematics lives here; whatever an answer says was computed by `attitude`.
"""

from .app import create_app, serve

__all__ = ["create_app", "serve"]
