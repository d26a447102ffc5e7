// The polhode: the curve of the body rate on its energy ellipsoid, body frame.

import * as THREE from "three";
import { colour } from "../dom.js";
import { norm, principal } from "../answers/rotation.js";
import { Arrow, ball, dots, line, Stage, Tail } from "./stage3d.js";

const MAX_POINTS = 24000;
const TAIL_POINTS = 360;
const LINE_OFFSET = 1.004; // lines are drawn slightly above the surface
const MIN_RELATIVE_DIFFERENCE = 1e-6; // of moments that have a separatrix

export class PolhodeView {
  constructor(element) {
    this.stage = new Stage(
      element,
      "The curve of the body rate on its energy ellipsoid, body frame",
      "Arrow keys turn the picture, plus and minus zoom.",
    );
  }

  show(ephemeris) {
    this.ephemeris = ephemeris;
    this.build();
  }

  build() {
    const { ephemeris, stage } = this;
    if (!ephemeris) return;
    stage.clear([0, 0, 0], 1.3);
    const maxEnergy = ephemeris.energy.reduce((a, b) => Math.max(a, b), 0);
    const { moments, axes } = principal(ephemeris.inertia);
    this.radii = moments.map((moment) => Math.sqrt((2 * maxEnergy) / moment));
    this.scale = maxEnergy > 0 ? 1 / Math.max(...this.radii) : 0;
    [this.axes, this.moments, this.maxEnergy] = [axes, moments, maxEnergy];
    this.#axes();
    if (this.scale) {
      this.#ellipsoid();
      this.#curves();
    }
    this.at(this.time ?? ephemeris.start);
  }

  at(time) {
    this.time = time;
    if (!this.ephemeris || !this.scale) return this.stage.draw();
    const now = this.ephemeris.at(time);
    this.surface.scale.setScalar(Math.max(1e-6, Math.sqrt(now.energy / this.maxEnergy)));
    this.tip.position.set(...this.#place(now.omega));
    this.arrow.point(now.omega, this.scale);
    this.#tail(time);
    this.stage.draw();
  }

  #place(omega) {
    return omega.map((x) => x * this.scale * LINE_OFFSET);
  }

  #axes() {
    for (const [i, paint] of ["--x", "--y", "--z"].entries()) {
      const axis = [0, 1, 2].map((k) => (k === i ? 1.12 : 0));
      this.stage.scene.add(line([axis.map((x) => -x), axis], colour(paint), 1.2, { transparent: true, opacity: 0.75 }));
      this.stage.name(`ω${"xyz"[i]}`, new THREE.Vector3(...axis).multiplyScalar(1.08), paint.slice(2));
    }
  }

  #ellipsoid() {
    this.surface = new THREE.Group();
    const basis = new THREE.Matrix4().makeBasis(...this.axes.map((axis) => new THREE.Vector3(...axis)));
    const stretch = new THREE.Matrix4().makeScale(...this.radii.map((radius) => radius * this.scale));
    const skin = new THREE.SphereGeometry(1, 64, 40).applyMatrix4(basis.multiply(stretch));
    const look = { color: colour("--body"), transparent: true, opacity: 0.82, polygonOffset: true, polygonOffsetFactor: 1 };
    this.surface.add(new THREE.Mesh(skin, new THREE.MeshLambertMaterial(look)));
    for (const [i, j] of [[0, 1], [0, 2], [1, 2]]) {
      this.surface.add(line(this.#ellipse(this.#semiAxis(i), this.#semiAxis(j)), colour("--hair-strong"), 1));
    }
    const separatrices = this.#separatrices();
    this.hasSeparatrices = separatrices.length > 0;
    for (const [first, second] of separatrices) {
      const more = { dashed: true, dashSize: 0.045, gapSize: 0.035 };
      const curve = line(this.#ellipse(first, second), colour("--muted"), 1.3, more);
      curve.computeLineDistances();
      this.surface.add(curve);
    }
    this.stage.scene.add(this.surface);
  }

  /** A semi-axis of the ellipsoid, scaled. */
  #semiAxis(i) {
    return this.axes[i].map((x) => x * this.radii[i] * this.scale);
  }

  #ellipse(first, second, count = 120) {
    return Array.from({ length: count + 1 }, (_, k) => {
      const [c, s] = [Math.cos((2 * Math.PI * k) / count), Math.sin((2 * Math.PI * k) / count)];
      return first.map((x, axis) => LINE_OFFSET * (c * x + s * second[axis]));
    });
  }

  /** Where I1 (I2 - I1) w1^2 = I3 (I3 - I2) w3^2: two planes through the middle axis; none under wheels. */
  #separatrices() {
    const [I1, I2, I3] = this.moments;
    if (this.ephemeris.hasMomentumColumns || I2 - I1 < MIN_RELATIVE_DIFFERENCE * I3 || I3 - I2 < MIN_RELATIVE_DIFFERENCE * I3) return [];
    const [along1, along3] = [Math.sqrt(I3 * (I3 - I2)), Math.sqrt(I1 * (I2 - I1))];
    const length = this.scale * Math.sqrt((2 * this.maxEnergy) / (I1 * along1 ** 2 + I3 * along3 ** 2));
    return [1, -1].map((sign) => [
      this.axes[0].map((x, k) => length * (along1 * x + sign * along3 * this.axes[2][k])),
      this.#semiAxis(1),
    ]);
  }

  #curves() {
    const { ephemeris, stage } = this;
    const paint = colour("--rate");
    const behind = { transparent: true, opacity: 0.25, depthTest: false };
    for (const segment of ephemeris.segments(MAX_POINTS)) {
      const points = segment.map((t) => this.#place(ephemeris.at(t).omega));
      if (!ephemeris.connected) stage.scene.add(dots(points, paint, 2));
      else if (points.length > 1) stage.scene.add(line(points, paint, 1.6), line(points, paint, 1, behind));
    }
    this.tail = new Tail(TAIL_POINTS, paint, 3.4);
    this.tip = ball(0.03, paint);
    this.arrow = new Arrow(paint, { width: 0.006, head: 0.05, more: { transparent: true, opacity: 0.4, depthTest: false } });
    stage.scene.add(this.tail.object, this.tip, this.arrow.object);
    stage.name("ω", () => (norm(this.tip.position.toArray()) ? this.tip.position.clone().setLength(this.tip.position.length() + 0.1) : null), "rate");
  }

  #tail(time) {
    const { ephemeris } = this;
    if (!ephemeris.connected || !ephemeris.meanRate) return this.tail.put([]);
    const since = ephemeris.jumps.findLast((jump) => jump <= time) ?? ephemeris.start;
    const length = Math.min(time - since, (2 * Math.PI) / ephemeris.meanRate);
    const times = Array.from({ length: TAIL_POINTS }, (_, k) => time - length + (length * k) / (TAIL_POINTS - 1));
    this.tail.put(length > 0 ? times.map((t) => this.#place(ephemeris.at(t).omega)) : []);
  }
}
