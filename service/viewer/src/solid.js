// The body's shape: that of the document's ground effect, or the box of equal inertia.

import * as THREE from "three";
import { ConvexGeometry } from "three/examples/jsm/geometries/ConvexGeometry.js";
import { principal } from "./rotation.js";

// Of the longest edge: plates without thickness would not be seen from the side.
const THINNEST = 0.02;
const METRES = { m: 1, cm: 1e-2, mm: 1e-3, km: 1e3, dm: 1e-1, um: 1e-6 };
const QUARTER = Math.PI / 2;

/** {geometry, edges, size, words, metres}: in the shape's unit; metres is null where it has none. */
export function solidOf(document, inertia) {
  const ground = document.effects?.find((effect) => effect?.type === "ground");
  const found = ground?.shape ? given(ground.shape) : equalBox(inertia);
  found.geometry.computeBoundingSphere();
  const { center, radius } = found.geometry.boundingSphere;
  return { ...found, edges: new THREE.EdgesGeometry(found.geometry, 24), size: center.length() + radius };
}

function given(shape) {
  const geometry = geometryOf(shape);
  geometry.translate(...(shape.centre ?? [0, 0, 0]));
  return { geometry, words: "shape of the ground effect", metres: METRES[shape.unit] ?? null };
}

function geometryOf(shape) {
  if (shape.box) return new THREE.BoxGeometry(...shape.box);
  if (shape.sphere) return new THREE.SphereGeometry(shape.sphere, 48, 32);
  if (shape.vertices) return new ConvexGeometry(shape.vertices.map((vertex) => new THREE.Vector3(...vertex)));
  const { radius, height, axis } = shape.cylinder;
  const cylinder = new THREE.CylinderGeometry(radius, radius, height, 64); // along y
  if (axis === "x") cylinder.rotateZ(QUARTER);
  return axis === "z" ? cylinder.rotateX(QUARTER) : cylinder;
}

/** Edges a, b, c with I1 ~ b2 + c2, and so on round: a2 ~ I2 + I3 - I1; their scale is anyone's. */
function equalBox(inertia) {
  const { moments, axes } = principal(inertia);
  const sum = moments[0] + moments[1] + moments[2];
  const edges = moments.map((moment) => Math.sqrt(Math.max(0, sum - 2 * moment)));
  const least = THINNEST * Math.max(...edges);
  const geometry = new THREE.BoxGeometry(...edges.map((edge) => Math.max(edge, least)));
  const turn = new THREE.Matrix4().makeBasis(...axes.map((axis) => new THREE.Vector3(...axis)));
  geometry.applyMatrix4(turn);
  return { geometry, words: "box of equal inertia", metres: null };
}

/** The plane of the ground effect: {normal, height}, m; null where there is none. */
export function groundOf(document) {
  const ground = document.effects?.find((effect) => effect?.type === "ground");
  const metres = METRES[ground?.height?.unit];
  if (!metres) return null;
  return { normal: new THREE.Vector3(...ground.normal).normalize(), height: ground.height.value * metres };
}
