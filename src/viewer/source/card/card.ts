// Values of receivers computed by the graphics card. Layers are textures, so that a sun that moves
// costs a few look-ups. In: textures of tiles, a light. Out: a texture of values with the places of
// `Paint`. Receivers that are not on the card keep the core's value there.

import {
  BufferAttribute, BufferGeometry, Camera, DataTexture, FloatType, GLSL3, Mesh, NearestFilter, NoBlending, RedFormat, RGBAFormat, ShaderMaterial, type Texture,
  Vector2, Vector3, Vector4, type WebGLRenderer, WebGLRenderTarget,
} from "three";
import type { LightTexels, TileTextures } from "../engine/client";
import { WIDTH } from "../view/paint";
import { Room } from "./room";
import { FRAGMENT, ROW, VERTEX } from "./shader";

/** Default memory of the card for receivers, MB. */
export const BUDGET_MB = 256;

const COMPONENTS = ["sun_direct", "sky_direct", "sun_reflected", "sky_reflected"];

/** Returns the components that count, or null if the card does not have them. */
function chosen(component: string): Vector4 | null {
  if (component === "total") return new Vector4(1, 1, 1, 1);
  const at = COMPONENTS.indexOf(component);
  return at < 0 ? null : new Vector4(0, 0, 0, 0).setComponent(at, 1);
}

export class Card {
  /** Changes of reflectances for which the textures were made. */
  changes = "";
  /** Number of receivers on the card. */
  receivers = 0;
  /** True when there are no more tiles to load. */
  complete = false;
  /** Light and component of the drawn values, while they are the newest. */
  shown: { light: LightTexels; component: string } | null = null;
  private readonly target: WebGLRenderTarget;
  private readonly pass: Mesh<BufferGeometry, ShaderMaterial>;
  private readonly camera = new Camera();
  private room: Room;
  private lightTexture: DataTexture | null = null;

  /** Returns null for a card that cannot draw floating-point numbers. */
  static of(renderer: WebGLRenderer, values: Texture, receivers: number, budgetMb: number): Card | null {
    return budgetMb > 0 && renderer.extensions.has("EXT_color_buffer_float") ? new Card(renderer, values, receivers, budgetMb) : null;
  }

  private constructor(
    private readonly renderer: WebGLRenderer,
    values: Texture,
    private readonly count: number,
    readonly budgetMb: number,
  ) {
    const height = Math.max(1, Math.ceil(count / WIDTH));
    this.target = new WebGLRenderTarget(WIDTH, height, {
      format: RedFormat, type: FloatType, internalFormat: "R32F", minFilter: NearestFilter, magFilter: NearestFilter, depthBuffer: false, generateMipmaps: false,
    });
    this.room = this.empty();
    const uniform = <T>(value: T): { value: T } => ({ value });
    const material = new ShaderMaterial({
      glslVersion: GLSL3, vertexShader: VERTEX, fragmentShader: FRAGMENT, depthTest: false, depthWrite: false, blending: NoBlending,
      uniforms: {
        page: uniform<Texture | null>(null), places: uniform<Texture | null>(null), light: uniform<Texture | null>(null), values: uniform(values),
        number: uniform(0), shape: uniform(new Vector3()), block: uniform(new Vector2()), parts: uniform(0), reflected: uniform(new Vector2()), field: uniform(0), radiances: uniform(new Vector2()), chosen: uniform(new Vector4()),
      },
    });
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
    this.pass = new Mesh(geometry, material);
    this.pass.frustumCulled = false;
    renderer.domElement.addEventListener("webglcontextlost", this.reset);
  }

  get values(): Texture {
    return this.target.texture;
  }

  /** Bytes of the textures of receivers: in use, and of whole pages. */
  get bytes(): { used: number; taken: number } {
    return { used: this.room.used, taken: this.room.taken };
  }

  /** True if all receivers are on the card. */
  get whole(): boolean {
    return this.receivers === this.count;
  }

  /** True if there is no more room. */
  get full(): boolean {
    return this.room.full;
  }

  /** Returns true if the card can give the values of a component for these changes. */
  serves(changes: string, component: string): boolean {
    return this.receivers > 0 && this.changes === changes && chosen(component) !== null;
  }

  /** Forgets all receivers. */
  readonly reset = (): void => {
    this.room.dispose();
    this.room = this.empty();
    [this.changes, this.receivers, this.complete, this.shown] = ["", 0, false, null];
  };

  /** Loads a tile. Returns false if the core has to compute it. */
  put(tile: TileTextures): boolean {
    if (!tile.served || !this.room.put(tile)) return false;
    this.receivers += tile.starts.length;
    return true;
  }

  /** Computes the values of a component under a light. */
  draw(light: LightTexels, component: string): void {
    const counts = chosen(component);
    const { shape, pages, places } = this.room;
    if (!counts || !shape) return;
    if (this.shown?.light !== light) this.bringLight(light);
    this.shown = { light, component };
    const { uniforms } = this.pass.material;
    const set = (name: string, value: unknown): void => void (uniforms[name]!.value = value);
    set("places", places);
    set("light", this.lightTexture);
    const [patches, response, groups, block, steps] = shape;
    set("shape", new Vector3(patches, response, groups));
    set("block", new Vector2(block, steps));
    set("parts", light.parts);
    set("reflected", new Vector2(...light.reflected));
    set("field", light.field);
    set("radiances", new Vector2(...light.radiances));
    set("chosen", counts);
    const { renderer } = this;
    const [before, clears] = [renderer.getRenderTarget(), renderer.autoClear];
    renderer.setRenderTarget(this.target);
    renderer.autoClear = false;
    for (const [number, page] of pages.entries()) {
      set("page", page);
      set("number", number);
      this.pass.material.uniformsNeedUpdate = true;
      renderer.render(this.pass, this.camera);
    }
    renderer.autoClear = clears;
    renderer.setRenderTarget(before);
  }

  /** Reads the values back, for tests. */
  read(): Float32Array {
    const { renderer, target } = this;
    const gl = renderer.getContext();
    const texels = new Float32Array(4 * target.width * target.height);
    const before = renderer.getRenderTarget();
    renderer.setRenderTarget(target);
    gl.readPixels(0, 0, target.width, target.height, gl.RGBA, gl.FLOAT, texels);
    renderer.setRenderTarget(before);
    return texels.filter((_, at) => at % 4 === 0);
  }

  dispose(): void {
    this.renderer.domElement.removeEventListener("webglcontextlost", this.reset);
    this.room.dispose();
    this.lightTexture?.dispose();
    this.target.dispose();
    this.pass.geometry.dispose();
    this.pass.material.dispose();
  }

  private empty(): Room {
    return new Room(this.renderer, this.target.width, this.target.height, this.budgetMb);
  }

  private bringLight(light: LightTexels): void {
    const rows = Math.max(1, Math.ceil(light.numbers.length / (4 * ROW)));
    let texture = this.lightTexture;
    if (!texture || texture.image.height !== rows) {
      texture?.dispose();
      texture = new DataTexture(new Float32Array(4 * ROW * rows), ROW, rows, RGBAFormat, FloatType);
      this.lightTexture = texture;
    }
    (texture.image.data as Float32Array).set(light.numbers);
    texture.needsUpdate = true;
  }
}
