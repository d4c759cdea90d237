// Colours of receivers on the graphics card: a texture of values by receiver, a colour map and a
// range. A new range costs nothing, new values one small upload. In: values by row of the archive.
// Out: a material for patches whose attribute `owner` is that row.

import { DataTexture, FloatType, FrontSide, GLSL3, RedFormat, RGBAFormat, ShaderMaterial, type Texture, UnsignedByteType, Vector2 } from "three";
import { STEPS, type ColourMap } from "../colour/map";
import { VIRIDIS } from "../../../results/page/viridis";

/** Receivers in a row of the texture of values. */
export const WIDTH = 1024;
/** Number that stands for "no value", since graphics cards differ in their NaN. */
const NONE = -1e30;

/**
 * Meaning of the colours: values, their change from those of another archive, or that change in
 * percent.
 */
export type Shown = "values" | "change" | "percent";
const SHOWN: readonly Shown[] = ["values", "change", "percent"];

const VALUE_OF = /* glsl */ `
  uniform highp sampler2D values;
  /** Of the archive before, and the receiver there of each here, -1 for none. */
  uniform highp sampler2D former;
  uniform highp sampler2D partners;
  uniform int shown;
  float at(highp sampler2D numbers, int owner) { return texelFetch(numbers, ivec2(owner % ${WIDTH}, owner / ${WIDTH}), 0).r; }
  float valueOf(int owner) {
    float value = at(values, owner);
    if (shown == 0) return value;
    int partner = int(at(partners, owner));
    if (partner < 0) return ${NONE.toExponential()};
    float before = at(former, partner);
    if (min(value, before) < ${(NONE / 10).toExponential()}) return ${NONE.toExponential()};
    if (shown == 1) return value - before;
    return before == 0.0 ? ${NONE.toExponential()} : 100.0 * (value - before) / before;
  }
`;

const VERTEX = /* glsl */ `
  precision highp float;
  precision highp int;
  in float owner;
  flat out float value;
  flat out float marked;
  flat out float shade;
  in vec3 face;
  uniform vec2 marks;
  ${VALUE_OF}
  void main() {
    value = valueOf(int(owner + 0.5));
    marked = owner == marks.x || owner == marks.y ? 1.0 : 0.0;
    // Nearly none, so that colours can be read off the legend, but enough to tell walls apart.
    shade = 0.95 + 0.05 * dot(face, vec3(0.35, -0.25, 0.9));
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }
`;

const FRAGMENT = /* glsl */ `
  precision highp float;
  flat in float value;
  flat in float marked;
  flat in float shade;
  uniform sampler2D map;
  uniform vec2 range;
  layout(location = 0) out vec4 colour;
  void main() {
    vec3 rgb = vec3(0.72, 0.74, 0.76);
    if (value > ${(NONE / 10).toExponential()}) {
      float share = clamp((value - range.x) / max(range.y - range.x, 1e-9), 0.0, 1.0);
      rgb = texelFetch(map, ivec2(int(share * ${STEPS - 1}.0 + 0.5), 0), 0).rgb;
    }
    colour = vec4(mix(rgb * shade, vec3(1.0, 0.25, 0.45), 0.65 * marked), 1.0);
  }
`;

export class Paint {
  readonly material: ShaderMaterial;
  /** Values of the core, [row of the archive]; values that the card makes have the same places. */
  readonly texture: DataTexture;
  private readonly data: Float32Array;
  private readonly maps = new Map<ColourMap, DataTexture>();
  private partners: DataTexture;

  /** `former`: colours of the archive before, if there is one, that these may be compared with. */
  constructor(readonly receivers: number, former: Paint | null = null) {
    const height = Math.max(1, Math.ceil(receivers / WIDTH));
    this.data = new Float32Array(WIDTH * height).fill(NONE);
    this.texture = new DataTexture(this.data, WIDTH, height, RedFormat, FloatType);
    this.texture.needsUpdate = true;
    this.partners = new DataTexture(new Float32Array([-1]), 1, 1, RedFormat, FloatType);
    const values = { value: this.texture };
    this.material = new ShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      side: FrontSide,
      polygonOffset: true,
      polygonOffsetFactor: -1,
      polygonOffsetUnits: -2,
      uniforms: {
        values,
        // Whatever the one before is coloured by.
        former: former?.material.uniforms["values"] ?? values,
        partners: { value: this.partners },
        shown: { value: 0 },
        map: { value: this.textureOf(VIRIDIS) },
        range: { value: new Vector2(0, 1) },
        marks: { value: new Vector2(-1, -1) },
      },
    });
  }

  /** Takes the values of all receivers; NaN where there is none. */
  show(values: Float32Array): void {
    for (let index = 0; index < this.receivers; index++) {
      const value = values[index]!;
      this.data[index] = Number.isFinite(value) ? value : NONE;
    }
    this.texture.needsUpdate = true;
  }

  /** Colours the values that the card made, or the core's values again. */
  use(made: Texture | null): void {
    this.material.uniforms["values"]!.value = made ?? this.texture;
  }

  /** Sets the receivers of the archive before, by those here; -1 where there is none. */
  compareWith(partners: Int32Array): void {
    const data = new Float32Array(this.data.length).fill(-1);
    data.set(partners);
    this.partners.dispose();
    this.partners = new DataTexture(data, WIDTH, this.texture.image.height, RedFormat, FloatType);
    this.partners.needsUpdate = true;
    this.material.uniforms["partners"]!.value = this.partners;
  }

  shows(shown: Shown, map: ColourMap): void {
    this.material.uniforms["shown"]!.value = SHOWN.indexOf(shown);
    this.material.uniforms["map"]!.value = this.textureOf(map);
  }

  range(low: number, high: number): void {
    (this.material.uniforms["range"]!.value as Vector2).set(low, high);
  }

  private textureOf(map: ColourMap): DataTexture {
    let texture = this.maps.get(map);
    if (!texture) {
      texture = new DataTexture(map.bytes, STEPS, 1, RGBAFormat, UnsignedByteType);
      texture.needsUpdate = true;
      this.maps.set(map, texture);
    }
    return texture;
  }

  dispose(): void {
    for (const texture of [this.texture, this.partners, ...this.maps.values()]) texture.dispose();
    this.material.dispose();
  }

  /** Marks two receivers; -1 for none. */
  mark(first: number, second: number): void {
    (this.material.uniforms["marks"]!.value as Vector2).set(first, second);
  }
}
