"""The service with two routes whose computations ignore every stop; it finds them stuck after one second."""

from __future__ import annotations

import ctypes
import time

from fastapi import Request

from service import deadline
from service.app import app

deadline.STUCK_AFTER_S = 1
pause = ctypes.PyDLL(None).pause  # keeps the interpreter's lock


@app.post("/ignores-stop")
async def ignores_stop(request: Request, seconds: float = 1000.0) -> None:
    await request.app.state.compute.run(time.sleep, seconds)


@app.post("/holds-lock")
async def holds_lock(request: Request) -> None:
    await request.app.state.compute.run(pause)
