// The patches that receivers stand for, as a few large meshes. In: overviews of tiles as they
// arrive. Each triangle faces the way its receiver does, so that the two sides of a module keep
// their own colours.

import { Box3, BufferAttribute, BufferGeometry, Mesh, type Group, type ShaderMaterial, Vector3 } from "three";
import type { Overview } from "../engine/client";

/**
 * Share of its size by which a patch is drawn wider on each side; the next constant is the least
 * widening in m. Neighbours' corners are rounded to mm, and the surface behind would shine through.
 */
const OVERLAP = 0.01;
const LEAST_OVERLAP_M = 0.004;

/** Number of triangles that are gathered before they become a mesh. */
const ENOUGH = 40_000;
/** Longest time that triangles wait for others, ms. */
const PATIENCE = 250;

export class Patches {
  readonly box = new Box3();
  private waiting: { overview: Overview; first: number }[] = [];
  private triangles = 0;
  private since = 0;

  constructor(
    private readonly group: Group,
    private readonly material: ShaderMaterial,
  ) {}

  add(overview: Overview, first: number): void {
    if (this.waiting.length === 0) this.since = performance.now();
    this.waiting.push({ overview, first });
    this.triangles += overview.owner.length;
    const { points } = overview;
    for (let at = 0; at < points.length; at += 3) this.box.expandByPoint(new Vector3(points[at], points[at + 1], points[at + 2]));
    if (this.triangles >= ENOUGH || performance.now() - this.since > PATIENCE) this.flush();
  }

  /** Returns the corners of all patches that are meshes: x, y, z one after the other. */
  points(): ArrayLike<number>[] {
    return this.group.children.map((mesh) => (mesh as Mesh<BufferGeometry>).geometry.getAttribute("position").array);
  }

  /** Makes a mesh of the gathered triangles. Returns true if there were any. */
  flush(): boolean {
    if (this.triangles === 0) return false;
    const positions = new Float32Array(9 * this.triangles);
    const owners = new Float32Array(3 * this.triangles);
    const faces = new Int8Array(9 * this.triangles);
    let corner = 0;
    for (const { overview, first } of this.waiting) {
      const { points, corners, owner, normal, middle } = overview;
      const along = (from: number, to: number, axis: number): number => points[3 * to + axis]! - points[3 * from + axis]!;
      for (let triangle = 0; triangle < owner.length; triangle++) {
        const row = owner[triangle]!;
        let [a, b, c] = [corners[3 * triangle]!, corners[3 * triangle + 1]!, corners[3 * triangle + 2]!];
        const facing =
          normal[3 * row]! * (along(a, b, 1) * along(a, c, 2) - along(a, b, 2) * along(a, c, 1)) +
          normal[3 * row + 1]! * (along(a, b, 2) * along(a, c, 0) - along(a, b, 0) * along(a, c, 2)) +
          normal[3 * row + 2]! * (along(a, b, 0) * along(a, c, 1) - along(a, b, 1) * along(a, c, 0));
        if (facing < 0) [b, c] = [c, b];
        for (const point of [a, b, c]) {
          const from = (axis: number): number => points[3 * point + axis]! - middle[3 * row + axis]!;
          const off = from(0) * normal[3 * row]! + from(1) * normal[3 * row + 1]! + from(2) * normal[3 * row + 2]!;
          const out = (axis: number): number => from(axis) - off * normal[3 * row + axis]!;
          const wider = Math.max(OVERLAP, LEAST_OVERLAP_M / Math.max(0.01, Math.hypot(out(0), out(1), out(2))));
          for (let axis = 0; axis < 3; axis++) {
            positions[3 * corner + axis] = points[3 * point + axis]! + wider * out(axis);
            faces[3 * corner + axis] = Math.round(127 * normal[3 * row + axis]!);
          }
          owners[corner] = first + row;
          corner += 1;
        }
      }
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setAttribute("owner", new BufferAttribute(owners, 1));
    geometry.setAttribute("face", new BufferAttribute(faces, 3, true));
    this.group.add(new Mesh(geometry, this.material));
    this.waiting = [];
    this.triangles = 0;
    return true;
  }
}
