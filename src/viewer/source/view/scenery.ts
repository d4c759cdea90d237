// The scene's triangles, in calm colours by what they are. In: chunks of the engine, materials of
// the site. Out: meshes; leaves are translucent.

import { BufferAttribute, BufferGeometry, DoubleSide, EdgesGeometry, GLSL3, type Group, LineBasicMaterial, LineSegments, Mesh, ShaderMaterial } from "three";
import type { Site } from "../engine/client";

type Material = Site["materials"][number];

/**
 * Largest number of triangles that are outlined: outlines of more take too long and hide more than
 * they show.
 */
const MOST_OUTLINED = 80_000;
const SHARP_DEG = 28;

const VERTEX = /* glsl */ `
  precision highp float;
  in vec3 tint;
  out vec3 base;
  out vec3 place;
  void main() {
    base = tint;
    place = position;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }
`;

const FRAGMENT = /* glsl */ `
  precision highp float;
  in vec3 base;
  in vec3 place;
  uniform float alpha;
  layout(location = 0) out vec4 colour;
  void main() {
    vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
    float light = 0.62 + 0.20 * abs(normal.z) + 0.18 * abs(dot(normal, vec3(-0.53, -0.45, 0.72)));
    colour = vec4(base * light, alpha);
  }
`;

function shader(alpha: number): ShaderMaterial {
  return new ShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    uniforms: { alpha: { value: alpha } },
    side: DoubleSide,
    transparent: alpha < 1,
    depthWrite: alpha === 1,
    polygonOffset: alpha === 1,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 2,
  });
}

const SOLID = shader(1);
export const LEAVES = shader(0.35);
const LINES = new LineBasicMaterial({ color: 0x55606a, transparent: true, opacity: 0.45 });

function tintOf(material: Material | undefined): [number, number, number] {
  if (!material) return [0.88, 0.88, 0.87];
  const kind = `${material.class} ${material.group} ${material.name}`.toLowerCase();
  if (material.canopy || /veget|tree|leaf|leaves|hedge/.test(kind)) return [0.45, 0.62, 0.42];
  if (/water|lake|river/.test(kind)) return [0.62, 0.76, 0.85];
  if (material.mirror || /glass|window/.test(kind)) return [0.72, 0.83, 0.88];
  if (/snow/.test(kind)) return [0.97, 0.98, 1.0];
  if (/ground|terrain|street|road|land/.test(kind)) return [0.87, 0.86, 0.82];
  if (/roof/.test(kind)) return [0.86, 0.83, 0.82];
  return [0.92, 0.92, 0.91];
}

export class Scenery {
  private outlined = 0;

  constructor(
    private readonly group: Group,
    private readonly materials: readonly Material[],
  ) {}

  add(chunk: { vertices: Float32Array; corners: Uint32Array; materials: Uint16Array }): void {
    const canopy = (triangle: number): boolean => this.materials[chunk.materials[triangle]!]?.canopy ?? false;
    const triangles = Array.from(chunk.materials.keys());
    const solid = this.geometry(chunk, triangles.filter((triangle) => !canopy(triangle)));
    const leaves = this.geometry(chunk, triangles.filter(canopy));
    if (solid) {
      this.group.add(new Mesh(solid, SOLID));
      this.outlined += chunk.materials.length;
      if (this.outlined <= MOST_OUTLINED) this.group.add(new LineSegments(new EdgesGeometry(solid, SHARP_DEG), LINES));
    }
    if (leaves) {
      const mesh = new Mesh(leaves, LEAVES);
      mesh.renderOrder = 2;
      this.group.add(mesh);
    }
  }

  private geometry(chunk: { vertices: Float32Array; corners: Uint32Array; materials: Uint16Array }, triangles: number[]): BufferGeometry | null {
    if (triangles.length === 0) return null;
    const positions = new Float32Array(9 * triangles.length);
    const tints = new Uint8Array(9 * triangles.length);
    const tintOfMaterial = this.materials.map((material) => tintOf(material).map((share) => Math.round(255 * share)));
    triangles.forEach((triangle, at) => {
      const tint = tintOfMaterial[chunk.materials[triangle]!] ?? [225, 225, 222];
      for (let corner = 0; corner < 3; corner++) {
        const vertex = chunk.corners[3 * triangle + corner]!;
        positions.set(chunk.vertices.subarray(3 * vertex, 3 * vertex + 3), 9 * at + 3 * corner);
        tints.set(tint, 9 * at + 3 * corner);
      }
    });
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setAttribute("tint", new BufferAttribute(tints, 3, true));
    return geometry;
  }
}
