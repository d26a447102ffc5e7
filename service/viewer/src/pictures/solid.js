// Solids for the body: the shape of the ground effect, the plates, the box of equal inertia, or a model.

import * as THREE from "three";
import { ConvexGeometry } from "three/examples/jsm/geometries/ConvexGeometry.js";
import { colour } from "../dom.js";
import { principal } from "../answers/rotation.js";

// Over the longest edge: plates without thickness would be invisible from the side.
const MIN_THICKNESS = 0.02;
const METRES_PER_UNIT = { m: 1, cm: 1e-2, mm: 1e-3, km: 1e3, dm: 1e-1, um: 1e-6 };
const QUARTER_TURN = Math.PI / 2;

/** A body to be drawn: geometries with their edges. */
class Solid {
  /** `parts` are [geometry, colour name, opacity]; metres is null where the unit of length is not known. */
  constructor(parts, description, metres = null) {
    Object.assign(this, { parts, description, metres });
    const spheres = parts.map(([geometry]) => {
      geometry.computeBoundingSphere();
      return geometry.boundingSphere;
    });
    this.size = Math.max(...spheres.map(({ center, radius }) => center.length() + radius));
  }

  object() {
    const group = new THREE.Group();
    for (const [geometry, paint, opacity] of this.parts) {
      group.add(new THREE.Mesh(geometry.clone(), faces(paint, opacity)));
    }
    return group.add(this.outline(colour("--body-edge")));
  }

  outline(paint) {
    const look = new THREE.LineBasicMaterial({ color: paint });
    return new THREE.Group().add(
      ...this.parts.map(([geometry]) => new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 24), look)),
    );
  }
}

function faces(paint, opacity) {
  return new THREE.MeshLambertMaterial({
    color: paint.startsWith("--") ? colour(paint) : paint, transparent: true, opacity, side: paint.startsWith("--") ? THREE.FrontSide : THREE.DoubleSide,
    polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
  });
}

/** The solids that a document gives, by name; the first is drawn unless another is chosen. */
export function solidsOf(document, inertia) {
  const ground = document.effects?.find((effect) => effect?.type === "ground");
  const plates = document.effects?.find((effect) => effect?.plates?.length)?.plates;
  return {
    ...(ground?.shape && { shape: shapeOf(ground.shape) }),
    ...(plates && { plates: platesOf(plates) }),
    box: equalBox(inertia),
  };
}

function shapeOf(shape) {
  const geometry = geometryOf(shape);
  geometry.translate(...(shape.centre ?? [0, 0, 0]));
  return new Solid([[geometry, "--body", 0.9]], "shape of the ground effect", METRES_PER_UNIT[shape.unit] ?? null);
}

function geometryOf(shape) {
  if (shape.box) return new THREE.BoxGeometry(...shape.box);
  if (shape.sphere) return new THREE.SphereGeometry(shape.sphere, 48, 32);
  if (shape.vertices) return new ConvexGeometry(shape.vertices.map((vertex) => new THREE.Vector3(...vertex)));
  const { radius, height, axis } = shape.cylinder;
  const cylinder = new THREE.CylinderGeometry(radius, radius, height, 64); // along y
  if (axis === "x") cylinder.rotateZ(QUARTER_TURN);
  return axis === "z" ? cylinder.rotateX(QUARTER_TURN) : cylinder;
}

/** A square of each plate's area about its centre; lighter for a greater reflectance. */
function platesOf(plates) {
  const parts = plates.map(({ area, normal, centre, specular = 0, diffuse = 0 }) => {
    const edge = Math.sqrt(area.value * areaUnit(area.unit));
    const geometry = new THREE.PlaneGeometry(edge, edge);
    const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...normal).normalize());
    geometry.applyQuaternion(turn).translate(...centre.value.map((x) => x * (METRES_PER_UNIT[centre.unit] ?? 1)));
    return [geometry, grey(specular + diffuse), 0.95];
  });
  return new Solid(parts, "plates, as squares; lighter ones reflect more light", 1);
}

const areaUnit = (unit) => (METRES_PER_UNIT[unit.replace(/(\^|\*\*)?2$/, "")] ?? 1) ** 2;
const grey = (part) => `hsl(205, 14%, ${Math.round(24 + 66 * Math.min(1, part))}%)`;

/** Edges a, b, c with I1 ~ b2 + c2, and so on round: a2 ~ I2 + I3 - I1; their scale is anyone's. */
function equalBox(inertia) {
  const { moments, axes } = principal(inertia);
  const sum = moments[0] + moments[1] + moments[2];
  const edges = moments.map((moment) => Math.sqrt(Math.max(0, sum - 2 * moment)));
  const least = MIN_THICKNESS * Math.max(...edges);
  const geometry = new THREE.BoxGeometry(...edges.map((edge) => Math.max(edge, least)));
  const turn = new THREE.Matrix4().makeBasis(...axes.map((axis) => new THREE.Vector3(...axis)));
  geometry.applyMatrix4(turn);
  return new Solid([[geometry, "--body", 0.9]], "box of equal inertia");
}

/** The plane of the ground effect: {normal, height}, m; null where there is none. */
export function groundOf(document) {
  const ground = document.effects?.find((effect) => effect?.type === "ground");
  const metres = METRES_PER_UNIT[ground?.height?.unit];
  if (!metres) return null;
  return { normal: new THREE.Vector3(...ground.normal).normalize(), height: ground.height.value * metres };
}
