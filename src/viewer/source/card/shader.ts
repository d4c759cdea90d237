// Adds up what the core made of receivers and of one light, texels as its `moment_textures` says. There is no formula of sun, sky or geometry
// here: sums of products, and the core's rule that no component is below 0.

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
  /** Texels of patches, response, groups; words of fine bits. */
  uniform ivec4 shape;
  uniform int parts;
  uniform ivec3 reflected;
  uniform ivec2 radiances;
  /** 1 for each component that counts: sun and sky directly, then by way of surfaces. */
  uniform vec4 chosen;
  layout(location = 0) out highp float value;

  uvec4 words(int at) { return texelFetch(page, ivec2(at & ${ROW - 1}, at >> 10), 0); }
  uint word(int first, int at) { return words(first + (at >> 2))[at & 3]; }
  vec4 lit(int at) { return texelFetch(light, ivec2(at & ${ROW - 1}, at >> 10), 0); }
  vec4 bytes(uint w) { return vec4(ivec4(int(w << 24) >> 24, int(w << 16) >> 24, int(w << 8) >> 24, int(w) >> 24)); }
  vec3 tens(uint w) { return vec3(ivec3(int(w << 22) >> 22, int(w << 12) >> 22, int(w << 2) >> 22)); }
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
    int block = (int(word(ranks, group)) + before) * shape.w;
    float sum = 0.0;
    for (int at = int(part.z); at < int(part.z + part.w); at++) {
      vec4 fine = lit(at);
      int place = int(fine.x);
      if ((word(first, block + (place >> 5)) >> uint(place & 31) & 1u) != 0u) sum += fine.y;
    }
    return sum;
  }

  float valueOf(int start) {
    vec4 head = uintBitsToFloat(words(start));
    vec4 steps = uintBitsToFloat(words(start + 1));
    int direct = start + 2;
    int response = direct + 2 * shape.x;
    int groups = response + shape.y;
    vec4 sums = vec4(0.0);

    for (int at = 0; at < parts; at++) {
      vec4 sun = lit(2 * at);
      float strength = dot(head.xyz, sun.xyz);
      if (strength > 0.0) sums[int(sun.w)] += strength * seen(groups, lit(2 * at + 1));
    }
    for (int at = 0; at < reflected.y + reflected.z; at++) {
      vec4 source = lit(reflected.x + at);
      float sum = head.w * dot(source.xyz, tens(word(response, int(source.w))));
      sums[at < reflected.y ? 2 : 3] += sum;
    }
    vec2 sky = vec2(0.0);
    int patches = radiances.x + 1;
    for (int at = 0; at < radiances.y; at++) {
      uvec4 a = words(direct + at);
      uvec4 b = words(direct + shape.x + at);
      for (int four = 0; four < 4; four++) {
        vec4 radiance = lit(patches + 4 * at + four);
        sky += vec2(dot(bytes(a[four]), radiance), dot(bytes(b[four]), radiance));
      }
    }
    sums.yw += sky * steps.xy + lit(radiances.x).x * steps.zw;
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
