// Shared by both 3D views: a canvas that is redrawn after changes, an orbiting camera, labels at points in 3D,
// and lines with a width.

import * as THREE from "three";
import { Line2 } from "three/examples/jsm/lines/Line2.js";
import { LineGeometry } from "three/examples/jsm/lines/LineGeometry.js";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { colour, make } from "../dom.js";

const FIELD_OF_VIEW = 26; // degrees; narrow, for little perspective distortion
const DEFAULT_VIEW = { azimuth: 0.62, elevation: 0.36, zoom: 1 };
const KEY_TURN = 0.12; // rad for a key
const MAX_ELEVATION = 1.55; // rad
const ORIGIN = new THREE.Vector3();

export class Stage {
  /** Throws where the browser has no WebGL. */
  constructor(element, name, help) {
    this.element = element;
    this.renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.canvas = this.renderer.domElement;
    this.labels = make("div", { class: "labels", "aria-hidden": "true" });
    element.replaceChildren(this.canvas, this.labels);
    for (const [key, value] of Object.entries({ tabindex: 0, role: "img", "aria-label": `${name}. ${help}` })) {
      this.canvas.setAttribute(key, value);
    }
    this.camera = new THREE.PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    this.scene = new THREE.Scene();
    this.anchors = [];
    this.reset();
    this.clear();
    this.#listen();
    new ResizeObserver(() => this.draw()).observe(element);
  }

  /** Starts an empty scene with its light and `world`, which turns with the camera axes.
   * `middle`, `reach`: centre and radius of the sphere that the camera shows whole. */
  clear(middle = [0, 0, 0], reach = 1) {
    this.scene.traverse((object) => {
      object.geometry?.dispose();
      object.material?.dispose();
    });
    this.scene = new THREE.Scene();
    this.world = new THREE.Group();
    this.scene.add(this.world);
    this.labels.replaceChildren();
    this.anchors = [];
    this.middle = new THREE.Vector3(...middle);
    this.reach = reach;
    this.globe = 0; // radius of the central body, where it is drawn
    const light = new THREE.DirectionalLight(0xffffff, 1.9);
    light.position.set(-0.6, 0.9, 1.4);
    this.eye = new THREE.Group();
    this.eye.add(light);
    this.scene.add(this.eye, new THREE.AmbientLight(0xffffff, 1.35));
    this.scene.fog = new THREE.Fog(colour("--panel"), 1, 2);
  }

  reset() {
    this.view = { ...DEFAULT_VIEW };
    this.draw();
  }

  turn(azimuth, elevation) {
    this.view.azimuth += azimuth;
    this.view.elevation = Math.max(-MAX_ELEVATION, Math.min(MAX_ELEVATION, this.view.elevation + elevation));
    this.draw();
  }

  zoom(factor) {
    this.view.zoom = Math.max(0.5, Math.min(8, this.view.zoom * factor));
    this.draw();
  }

  /** Adds a label at a point of `world`, or at the point that a function returns. */
  name(text, point, kind = "") {
    const label = make("span", { class: `label ${kind}` }, text);
    this.labels.append(label);
    this.anchors.push({ label, point });
    return label;
  }

  /** Schedules one rendering before the next frame. */
  draw() {
    if (this.isScheduled || !this.scene) return;
    this.isScheduled = true;
    requestAnimationFrame(() => {
      this.isScheduled = false;
      this.#render();
    });
  }

  #render() {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!width || !height) return;
    const size = this.renderer.getSize(new THREE.Vector2());
    if (size.x !== width || size.y !== height) this.renderer.setSize(width, height);
    this.#look(width, height);
    this.renderer.render(this.scene, this.camera);
    this.#placeNames(width, height);
  }

  #look(width, height) {
    const narrow = Math.min(1, width / height);
    const half = Math.atan(Math.tan((FIELD_OF_VIEW * Math.PI) / 360) * narrow);
    const far = this.reach / Math.sin(half);
    const distance = far / this.view.zoom;
    const { azimuth, elevation } = this.view;
    const across = Math.cos(elevation) * distance;
    this.camera.position.set(across * Math.cos(azimuth), across * Math.sin(azimuth), Math.sin(elevation) * distance);
    this.camera.position.add(this.middle);
    this.camera.lookAt(this.middle);
    this.camera.aspect = width / height;
    [this.camera.near, this.camera.far] = [distance * 0.02, distance + 20 * this.reach];
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    this.eye.position.copy(this.camera.position);
    this.eye.quaternion.copy(this.camera.quaternion);
    [this.scene.fog.near, this.scene.fog.far] = [distance - 0.35 * this.reach, distance + 2.1 * this.reach];
  }

  /** Places each label at its point, inside the picture, clear of earlier labels. */
  #placeNames(width, height) {
    const at = new THREE.Vector3();
    const occupied = [];
    for (const { label, point } of this.anchors) {
      const place = typeof point === "function" ? point() : point;
      label.hidden = !place;
      if (!place) continue;
      at.copy(place);
      if (place === point) this.world.localToWorld(at);
      label.hidden = this.#isBehindGlobe(at);
      if (label.hidden) continue;
      at.project(this.camera);
      const wanted = [(0.5 + 0.5 * at.x) * width, (0.5 - 0.5 * at.y) * height];
      label.room ||= label.offsetWidth;
      const [x, y] = freePosition(occupied, clamped(wanted, width, height), label.room);
      occupied.push([x, y, label.room]);
      label.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -50%)`;
    }
  }

  /** Whether the central body hides a point from the camera. */
  #isBehindGlobe(point) {
    const sight = new THREE.Line3(this.camera.position, point);
    return sight.closestPointToPoint(ORIGIN, true, new THREE.Vector3()).length() < this.globe;
  }

  #listen() {
    let last = null;
    this.canvas.addEventListener("pointerdown", (event) => {
      last = [event.clientX, event.clientY];
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (!last) return;
      const scale = 3.2 / this.element.clientHeight;
      this.turn((last[0] - event.clientX) * scale, (event.clientY - last[1]) * scale);
      last = [event.clientX, event.clientY];
    });
    for (const end of ["pointerup", "pointercancel"]) this.canvas.addEventListener(end, () => (last = null));
    this.canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    this.canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  /** Zooms with Ctrl (or two fingers) only, so that the page can scroll past its pictures. */
  #wheel(event) {
    if (!event.ctrlKey) return;
    event.preventDefault();
    this.zoom(Math.exp(-event.deltaY * 0.002));
  }

  #key(event) {
    const keys = {
      ArrowLeft: () => this.turn(-KEY_TURN, 0),
      ArrowRight: () => this.turn(KEY_TURN, 0),
      ArrowUp: () => this.turn(0, KEY_TURN),
      ArrowDown: () => this.turn(0, -KEY_TURN),
      "+": () => this.zoom(1.2),
      "=": () => this.zoom(1.2),
      "-": () => this.zoom(1 / 1.2),
      0: () => this.reset(),
    };
    const act = keys[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    act();
  }
}

const LABEL_MARGIN = 12; // px, from a label to the edge of the picture
const LABEL_SPACING = 16; // px, between labels above each other

const clamped = ([x, y], width, height) => [
  Math.max(LABEL_MARGIN, Math.min(width - LABEL_MARGIN, x)),
  Math.max(LABEL_MARGIN, Math.min(height - LABEL_MARGIN, y)),
];

/** The position, or the first one near it at which a label of this width covers no other. */
function freePosition(occupied, [x, y], labelWidth) {
  const isFree = (place) =>
    occupied.every(([ox, oy, other]) => Math.abs(place[1] - oy) >= LABEL_SPACING || Math.abs(place[0] - ox) >= 0.5 * (labelWidth + other) + 3);
  for (const distance of [0, LABEL_SPACING, 2 * LABEL_SPACING]) {
    for (const [across, down] of [[0, 1], [0, -1], [1, 0], [-1, 0]]) {
      const place = [x + distance * across, y + distance * down];
      if (isFree(place)) return place;
    }
  }
  return [x, y];
}

// -- objects for a scene ---------------------------------------------------------------------

const MAX_WIDE_POINTS = 3000; // of a line with a width, whose segments are drawn as two triangles each

/** A line through points, `width` in pixels; one pixel wide for more than MAX_WIDE_POINTS points. */
export function line(points, paint, width = 1.5, more = {}) {
  if (points.length > MAX_WIDE_POINTS && !more.dashed) {
    const thin = new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(points.flat(), 3));
    return new THREE.Line(thin, new THREE.LineBasicMaterial({ color: paint, fog: true, ...more }));
  }
  const geometry = new LineGeometry();
  geometry.setPositions(new Float32Array(points.flat()));
  return new Line2(geometry, material(paint, width, more));
}

const material = (paint, width, more) => new LineMaterial({ color: paint, linewidth: width, fog: true, ...more });

/** Points, for samples that are too far apart to be joined. */
export function dots(points, paint, size = 2) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(points.flat(), 3));
  return new THREE.Points(geometry, new THREE.PointsMaterial({ color: paint, size, sizeAttenuation: false }));
}

/** A line whose points are replaced in each frame. */
export class Tail {
  constructor(count, paint, width, more = {}) {
    this.count = count;
    this.object = line(Array.from({ length: count }, () => [0, 0, 0]), paint, width, more);
    this.object.frustumCulled = false;
  }

  /** Replaces the points, at most `count` of them. */
  put(points) {
    const buffer = this.object.geometry.attributes.instanceStart.data;
    points.slice(0, this.count).forEach((point, i) => {
      if (i < this.count - 1) buffer.array.set(point, 6 * i);
      if (i > 0) buffer.array.set(point, 6 * i - 3);
    });
    buffer.needsUpdate = true;
    this.object.geometry.instanceCount = Math.max(0, Math.min(points.length, this.count) - 1);
    this.object.visible = points.length > 1;
  }
}

const Y_AXIS = new THREE.Vector3(0, 1, 0);

/** An arrow from the origin. */
export class Arrow {
  constructor(paint, { width = 0.012, head = 0.08, more = {} } = {}) {
    const basic = new THREE.MeshBasicMaterial({ color: paint, ...more });
    this.head = head;
    this.shaft = new THREE.Mesh(new THREE.CylinderGeometry(width, width, 1, 12).translate(0, 0.5, 0), basic);
    this.tip = new THREE.Mesh(new THREE.ConeGeometry(0.36 * head, head, 20).translate(0, -0.5 * head, 0), basic);
    this.object = new THREE.Group();
    this.object.add(this.shaft, this.tip);
    this.end = new THREE.Vector3();
  }

  /** Points along a vector with its length times `scale`; a zero vector hides the arrow. */
  point(vector, scale = 1) {
    this.end.set(...vector);
    const size = this.end.length();
    this.object.visible = size > 0;
    if (!size) return this;
    this.end.divideScalar(size);
    this.object.quaternion.setFromUnitVectors(Y_AXIS, this.end);
    const length = size * scale;
    this.shaft.scale.y = Math.max(1e-6, length - this.head);
    this.tip.position.y = length;
    this.end.multiplyScalar(length);
    return this;
  }

  /** The position of the label, beyond the tip. */
  labelPosition(distance = 0.09) {
    if (!this.object.visible) return null;
    const place = this.end.clone().setLength(this.end.length() + distance);
    return this.object.parent ? this.object.parent.localToWorld(place) : place;
  }
}

const SIGN_DISTANCE = 1.12; // of the sign of a direction from the centre, in radii of the sphere
const RAYS = 8;

/** A direction, marked by a sign outside the sphere: a sun, a globe, or an arrow head. */
export class Pointer {
  constructor(kind, paint, unit) {
    const basic = new THREE.MeshBasicMaterial({ color: paint });
    this.object = new THREE.Group();
    this.object.scale.setScalar(unit);
    const stem = line([[0, 0, 0], [0, SIGN_DISTANCE, 0]], paint, 1, { dashed: true, dashSize: 0.03, gapSize: 0.04 });
    stem.computeLineDistances();
    const size = kind === "velocity" ? new THREE.ConeGeometry(0.04, 0.12, 20) : new THREE.SphereGeometry(0.045, 20, 14);
    this.object.add(stem, new THREE.Mesh(size.translate(0, SIGN_DISTANCE, 0), basic));
    if (kind === "sun") this.object.add(...rays(paint));
    if (kind === "earth") this.object.add(new THREE.Mesh(new THREE.TorusGeometry(0.075, 0.007, 8, 40).translate(0, SIGN_DISTANCE, 0), basic));
  }

  point(vector) {
    this.object.quaternion.setFromUnitVectors(Y_AXIS, new THREE.Vector3(...vector));
  }

  /** The position of the label, beyond the sign. */
  labelPosition() {
    return this.object.localToWorld(new THREE.Vector3(0, SIGN_DISTANCE + 0.14, 0));
  }
}

function rays(paint) {
  return Array.from({ length: RAYS }, (_, k) => {
    const [x, z] = [Math.cos((2 * Math.PI * k) / RAYS), Math.sin((2 * Math.PI * k) / RAYS)];
    return line([0.06, 0.09].map((r) => [r * x, SIGN_DISTANCE + r * z, 0]), paint, 1.6);
  });
}

export function ball(radius, paint) {
  return new THREE.Mesh(new THREE.SphereGeometry(radius, 20, 14), new THREE.MeshBasicMaterial({ color: paint }));
}

/** A circle about a unit axis, at a height along it, on the sphere of radius 1. */
export function circle(axis, height, count = 96) {
  const across = new THREE.Vector3(...axis);
  const first = new THREE.Vector3(axis[2], axis[0], axis[1]).cross(across).normalize();
  const second = across.clone().cross(first);
  const radius = Math.sqrt(1 - height * height);
  return Array.from({ length: count + 1 }, (_, k) => {
    const angle = (2 * Math.PI * k) / count;
    return new THREE.Vector3()
      .addScaledVector(across, height)
      .addScaledVector(first, radius * Math.cos(angle))
      .addScaledVector(second, radius * Math.sin(angle))
      .toArray();
  });
}
