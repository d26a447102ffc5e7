"""The library over HTTP: a document in, one library call, the answer out.

routes has the handlers, schemas and dependencies what they take, computations the library calls that compute
runs in threads; streaming, errors and openapi make and describe the answers; around all stand
middleware, security, logs and metrics.
No mathematics is done here: what an answer says `attitude` computed.
"""

from .app import create_app
from .server import serve

__all__ = ["create_app", "serve"]
