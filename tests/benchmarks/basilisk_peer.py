"""Ours beside Basilisk (AVS Lab, University of Colorado): gravity gradient, drag of plates, a rotor.

    python -m tests.benchmarks.basilisk_peer                        (pip install bsk)

Basilisk integrates spacecraft and orbit together by Runge and Kutta's method of order 4 in steps of a fixed
length.  In two lengths its answers differ by its own error: neither may be off ours by more, and one of them
has to be much nearer (by 16 the finer, where no plate turns its edge within a step).  Its gravity gradient
acts on the wheel too, so that the rotor has none.
"""

from __future__ import annotations

import sys
import warnings
from time import perf_counter
from typing import Any

import numpy as np
from Basilisk.architecture import messaging
from Basilisk.simulation import (
    GravityGradientEffector,
    facetDragDynamicEffector,
    reactionWheelStateEffector,
    spacecraft,
)
from Basilisk.utilities import SimulationBaseClass, macros, simIncludeGravBody, simIncludeRW

from attitude import Scene

STEPS = 0.2, 0.1  # s
SECONDS = 3000.0
MASS = 1e9  # kg: drag does not change the orbit
MOMENTS = [0.9, 1.1, 1.3]
RATE = [0.02, -0.03, 0.015]  # rad/s
Q = np.array([0.5, -0.5, 0.1, 0.7]) / np.linalg.norm([0.5, -0.5, 0.1, 0.7])
A, INCLINATION = 7.0e6, 0.9  # m, rad
DENSITY = 2e-11  # kg/m3
# area, drag coefficient, normal, centre
PLATES = (
    (0.5, 2.2, [0.0, 0.0, 1.0], [0.02, -0.01, 0.3]),
    (0.3, 2.2, [0.0, 0.6, -0.8], [0.1, 0.2, -0.1]),
)
WHEEL = 0.08  # kg m2, about y
SPEED = 6.0  # rad/s, relative to the body


def quantity(value: Any, unit: str) -> dict[str, Any]:
    return {"value": value, "unit": unit}


def document(moments: list[float], effects: list[dict[str, Any]], mu: float) -> dict[str, Any]:
    return {
        "body": {"moments": moments, "unit": "kg m2"},
        "frame": "INERTIAL",
        "attitude": {"quaternion": Q.tolist(), "order": "wxyz"},
        "angular_velocity": quantity(RATE, "rad/s"),
        "times": {"elapsed": [SECONDS], "unit": "s"},
        "orbit": {
            "semi_major_axis": quantity(A, "m"),
            "inclination": quantity(INCLINATION, "rad"),
            "mu": quantity(mu, "m3/s2"),
        },
        "effects": effects,
        "tolerance": quantity(1e-11, "rad"),
    }


class Peer:
    """One spacecraft on a circular orbit."""

    def __init__(self, step: float):
        self.simulation = SimulationBaseClass.SimBaseClass()
        process = self.simulation.CreateNewProcess("process")
        process.addTask(self.simulation.CreateNewTask("task", macros.sec2nano(step)))
        self.spacecraft = body = spacecraft.Spacecraft()
        bodies = simIncludeGravBody.gravBodyFactory()
        self.earth = bodies.createEarth()
        self.earth.isCentralBody = True
        bodies.addBodiesTo(body)
        speed = np.sqrt(self.earth.mu / A)
        body.hub.mHub, body.hub.IHubPntBc_B = MASS, np.diag(MOMENTS).tolist()
        body.hub.r_CN_NInit = [A, 0.0, 0.0]
        body.hub.v_CN_NInit = [0.0, speed * np.cos(INCLINATION), speed * np.sin(INCLINATION)]
        body.hub.sigma_BNInit = (Q[1:] / (1.0 + Q[0])).reshape(3, 1).tolist()
        body.hub.omega_BN_BInit = np.array(RATE).reshape(3, 1).tolist()
        self.simulation.AddModelToTask("task", body)

    def attitude(self) -> tuple[np.ndarray, float]:
        """(4,) wxyz at the end, and s of the integration."""
        self.simulation.InitializeSimulation()
        self.simulation.ConfigureStopTime(macros.sec2nano(SECONDS))
        begun = perf_counter()
        self.simulation.ExecuteSimulation()
        seconds = perf_counter() - begun
        sigma = np.array(self.spacecraft.scStateOutMsg.read().sigma_BN)
        square = sigma @ sigma
        return np.append(1.0 - square, 2.0 * sigma) / (1.0 + square), seconds


def gravity_gradient(step: float) -> Peer:
    peer = Peer(step)
    peer.effector = GravityGradientEffector.GravityGradientEffector()
    peer.effector.addPlanetName(peer.earth.planetName)
    peer.spacecraft.addDynamicEffector(peer.effector)
    peer.simulation.AddModelToTask("task", peer.effector)
    return peer


def drag(step: float) -> Peer:
    peer = Peer(step)
    peer.effector = facetDragDynamicEffector.FacetDragDynamicEffector()
    for plate in PLATES:
        peer.effector.addFacet(*plate)
    peer.density = messaging.AtmoPropsMsg().write(messaging.AtmoPropsMsgPayload(neutralDensity=DENSITY))
    peer.effector.atmoDensInMsg.subscribeTo(peer.density)
    peer.spacecraft.addDynamicEffector(peer.effector)
    peer.simulation.AddModelToTask("task", peer.effector)
    return peer


def rotor(step: float) -> Peer:
    """A wheel without a motor: its own momentum along its axis stays, that relative to space."""
    peer = Peer(step)
    wheels = simIncludeRW.rwFactory()
    options = {"Js": WHEEL, "Omega": SPEED / macros.RPM, "RWModel": messaging.BalancedWheels}
    wheels.create("custom", [0.0, 1.0, 0.0], u_max=1.0, **options)
    peer.wheels = reactionWheelStateEffector.ReactionWheelStateEffector()
    wheels.addToSpacecraft("wheels", peer.wheels, peer.spacecraft)
    peer.simulation.AddModelToTask("task", peer.wheels)
    return peer


def ours(name: str, mu: float) -> dict[str, Any]:
    if name == "gravity gradient":
        return document(MOMENTS, [{"type": "gravity_gradient"}], mu)
    if name == "drag of plates":
        plates = [
            {
                "area": quantity(area, "m2"),
                "coefficient": coefficient,
                "normal": normal,
                "centre": quantity(centre, "m"),
            }
            for area, coefficient, normal, centre in PLATES
        ]
        air = {"plates": plates, "density": quantity(DENSITY, "kg/m3"), "corotating": False}
        return document(MOMENTS, [{"type": "drag", **air}], mu)
    # the body without the wheel's inertia about its axis, and the wheel's momentum relative to space
    momentum = [0.0, WHEEL * (SPEED + RATE[1]), 0.0]
    body = [MOMENTS[0], MOMENTS[1] - WHEEL, MOMENTS[2]]
    return document(body, [{"type": "wheels", "momentum": quantity(momentum, "N m s")}], mu)


def angle(p: np.ndarray, q: np.ndarray) -> float:
    """rad."""
    return float(2.0 * np.linalg.norm(p[0] * q[1:] - q[0] * p[1:] - np.cross(p[1:], q[1:])))


ROWS = {"gravity gradient": gravity_gradient, "drag of plates": drag, "a rotor": rotor}


def print_row(name: str) -> bool:
    mu = ROWS[name](1.0).earth.mu
    scene = Scene.model_validate(ours(name, mu))
    scene.run()
    begun = perf_counter()
    run = scene.run()
    seconds = perf_counter() - begun
    (coarse, _), (fine, theirs) = (ROWS[name](step).attitude() for step in STEPS)
    q = run.quaternion("wxyz")[0]
    errors, apart = [angle(coarse, q), angle(fine, q)], angle(coarse, fine)
    text = (
        f"ours {1e3 * seconds:.1f} ms, bound {run.plan.error_bound:.1e} rad; Basilisk {1e3 * theirs:.0f} ms,"
    )
    text += f" off ours {errors[0]:.1e} and {errors[1]:.1e} in steps of {STEPS[0]:g} and {STEPS[1]:g} s"
    print(f"{name:16} {text}; {apart:.1e} apart", flush=True)
    return min(errors) < 0.3 * apart and max(errors) < 1.3 * apart


def main() -> int:
    warnings.simplefilter("ignore")
    agreed = [print_row(name) for name in ROWS]
    return 0 if all(agreed) else 1


if __name__ == "__main__":
    sys.exit(main())
