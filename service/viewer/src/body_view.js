// The body turning: inertial and body axes, momentum and rate, the track of a body axis on the
// sphere; or, of a body that travels, where it is.

import * as THREE from "three";
import { colour } from "./dom.js";
import { norm, rotate } from "./rotation.js";
import { groundOf, solidOf } from "./solid.js";
import { Arrow, ball, circle, dots, line, Stage, Tail } from "./stage3d.js";

const AXES = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
const PAINTS = ["--x", "--y", "--z"];
const NAMES = ["x", "y", "z"];
const MOST_POINTS = 24000;
const TAIL_POINTS = 480;
const TAIL_TURNS = 1.25;
const FILLS = 0.6; // of the sphere, by the body

export class BodyView {
  constructor(element) {
    this.stage = new Stage(
      element,
      "The body with its axes, its momentum and the track of an axis on the sphere",
      "Arrow keys turn the picture, plus and minus zoom.",
    );
    this.axis = 2;
    this.travels = false;
  }

  show(course, document) {
    [this.course, this.document] = [course, document];
    this.build();
  }

  /** Everything anew: for another course, axis, mode or set of colours. */
  build() {
    if (!this.course) return;
    this.solid = solidOf(this.document, this.course.inertia);
    if (this.travels) this.#buildTravel();
    else this.#buildSphere();
    this.#buildBody();
    this.at(this.time ?? this.course.start);
  }

  /** Whether positions are known, in the unit of the shape. */
  static canTravel(course, document) {
    return Boolean(course.place && solidOf(document, course.inertia).metres);
  }

  at(time) {
    this.time = time;
    if (!this.course) return;
    const now = this.course.at(time);
    this.body.quaternion.set(now.quaternion[1], now.quaternion[2], now.quaternion[3], now.quaternion[0]);
    this.momentum.point(now.momentum, this.vectorScale / (norm(now.momentum) || 1));
    this.rate.point(rotate(now.quaternion, now.omega), (0.92 * this.vectorScale) / (norm(now.omega) || 1));
    if (this.travels) this.carried.position.set(...now.place);
    else this.#track(time, now.quaternion);
    this.stage.draw();
  }

  // -- the sphere -----------------------------------------------------------------------------

  #buildSphere() {
    this.stage.clear([0, 0, 0], 1.34);
    const { scene } = this.stage;
    this.bodyScale = FILLS / this.solid.size;
    this.vectorScale = 1.16;
    this.carried = new THREE.Group();
    scene.add(this.carried);
    const hair = colour("--hair");
    for (const degrees of [-60, -30, 0, 30, 60]) {
      scene.add(line(circle([0, 0, 1], Math.sin((degrees * Math.PI) / 180)), hair, degrees ? 0.8 : 1.3));
    }
    for (let k = 0; k < 6; k++) {
      const angle = (k * Math.PI) / 6;
      scene.add(line(circle([Math.cos(angle), Math.sin(angle), 0], 0), hair, 0.8));
    }
    this.#inertialAxes(1.2, [0, 0, 0]);
    this.#buildTrack();
  }

  #inertialAxes(length, from) {
    for (const [i, axis] of AXES.entries()) {
      const end = axis.map((x, k) => from[k] + length * x);
      this.stage.scene.add(line([from, end], colour("--inertial"), 1.4));
      const place = new THREE.Vector3(...axis.map((x, k) => from[k] + 1.06 * length * x));
      this.stage.name("XYZ"[i], place, "inertial");
    }
  }

  #buildTrack() {
    const { course, stage } = this;
    const paint = colour(PAINTS[this.axis]);
    const points = course.smooth(MOST_POINTS).map((t) => this.#tip(course.at(t).quaternion));
    if (!course.connected) stage.scene.add(dots(points, paint, 2));
    else if (points.length > 1) {
      // fainter, the more often it passes the same places
      const crowded = Math.min(0.5, 7 / Math.max(1, (course.meanRate * course.span) / (2 * Math.PI)));
      const more = { transparent: true, opacity: Math.max(0.07, crowded), depthWrite: false };
      stage.scene.add(line(points, paint, 1.2, more));
    }
    this.tail = new Tail(TAIL_POINTS, paint, 3);
    this.tip = ball(0.026, paint);
    stage.scene.add(this.tail.object, this.tip);
  }

  #tip(quaternion) {
    return rotate(quaternion, AXES[this.axis]);
  }

  /** The way of the axis over the last turn or so, bold, up to where it is. */
  #track(time, quaternion) {
    const tip = this.#tip(quaternion);
    this.tip.position.set(...tip);
    const { course } = this;
    if (!course.connected || !course.meanRate) return this.tail.put([]);
    const length = Math.min(time - course.start, (TAIL_TURNS * 2 * Math.PI) / course.meanRate);
    const from = time - length;
    const times = Array.from({ length: TAIL_POINTS }, (_, k) => from + (length * k) / (TAIL_POINTS - 1));
    this.tail.put(length > 0 ? times.map((t) => this.#tip(course.at(t).quaternion)) : []);
  }

  // -- where it travels -----------------------------------------------------------------------

  #buildTravel() {
    const { course, stage } = this;
    const size = this.solid.size * this.solid.metres;
    const points = course.smooth(4000).map((t) => course.at(t).place);
    const box = new THREE.Box3().setFromPoints(points.map((point) => new THREE.Vector3(...point)));
    const ground = groundOf(this.document);
    const middle = box.getCenter(new THREE.Vector3());
    if (ground) box.expandByPoint(middle.clone().addScaledVector(ground.normal, ground.height - middle.dot(ground.normal)));
    box.getCenter(middle);
    const reach = 0.5 * box.getSize(new THREE.Vector3()).length() + 1.9 * size;
    stage.clear(middle.toArray(), reach);
    this.bodyScale = this.solid.metres;
    this.vectorScale = 1.7 * size;
    this.carried = new THREE.Group();
    stage.scene.add(this.carried, line(points, colour("--muted"), 1.5));
    if (ground) this.#plane(ground, middle, reach);
    this.#inertialAxes(0.22 * reach, [0, 0, 0]);
  }

  #plane({ normal, height }, middle, reach) {
    const grid = new THREE.GridHelper(1.2 * reach, 12, colour("--hair"), colour("--hair"));
    grid.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), normal);
    grid.position.copy(middle).addScaledVector(normal, height - middle.dot(normal));
    this.stage.scene.add(grid);
  }

  // -- the body -------------------------------------------------------------------------------

  #buildBody() {
    const { stage, solid, bodyScale } = this;
    const unit = this.vectorScale / 1.16; // what 1 is on the sphere
    const faces = new THREE.MeshLambertMaterial({
      color: colour("--body"), transparent: true, opacity: 0.9,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
    });
    const shape = new THREE.Group();
    shape.add(
      new THREE.Mesh(solid.geometry, faces),
      new THREE.LineSegments(solid.edges, new THREE.LineBasicMaterial({ color: colour("--body-edge") })),
    );
    shape.scale.setScalar(bodyScale);
    this.body = new THREE.Group();
    this.body.add(shape);
    this.carried.add(this.body);
    this.#bodyAxes(unit);
    const [momentum, rate] = ["--momentum", "--rate"].map(colour);
    const form = { width: 0.011 * unit, head: 0.085 * unit };
    this.momentum = new Arrow(momentum, form);
    this.rate = new Arrow(rate, { width: 0.008 * unit, head: 0.07 * unit });
    this.carried.add(this.rate.object);
    if (this.course.bodyKnown) {
      this.carried.add(this.momentum.object);
      stage.name("L", () => this.momentum.beyond(0.08 * unit), "momentum");
    }
    stage.name("ω", () => this.rate.beyond(0.06 * unit), "rate");
  }

  #bodyAxes(unit) {
    for (const [i, axis] of AXES.entries()) {
      const arrow = new Arrow(colour(PAINTS[i]), { width: 0.009 * unit, head: 0.07 * unit });
      arrow.point(axis, 0.86 * unit);
      this.body.add(arrow.object);
      this.stage.name(NAMES[i], () => arrow.beyond(0.07 * unit), PAINTS[i].slice(2));
    }
  }
}
