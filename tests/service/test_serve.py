"""The process: starts, answers, and stops on SIGTERM with what is in flight answered."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from urllib.error import URLError
from urllib.request import ProxyHandler, build_opener

from asking import READY_WITHIN_S, wait_until_ready

SERVE = "from service.app import serve; serve(port=0)"
direct = build_opener(ProxyHandler({}))


def is_ready(address):
    try:
        return direct.open(f"{address}/readyz", timeout=5).status == 200
    except URLError:
        return False


def test_process_starts_gets_ready_and_stops_cleanly():
    process = subprocess.Popen([sys.executable, "-c", SERVE], stderr=subprocess.PIPE, text=True)
    try:
        log = ""
        while "running on" not in log:
            line = process.stderr.readline()
            assert line, log
            log += line
        address = re.search(r"http://127\.0\.0\.1:\d+", log)[0]
        wait_until_ready(lambda: is_ready(address))
        process.send_signal(signal.SIGTERM)
        log += process.communicate(timeout=READY_WITHIN_S)[1]
    finally:
        process.kill()
        process.wait()
    assert "known case right" in log
    assert "Application shutdown complete" in log
    assert "Traceback" not in log
