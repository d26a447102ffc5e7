// The body in 3D, seen in inertial, body or orbit axes: momentum, rate, Sun, nadir, velocity and the track of a
// direction on the sphere; or its path, or its orbit.

import * as THREE from "three";
import { colour } from "../dom.js";
import { conjugate, fromAxes, norm, rotate } from "../answers/rotation.js";
import { groundOf } from "./solid.js";
import { Arrow, ball, circle, dots, line, Pointer, Stage, Tail } from "./stage3d.js";

const AXES = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
const AXIS_COLOURS = ["--x", "--y", "--z"];
const AXIS_NAMES = ["x", "y", "z"];
const DISCONTINUOUS = ["L", "omega"];
const IDENTITY = [1, 0, 0, 0];
const MAX_POINTS = 24000;
const MAX_DASHED_POINTS = 3000;
const TAIL_POINTS = 320;
const TAIL_TURNS = 1.25;
const BODY_SHARE = 0.6; // size of the body over the radius of the sphere
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
    this.pointers = new Set(["sun", "earth", "velocity"]); // shown where the scene has them
  }

  /** `shown` of answers/scene.js, the solid of the body, and the reference scene or null. */
  show(shown, solid, reference) {
    Object.assign(this, { ephemeris: shown.ephemeris, surroundings: shown.surroundings, document: shown.document, solid, reference });
    this.build();
  }

  /** Rebuilds the scene, for another ephemeris, track, scenery, camera or theme. */
  build() {
    if (!this.ephemeris) return;
    if (this.scenery === "path") this.#buildPath();
    else if (this.scenery === "orbit") this.#buildOrbit();
    else this.#buildSphere();
    this.#buildBody();
    this.#buildPointers();
    this.at(this.time ?? this.ephemeris.start);
  }

  at(time) {
    this.time = time;
    if (!this.ephemeris) return;
    const now = this.ephemeris.at(time);
    turn(this.stage.world, this.#camera(time, now.quaternion));
    turn(this.body, now.quaternion);
    this.momentum.point(now.momentum, this.vectorScale / (norm(now.momentum) || 1));
    this.rate.point(rotate(now.quaternion, now.omega), (0.92 * this.vectorScale) / (norm(now.omega) || 1));
    for (const [name, pointer] of this.shownPointers) pointer.point(this.surroundings.direction(name, time));
    if (this.scenery === "path") this.bodyGroup.position.set(...now.position);
    else if (this.scenery === "orbit") this.bodyGroup.position.set(...this.#orbitPlace(time));
    else this.#drawTail(time);
    this.#placeGhost(time);
    this.stage.draw();
  }

  // -- seen from ------------------------------------------------------------------------------

  /** The rotation from inertial components to those along the axes of the camera. */
  #camera(time, quaternion) {
    if (this.camera === "body") return conjugate(quaternion ?? this.ephemeris.at(time).quaternion);
    return this.camera === "orbit" ? fromAxes(this.surroundings.axes(time)) : IDENTITY;
  }

  /** A direction, inertial components: a body axis, L, omega, or a target of the service. */
  #direction(name, time, now) {
    const axis = AXIS_NAMES.indexOf(name);
    if (axis >= 0) return rotate(now.quaternion, AXES[axis]);
    if (name === "L") return unit(now.momentum);
    if (name === "omega") return unit(rotate(now.quaternion, now.omega));
    return this.surroundings.direction(name, time);
  }

  /** The end point of the track at a time, along the axes of the camera. */
  #tip(time) {
    const now = this.ephemeris.at(time);
    return rotate(this.#camera(time, now.quaternion), this.#direction(this.track, time, now));
  }

  // -- the sphere -----------------------------------------------------------------------------

  #buildSphere() {
    this.stage.clear([0, 0, 0], 1.34);
    this.bodyScale = BODY_SHARE / this.solid.size;
    this.vectorScale = 1.16;
    this.#addBodyGroup();
    this.stage.scene.add(...graticule(1, colour("--hair")));
    this.#inertialAxes(1.2);
    this.#buildTrack();
  }

  #addBodyGroup() {
    this.bodyGroup = new THREE.Group();
    this.stage.world.add(this.bodyGroup);
  }

  #inertialAxes(length) {
    for (const [i, axis] of AXES.entries()) {
      this.stage.world.add(line([[0, 0, 0], axis.map((x) => length * x)], colour("--inertial"), 1.4));
      const position = new THREE.Vector3(...axis).multiplyScalar(1.06 * length);
      this.stage.name("XYZ"[i], position, "inertial");
    }
  }

  #buildTrack() {
    const { ephemeris, stage } = this;
    const paint = colour(this.#trackPaint());
    if (!ephemeris.connected) stage.scene.add(dots(ephemeris.smooth(MAX_POINTS).map((t) => this.#tip(t)), paint, 2));
    else for (const points of this.#segments()) stage.scene.add(line(points, paint, 1.2, trackStyle(ephemeris)));
    this.tail = new Tail(TAIL_POINTS, paint, 3);
    this.tip = ball(0.026, paint);
    stage.scene.add(this.tail.object, this.tip);
  }

  /** Points of the track, divided at events for momentum and rate, which jump there. */
  #segments() {
    const { ephemeris } = this;
    const times = DISCONTINUOUS.includes(this.track) ? ephemeris.segments(MAX_POINTS) : [ephemeris.smooth(MAX_POINTS)];
    return times.map((segment) => segment.map((t) => this.#tip(t))).filter((points) => points.length > 1);
  }

  #trackPaint() {
    const axis = AXIS_NAMES.indexOf(this.track);
    return axis >= 0 ? AXIS_COLOURS[axis] : { L: "--momentum", omega: "--rate" }[this.track] ?? POINTERS[this.track][1];
  }

  /** Draws the track over the last turn as a thick line up to the current time. */
  #drawTail(time) {
    this.tip.position.set(...this.#tip(time));
    const { ephemeris } = this;
    if (!ephemeris.connected || !ephemeris.meanRate) return this.tail.put([]);
    const length = Math.min(time - ephemeris.start, (TAIL_TURNS * 2 * Math.PI) / ephemeris.meanRate);
    const from = time - length;
    const times = Array.from({ length: TAIL_POINTS }, (_, k) => from + (length * k) / (TAIL_POINTS - 1));
    return this.tail.put(length > 0 ? times.map((t) => this.#tip(t)) : []);
  }

  // -- the path of the centre of mass -----------------------------------------------------------------------

  #buildPath() {
    const { ephemeris, stage } = this;
    const size = this.solid.size * this.solid.metres;
    const points = ephemeris.smooth(4000).map((t) => ephemeris.at(t).position);
    const box = new THREE.Box3().setFromPoints(points.map((point) => new THREE.Vector3(...point)));
    const ground = groundOf(this.document);
    const middle = box.getCenter(new THREE.Vector3());
    if (ground) box.expandByPoint(middle.clone().addScaledVector(ground.normal, ground.height - middle.dot(ground.normal)));
    box.getCenter(middle);
    const reach = 0.5 * box.getSize(new THREE.Vector3()).length() + 1.9 * size;
    stage.clear(middle.toArray(), reach);
    this.bodyScale = this.solid.metres;
    this.vectorScale = 1.7 * size;
    this.#addBodyGroup();
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

  // -- the orbit ------------------------------------------------------------------------

  /** The orbit, scaled to a greatest radius of 1; the central body to scale, the satellite enlarged. */
  #buildOrbit() {
    const { surroundings, stage } = this;
    const path = surroundings.path();
    const farthest = path.flat().reduce((far, position) => Math.max(far, norm(position)), 0);
    this.orbitScale = 1 / farthest;
    stage.clear([0, 0, 0], 1.45);
    this.vectorScale = 0.42;
    this.bodyScale = (0.5 * this.vectorScale) / this.solid.size;
    this.#addBodyGroup();
    this.#centralBody();
    const scaled = path.map((segment) => segment.map((position) => position.map((x) => x * this.orbitScale)));
    const joined = scaled.filter((segment) => segment.length > 1);
    for (const segment of joined) stage.world.add(line(segment, colour("--muted"), 1.2, { transparent: true, opacity: 0.6 }));
    if (!joined.length) stage.world.add(dots(scaled.flat(), colour("--muted"), 3));
    this.#inertialAxes(1.15);
  }

  #centralBody() {
    const { is_earth: isEarth, radius_m: radius } = this.surroundings.centralBody;
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
    return this.surroundings.position(time).map((x) => x * this.orbitScale);
  }

  // -- the body and the reference ---------------------------------------------------

  #buildBody() {
    const { stage } = this;
    const unit = this.vectorScale / 1.16; // the radius of the sphere
    const shape = this.solid.object();
    shape.scale.setScalar(this.bodyScale);
    this.body = new THREE.Group();
    this.body.add(shape);
    this.bodyGroup.add(this.body);
    this.#bodyAxes(unit);
    this.momentum = new Arrow(colour("--momentum"), { width: 0.011 * unit, head: 0.085 * unit });
    this.rate = new Arrow(colour("--rate"), { width: 0.008 * unit, head: 0.07 * unit });
    this.#buildGhost();
    if (this.scenery === "orbit") return; // there is room for its axes only
    this.bodyGroup.add(this.rate.object);
    if (this.ephemeris.bodyKnown) {
      this.bodyGroup.add(this.momentum.object);
      stage.name("L", () => this.momentum.labelPosition(0.08 * unit), "momentum");
    }
    stage.name("ω", () => this.rate.labelPosition(0.06 * unit), "rate");
  }

  #bodyAxes(unit) {
    for (const [i, axis] of AXES.entries()) {
      const arrow = new Arrow(colour(AXIS_COLOURS[i]), { width: 0.009 * unit, head: 0.07 * unit });
      arrow.point(axis, 0.86 * unit);
      this.body.add(arrow.object);
      this.stage.name(AXIS_NAMES[i], () => arrow.labelPosition(0.07 * unit), AXIS_COLOURS[i].slice(2));
    }
  }

  /** The edges of the reference body, and the track of its axis, dashed. */
  #buildGhost() {
    this.ghost = null;
    if (!this.reference || this.scenery !== "attitude") return;
    this.ghost = this.reference.solid.outline(colour("--muted"));
    this.ghost.scale.setScalar(BODY_SHARE / this.reference.solid.size);
    this.bodyGroup.add(this.ghost);
    const { ephemeris } = this.reference;
    const axis = AXIS_NAMES.indexOf(this.track);
    if (axis < 0 || this.camera !== "inertial" || !ephemeris.connected) return;
    const points = ephemeris.smooth(MAX_DASHED_POINTS).map((t) => rotate(ephemeris.at(t).quaternion, AXES[axis]));
    if (points.length > 1) this.stage.scene.add(dashed(points, colour("--muted")));
  }

  #placeGhost(time) {
    if (!this.ghost) return;
    const { ephemeris } = this.reference;
    this.ghost.visible = time >= ephemeris.start && time <= ephemeris.stop;
    if (this.ghost.visible) turn(this.ghost, ephemeris.at(time).quaternion);
  }

  #buildPointers() {
    const unit = this.vectorScale / 1.16;
    const isShown = (name) => this.pointers.has(name) && !(name === "earth" && this.scenery === "orbit");
    this.shownPointers = this.surroundings.targets.filter(isShown).map((name) => {
      const [text, paint] = POINTERS[name];
      const pointer = new Pointer(name, colour(paint), unit);
      this.bodyGroup.add(pointer.object);
      this.stage.name(text, () => pointer.labelPosition(), name);
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

/** The style of a track, fainter for more turns. */
function trackStyle(ephemeris) {
  const turns = (ephemeris.meanRate * ephemeris.span) / (2 * Math.PI);
  return { transparent: true, opacity: Math.max(0.07, Math.min(0.5, 7 / Math.max(1, turns))), depthWrite: false };
}

function dashed(points, paint) {
  const curve = line(points, paint, 1, { dashed: true, dashSize: 0.03, gapSize: 0.03, transparent: true, opacity: 0.7 });
  curve.computeLineDistances();
  return curve;
}
