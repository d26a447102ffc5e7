"""Truth of scenes under all effects at once: heyoka's Taylor series in 80-bit numbers.

The equations are written from the document's own numbers and share nothing with the library.  They are
compiled once, with every number of a scene as a parameter; plates that turn their edges and the border of the
shadow are events, and thrust and impulses cut the span.
"""

from __future__ import annotations

import math
from itertools import count
from typing import Any

import heyoka as hy
import numpy as np

LD = np.longdouble
AU, PRESSURE = 149597870700.0, 1361.0 / 299792458.0
MAX_STEPS = 4000  # from one instant to the next


class TooManyStepsError(ArithmeticError):
    """The body turns too far."""


def dot(a, b):
    return sum(p * k for p, k in zip(a, b, strict=True))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def plus(*vectors):
    return [sum(parts) for parts in zip(*vectors, strict=True)]


def times(factor, v):
    return [factor * k for k in v]


def seen(q, v):
    """conj(q) v q."""
    w, x, y, z = q
    u = [x, y, z]
    twice = times(-2.0, cross(u, v))
    return plus(v, times(w, twice), times(-1.0, cross(u, twice)))


class _Numbers:
    """Parameters by name, in vectors of some length."""

    def __init__(self, make):
        self._make, self._next = make, count()
        self.index: dict[str, list[int]] = {}

    def __call__(self, name, size=3):
        self.index[name] = [next(self._next) for _ in range(size)]
        return [self._make(i) for i in self.index[name]]


class CampaignTruth:
    """Attitudes of documents.

    plates : how many of drag, and of sunlight, the documents have at the most; their edges are events
    groups : plates, those of drag first, that turn their edges together (heyoka stops at one event of a
        time), as (index, 1, or -1 where one faces the other way); by default none do
    disturbance : by this part of its size the momentum at the epoch is off, for what that grows to
    max_steps : from one instant to the next; 0 for any number

    Units: the greatest moment, a rate `pace` and, on the orbit, its semi-major axis.
    """

    def __init__(
        self,
        plates: int,
        tolerance: float,
        disturbance: float = 0.0,
        max_steps: int = MAX_STEPS,
        groups: Any = None,
    ):
        numbers = _Numbers(lambda i: hy.par[i])
        equations, cosines = _equations(numbers, plates)
        self.index, self.plates, self.max_steps = numbers.index, plates, max_steps
        self._disturbance = LD(disturbance)
        self._direction, events = 1.0, []
        alone = [((i, 1),) for i in range(len(cosines))]  # the border of the shadow is the last
        for group in [*groups, alone[-1]] if groups else alone:
            events.append(hy.t_event(cosines[group[0][0]], fp_type=LD, callback=self._sides(group)))
        size = sum(len(indices) for indices in self.index.values())
        self._integrator = hy.taylor_adaptive(
            equations,
            [LD(1)] * len(equations),
            time=LD(0),
            pars=np.ones(size, dtype=LD),
            fp_type=LD,
            tol=LD(tolerance),
            t_events=events,
            compact_mode=True,
            high_accuracy=True,
        )

    def _sides(self, group):
        def change(integrator, sign):
            for i, facing in group:
                after = LD(sign * group[0][1] * facing * self._direction > 0)
                if i < 2 * self.plates:
                    integrator.pars[self.index["lit"][i]] = after
                elif dot(integrator.state[7:10], self._sun) < 0:  # the shadow is behind the central body
                    integrator.pars[self.index["shine"][0]] = after
            return True

        return change

    def attitudes(self, document: dict[str, Any], seconds: np.ndarray) -> np.ndarray:
        """(n, 4) wxyz, normalised, at instants (n,) s, 80 bits, in any order."""
        out = np.empty((len(seconds), 4), dtype=LD)
        for direction in (1.0, -1.0):
            side = np.flatnonzero(seconds >= 0.0 if direction > 0.0 else seconds < 0.0)
            order = side[np.argsort(np.abs(seconds[side]))]
            if order.size:
                out[order] = self._outwards(document, seconds[order], direction)
        return out / np.sqrt((out * out).sum(axis=1))[:, None]

    def _outwards(self, document, seconds, direction):
        self._direction, scene = direction, _Scene(document, self.plates)
        self._sun = scene.sun
        integrator, pace = self._integrator, scene.pace
        integrator.time = LD(0)
        integrator.reset_cooldowns() if self.plates else None
        integrator.state[:] = scene.state
        integrator.state[4:7] += self._disturbance * np.abs(scene.state[4:7]).max()
        for name, values in scene.numbers(direction).items():
            if name in self.index:
                integrator.pars[self.index[name]] = values
        if self.plates:
            self._begin(scene, direction)
        end, out = seconds[-1], []
        cuts = sorted({t for t in scene.cuts if 0.0 < t * direction <= end * direction} | {0.0}, key=abs)
        instants = sorted({*cuts, *seconds}, key=abs)
        for t in instants:
            outcome = integrator.propagate_until(LD(t) * LD(pace), max_steps=self.max_steps)[0]
            if outcome.name == "step_limit":
                raise TooManyStepsError
            if outcome.name != "time_limit":
                raise ArithmeticError(f"heyoka: {outcome.name} in {document}")
            if t in cuts:
                if t != 0.0 or direction > 0.0:  # the state at the epoch is that before an impulse then
                    integrator.state[4:7] += direction * scene.jump(t, integrator.state[:4])
                integrator.pars[self.index["fixed"]] = scene.thrust(t, direction)
            if t in seconds:
                out += [integrator.state[:4].copy()] * int((seconds == t).sum())
        return np.array(out)

    def _begin(self, scene, direction):
        """Plates in wind or light, and whether the Sun shines, a moment after the epoch."""
        integrator, moment = self._integrator, LD(direction * 1e-9)
        state = integrator.state.copy()
        cosines = scene.cosines(state + moment * scene.rough_slope(state))
        integrator.pars[self.index["lit"]] = (cosines > 0).astype(LD)
        integrator.pars[self.index["shine"]] = LD(scene.shines(state[7:10]))


def _equations(numbers, plates):
    """(equations, events) in the parameters."""
    names = ["q0", "q1", "q2", "q3", "m1", "m2", "m3", "r1", "r2", "r3", "v1", "v2", "v3"]
    state = hy.make_vars(*names)
    q, m, r, v = state[:4], state[4:7], state[7:10], state[10:13]
    inverses, rotors, (alpha,) = numbers("inverses"), numbers("rotors"), numbers("alpha", 1)
    moments = numbers("moments")
    w = [a * (k - h) for a, k, h in zip(inverses, m, rotors, strict=True)]
    W = plus(w, times(alpha, cross(m, w)))
    (pull,) = numbers("pull", 1)  # (n / pace)^2
    square = dot(r, r)
    inverse3 = square ** LD(-1.5)
    e, shorter2 = seen(q, r), square ** LD(-1.0)
    C = [numbers(f"damping {i}") for i in range(3)]
    torque = plus(numbers("fixed"), seen(q, numbers("inertial")), [-dot(row, w) for row in C])
    (gradient,) = numbers("gradient", 1)
    moment_e = [a * k for a, k in zip(moments, e, strict=True)]
    torque = plus(torque, times(gradient * inverse3 * shorter2, cross(e, moment_e)))
    (turn,) = numbers("turn", 1)
    c, s = hy.cos(turn * hy.time), hy.sin(turn * hy.time)
    d = plus(numbers("axis a"), times(c, numbers("axis b")), times(s, numbers("axis c")))
    field = plus(times(LD(3) * dot(d, r) * shorter2, r), times(LD(-1), d))
    torque = plus(torque, times(inverse3, cross(numbers("dipole"), seen(q, field))))
    (beat,) = numbers("beat", 1)
    torque = plus(torque, times(hy.sin(beat * hy.time), numbers("swing")))
    cosines = []
    if plates:
        more, cosines = _plates(numbers, plates, q, r, v, square)
        torque = plus(torque, more)
    half = [LD(0.5) * k for k in W]
    slopes = [
        -q[1] * half[0] - q[2] * half[1] - q[3] * half[2],
        q[0] * half[0] + q[2] * half[2] - q[3] * half[1],
        q[0] * half[1] - q[1] * half[2] + q[3] * half[0],
        q[0] * half[2] + q[1] * half[1] - q[2] * half[0],
    ]
    slopes += plus(cross(m, W), torque)
    slopes += [*v, *times(-pull * inverse3, r)]
    return list(zip(state, slopes, strict=True)), cosines


def _plates(numbers, plates, q, r, v, square):
    """(torque, events) of drag and sunlight."""
    lit, (shine,), (spin,) = numbers("lit", 2 * plates), numbers("shine", 1), numbers("spin", 1)
    wind = plus(v, [spin * r[1], -spin * r[0], LD(0) * r[2]])
    speed2, to_sun = dot(wind, wind), plus(numbers("sun"), times(LD(-1), r))
    distance2 = dot(to_sun, to_sun)
    (reference,), (shorter,), (radius2,) = (numbers(k, 1) for k in ("reference", "shorter", "radius2"))
    thickness = hy.exp(shorter * (reference - hy.sqrt(square)))
    ahead = seen(q, times(speed2 ** LD(-0.5), wind))
    light = seen(q, times(distance2 ** LD(-0.5), to_sun))
    torque, cosines = [LD(0) * k for k in r], []
    for i in range(plates):
        normal, centre, (area,) = (numbers(f"drag {k} {i}", n) for k, n in (("n", 3), ("c", 3), ("a", 1)))
        cosines.append(dot(normal, ahead))
        force = times(lit[i] * area * thickness * speed2 * cosines[-1], ahead)
        torque = plus(torque, times(LD(-1), cross(centre, force)))
    for i in range(plates):
        normal, centre, (area,) = (numbers(f"light {k} {i}", n) for k, n in (("n", 3), ("c", 3), ("a", 1)))
        mirrored, scattered = numbers(f"light o {i}", 2)
        cosines.append(dot(normal, light))
        size = lit[plates + i] * shine * area * distance2 ** LD(-1) * cosines[-1]
        along = times(LD(2) * (mirrored * cosines[-1] + scattered / LD(3)), normal)
        force = plus(times(LD(1) - mirrored, light), along)
        torque = plus(torque, times(LD(-1) * size, cross(centre, force)))
    direction = numbers("to sun")
    off = plus(r, times(LD(-1) * dot(r, direction), direction))
    return torque, [*cosines, dot(off, off) - radius2]


class _Scene:
    """The numbers of a document in the units of the equations."""

    def __init__(self, document, plates):
        self.effects, self.plates = document["effects"], plates
        self.moments = np.array(document["body"]["moments"], dtype=LD)
        q = np.array(document["attitude"]["quaternion"], dtype=LD)
        self.q = q / np.sqrt(q @ q)
        self.rate = np.array(document["angular_velocity"]["value"], dtype=LD)
        self.orbit = {
            k: LD(v["value"]) if isinstance(v, dict) else LD(v) for k, v in document["orbit"].items()
        }
        a, mu = self.orbit["semi_major_axis"], self.orbit["mu"]
        n = np.sqrt(mu / a**3)
        self.unit = self.moments.max()
        self.pace = max(float(np.sqrt(self.rate @ self.rate)), float(n))
        self.torque_unit = self.unit * LD(self.pace) ** 2
        self.n = n / LD(self.pace)
        self.alpha = sum((LD(e["coefficient"]["value"]) for e in self._of("dissipation")), LD(0))
        self.rotors = self._sum("wheels", "momentum") / (self.unit * LD(self.pace))
        sun = [e["sun"]["direction"] for e in self._of("solar_pressure")] or [[1.0, 0.0, 0.0]]
        self.sun = np.array(sun[0], dtype=LD)
        self.sun = self.sun / np.sqrt(self.sun @ self.sun)
        self.cuts = {0.0}
        for effect in self._of("constant_torque"):
            self.cuts |= {effect[key]["value"] for key in ("start", "stop") if key in effect}
        self.cuts |= {effect["time"]["value"] for effect in self._of("impulse")}
        self.state = np.concatenate([self.q, self._momentum(), *self._place()])

    def _of(self, kind):
        return [effect for effect in self.effects if effect["type"] == kind]

    def _sum(self, kind, name, **fixed):
        chosen = [e for e in self._of(kind) if all(e.get(k) == v for k, v in fixed.items())]
        return sum((np.array(e[name]["value"], dtype=LD) for e in chosen), np.zeros(3, dtype=LD))

    def _momentum(self):
        """m, of the rate W that a document gives: W = w + alpha m x w."""
        whole, moments = self.rate / LD(self.pace), self.moments / self.unit
        alpha, w = self.alpha * self.unit * LD(self.pace), whole
        for _ in range(300 if alpha else 0):
            w = whole - alpha * np.array(cross(moments * w + self.rotors, w))
        return moments * w + self.rotors

    def _place(self):
        """Position and velocity, in units of a and a pace."""
        e, M = self.orbit.get("eccentricity", LD(0)), self.orbit["mean_anomaly"]
        E = M
        for _ in range(200):
            E = E - (E - e * np.sin(E) - M) / (LD(1) - e * np.cos(E))
        node, argument, i = (self.orbit[k] for k in ("raan", "argument_of_pericentre", "inclination"))
        along = np.array([np.cos(node), np.sin(node), LD(0)])
        across = np.array([-np.sin(node) * np.cos(i), np.cos(node) * np.cos(i), np.sin(i)])
        P, Q = np.cos(argument) * along + np.sin(argument) * across, None
        Q = np.cos(argument) * across - np.sin(argument) * along
        minor, slow = np.sqrt(LD(1) - e * e), LD(1) - e * np.cos(E)
        r = P * (np.cos(E) - e) + Q * (minor * np.sin(E))
        return r, (self.n / slow) * (Q * (minor * np.cos(E)) - P * np.sin(E))

    def thrust(self, t, direction):
        """Constant torques along the body's axes that act just after an instant, outwards."""
        total = np.zeros(3, dtype=LD)
        for effect in self._of("constant_torque"):
            if effect["frame"] == "body":
                start = effect.get("start", {"value": -math.inf})["value"]
                stop = effect.get("stop", {"value": math.inf})["value"]
                if start <= t < stop if direction > 0 else start < t <= stop:
                    total = total + np.array(effect["torque"]["value"], dtype=LD)
        return total / self.torque_unit

    def jump(self, t, q):
        """Momentum that impulses of this instant add, along the body's axes."""
        total = np.zeros(3, dtype=LD)
        for effect in self._of("impulse"):
            if effect["time"]["value"] == t:
                value = np.array(effect["angular_impulse"]["value"], dtype=LD)
                inertial = effect["frame"] == "inertial"
                unit = q / np.sqrt(q @ q)
                total = total + (np.array(seen(unit, list(value))) if inertial else value)
        return total / (self.unit * LD(self.pace))

    def numbers(self, direction):
        """Parameters by name."""
        unit, pace, a = self.unit, LD(self.pace), self.orbit["semi_major_axis"]
        out = {
            "inverses": unit / self.moments,
            "moments": self.moments / unit,
            "rotors": self.rotors,
            "alpha": [self.alpha * unit * pace],
            "pull": [self.n**2],
            "fixed": self.thrust(0.0, direction),
            "inertial": self._sum("constant_torque", "torque", frame="inertial") / self.torque_unit,
            "gradient": [LD(3) * self.n**2 if self._of("gravity_gradient") else LD(0)],
        }
        damping = sum((np.array(e["tensor"], dtype=LD) for e in self._of("eddy_damping")), np.zeros((3, 3)))
        user = self._of("user")
        damping = damping + sum((LD(e["damping"]) * np.eye(3) for e in user), np.zeros((3, 3)))
        out |= {f"damping {i}": damping[i] / (unit * pace) for i in range(3)}
        swing = sum((np.array(e["swing"], dtype=LD) for e in user), np.zeros(3))
        out |= {"swing": swing / self.torque_unit, "beat": [LD(user[0]["beat"]) / pace if user else LD(0)]}
        return out | self._magnetic(pace, a) | self._drag(pace, a) | self._light(a)

    def _magnetic(self, pace, a):
        zero = np.zeros(3, dtype=LD)
        out = {"dipole": zero, "axis a": zero, "axis b": zero, "axis c": zero, "turn": [LD(0)]}
        for effect in self._of("magnetic_dipole"):
            field = {k: LD(v["value"]) for k, v in effect["field"].items()}
            # inwards in the north: the dipole itself points south
            flat, long = -np.sin(field["tilt"]), field["longitude"]
            x, y, z = flat * np.cos(long), flat * np.sin(long), -np.cos(field["tilt"])
            strength = field["strength"] * (field["radius"] / a) ** 3 / self.torque_unit
            out["dipole"] = strength * np.array(effect["dipole"]["value"], dtype=LD)
            out["axis a"], out["axis b"] = np.array([LD(0), LD(0), z]), np.array([x, y, LD(0)])
            out["axis c"], out["turn"] = np.array([-y, x, LD(0)]), [field["rotation"] / pace]
        return out

    def _drag(self, pace, a):
        sizes = (("c", 3), ("a", 1))
        out = {f"drag {k} {i}": np.zeros(n, dtype=LD) for i in range(self.plates) for k, n in sizes}
        out |= {f"drag n {i}": np.array([LD(0), LD(0), LD(1)]) for i in range(self.plates)}
        out |= {"spin": [LD(0)], "reference": [LD(0)], "shorter": [LD(0)]}
        for effect in self._of("drag"):
            out["spin"] = [LD(effect["rotation"]["value"]) / pace]
            if "scale_height" in effect:
                out["shorter"] = [a / LD(effect["scale_height"]["value"])]
                height = self.orbit["radius"] + LD(effect["reference_altitude"]["value"])
                out["reference"] = [height / a]
            size = LD(0.5) * LD(effect["density"]["value"]) * (a * pace) ** 2 / self.torque_unit
            for i, plate in enumerate(effect["plates"]):
                normal = np.array(plate["normal"], dtype=LD)
                out[f"drag n {i}"] = normal / np.sqrt(normal @ normal)
                out[f"drag c {i}"] = np.array(plate["centre"]["value"], dtype=LD)
                out[f"drag a {i}"] = [size * LD(plate["coefficient"]) * LD(plate["area"]["value"])]
        return out

    def _light(self, a):
        sizes = (("c", 3), ("a", 1), ("o", 2))
        out = {f"light {k} {i}": np.zeros(n, dtype=LD) for i in range(self.plates) for k, n in sizes}
        out |= {f"light n {i}": np.array([LD(0), LD(0), LD(1)]) for i in range(self.plates)}
        out |= {"sun": self.sun * LD(AU) / a, "to sun": self.sun}
        shadow = any(effect["shadow"] for effect in self._of("solar_pressure"))
        out["radius2"] = [(self.orbit["radius"] / a) ** 2 if shadow else LD(0)]
        for effect in self._of("solar_pressure"):
            size = LD(PRESSURE) * (LD(AU) / a) ** 2 / self.torque_unit
            for i, plate in enumerate(effect["plates"]):
                normal = np.array(plate["normal"], dtype=LD)
                out[f"light n {i}"] = normal / np.sqrt(normal @ normal)
                out[f"light c {i}"] = np.array(plate["centre"]["value"], dtype=LD)
                out[f"light a {i}"] = [size * LD(plate["area"]["value"])]
                out[f"light o {i}"] = [LD(plate["specular"]), LD(plate["diffuse"])]
        return out

    def shines(self, r):
        """Whether the body is in sunlight, on the orbit at r; always where there is no shadow."""
        if not any(effect["shadow"] for effect in self._of("solar_pressure")):
            return 1.0
        off = r - (r @ self.sun) * self.sun
        return float(
            r @ self.sun > 0 or off @ off > (self.orbit["radius"] / self.orbit["semi_major_axis"]) ** 2
        )

    def cosines(self, state):
        """Of the plates to wind and light."""
        numbers, q, r, v = self.numbers(1.0), list(state[:4]), state[7:10], state[10:13]
        spin = numbers["spin"][0]
        wind = v + np.array([spin * r[1], -spin * r[0], LD(0)])
        sources = [seen(q, list(wind))] * self.plates + [seen(q, list(numbers["sun"] - r))] * self.plates
        normals = [numbers[f"{k} n {i}"] for k in ("drag", "light") for i in range(self.plates)]
        return np.array([dot(n, s) for n, s in zip(normals, sources, strict=True)], dtype=LD)

    def rough_slope(self, state):
        """Of attitude and place alone: which way the cosines go."""
        q, m = state[:4], state[4:7]
        x, y, z = (m - self.rotors) * (self.unit / self.moments) / LD(2)
        turn = [
            -q[1] * x - q[2] * y - q[3] * z,
            q[0] * x + q[2] * z - q[3] * y,
            q[0] * y - q[1] * z + q[3] * x,
            q[0] * z + q[1] * y - q[2] * x,
        ]
        return np.concatenate([np.array(turn), np.zeros(3), state[10:13], np.zeros(3)]).astype(LD)


def most_plates(document: dict[str, Any]) -> int:
    """Of one effect of a document."""
    return max((len(effect.get("plates", ())) for effect in document["effects"]), default=0)
