// A model of the body from a .glb file; its coordinates are those of the body frame.

import * as THREE from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";

/** A solid as in solid.js; throws an Error with a message for the user for an unsuitable file. */
export async function modelSolid(file) {
  if (!/\.glb$/i.test(file.name)) throw new Error("a model is a .glb file, which holds everything in one file");
  const loader = new GLTFLoader();
  loader.register((parser) => new EmbeddedTextures(parser));
  const { scene } = await loader.parseAsync(await file.arrayBuffer(), "").catch(() => {
    throw new Error("this file holds no model that can be drawn");
  });
  const box = new THREE.Box3().setFromObject(scene);
  const corner = new THREE.Vector3().fromArray(["x", "y", "z"].map((k) => Math.max(Math.abs(box.min[k]), Math.abs(box.max[k]))));
  if (!(corner.length() > 0)) throw new Error("this model is empty");
  return new ModelSolid(scene, corner.length(), file.name);
}

class ModelSolid {
  constructor(scene, size, name) {
    Object.assign(this, { scene, size, description: `model ${name}`, metres: 1 });
  }

  /** A copy with its own geometries and materials, because a stage disposes of what it showed. */
  object() {
    const copy = this.scene.clone();
    copy.traverse((part) => {
      if (part.geometry) part.geometry = part.geometry.clone();
      if (part.material) part.material = part.material.clone();
    });
    return copy;
  }

  outline(paint) {
    const look = new THREE.LineBasicMaterial({ color: paint });
    this.scene.updateMatrixWorld(true);
    const group = new THREE.Group();
    this.scene.traverse((part) => {
      if (part.isMesh) group.add(new THREE.LineSegments(new THREE.EdgesGeometry(part.geometry, 24).applyMatrix4(part.matrixWorld), look));
    });
    return group;
  }
}

/** Reads textures from the file: the loader would fetch them from a blob URL, which the page forbids. */
class EmbeddedTextures {
  constructor(parser) {
    this.parser = parser;
    this.name = "ATTITUDE_embedded_textures";
  }

  async loadTexture(index) {
    const { json } = this.parser;
    const { source } = json.textures[index];
    const { bufferView, mimeType } = json.images[source] ?? {};
    if (bufferView === undefined) throw new Error("a texture outside the file");
    const bytes = await this.parser.getDependency("bufferView", bufferView);
    const texture = new THREE.Texture(await createImageBitmap(new Blob([bytes], { type: mimeType })));
    texture.flipY = false;
    texture.needsUpdate = true;
    return texture;
  }
}
