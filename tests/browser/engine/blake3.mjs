// The checksum of a header slot: the first 8 bytes of BLAKE3 of at most 1024 bytes (Connor, Aumasson, Neves and Wilcox-O'Hearn, 2020), to make
// headers of later formats.
const IV = [0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a, 0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19];
const ORDER = [2, 6, 3, 10, 7, 0, 4, 13, 1, 11, 12, 5, 9, 14, 15, 8];
const [CHUNK_START, CHUNK_END, ROOT] = [1, 2, 8];

function compress(value, words, length, flags) {
  const s = [...value, ...IV.slice(0, 4), 0, 0, length, flags];
  const turn = (x, by) => (x >>> by) | (x << (32 - by));
  const mix = (a, b, c, d, x, y) => {
    for (const [word, first, second] of [[x, 16, 12], [y, 8, 7]]) {
      s[a] = (s[a] + s[b] + word) | 0;
      s[d] = turn(s[d] ^ s[a], first);
      s[c] = (s[c] + s[d]) | 0;
      s[b] = turn(s[b] ^ s[c], second);
    }
  };
  for (let round = 0, m = words; round < 7; round++, m = ORDER.map((i) => m[i])) {
    [[0, 4, 8, 12], [1, 5, 9, 13], [2, 6, 10, 14], [3, 7, 11, 15], [0, 5, 10, 15], [1, 6, 11, 12], [2, 7, 8, 13], [3, 4, 9, 14]]
      .forEach(([a, b, c, d], i) => mix(a, b, c, d, m[2 * i], m[2 * i + 1]));
  }
  return s.slice(0, 8).map((x, i) => x ^ s[i + 8]);
}

function checksum(bytes) {
  let value = IV;
  for (let at = 0; at < bytes.length; at += 64) {
    const part = Buffer.alloc(64);
    const length = bytes.copy(part, 0, at, at + 64);
    const last = at + 64 >= bytes.length;
    const words = Array.from({ length: 16 }, (_, i) => part.readUInt32LE(4 * i));
    value = compress(value, words, length, (at === 0 ? CHUNK_START : 0) | (last ? CHUNK_END | ROOT : 0));
  }
  const out = Buffer.alloc(8);
  value.slice(0, 2).forEach((word, i) => out.writeInt32LE(word | 0, 4 * i));
  return out;
}

/** An archive whose header's slots say format 2. */
export function later(archive) {
  const bytes = Buffer.from(archive);
  for (const slot of [0, 4096]) {
    bytes.writeUInt16LE(2, slot + 8);
    checksum(bytes.subarray(slot, slot + 504)).copy(bytes, slot + 504);
  }
  return bytes;
}
