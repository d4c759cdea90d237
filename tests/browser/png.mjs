// Pictures that the tests make. In: a side and the levels of its pixels. Out: bytes of a PNG.
import { crc32, deflateSync } from "node:zlib";

function chunk(kind, data) {
  const body = Buffer.concat([Buffer.from(kind), data]);
  const [length, check] = [Buffer.alloc(4), Buffer.alloc(4)];
  length.writeUInt32BE(data.length);
  check.writeUInt32BE(crc32(body));
  return Buffer.concat([length, body, check]);
}

/** Kinds of pixels by their number of levels: grey, grey with opacity, colours, colours with opacity. */
const KINDS = [0, 4, 2, 6];

/** `levels(column, row)` gives the levels of a pixel, from 0 to 255; `gamma` stands in its chunk gAMA. */
export function png(width, height, levels, gamma = null) {
  const channels = levels(0, 0).length;
  const rows = Buffer.alloc(height * (1 + channels * width));
  for (let row = 0; row < height; row++) {
    for (let column = 0; column < width; column++) rows.set(levels(column, row), row * (1 + channels * width) + 1 + channels * column);
  }
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  head.set([8, KINDS[channels - 1]], 8);
  const exponent = Buffer.alloc(4);
  exponent.writeUInt32BE(Math.round(1e5 * (gamma ?? 0)));
  const chunks = [chunk("IHDR", head), ...(gamma === null ? [] : [chunk("gAMA", exponent)]), chunk("IDAT", deflateSync(rows)), chunk("IEND", Buffer.alloc(0))];
  return Buffer.concat([Buffer.from("\x89PNG\r\n\x1a\n", "latin1"), ...chunks]);
}
