"""The library over HTTP: a document in, one library call, the answer out.

    settings   ATTITUDE_* variables, read once into a frozen object
    limits     what is refused for its size, before anything is computed
    errors     the one table from what can go wrong to an HTTP status
    openapi    what /openapi.json says beyond what FastAPI finds by itself
    routes     the handlers
    pages      the viewer at /

    jobs       what becomes of one request: its id, its time, whether anybody still waits
    compute    the threads that compute, and how many requests may wait for them
    readiness  the warm-up that /readyz waits for
    requests   around every request: id, log, figures, headers
    auth, cors, headers, logs, metrics    what their names say

    app        create_app: wiring only
    protocol   HTTP before an application is asked: refusals, and clients that are slow
    server     the process that listens, and how it stops
    workers    several of them at one port

No mathematics lives here; whatever an answer says was computed by `attitude`.
"""

from .app import create_app
from .server import serve

__all__ = ["create_app", "serve"]
