"""Bodies of plates beside an independent truth, with times (docs/torques.md, section 5).

    python -m tests.benchmarks.plate_truth [ROW ...]      (the extra `peers`; without a ROW all of them)

The truth is heyoka's Taylor series in 80-bit numbers, tolerance 1e-19, with the edges as its events: it
shares nothing with the library.  It has no penumbra: there the rows are without a truth, or have a
cylindrical shadow.
"""

import sys
import warnings
from statistics import median
from time import perf_counter, process_time

import numpy as np

from attitude import Scene
from tests.dynamics.motions import angle
from tests.dynamics.scenes import quantity
from tests.dynamics.test_plates import DRAG, LIGHT, cubesat
from tests.oracles.plate_motion import AU, MU, PRESSURE, PlateMotion, rotation

DAY = 86400
LD = np.longdouble
CUBESAT_LIGHT = LIGHT | {
    "plates": [p | {"area": quantity(0.1 * p["area"]["value"], "m2")} for p in LIGHT["plates"]],
    "shadow": "cylindrical",
}


def times(stop, step):
    return {"start": 0, "stop": stop, "step": step, "unit": "s"}


def many_plates(count):
    """Effects of a round body of so many plates."""
    rng, drag, light = np.random.default_rng(1), [], []
    for _ in range(count):
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        centre = 0.1 * normal + 0.02 * rng.normal(size=3)
        plate = {
            "normal": normal.tolist(),
            "centre": quantity(centre.tolist(), "m"),
            "area": quantity(0.14 / count, "m2"),
        }
        drag.append(plate | {"coefficient": 2.2})
        light.append(plate | {"specular": 0.1, "diffuse": 0.2})
    return DRAG | {"plates": drag}, CUBESAT_LIGHT | {"plates": light}


GRADIENT = {"type": "gravity_gradient"}
PLAIN = cubesat(GRADIENT, DRAG, CUBESAT_LIGHT, times=times(DAY, 60), tolerance=quantity(1e-9, "rad"))
FAST = {"angular_velocity": quantity([20, 15, -16], "deg/s"), "tolerance": quantity(1e-7, "rad")}
AT_REST = {"angular_velocity": quantity([0, 0, 0], "deg/s")}
ROUND = cubesat(GRADIENT, *many_plates(100), times=times(DAY, 60), tolerance=quantity(1e-8, "rad"))
# name: the document, and up to which instant the truth goes (0: none)
ROWS = {
    "CubeSat, one orbit": (PLAIN | {"times": times(5520, 60)}, 5520),
    "CubeSat, one day": (PLAIN, DAY),
    "the same with a penumbra": (
        PLAIN | {"effects": [GRADIENT, DRAG, CUBESAT_LIGHT | {"shadow": "conical"}]},
        0,
    ),
    "at 30 deg/s, one day": (PLAIN | FAST, DAY),
    "at rest, one day, 3e-11": (PLAIN | AT_REST | {"tolerance": quantity(3e-11, "rad")}, DAY),
    "100 plates, one day": (ROUND, 600),
}


class Truth(PlateMotion):
    """The same document by heyoka."""

    def equations(self):
        """(equations, cosines of the plates): parameters are the lit plates, and after them the light."""
        import heyoka as hy

        q, L = hy.make_vars("q0", "q1", "q2", "q3"), hy.make_vars("L0", "L1", "L2")
        (w, x, y, z), t = q, hy.time
        double = LD(2) / (w * w + x * x + y * y + z * z)
        R = [
            [LD(1) - double * (y * y + z * z), double * (x * y - w * z), double * (x * z + w * y)],
            [double * (x * y + w * z), LD(1) - double * (x * x + z * z), double * (y * z - w * x)],
            [double * (x * z - w * y), double * (y * z + w * x), LD(1) - double * (x * x + y * y)],
        ]
        n = np.sqrt(LD(MU) / LD(self.a) ** 3)
        c, s = hy.cos(n * t), hy.sin(n * t)
        r = [LD(self.a) * (c * LD(p) + s * LD(k)) for p, k in zip(self.P, self.Q, strict=True)]
        v = [LD(self.a) * n * (c * LD(k) - s * LD(p)) for p, k in zip(self.P, self.Q, strict=True)]
        turn = LD(self.drag["rotation"]["value"])
        wind, to_sun = (
            [v[0] + turn * r[1], v[1] - turn * r[0], v[2]],
            [LD(k) - p for k, p in zip(self.sun, r, strict=True)],
        )
        m, e = seen(R, L), [k / LD(self.a) for k in seen(R, r)]
        rate = [m[j] / LD(self.moments[j]) for j in range(3)]
        torque = [LD(3) * n * n * k for k in cross(e, [LD(self.moments[j]) * e[j] for j in range(3)])]
        speed2, distance2 = dot(wind, wind), dot(to_sun, to_sun)
        sources = [
            [k / hy.sqrt(speed2) for k in seen(R, wind)],
            [k / hy.sqrt(distance2) for k in seen(R, to_sun)],
        ]
        pressure = LD(PRESSURE) * LD(AU) ** 2 / distance2 * hy.par[len(self.plates)]
        cosines = []
        for i, (source, plate, normal, centre, area) in enumerate(self.plates):
            d, normal = sources[source], [LD(k) for k in normal]
            cosines.append(dot(normal, d))
            if source == 0:
                size = LD(-0.5) * LD(self.drag["density"]["value"]) * LD(plate["coefficient"]) * speed2
                force = [hy.par[i] * size * LD(area) * cosines[-1] * k for k in d]
            else:
                a, b = LD(plate["specular"]), LD(plate["diffuse"])
                along = LD(2) * (a * cosines[-1] + b / 3)
                force = [
                    -hy.par[i] * pressure * LD(area) * cosines[-1] * ((LD(1) - a) * d[j] + along * normal[j])
                    for j in range(3)
                ]
            torque = [p + k for p, k in zip(torque, cross([LD(k) for k in centre], force), strict=True)]
        half, (o1, o2, o3) = LD(0.5), rate
        slopes = [
            -x * o1 - y * o2 - z * o3,
            w * o1 + y * o3 - z * o2,
            w * o2 - x * o3 + z * o1,
            w * o3 + x * o2 - y * o1,
        ]
        forces = [sum(R[i][j] * torque[j] for j in range(3)) for i in range(3)]
        return [*zip(q, [half * k for k in slopes], strict=True), *zip(L, forces, strict=True)], cosines

    def groups(self):
        """Plates that turn their edges together: [(index, sign), ...] of each."""
        groups = []
        for i, (source, _, normal, *_) in enumerate(self.plates):
            for group in groups:
                other, _, facing, *_ = self.plates[group[0][0]]
                if other == source and abs(abs(normal @ facing) - 1.0) < 1e-14:
                    group.append((i, np.sign(normal @ facing)))
                    break
            else:
                groups.append([(i, 1.0)])
        return groups

    def attitudes(self, ends):
        """(n, 4) at instants, ascending; and the number of edges."""
        import heyoka as hy

        equations, cosines = self.equations()
        edges = [0]

        def sides(group):
            def change(integrator, sign):
                for i, facing in group:
                    integrator.pars[i] = LD(sign * facing > 0)
                    edges[0] += 1
                return True

            return change

        groups = self.groups()
        events = [hy.t_event(cosines[g[0][0]], fp_type=LD, callback=sides(g)) for g in groups]
        q = np.array(self.document["attitude"]["quaternion"], dtype=float)
        rate = np.radians(np.array(self.document["angular_velocity"]["value"], dtype=float))
        y = np.concatenate([q, rotation(q) @ (self.moments * rate)])
        later = y + 1e-6 * self.slope(0.0, y, np.zeros(len(self.plates)), False)
        lit = np.append(self.cosines(1e-6, later) > 0, self.light(1e-6) > 0).astype(LD)
        integrator = hy.taylor_adaptive(
            equations,
            y.astype(LD),
            time=LD(0),
            pars=lit,
            fp_type=LD,
            tol=LD(1e-19),
            t_events=events,
            compact_mode=True,
            high_accuracy=True,
        )
        cuts = [t for t in self.light_cuts(ends[-1]) if t < ends[-1]]
        out = []
        for t in sorted({*cuts, *ends}):
            integrator.propagate_until(LD(t))
            if t in cuts:
                integrator.pars[len(self.plates)] = LD(self.light(t + 1e-3))
            if t in ends:
                out.append(integrator.state[:4].astype(float))
        return np.array(out) / np.linalg.norm(out, axis=1)[:, None], edges[0]


def dot(a, b):
    return sum(p * k for p, k in zip(a, b, strict=True))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def seen(R, v):
    """Components in the body's axes."""
    return [sum(R[i][j] * v[i] for i in range(3)) for j in range(3)]


def print_row(name, document, end):
    Scene.model_validate(document).run()
    wall, processor = [], []
    for _ in range(5):
        scene = Scene.model_validate(document)
        begun, used = perf_counter(), process_time()
        run = scene.run()
        wall.append(perf_counter() - begun)
        processor.append(process_time() - used)
    plan = scene.plan()
    arcs, both = run.plan.solver.split(": ")[1], "of both processors"
    text = f"{name:26} {arcs:27} {1e3 * median(wall):6.1f} ms, {1e3 * median(processor):5.0f} {both}"
    text += f"  plan {1e3 * plan.predicted_seconds:4.0f} ms  bound {run.plan.error_bound:.1e} rad"
    if end:
        at = np.flatnonzero((run.elapsed > 0) & (run.elapsed <= end))[-1:]
        truth, edges = Truth(document).attitudes(run.elapsed[at].tolist())
        text += f"  error {angle(run.quaternion('wxyz')[at].T, truth.T):.1e} rad at {end} s, {edges} edges"
    print(text, flush=True)


def print_random(count=24):
    """Random attitudes, and rates of 0.01 to 30 deg/s, for an orbit."""
    rng, worst, missed = np.random.default_rng(5), [], 0
    for _ in range(count):
        q, w = rng.normal(size=4), rng.normal(size=3)
        document = PLAIN | {
            "attitude": {"quaternion": (q / np.linalg.norm(q)).tolist(), "order": "wxyz"},
            "angular_velocity": quantity(
                (w * 10 ** rng.uniform(-2, 1.5) / np.linalg.norm(w)).tolist(), "deg/s"
            ),
            "times": times(5520, 5520),
        }
        run = Scene.model_validate(document).run()
        truth, _ = Truth(document).attitudes([5520.0])
        error = angle(run.quaternion("wxyz")[1:].T, truth.T)
        worst.append(error)
        missed += error > run.plan.error_bound
    print(
        f"{count} random bodies, an orbit: worst error {max(worst):.1e} rad, above the bound {missed} times"
    )


def main(rows):
    warnings.simplefilter("ignore")
    for name, (document, end) in ROWS.items():
        if not rows or name in rows:
            print_row(name, document, end)
    if not rows or "random" in rows:
        print_random()


if __name__ == "__main__":
    main(sys.argv[1:])
