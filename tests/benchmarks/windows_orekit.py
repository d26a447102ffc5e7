"""Ends of windows beside Orekit's FieldOfViewDetector on its own TorqueFree motion.

    python -m tests.benchmarks.windows_orekit FOLDER [max_check_s]

needs orekit_jpype, and a folder with tai-utc.dat.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from attitude import RigidBody, TorqueFreeMotion
from attitude.windows import angle

SPAN, TUMBLERS = 3000.0, 20  # s


def main(folder: str, max_check: str = "0.05") -> None:
    """Print how many ends there are, and the greatest difference."""
    import orekit_jpype

    orekit_jpype.initVM()
    from java.io import File
    from org.orekit.data import DataContext, DirectoryCrawler

    DataContext.getDefault().getDataProvidersManager().addProvider(DirectoryCrawler(File(folder)))
    rng, differences, counts = np.random.default_rng(5), [0.0], np.zeros(2, int)
    for _ in range(TUMBLERS):
        moments, rate = np.sort(rng.uniform(1, 2, 3)), rng.normal(size=3) * 0.1
        axis, to = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
        limit = float(rng.uniform(0.2, 1.4))
        motion = TorqueFreeMotion(RigidBody(moments), [1, 0, 0, 0], rate, order="wxyz")
        windows = motion.crossings(angle(axis, to=to) < limit, 0.0, SPAN)
        begun, ended = ~windows.begins_before, ~windows.ends_after
        ours = np.sort(np.append(windows.start.seconds[begun], windows.stop.seconds[ended]))
        theirs = crossings_of_orekit((moments, rate, axis, to), limit, float(max_check))
        counts += len(ours), len(theirs)
        if len(ours) == len(theirs):
            differences.append(float(np.abs(ours - theirs).max(initial=0.0)))
    print(f"{counts[0]} ends, {counts[1]} by Orekit; greatest difference {max(differences):.1e} s")


def crossings_of_orekit(case: tuple[np.ndarray, ...], limit: float, max_check: float) -> np.ndarray:
    """Instants, s, at which a target far away enters or leaves a circular field of view."""
    from org.hipparchus.geometry.euclidean.threed import Rotation, Vector3D
    from org.orekit.attitudes import Attitude, Inertia, InertiaAxis, TorqueFree
    from org.orekit.frames import FramesFactory
    from org.orekit.geometry.fov import CircularFieldOfView
    from org.orekit.orbits import KeplerianOrbit, PositionAngleType
    from org.orekit.propagation.analytical import KeplerianPropagator
    from org.orekit.propagation.events import FieldOfViewDetector
    from org.orekit.propagation.events.handlers import RecordAndContinue
    from org.orekit.time import AbsoluteDate, TimeScalesFactory
    from org.orekit.utils import ConstantPVCoordinatesProvider

    def vector(values: Any) -> Any:
        return Vector3D(*map(float, values))

    moments, rate, axis, to = case
    frame, start = FramesFactory.getGCRF(), AbsoluteDate(2024, 1, 1, 0, 0, 0.0, TimeScalesFactory.getTAI())
    principal = [InertiaAxis(float(m), vector(row)) for m, row in zip(moments, np.eye(3), strict=True)]
    acceleration = -np.cross(rate, moments * rate) / moments
    attitude = Attitude(start, frame, Rotation(1.0, 0.0, 0.0, 0.0, False), vector(rate), vector(acceleration))
    anomaly = PositionAngleType.TRUE
    orbit = KeplerianOrbit(7e6, 0.001, 1.0, 0.0, 0.0, 0.0, anomaly, frame, start, 3.986004415e14)
    propagator = KeplerianPropagator(orbit, TorqueFree(attitude, Inertia(*principal)))
    target, record = ConstantPVCoordinatesProvider(vector(to * 1e18), frame), RecordAndContinue()
    detector = FieldOfViewDetector(target, CircularFieldOfView(vector(axis), limit, 0.0))
    propagator.addEventDetector(detector.withMaxCheck(max_check).withThreshold(1e-10).withHandler(record))
    propagator.propagate(start.shiftedBy(SPAN))
    return np.array([each.getState().getDate().durationFrom(start) for each in record.getEvents()])


if __name__ == "__main__":
    main(*sys.argv[1:])
