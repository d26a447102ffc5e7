// The body turning, seen from axes that stand still, from its own or from those of its orbit: momentum and
// rate, Sun, nadir and velocity, the track of a direction on the sphere; or where the body travels, or orbits.

import * as THREE from "three";
import { colour } from "../dom.js";
import { conjugate, fromAxes, norm, rotate } from "../answers/rotation.js";
import { groundOf } from "./solid.js";
import { Arrow, ball, circle, dots, line, Pointer, Stage, Tail } from "./stage3d.js";

const AXES = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
const PAINTS = ["--x", "--y", "--z"];
const NAMES = ["x", "y", "z"];
const JUMPING = ["L", "omega"];
const STILL = [1, 0, 0, 0];
const MOST_POINTS = 24000;
const MOST_DASHED = 3000;
const TAIL_POINTS = 320;
const TAIL_TURNS = 1.25;
const FILLS = 0.6; // of the sphere, by the body
const POINTERS = { sun: ["Sun", "--sun"], earth: ["nadir", "--earth"], velocity: ["velocity", "--muted"] };

export class BodyView {
  constructor(element) {
    this.stage = new Stage(
      element,
      "The body with its axes, its momentum and the track of a direction on the sphere",
      "Arrow keys turn the picture, plus and minus zoom.",
    );
    this.track = "z";
    this.scenery = "attitude"; // or "path", "orbit"
    this.camera = "inertial"; // or "body", "orbit"
    this.pointers = new Set(["sun", "earth", "velocity"]); // those that are shown where they are known
  }

  /** `shown` of answers/scene.js, the body's solid, and another scene to be compared with, or null. */
  show(shown, solid, reference) {
    Object.assign(this, { course: shown.course, about: shown.about, document: shown.document, solid, reference });
    this.build();
  }

  /** Everything anew: for another course, track, scenery, camera or set of colours. */
  build() {
    if (!this.course) return;
    if (this.scenery === "path") this.#buildPath();
    else if (this.scenery === "orbit") this.#buildOrbit();
    else this.#buildSphere();
    this.#buildBody();
    this.#buildPointers();
    this.at(this.time ?? this.course.start);
  }

  at(time) {
    this.time = time;
    if (!this.course) return;
    const now = this.course.at(time);
    turn(this.stage.world, this.#camera(time, now.quaternion));
    turn(this.body, now.quaternion);
    this.momentum.point(now.momentum, this.vectorScale / (norm(now.momentum) || 1));
    this.rate.point(rotate(now.quaternion, now.omega), (0.92 * this.vectorScale) / (norm(now.omega) || 1));
    for (const [name, pointer] of this.shownPointers) pointer.point(this.about.direction(name, time));
    if (this.scenery === "path") this.carried.position.set(...now.place);
    else if (this.scenery === "orbit") this.carried.position.set(...this.#orbitPlace(time));
    else this.#follow(time);
    this.#placeGhost(time);
    this.stage.draw();
  }

  // -- seen from ------------------------------------------------------------------------------

  /** The rotation from inertial components to those of the axes that stand still in the picture. */
  #camera(time, quaternion) {
    if (this.camera === "body") return conjugate(quaternion ?? this.course.at(time).quaternion);
    return this.camera === "orbit" ? fromAxes(this.about.axes(time)) : STILL;
  }

  /** A direction of the motion, inertial components: a body axis, L, or what the service knows. */
  #direction(name, time, now) {
    const axis = NAMES.indexOf(name);
    if (axis >= 0) return rotate(now.quaternion, AXES[axis]);
    if (name === "L") return unit(now.momentum);
    if (name === "omega") return unit(rotate(now.quaternion, now.omega));
    return this.about.direction(name, time);
  }

  /** Where the track is at a time, in the picture. */
  #tip(time) {
    const now = this.course.at(time);
    return rotate(this.#camera(time, now.quaternion), this.#direction(this.track, time, now));
  }

  // -- the sphere -----------------------------------------------------------------------------

  #buildSphere() {
    this.stage.clear([0, 0, 0], 1.34);
    this.bodyScale = FILLS / this.solid.size;
    this.vectorScale = 1.16;
    this.#carry();
    this.stage.scene.add(...graticule(1, colour("--hair")));
    this.#inertialAxes(1.2);
    this.#buildTrack();
  }

  #carry() {
    this.carried = new THREE.Group();
    this.stage.world.add(this.carried);
  }

  #inertialAxes(length) {
    for (const [i, axis] of AXES.entries()) {
      this.stage.world.add(line([[0, 0, 0], axis.map((x) => length * x)], colour("--inertial"), 1.4));
      const place = new THREE.Vector3(...axis).multiplyScalar(1.06 * length);
      this.stage.name("XYZ"[i], place, "inertial");
    }
  }

  #buildTrack() {
    const { course, stage } = this;
    const paint = colour(this.#trackPaint());
    if (!course.connected) stage.scene.add(dots(course.smooth(MOST_POINTS).map((t) => this.#tip(t)), paint, 2));
    else for (const points of this.#stretches()) stage.scene.add(line(points, paint, 1.2, crowded(course)));
    this.tail = new Tail(TAIL_POINTS, paint, 3);
    this.tip = ball(0.026, paint);
    stage.scene.add(this.tail.object, this.tip);
  }

  /** Momentum and rate jump at an event; attitudes do not. */
  #stretches() {
    const { course } = this;
    const times = JUMPING.includes(this.track) ? course.stretches(MOST_POINTS) : [course.smooth(MOST_POINTS)];
    return times.map((stretch) => stretch.map((t) => this.#tip(t))).filter((points) => points.length > 1);
  }

  #trackPaint() {
    const axis = NAMES.indexOf(this.track);
    return axis >= 0 ? PAINTS[axis] : { L: "--momentum", omega: "--rate" }[this.track] ?? POINTERS[this.track][1];
  }

  /** The way of the direction over the last turn or so, bold, up to where it is. */
  #follow(time) {
    this.tip.position.set(...this.#tip(time));
    const { course } = this;
    if (!course.connected || !course.meanRate) return this.tail.put([]);
    const length = Math.min(time - course.start, (TAIL_TURNS * 2 * Math.PI) / course.meanRate);
    const from = time - length;
    const times = Array.from({ length: TAIL_POINTS }, (_, k) => from + (length * k) / (TAIL_POINTS - 1));
    return this.tail.put(length > 0 ? times.map((t) => this.#tip(t)) : []);
  }

  // -- where it travels -----------------------------------------------------------------------

  #buildPath() {
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
    this.#carry();
    stage.world.add(line(points, colour("--muted"), 1.5));
    if (ground) this.#plane(ground, middle, reach);
    this.#inertialAxes(0.22 * reach);
  }

  #plane({ normal, height }, middle, reach) {
    const grid = new THREE.GridHelper(1.2 * reach, 12, colour("--hair"), colour("--hair"));
    grid.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), normal);
    grid.position.copy(middle).addScaledVector(normal, height - middle.dot(normal));
    this.stage.world.add(grid);
  }

  // -- where it orbits ------------------------------------------------------------------------

  /** The orbit with its farthest place at 1; the central body to scale, the satellite far larger. */
  #buildOrbit() {
    const { about, stage } = this;
    const path = about.path();
    const most = path.flat().reduce((far, place) => Math.max(far, norm(place)), 0);
    this.orbitScale = 1 / most;
    stage.clear([0, 0, 0], 1.45);
    this.vectorScale = 0.42;
    this.bodyScale = (0.5 * this.vectorScale) / this.solid.size;
    this.#carry();
    this.#centralBody();
    const scaled = path.map((stretch) => stretch.map((place) => place.map((x) => x * this.orbitScale)));
    const joined = scaled.filter((stretch) => stretch.length > 1);
    for (const stretch of joined) stage.world.add(line(stretch, colour("--muted"), 1.2, { transparent: true, opacity: 0.6 }));
    if (!joined.length) stage.world.add(dots(scaled.flat(), colour("--muted"), 3));
    this.#inertialAxes(1.15);
  }

  #centralBody() {
    const { is_earth: isEarth, radius_m: radius } = this.about.centralBody;
    const size = radius ? radius * this.orbitScale : 0.03;
    const skin = new THREE.MeshLambertMaterial({ color: colour("--globe"), polygonOffset: true, polygonOffsetFactor: 1 });
    const { world } = this.stage;
    world.add(new THREE.Mesh(new THREE.SphereGeometry(size, 48, 32), skin));
    if (radius) world.add(...graticule(1.002 * size, colour("--hair-strong")));
    const below = () => new THREE.Vector3(0, -size - 0.1, 0).applyQuaternion(this.stage.camera.quaternion);
    this.stage.name(isEarth ? "Earth" : "central body", below, "inertial");
    this.stage.globe = 0.98 * size;
  }

  #orbitPlace(time) {
    return this.about.place(time).map((x) => x * this.orbitScale);
  }

  // -- the body, and what it is compared with ---------------------------------------------------

  #buildBody() {
    const { stage } = this;
    const unit = this.vectorScale / 1.16; // what 1 is on the sphere
    const shape = this.solid.object();
    shape.scale.setScalar(this.bodyScale);
    this.body = new THREE.Group();
    this.body.add(shape);
    this.carried.add(this.body);
    this.#bodyAxes(unit);
    this.momentum = new Arrow(colour("--momentum"), { width: 0.011 * unit, head: 0.085 * unit });
    this.rate = new Arrow(colour("--rate"), { width: 0.008 * unit, head: 0.07 * unit });
    this.#buildGhost();
    if (this.scenery === "orbit") return; // where there is no room for more than its axes
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

  /** The body of the reference by its edges alone, and the track of its axis, dashed. */
  #buildGhost() {
    this.ghost = null;
    if (!this.reference || this.scenery !== "attitude") return;
    this.ghost = this.reference.solid.outline(colour("--muted"));
    this.ghost.scale.setScalar(FILLS / this.reference.solid.size);
    this.carried.add(this.ghost);
    const { course } = this.reference;
    const axis = NAMES.indexOf(this.track);
    if (axis < 0 || this.camera !== "inertial" || !course.connected) return;
    const points = course.smooth(MOST_DASHED).map((t) => rotate(course.at(t).quaternion, AXES[axis]));
    if (points.length > 1) this.stage.scene.add(dashed(points, colour("--muted")));
  }

  #placeGhost(time) {
    if (!this.ghost) return;
    const { course } = this.reference;
    this.ghost.visible = time >= course.start && time <= course.stop;
    if (this.ghost.visible) turn(this.ghost, course.at(time).quaternion);
  }

  #buildPointers() {
    const unit = this.vectorScale / 1.16;
    const isShown = (name) => this.pointers.has(name) && !(name === "earth" && this.scenery === "orbit");
    this.shownPointers = this.about.known.filter(isShown).map((name) => {
      const [text, paint] = POINTERS[name];
      const pointer = new Pointer(name, colour(paint), unit);
      this.carried.add(pointer.object);
      this.stage.name(text, () => pointer.beyond(), name);
      return [name, pointer];
    });
  }
}

function unit(vector) {
  const length = norm(vector) || 1;
  return vector.map((x) => x / length);
}

function turn(object, [w, x, y, z]) {
  object.quaternion.set(x, y, z, w);
}

/** Parallels and meridians of a sphere about the origin. */
function graticule(radius, paint) {
  const scaled = (points) => points.map((point) => point.map((x) => radius * x));
  const parallels = [-60, -30, 0, 30, 60].map((degrees) => {
    const circleAt = circle([0, 0, 1], Math.sin((degrees * Math.PI) / 180));
    return line(scaled(circleAt), paint, degrees ? 0.8 : 1.3);
  });
  const meridians = Array.from({ length: 6 }, (_, k) => {
    const angle = (k * Math.PI) / 6;
    return line(scaled(circle([Math.cos(angle), Math.sin(angle), 0], 0)), paint, 0.8);
  });
  return [...parallels, ...meridians];
}

/** A track is fainter, the more often it passes the same places. */
function crowded(course) {
  const turns = (course.meanRate * course.span) / (2 * Math.PI);
  return { transparent: true, opacity: Math.max(0.07, Math.min(0.5, 7 / Math.max(1, turns))), depthWrite: false };
}

function dashed(points, paint) {
  const curve = line(points, paint, 1, { dashed: true, dashSize: 0.03, gapSize: 0.03, transparent: true, opacity: 0.7 });
  curve.computeLineDistances();
  return curve;
}
