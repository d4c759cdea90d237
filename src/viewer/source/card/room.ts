// Memory of the graphics card for receivers, within a budget. In: tiles as the engine makes texels
// of them. Out: pages, textures of whole rows of texels, and a place for each receiver.

import { DataTexture, NearestFilter, RedIntegerFormat, RGBAIntegerFormat, UnsignedIntType, Vector2, type WebGLRenderer } from "three";
import type { TileTextures } from "../engine/client";
import { PAGE_BITS, ROW } from "./shader";

const ROWS = (1 << PAGE_BITS) / ROW;
const WORDS = 4;
const ROW_BYTES = ROW * WORDS * 4;
export const PAGE_BYTES = ROWS * ROW_BYTES;
const MB = 1 << 20;

/** Texture of words; its size is in `width` texels. */
function integers(data: Uint32Array | null, width: number, height: number, single: boolean): DataTexture {
  const texture = new DataTexture(data, width, height, single ? RedIntegerFormat : RGBAIntegerFormat, UnsignedIntType);
  texture.internalFormat = single ? "R32UI" : "RGBA32UI";
  texture.minFilter = texture.magFilter = NearestFilter;
  texture.unpackAlignment = 4;
  texture.needsUpdate = true;
  return texture;
}

export class Room {
  readonly pages: DataTexture[] = [];
  /** [row of the archive]: page and first texel, 0 if the core computes the receiver. */
  readonly places: DataTexture;
  /** Bytes of receivers that are loaded. */
  used = 0;
  shape: TileTextures["shape"] | null = null;
  private readonly placesData: Uint32Array;
  private rows = ROWS;
  /** True if nothing more fits. */
  full = false;

  constructor(
    private readonly renderer: WebGLRenderer,
    width: number,
    height: number,
    private readonly budgetMb: number,
  ) {
    this.placesData = new Uint32Array(width * height);
    this.places = integers(this.placesData, width, height, true);
  }

  /** Bytes of the pages. */
  get taken(): number {
    return this.pages.length * PAGE_BYTES;
  }

  /** Loads a tile. Returns false if there is no room for it. */
  put(tile: TileTextures): boolean {
    const rows = Math.ceil((tile.words.length * 4) / ROW_BYTES);
    this.shape ??= tile.shape;
    if (this.full || rows > ROWS || this.shape.join() !== tile.shape.join()) return false;
    if (this.rows + rows > ROWS && !this.another()) return false;
    const page = this.pages.length - 1;
    const words = new Uint32Array(rows * ROW * WORDS);
    words.set(tile.words);
    const from = integers(words, ROW, rows, false);
    this.renderer.copyTextureToTexture(from, this.pages[page]!, null, new Vector2(0, this.rows));
    from.dispose();
    tile.starts.forEach((start, row) => (this.placesData[tile.first + row] = 1 + ((page << PAGE_BITS) | (this.rows * ROW + start))));
    this.rows += rows;
    this.used += rows * ROW_BYTES;
    this.places.needsUpdate = true;
    return true;
  }

  dispose(): void {
    for (const texture of [...this.pages, this.places]) texture.dispose();
    this.pages.length = 0;
  }

  private another(): boolean {
    const gl = this.renderer.getContext();
    this.full = this.taken + PAGE_BYTES > this.budgetMb * MB || gl.getParameter(gl.MAX_TEXTURE_SIZE) < Math.max(ROW, ROWS);
    if (this.full) return false;
    while (gl.getError() !== gl.NO_ERROR && !gl.isContextLost());
    const page = integers(null, ROW, ROWS, false);
    // This only allocates memory: tiles are loaded one by one.
    page.source.dataReady = false;
    this.renderer.initTexture(page);
    // The card may have less memory than the budget.
    if (gl.getError() !== gl.NO_ERROR) {
      page.dispose();
      this.full = true;
      return false;
    }
    this.pages.push(page);
    this.rows = 0;
    return true;
  }
}
