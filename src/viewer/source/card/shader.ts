// Shader that adds up the texels that the core made of receivers and of one light, as its
// `interactive` module lays them out. It has no formula of sun, sky or geometry: it computes sums
// of products and applies the rule of the core that no component is below 0.

export const ROW = 1024;
/** Bits of a place: texel of a page; above them the page; 1 more than both, so that 0 is none. */
export const PAGE_BITS = 18;

export const VERTEX = /* glsl */ `
  void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }
`;

export const FRAGMENT = /* glsl */ `
  precision highp float;
  precision highp int;
  uniform highp usampler2D page;
  uniform highp usampler2D places;
  uniform highp sampler2D light;
  uniform highp sampler2D values;
  uniform int number;
  /** Texels of patches, response, groups. */
  uniform ivec3 shape;
  /** Side of a base texel, words of its steps. */
  uniform ivec2 block;
  uniform int parts;
  uniform ivec2 reflected;
  uniform int field;
  uniform ivec2 radiances;
  /** 1 for each component that counts: sun and sky directly, then by way of surfaces. */
  uniform vec4 chosen;
  layout(location = 0) out highp float value;

  uvec4 words(int at) { return texelFetch(page, ivec2(at & ${ROW - 1}, at >> 10), 0); }
  uint word(int first, int at) { return words(first + (at >> 2))[at & 3]; }
  vec4 lit(int at) { return texelFetch(light, ivec2(at & ${ROW - 1}, at >> 10), 0); }
  vec4 bytes(uint w) { return vec4(uvec4(w, w >> 8, w >> 16, w >> 24) & 255u); }
  /** Along a texel's direction, and twice across. */
  vec3 vector(uint w) { return vec3(ivec3(int(w << 18) >> 18, int(w << 9) >> 23, int(w) >> 23)); }
  int count(uint w) {
    w = w - ((w >> 1) & 0x55555555u);
    w = (w & 0x33333333u) + ((w >> 2) & 0x33333333u);
    return int((((w + (w >> 4)) & 0x0f0f0f0fu) * 0x01010101u) >> 24);
  }

  /** Share of a disc that is seen: whole base texels at once, those in part by their fine bits. */
  float seen(int groups, vec4 part) {
    int texel = int(part.x);
    int group = texel >> 6;
    uvec4 of = words(groups + group);
    bool high = (texel & 32) != 0;
    uint bit = 1u << uint(texel & 31);
    if (((high ? of.y : of.x) & bit) != 0u) return part.y;
    if (((high ? of.w : of.z) & bit) == 0u) return 0.0;
    int before = high ? count(of.z) + count(of.w & (bit - 1u)) : count(of.z & (bit - 1u));
    int ranks = groups + shape.z;
    int first = ranks + ((shape.z + 3) >> 2);
    int number = int(word(ranks, group)) + before;
    int bits = 2 * ((block.x * block.x + 63) / 64);
    int place = number * (block.y == 0 ? bits : block.y);
    uint last = block.y == 0 ? 0u : word(first, place + block.y - 1);
    bool rows = block.y > 0 && (last >> 31) == 0u;
    if (block.y > 0 && !rows) place = int(word(first, place) & 0x7fffffffu);
    bool right = (last >> 30 & 1u) != 0u;
    int wide = 1;
    while (block.x >> wide > 0) wide++;
    float sum = 0.0;
    int row = -1;
    int length = 0;
    for (int at = int(part.z); at < int(part.z + part.w); at++) {
      vec4 fine = lit(at);
      int inside = int(fine.x);
      if (rows) {
        if (inside / block.x != row) {
          row = inside / block.x;
          int bit = row * wide;
          uint low = word(first, place + (bit >> 5)) >> uint(bit & 31);
          uint high = (bit & 31) == 0 ? 0u : word(first, place + (bit >> 5) + 1) << uint(32 - (bit & 31));
          length = int((low | high) & ((1u << uint(wide)) - 1u));
        }
        int column = inside % block.x;
        if (right ? column >= block.x - length : column < length) sum += fine.y;
      } else if ((word(first, place + (inside >> 5)) >> uint(inside & 31) & 1u) != 0u) sum += fine.y;
    }
    return sum;
  }

  float valueOf(int start) {
    vec4 head = uintBitsToFloat(words(start));
    vec4 more = uintBitsToFloat(words(start + 1));
    int direct = start + 2;
    int response = direct + shape.x;
    int groups = response + shape.y + (shape.y + 3) / 4;
    vec4 sums = vec4(0.0);

    for (int at = 0; at < parts; at++) {
      vec4 sun = lit(2 * at);
      float strength = dot(head.xyz, sun.xyz);
      if (strength > 0.0) sums[int(sun.w)] += strength * seen(groups, lit(2 * at + 1));
    }
    if (shape.y > 0) {
      // What words leave is too little to be seen.
      vec3 steps = vec3(4.0 * head.w, 8.0 * more.xx);
      for (int at = 0; at < reflected.y; at++) {
        vec4 source = lit(reflected.x + at);
        sums.z += dot(source.xyz, steps * vector(word(response, int(source.w))));
      }
      vec3 sky = vec3(0.0);
      for (int at = 0; at < shape.y; at++) {
        uvec4 of = words(response + at);
        for (int texel = 0; texel < 4; texel++) sky += lit(field + 4 * at + texel).xyz * vector(of[texel]);
      }
      sums.w += dot(sky, steps);
    }
    float sky = 0.0;
    int patches = radiances.x + 1;
    for (int at = 0; at < radiances.y; at++) {
      uvec4 of = words(direct + at);
      for (int four = 0; four < 4; four++) sky += dot(bytes(of[four]), lit(patches + 4 * at + four));
    }
    sums.y += sky * more.y + lit(radiances.x).x * more.z;
    return dot(chosen, max(sums, 0.0));
  }

  void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    uint place = texelFetch(places, here, 0).r;
    // One branch for each: what goes on after a discard costs as much as what counts.
    if (place == 0u) value = texelFetch(values, here, 0).r;
    else if (int((place - 1u) >> ${PAGE_BITS}u) == number) value = valueOf(int((place - 1u) & ${(1 << PAGE_BITS) - 1}u));
    else discard;
  }
`;
