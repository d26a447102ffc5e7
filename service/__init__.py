"""The library over HTTP: a document in, one library call, the answer out.

    app           create_app, and `uvicorn service.app:app`
    server        `attitude serve`: uvicorn with the options that the settings give it
    settings      ATTITUDE_* variables
    routes        the handlers of /v1 and of the process; pages: the viewer and /docs
    dependencies  what handlers depend on: the query's parameters, the raw document
    negotiation   the format that Accept names
    schemas       what answers hold, for the description
    openapi       what /openapi.json says beyond what FastAPI finds by itself
    computations  the library calls, in threads
    limits        what is refused for its size, before anything is computed
    compute       the threads that compute, and the state of one request
    streaming     responses: blocks, tags, 304
    middleware    around every request: id, log line, figures, headers, gzip, CORS
    security      the bearer token
    errors        the one table from what can go wrong to an HTTP status
    readiness     the warm-up that /readyz waits for
    logs, metrics

No mathematics is done here; whatever an answer says was computed by `attitude`.
"""

from .app import create_app
from .server import serve

__all__ = ["create_app", "serve"]
