// Which receiver is drawn at a pixel: the graphics card draws that one pixel with rows in place of
// colours.

import { type Camera, Color, DoubleSide, FrontSide, GLSL3, Mesh, type Object3D, type PerspectiveCamera, type Scene, ShaderMaterial, type WebGLRenderer, WebGLRenderTarget } from "three";
import { LEAVES } from "./scenery";

const VERTEX = /* glsl */ `
  precision highp float;
  in float owner;
  flat out float row;
  void main() {
    row = owner;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }
`;

const ROWS = /* glsl */ `
  precision highp float;
  flat in float row;
  layout(location = 0) out vec4 colour;
  void main() {
    float id = row + 1.0;
    colour = vec4(mod(id, 256.0), mod(floor(id / 256.0), 256.0), floor(id / 65536.0), 255.0) / 255.0;
  }
`;

const NOTHING = /* glsl */ `
  precision highp float;
  layout(location = 0) out vec4 colour;
  void main() { colour = vec4(0.0, 0.0, 0.0, 1.0); }
`;

const rows = new ShaderMaterial({
  glslVersion: GLSL3, vertexShader: VERTEX, fragmentShader: ROWS, side: FrontSide,
  polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -2,
});
const nothing = new ShaderMaterial({
  glslVersion: GLSL3,
  vertexShader: VERTEX.replace("in float owner;", "").replace("row = owner;", "row = 0.0;"),
  fragmentShader: NOTHING,
  side: DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 2,
});

export class Picker {
  private readonly target = new WebGLRenderTarget(1, 1);

  constructor(private readonly renderer: WebGLRenderer) {}

  /**
   * Returns the row of the receiver at a pixel of the canvas (page pixels), or none. Leaves are
   * looked through.
   */
  at(scene: Scene, camera: PerspectiveCamera, patches: Object3D, x: number, y: number, width: number, height: number): number | null {
    const restore: (() => void)[] = [];
    const isPatch = new Set(patches.children);
    scene.traverse((object) => {
      if (object === scene || object.children.length > 0) return;
      if (!(object instanceof Mesh) || object.material === LEAVES) {
        const { visible } = object;
        object.visible = false;
        restore.push(() => (object.visible = visible));
        return;
      }
      const material: unknown = object.material;
      object.material = isPatch.has(object) ? rows : nothing;
      restore.push(() => (object.material = material));
    });
    const clear = this.renderer.getClearColor(new Color());
    camera.setViewOffset(width, height, x, y, 1, 1);
    this.renderer.setRenderTarget(this.target);
    this.renderer.setClearColor(0x000000, 1);
    this.renderer.clear();
    this.renderer.render(scene, camera as Camera);
    const pixel = new Uint8Array(4);
    this.renderer.readRenderTargetPixels(this.target, 0, 0, 1, 1, pixel);
    this.renderer.setRenderTarget(null);
    this.renderer.setClearColor(clear, 1);
    camera.clearViewOffset();
    for (const undo of restore) undo();
    const id = pixel[0]! + 256 * pixel[1]! + 65536 * pixel[2]!;
    return id === 0 ? null : id - 1;
  }
}
