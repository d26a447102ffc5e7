"""A body of plates in wind and sunlight, by SciPy's DOP853 cut at every edge; shares nothing with the
library.

Equations of the document itself, in its units of SI; circular orbits in a frame of the user's own, a Sun of
fixed direction.  Between cuts the lit plates are fixed.  An edge is an event of the integration, located on
its dense output, and the arc up to there is integrated once more, for its end is then as exact as the method.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

MU, RADIUS, SUN_RADIUS = 3.986004e14, 6378100.0, 6.957e8  # m3/s2, m
AU, PRESSURE = 149597870700.0, 1361.0 / 299792458.0
ACCURACY = {"method": "DOP853", "rtol": 3e-14, "atol": 1e-16}


def rotation(q):
    """Body to inertial, of a quaternion of any length."""
    w, x, y, z = q / math.sqrt(q @ q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def cross(a, b):
    """Of two vectors of three; numpy's own takes ten times as long."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


class PlateMotion:
    """A document with a circular orbit, and any of drag, solar_pressure, gravity_gradient, wheels and an
    impulse.

    user : (t, rate) -> (3,) N m, body frame, a torque besides
    """

    accuracy = ACCURACY

    def __init__(self, document, user=None):
        self.document, self.user = document, user
        self.moments = np.array(document["body"]["moments"], dtype=float)
        effects = {effect["type"]: effect for effect in document["effects"]}
        self.drag, self.sunlight = effects.get("drag"), effects.get("solar_pressure")
        self.gradient = "gravity_gradient" in effects
        self.rotors = np.array(effects.get("wheels", {"momentum": {"value": [0.0] * 3}})["momentum"]["value"])
        self.impulse = effects.get("impulse")
        orbit = document["orbit"]
        self.a = RADIUS + 1e3 * orbit["altitude"]["value"]
        i = math.radians(orbit["inclination"]["value"])
        self.P, self.Q = np.array([1.0, 0.0, 0.0]), np.array([0.0, math.cos(i), math.sin(i)])
        self.n = math.sqrt(MU / self.a**3)
        self.plates = [(0, p, *geometry(p)) for p in (self.drag or {"plates": []})["plates"]]
        self.plates += [(1, p, *geometry(p)) for p in (self.sunlight or {"plates": []})["plates"]]
        direction = np.array(
            (self.sunlight or {"sun": {"direction": [1, 0, 0]}})["sun"]["direction"], dtype=float
        )
        self.sun = AU * direction / math.sqrt(direction @ direction)

    def place(self, t):
        """Position and velocity on the orbit."""
        c, s = math.cos(self.n * t), math.sin(self.n * t)
        return self.a * (c * self.P + s * self.Q), self.a * self.n * (c * self.Q - s * self.P)

    def density(self, t, r):
        """Of the air, kg/m3."""
        return self.drag["density"]["value"]

    def directions(self, t):
        """Where the wind and the light come from: vectors, inertial."""
        r, v = self.place(t)
        turning = np.array(
            [0.0, 0.0, self.drag.get("rotation", {"value": 0.0})["value"] if self.drag else 0.0]
        )
        return r, (v - cross(turning, r), self.sun - r)

    def cosines(self, t, y):
        """Of every plate to its source."""
        _, sources = self.directions(t)
        R = rotation(y[:4])
        seen = [R.T @ source / math.sqrt(source @ source) for source in sources]
        return np.array([normal @ seen[k] for k, _, normal, _, _ in self.plates])

    def overlap(self, t):
        """Angles: radii of Sun and central body as the body sees them, and between their centres."""
        r, (_, s) = self.directions(t)
        a, b = math.asin(SUN_RADIUS / math.sqrt(s @ s)), math.asin(RADIUS / math.sqrt(r @ r))
        return a, b, math.acos(-(r @ s) / math.sqrt((r @ r) * (s @ s)))

    def light(self, t):
        """Part of the Sun that is seen: discs that overlap (a cylinder: all or nothing)."""
        shadow = self.sunlight.get("shadow", "conical")
        if shadow is False:
            return 1.0
        if shadow != "conical":
            r, s = self.place(t)[0], self.sun / AU
            return float(r @ s > 0 or np.linalg.norm(r - (r @ s) * s) > RADIUS)
        a, b, c = self.overlap(t)
        if c >= a + b or c <= b - a:
            return float(c >= a + b)
        x = (c * c + a * a - b * b) / (2 * c)
        covered = a * a * math.acos(x / a) + b * b * math.acos((c - x) / b) - c * math.sqrt(a * a - x * x)
        return 1.0 - covered / (math.pi * a * a)

    def light_cuts(self, end):
        """Instants at which light begins or ends, and those around which it is not smooth."""
        if self.sunlight is None or self.sunlight.get("shadow", "conical") is False:
            return []
        ts = np.linspace(0.0, end, max(400, int(abs(end) / 20)))
        if self.sunlight.get("shadow", "conical") == "conical":
            functions = [lambda t, s=s: (lambda a, b, c: c - b - s * a)(*self.overlap(t)) for s in (1, -1)]
        else:
            functions = [lambda t: np.linalg.norm(np.cross(self.place(t)[0], self.sun / AU)) - RADIUS]
        cuts = []
        for f in functions:
            values = [f(t) for t in ts]
            pairs = zip(ts[:-1], ts[1:], values[:-1], values[1:], strict=True)
            cuts += [brentq(f, a, b, xtol=1e-12, rtol=1e-15) for a, b, u, v in pairs if u * v < 0]
        return [t for t in cuts if self.place(t)[0] @ self.sun < 0]

    def slope(self, t, y, lit, shines):
        """Of attitude (4) and momentum (3, inertial)."""
        r, (wind, to_sun) = self.directions(t)
        R = rotation(y[:4])
        rate = (R.T @ y[4:] - self.rotors) / self.moments
        torque = np.zeros(3) if self.user is None else np.asarray(self.user(t, rate))
        if self.gradient:
            e = R.T @ r / self.a
            torque = torque + 3 * MU / self.a**3 * cross(e, self.moments * e)
        w = R.T @ wind
        d = math.sqrt(to_sun @ to_sun)
        s, pressure = R.T @ to_sun / d, (PRESSURE * (AU / d) ** 2 * self.light(t) if shines else 0.0)
        density = self.density(t, r) if self.drag else 0.0
        for (source, plate, normal, centre, area), is_lit in zip(self.plates, lit, strict=True):
            if is_lit and source == 0:
                force = -0.5 * density * plate["coefficient"] * area * (normal @ w) * w
                torque = torque + cross(centre, force)
            elif is_lit and pressure:
                c, mirrored, scattered = normal @ s, plate["specular"], plate["diffuse"]
                along = (1 - mirrored) * s + 2 * (mirrored * c + scattered / 3) * normal
                torque = torque + cross(centre, -pressure * area * c * along)
        a, b, c, d = y[:4]
        x, y_, z = rate
        turn = (
            -b * x - c * y_ - d * z,
            a * x + c * z - d * y_,
            a * y_ - b * z + d * x,
            a * z + b * y_ - c * x,
        )
        return np.concatenate([0.5 * np.array(turn), R @ torque])

    def states(self, ends):
        """Attitude and momentum at instants on one side of the epoch, outwards; and the number of edges."""
        q = np.array(self.document["attitude"]["quaternion"], dtype=float)
        unit = {"deg/s": math.radians(1.0), "rad/s": 1.0}[self.document["angular_velocity"]["unit"]]
        rate = unit * np.array(self.document["angular_velocity"]["value"], dtype=float)
        y = np.concatenate([q, rotation(q) @ (self.moments * rate + self.rotors)])
        sign = math.copysign(1.0, ends[-1])
        firing = self.impulse["time"]["value"] if self.impulse else math.nan
        cuts = [t for t in self.light_cuts(ends[-1]) if 0 < sign * t < sign * ends[-1]]
        stops = sorted({*ends, *cuts, *([firing] if sign * firing > 0 else [])}, key=abs)
        t, out, edges = 0.0, [], 0
        later = y + 1e-6 * sign * self.slope(t, y, np.zeros(len(self.plates)), False)
        lit = self.cosines(1e-6 * sign, later) > 0
        for stop in stops:
            shines = self.sunlight is not None and self.light(0.5 * (t + stop)) > 0
            found = self.cosines(t, y)
            lit = np.where(np.abs(found) > 1e-7, found > 0, lit)
            y, lit, met = self.arc(t, y, stop, lit, shines)
            edges += met
            t = stop
            if stop == firing:
                y[4:] += sign * (rotation(y[:4]) @ np.array(self.impulse["angular_impulse"]["value"]))
            if stop in ends:
                out.append(y.copy())
        return np.array(out), edges

    def edge(self, i, lit):
        """The cosine of a plate, positive until its edge, as solve_ivp takes events."""
        side = 1.0 if lit[i] else -1.0

        def falls(t, y):
            return side * self.cosines(t, y)[i]

        falls.terminal, falls.direction = True, -1.0
        return falls

    def arc(self, t, y, stop, lit, shines):
        """To an instant, across the edges on the way: the state, the lit plates, and how many edges."""
        met = 0
        counted = [i for i, plate in enumerate(self.plates) if shines or plate[0] == 0]
        while t != stop:

            def slope(t, y, lit=lit):
                return self.slope(t, y, lit, shines)

            first = unique(self.plates, counted)
            found = solve_ivp(slope, (t, stop), y, events=[self.edge(i, lit) for i in first], **self.accuracy)
            if found.status == 0:
                return found.y[:, -1], lit, met
            end = found.t[-1]
            y = solve_ivp(slope, (t, end), y, **self.accuracy).y[:, -1]
            t, lit = end, lit.copy()
            now = self.cosines(t, y)
            for i in counted:
                if abs(now[i]) < 1e-7:
                    lit[i] = not lit[i]
                    met += 1
        return y, lit, met


def unique(plates, counted):
    """Indices of plates of which none is parallel to another of the same source."""
    out = []
    for i in counted:
        parallel = (
            abs(abs(plates[i][2] @ plates[j][2]) - 1) < 1e-12 and plates[i][0] == plates[j][0] for j in out
        )
        if not any(parallel):
            out.append(i)
    return out


def geometry(plate):
    """(unit normal, centre, area) of a plate of a document."""
    normal = np.array(plate["normal"], dtype=float)
    return normal / math.sqrt(normal @ normal), np.array(plate["centre"]["value"]), plate["area"]["value"]
