// A picture of clouds. In: a file. Out: its levels as they are coded, and its map as the engine
// makes it. The engine turns levels into shares of light.

import type { Engine } from "./engine/client";
import { el } from "./dom";
import { EngineError } from "./engine/failure";

/** Largest number of pixels to a side. */
const MOST = 4096;

/** Number of points to a side of the map. */
const MAP = 256;

/**
 * Colour of clouds on the map. They are not drawn opaque, so that the content behind them stays
 * visible.
 */
export const CLOUD_RGB = [104, 114, 125] as const;

export const CLOUD_OPACITY = 0.8;

export interface CloudPicture {
  name: string;
  side: number;
  /** Red, green, blue and opacity of each pixel, by rows from the top. */
  levels: Uint8Array;
}

/** Picture that an engine has, with its map. */
export interface Clouds {
  name: string;
  /**
   * Map whose top is the top of the picture and whose right is clockwise of it; transparent where
   * nothing is hidden.
   */
  map: HTMLCanvasElement;
}

function refused(message: string, hint: string): EngineError {
  return new EngineError({ kind: "other", message, hint });
}

/** Reads a picture. Throws an error if it is not square. */
export async function readPicture(file: File): Promise<CloudPicture> {
  let bitmap: ImageBitmap;
  try {
    // Levels are shares as they stand in the file, so colour space and opacity must not change
    // them.
    bitmap = await createImageBitmap(file, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
  } catch {
    throw refused("this browser cannot read the file as a picture", "Save the picture as PNG.");
  }
  const { width, height } = bitmap;
  try {
    if (width !== height) throw refused(`the picture of ${width} x ${height} pixels is not square`, "Crop it to the square around the circle of the horizon, whose middle is the zenith.");
    if (width > MOST) throw refused(`the picture has ${width} x ${height} pixels, and the limit is ${MOST} x ${MOST}`, "Scale the picture down.");
    return { name: file.name, side: width, levels: levelsOf(bitmap) };
  } finally {
    bitmap.close();
  }
}

/**
 * Returns the levels of a picture by way of a texture: a 2D canvas would multiply them by opacity,
 * which cannot be undone.
 */
function levelsOf(bitmap: ImageBitmap): Uint8Array {
  const { width, height } = bitmap;
  const gl = new OffscreenCanvas(1, 1).getContext("webgl2");
  if (!gl) throw refused("this browser has no WebGL 2, which reading a picture needs", "Allow graphics acceleration, or use a newer browser.");
  try {
    if (width > (gl.getParameter(gl.MAX_TEXTURE_SIZE) as number)) throw refused(`the picture has ${width} x ${height} pixels, more than the graphics card accepts`, "Scale the picture down.");
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
    gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, gl.getParameter(gl.TEXTURE_BINDING_2D) as WebGLTexture, 0);
    const levels = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, levels);
    return levels;
  } finally {
    gl.getExtension("WEBGL_lose_context")?.loseContext();
  }
}

/** Gives a picture to an engine and returns it with its map. */
export async function cloudsOf(engine: Engine, { name, side, levels }: CloudPicture): Promise<Clouds> {
  const hidden = await engine.clouds(side, levels, MAP);
  const map = el("canvas", { width: MAP, height: MAP });
  const pixels = new ImageData(MAP, MAP);
  hidden.forEach((level, at) => pixels.data.set([...CLOUD_RGB, level], 4 * at));
  map.getContext("2d")?.putImageData(pixels, 0, 0);
  return { name, map };
}
