"""When the service may be sent work: the kernel is compiled, or loaded, and a known case came out right.

The same warm-up runs when the container image is built, so that it has the compiled kernel on board.
"""

import gc
import logging
import threading
import time
from collections.abc import Iterator
from typing import Any

from attitude.formats.encoding import encoded_file
from attitude.formats.registry import FORMATS
from attitude.runtime import compiled
from attitude.scene.builtin_scenes import builtin_names
from attitude.scene.motion_summary import motion_summary
from attitude.scene.scene import Scene
from attitude.stopping import Stop, stoppable

log = logging.getLogger(__name__)

# Check case 2 of NASA/TM-2015-218675, the tumbling brick: attitude at 30 s, the last instant of its scene.
KNOWN_SCENE = "nasa-brick"
KNOWN_QUATERNION_WXYZ = (-0.8811471853104235, 0.4701825277666925, 0.01172825232487118, 0.04868753947208377)
# The published digits are good to 1e-13; a kernel that is compiled wrongly misses by far more.
KNOWN_WITHIN = 1e-12


class KnownCaseError(Exception):
    """The known case came out wrong: no answer of this process is to be trusted."""


class Readiness:
    """Whether work may be sent here: `obstacle` says why not, in words, and is None where it may.

    Decided by the warm-up, in a thread of its own; once `stop` is set, it ends without a word.
    """

    def __init__(self) -> None:
        self.obstacle: str | None = "the kernel is being compiled or loaded"
        self.stop = Stop()

    def start(self) -> None:
        # a daemon: a stop that comes while the kernel is compiled is not to wait for it
        threading.Thread(target=self.run, name="warm-up", daemon=True).start()

    def run(self) -> None:
        try:
            with stoppable(self.stop):
                summary = warm_up()
        except BaseException as error:
            if not self.stop.flag[0]:
                unexpected = "the warm-up ended with an unexpected error, which the service's log has"
                self.obstacle = str(error) if isinstance(error, KnownCaseError) else unexpected
                log.critical("not ready, and never will be", exc_info=True)
        else:
            self.obstacle = None
            log.info("ready: %s", summary)


def warm_up() -> str:
    """Compute the known case and one request of every form; says what that took.

    Raises KnownCaseError where the known case comes out wrong.
    """
    begun = time.monotonic()
    count = compiled.compile_all()
    check_known_case()
    for document in request_forms():
        scene = Scene.model_validate(document)
        encoded_file(scene.samples(), FORMATS["json"])
        motion_summary(scene.motion(), scene.name)
    encoded_file(Scene.builtin("toutatis").samples(), FORMATS["czml"])  # reads tables of the Earth
    gc.freeze()  # what was loaded stays: to look through it for garbage takes longer than most requests
    return f"known case right, {count} kernels compiled, {time.monotonic() - begun:.2f} s"


def check_known_case() -> None:
    quaternion = Scene.builtin(KNOWN_SCENE).run().quaternion("wxyz")[-1].tolist()
    pairs = zip(quaternion, KNOWN_QUATERNION_WXYZ, strict=True)
    if not all(abs(found - known) <= KNOWN_WITHIN for found, known in pairs):
        known = list(KNOWN_QUATERNION_WXYZ)
        raise KnownCaseError(f"{KNOWN_SCENE}: {quaternion} is not within {KNOWN_WITHIN} of {known}")


def request_forms() -> Iterator[dict[str, Any]]:
    """Documents that between them call all that a request can: no first caller waits for a compiler."""
    yield from ({"scene": name} for name in builtin_names())
    dates = ["2026-01-01T00:00:00", "2026-01-01T00:00:00.1"]
    dated = {"scene": KNOWN_SCENE, "epoch": {"time": dates[0], "scale": "utc"}}
    yield dated | {"body": {"tensor": [[2, 0.1, 0], [0.1, 3, 0], [0, 0, 4]], "unit": "kg m2"}}
    yield dated | {"times": {"start": 0, "stop": 3, "step": 1, "unit": "s"}}
    for scale in ("utc", "tai"):  # one converted, one not
        yield dated | {"times": {"dates": dates, "scale": scale}}
