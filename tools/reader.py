#!/usr/bin/env python3
"""Second reader of heliotile archives, written from schema/ alone (heliotile-1.md, layers.md, manifest.schema.json).

    reader.py SITE.helio                 check everything, print a summary
    reader.py SITE.helio --digests       ... print one line an array: kind tile array BLAKE3(canonical bytes)

Exit code 0: whole; 1: opened, but blocks are damaged, each is named; 2: cannot be opened. Needs Python 3.9, `blake3`
and, before Python 3.14, `zstandard`.

Canonical bytes of an array are its values without gaps, little-endian; strings: u32 length, UTF-8 bytes. Arrays:
  tables     the columns under their names, as the tables of heliotile-1.md list them and as the block holds them
  sky        sky: R planes of sky_fine^2 bits, each packed row-major, lowest bit first, and filled up to a byte
  hit        level i8, facing u8, material u16, voxel 3 x i32, one a key; texels u32 [receiver][texel], 0 or key + 1
  response   g: f32 [receiver][class][axis][texel]
  mirror, probe-mirror, bounce-mirror
             windows: u32 row, u8 mirrors, u16 each, of kind mirror also u16 column, row, side; bits: of each window, of
             kind mirror refined as sky, of cells u32 number of texels, u16 each; paths: u32 row, u32 texel (of cells u8: starts above the horizon), level i8,
             facing u8, material u16, voxel 3 x i32, u8 steps, each u16 material, u8 cosine
  other rows of bytes (3.9)  lengths: u32 [row]; bytes: all rows; of kind canopy also crossings: u32 row, u32 ray to the sky, u16 material, u16 count
"""
import json
import math
import mmap
import re
import struct
import sys
from collections import namedtuple
from pathlib import Path

from blake3 import blake3

MAGIC = bytes.fromhex("89484c4f0d0a1a0a")
FIRST_BLOCK, ALIGN, ENTRY_SIZE, MAX_RAW, MAX_ENTRIES, MAX_MANIFEST = 8192, 64, 80, 8388608, 67108864, 1048576
MAX_ROWS, MAX_STRING, MAX_MATERIALS, MAX_SEEN, NOTHING = 4096, 1024, 65536, 32767, 0x7FFF
MAX_SIDE = 8192  # What this program holds; the format states smaller limits for each setting.
SLOT = namedtuple("Slot", "magic major minor state required optional generation committed directory_offset "
                          "directory_length directory_count manifest_offset manifest_length root reserved checksum")
ENTRY = namedtuple("Entry", "kind tile offset stored raw codec schema items checksum content reserved")


def share(x):
    return 0 <= x <= 1


def text(least, most=MAX_STRING):
    return lambda s: least <= len(s) <= most


# Columns: name, values in a row and their struct letter (s is a string), range of a value.
KEY = [("voxel", "3i", None), ("tag", "1I", lambda t: t < 65536), ("material", "1H", None)]
CELLS = KEY + [("normal", "3f", lambda n: math.hypot(*n) <= 1 + 1e-6), ("bits", "1B", None)]
CELLS += [("seen_" + name, kind, good) for name, kind, good in KEY] + [("hits", "1H", None), ("doubtful", "1B", share)]
RECEIVERS = [
    ("ids", "s", text(1)), ("position", "3d", lambda p: all(map(math.isfinite, p))),
    ("normal", "3d", lambda n: abs(math.hypot(*n) - 1) <= 1e-6), ("area", "1d", lambda a: 0 <= a < math.inf),
    ("surface", "s", text(0)), ("sky_view", "1f", share), ("ground_view", "1f", share),
    ("obstruction_view", "1f", share)]
MATERIALS = [("name", "s", text(1)), ("diffuse", "1d", share), ("specular", "1d", share), ("class", "1B", share),
             ("group", "s", text(0))]
PARTS = [(name, "s", text(0)) for name in ("object", "building", "kind", "object_type", "face")]
# kind: name, schema, columns of a table.
OPTICS = [("panes", "1B", lambda p: p <= 2), ("canopy", "1B", lambda k: k <= 2), ("transmittance", "1d", share)]
MIRRORS = [("normal", "3d", lambda n: abs(math.hypot(*n) - 1) <= 1e-6), ("material", "1H", None)]
SCENE = [("vertex", "3f", lambda v: all(abs(x) <= 2**20 for x in v)), ("corner", "3I", None), ("material", "1H", None)]
OVERVIEW = [
    ("position", "3f", lambda p: all(abs(x) <= 2e9 for x in p)), ("normal", "3h", lambda n: abs(math.hypot(*n) - 32767) <= 2),
    ("area", "1f", lambda a: 0 <= a < math.inf), ("sky_view", "1B", None), ("clear_year", "1f", lambda y: 0 <= y < math.inf),
    ("polygons", "1B", None), ("corners", "1B", lambda c: c >= 3), ("offset", "3i", lambda o: all(abs(x) <= 2**30 for x in o))]
EXTENTS = [(name, "3d", lambda p: all(map(math.isfinite, p))) for name in ("low", "high")]
NAMES = [("of", "1B", lambda o: o <= 3), ("shared", "1H", lambda n: n <= MAX_STRING),
         ("own", "1H", lambda n: n <= MAX_STRING), ("text", "1B", None), ("tile", "1I", None)]
OBJECTS = [(name, "s", text(0)) for name in ("name", "object", "building", "object_type")]
OBJECTS += [("beside", "1B", share), ("row", "1H", None), ("attributes", "s", text(0, 16384))]
BANDS = [("material", "1H", None), ("property", "1B", lambda p: p <= 3), ("band", "1B", lambda b: b <= 4),
         ("value", "1d", share)]
KINDS = {1: ("receivers", 1, RECEIVERS), 2: ("sky", 1, None), 3: ("hit", 4, None), 4: ("response", 2, None),
         5: ("probes", 4, CELLS), 6: ("bounce", 4, CELLS), 7: ("index", 2, KEY), 8: ("mirror", 2, None),
         9: ("canopy", 5, None), 10: ("materials", 2, MATERIALS), 11: ("optics", 1, OPTICS),
         12: ("probe-mirror", 2, None), 13: ("bounce-mirror", 2, None), 14: ("probe-canopy", 3, None),
         15: ("bounce-canopy", 3, None), 16: ("mirrors", 1, MIRRORS), 17: ("parts", 1, PARTS),
         18: ("scene", 1, SCENE), 19: ("overview", 1, OVERVIEW), 20: ("extents", 1, EXTENTS),
         21: ("names", 1, NAMES), 22: ("objects", 2, OBJECTS), 23: ("bands", 2, BANDS)}
EXTRAS = {8: "receivers", 9: "receivers", 12: "probes", 13: "bounce", 14: "probes", 15: "bounce"}
# Which cells are seen in mirrors, and cells of leaves behind others.
MIRRORED = {"mirror": "probes", "probe-mirror": "bounce", "bounce-mirror": "bounce"}
CROSSED = {"canopy": "probes", "probe-canopy": "bounce", "bounce-canopy": "bounce"}
LEAF = 128


class Damage(Exception):
    """What is wrong with a file or block."""


def need(holds, message):
    if not holds:
        raise Damage(message)


def up(offset):
    return -(-offset // ALIGN) * ALIGN


def unzstd(stored, raw):
    """Exactly one zstd frame (RFC 8878) that states `raw`."""
    need(stored[:4] == b"\x28\xb5\x2f\xfd" and len(stored) > 6, "no zstd frame")
    descriptor, single = stored[4], stored[4] >> 5 & 1
    at, width = 6 - single + (0, 1, 2, 4)[descriptor & 3], (single, 2, 4, 8)[descriptor >> 6]
    need(width, "zstd frame without content size")
    size = int.from_bytes(stored[at:at + width], "little") + (256 if width == 2 else 0)
    need(size == raw, f"zstd frame of {size} bytes, the entry says {raw}")
    try:
        if sys.version_info >= (3, 14):
            from compression.zstd import ZstdDecompressor
            frame = ZstdDecompressor()
            out = frame.decompress(stored, max_length=raw)
            need(frame.eof and not frame.unused_data, "zstd frame does not end with the block")
        else:
            from zstandard import ZstdDecompressor
            out = ZstdDecompressor().decompress(stored, allow_extra_data=False)
    except ImportError:
        raise
    except Exception as error:
        raise Damage(f"zstd: {error}") from error
    need(len(out) == raw, f"{len(out)} bytes decoded, the entry says {raw}")
    return out


def conforms(value, schema, at="manifest"):
    """The part of JSON Schema that manifest.schema.json uses."""
    kinds = {"object": dict, "array": list, "string": str, "boolean": bool, "integer": int, "number": (int, float)}
    kind = schema.get("type", "object")
    need(isinstance(value, kinds[kind]) and (kind == "boolean" or not isinstance(value, bool)), f"{at} is no {kind}")
    need(value == schema.get("const", value), f"{at} is {value!r}, not {schema.get('const')!r}")
    if kind in ("integer", "number"):
        need(schema.get("minimum", value) <= value <= schema.get("maximum", value), f"{at} is {value}")
    if kind == "array":
        need(schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value)), f"{at}: {len(value)} items")
        for i, item in enumerate(value):
            conforms(item, schema["items"], f"{at}[{i}]")
    if kind == "object":
        for name in schema.get("required", []):
            need(name in value, f"{at} has no {name}")
        for name in value.keys() & schema.get("properties", {}).keys():
            conforms(value[name], schema["properties"][name], f"{at}.{name}")


def table(raw, columns):
    """Section 3.1: name -> (canonical bytes, values)."""
    found, at = {}, len(raw) - 8 * len(columns)
    need(at >= 0, "table shorter than its root")
    for name, kind, good in columns:
        distance, count = struct.unpack_from("<iI", raw, at)
        start, letter = at + distance, kind[-1]
        size = 8 if letter == "s" else int(kind[0]) * struct.calcsize("<" + letter)
        need(0 <= start and start + count * size <= len(raw), f"column {name} leaves the block")
        need(start % (4 if letter == "s" else struct.calcsize("<" + letter)) == 0, f"column {name} is not aligned")
        if letter == "s":
            values = [string(raw, start + 8 * i, name) for i in range(count)]
            packed = b"".join(struct.pack("<I", len(s)) + s for s in values)
        else:
            packed = raw[start:start + count * size]
            values = struct.unpack(f"<{count * int(kind[0])}{letter}", packed)
            if kind[0] == "3":
                values = list(zip(values[::3], values[1::3], values[2::3]))
        wrong = next((i for i, value in enumerate(values) if good and not good(value)), None)
        need(wrong is None, f"{name} in row {wrong} is out of range")
        found[name] = (packed, values)
        at += 8
    return found


def string(raw, at, name):
    if raw[at] & 0xC0 != 0x80:
        text = bytes(raw[at:at + 8]).split(b"\xff")[0]
    else:
        word, distance = struct.unpack_from("<Ii", raw, at)
        length, start = word & 0x3F | (word & 0xFFFFFF00) >> 2, at + distance
        need(length <= MAX_STRING and 0 <= start and start + length <= len(raw), f"a string of {name} leaves the block")
        text = bytes(raw[start:start + length])
    try:
        text.decode()
    except UnicodeDecodeError as error:
        raise Damage(f"a string of {name} is not UTF-8") from error
    return text


def order(voxel, tag, material):
    """Section 3.6: what keys are compared by."""
    level, code = (tag >> 8) - 128, 0
    for axis, v in enumerate(voxel):
        r = v << level - 6 if level >= 6 else v >> 6 - level
        r = min(max(r, -1 << 20), (1 << 20) - 1) + (1 << 20)
        code |= int(f"{r:b}", 8) << axis  # Binary digits read as octal: bit i moves to bit 3i.
    return (code, level, tag & 255, material, *voxel)


def texels(bits, side):
    return f"{bits:0{side * side}b}"[::-1]


def doubled(bits, side):
    """Every texel passed on to its four children; one character a texel, in order."""
    line = texels(bits, side).replace("0", "x").replace("1", "11").replace("x", "00")
    return "".join(line[i:i + 2 * side] * 2 for i in range(0, len(line), 2 * side))


def refined(bits, front, side):
    first = ((1 << side * side) - 1) // ((1 << side) - 1)  # Column 0 of every row.
    whole = (1 << side * side) - 1

    def spread(x):
        x |= x << 1 & whole & ~first | x >> 1 & ~(first << side - 1)
        return (x | x << side | x >> side) & whole

    return front & spread(front & bits) & spread(front & ~bits)


def sky(raw, rows, base, fine):
    need(1 <= base <= fine <= MAX_SIDE, f"sides {base} to {fine}, this program reads 1 to {MAX_SIDE}")
    wide = -(-base // 8)  # Bytes of a row: each starts on a byte.
    need(len(raw) >= 2 * rows * wide * base, "sky shorter than its planes")
    lines = [int.from_bytes(raw[i:i + wide], "little") for i in range(0, 2 * rows * wide * base, wide)]
    need(all(line >> base == 0 for line in lines), "bits after a row")
    planes = [sum(line << base * i for i, line in enumerate(lines[p:p + base])) for p in range(0, len(lines), base)]
    fronts, bits, side, at = planes[:rows], planes[rows:], base, 2 * rows * wide * base
    need(all(b & ~f == 0 for f, b in zip(fronts, bits)), "sky behind a surface")
    pair = [b"00", b"10", b"01", b"11"]
    while side < fine:
        for r in range(rows):
            mixed = refined(bits[r], fronts[r], side)
            places = [m.start() for m in re.finditer("1", texels(mixed, side))]
            halves = raw[at:at + (len(places) + 1) // 2]
            need(len(halves) == (len(places) + 1) // 2, "half bytes of the sky are missing")
            need(len(places) % 2 == 0 or halves[-1] >> 4 == 0, "a half byte left over is not 0")
            at += len(halves)
            line = bytearray(doubled(bits[r] & ~mixed, side), "ascii")
            for k, place in enumerate(places):
                half = halves[k >> 1] >> 4 * (k & 1) & 15
                to = place // side * 4 * side + place % side * 2
                line[to:to + 2], line[to + 2 * side:to + 2 * side + 2] = pair[half & 3], pair[half >> 2]
            bits[r] = int(line[::-1], 2)
            fronts[r] = int(doubled(fronts[r], side)[::-1], 2)
        side *= 2
    need(at == len(raw), f"{len(raw) - at} bytes after the sky")
    need(side == fine, "sky_fine is not sky_base times a power of 2")
    return {"sky": b"".join(b.to_bytes(-(-side * side // 8), "little") for b in bits)}


def hit(raw, rows, side):
    need(len(raw) >= 4, "hit shorter than its head")
    keys, = struct.unpack_from("<I", raw)
    texel_count, at, found = rows * side * side, 4, {}
    need(len(raw) == 4 + 16 * keys + 4 * texel_count, f"hit of {len(raw)} bytes with {keys} keys")
    for name, size in [("level", 1), ("facing", 1), ("material", 2), ("x", 4), ("y", 4), ("z", 4)]:
        found[name] = raw[at:at + size * keys]
        at += size * keys
    voxels = list(zip(*(struct.unpack(f"<{keys}i", found.pop(axis)) for axis in "xyz")))
    found["voxel"] = b"".join(struct.pack("<3i", *v) for v in voxels)
    tags = [(level ^ 128) << 8 | facing for level, facing in zip(found["level"], found["facing"])]
    palette = list(map(order, voxels, tags, struct.unpack(f"<{keys}H", found["material"])))
    need(all(a < b for a, b in zip(palette, palette[1:])), "keys do not ascend")
    planes = bytearray(4 * texel_count)
    for i in range(4):
        planes[i::4] = raw[at + i * texel_count:at + (i + 1) * texel_count]
    need(max(struct.unpack(f"<{texel_count}I", planes), default=0) <= keys, "a texel names a key that does not exist")
    found["texels"] = bytes(planes)
    return found, palette


class Values:
    """Values coded by rANS, with the frequencies of some contexts."""

    def __init__(self, raw, contexts):
        at, self.tables = 0, []
        for _ in range(contexts):
            table = []
            for symbol in range(36):
                need(at + 1 < len(raw), "frequencies are missing")
                frequency, at = raw[at], at + 1
                if frequency >= 128:
                    frequency, at = frequency - 128 + 128 * raw[at], at + 1
                start = len(table)
                table += [(symbol, start, frequency)] * min(frequency, 513)
                if len(table) >= 512:
                    break
            need(len(table) == 512, "frequencies do not add up")
            self.tables.append(table)
        need(len(raw) >= at + 32 and (len(raw) - at) % 2 == 0, "states or half a word is missing")
        self.states = list(struct.unpack_from("<8I", raw, at))
        need(min(self.states) >= 65536, "a state is too small")
        self.words = iter(struct.unpack(f"<{(len(raw) - at) // 2 - 16}H", raw[at + 32:]))

    def move(self, number, state):
        if state < 65536:
            word = next(self.words, None)
            need(word is not None, "words of the code are missing")
            state = state << 16 | word
        self.states[number] = state

    def bits(self, number, count):
        state = self.states[number]
        self.move(number, state >> count)
        return state & (1 << count) - 1

    def take(self, context, number):
        slot = self.states[number] & 511
        symbol, start, frequency = self.tables[context][slot]
        self.move(number, frequency * (self.states[number] >> 9) + slot - start)
        if symbol < 16:
            return symbol
        low = min(symbol - 12, 12)
        return 1 << symbol - 12 | self.bits(number, low) | self.bits(number, symbol - 12 - low) << low

    def is_done(self):
        return set(self.states) == {65536} and next(self.words, None) is None


def cosine_of(sixteenths):
    """Of so many sixteenths of half a turn."""
    j = min(sixteenths % 32, 32 - sixteenths % 32)
    c = (1.0, 0.9807852804032304, 0.9238795325112867, 0.8314696123025452, 0.7071067811865476, 0.5555702330196022,
         0.3826834323650898, 0.19509032201612828, 0.0)
    return c[j] if j <= 8 else -c[16 - j]


def parts_of_texels(side):
    """sx, sy, sz, u, v of each texel's centre."""
    found = []
    for t in range(side * side):
        a, b = (2 * (i + 0.5) / side - 1 for i in (t % side, t // side))
        r, other = (a, b) if abs(a) >= abs(b) else (b, a)
        angle, h = math.pi / 4 * other / r, r * math.sqrt(2 - r * r)
        x, y = h * math.cos(angle), h * math.sin(angle)
        s = [round(c * 2**24) / 2**24 for c in ((x, y) if abs(a) >= abs(b) else (y, x)) + (1 - r * r,)]
        found.append((*s, s[0] / (1 + s[2]), s[1] / (1 + s[2])))
    return found


def coefficients(values, across, base):
    """Coefficients of a block, added to those of the reference: {(row, column): not 0}."""
    extent, block = values.take(1 + across, 0), dict(base)
    need(extent <= 15, f"extent {extent}")
    above, above2 = [0] * 10, [0] * 10
    for j in range(min(extent, 8)):
        line = [0] * 10
        for k in range(min(extent - j, 8)):
            z = 3 * above[k] + 2 * above[k - 1] + above[k + 1] + above2[k] if j else 6 * (extent - 1 - k)
            place = 1 + sum(t <= z for t in (1, 3, 7, 13, 23, 39, 63, 103)) if j + k else 0
            w = values.take((13 if across else 3) + place, k)
            line[k] = min(w, 31)
            if w:
                block[j, k] = block.get((j, k), 0) + ((w + 1) // 2 if w % 2 else -(w // 2))
                need(abs(block[j, k]) < 2**22, "a coefficient is too large")
        above, above2 = line, above
    return {at: c for at, c in block.items() if c}


def response(raw, rows, side):
    need(side and side % 8 == 0 and rows * 6 * side * side <= 2**23, f"responses of {rows} receivers, {side} texels a side")
    need(raw[0] <= 40, f"exponent {raw[0]}")
    values, wide, texels = Values(raw[1:], 23), side // 8, parts_of_texels(side)
    cosine = [[cosine_of(k * (2 * i + 1) if k else 4) / 2 for i in range(8)] for k in range(8)]
    known, out = [], []
    for row in range(rows):
        before = values.take(0, 0)
        need(before <= min(row, 63), f"reference {before} of receiver {row}")
        base = known[row - before] if before else [{}] * (6 * wide * wide)
        own, planes = [], []
        for plane in range(6):
            step, square = 2.0**-raw[0] * (side if plane % 3 else 1), [0.0] * (side * side)
            for number in range(wide * wide):
                block = coefficients(values, int(plane % 3 != 0), base[len(own)])
                own.append(block)
                lines = {}
                for (j, k), c in sorted(block.items()):
                    line = lines.get(j, [0.0] * 8)
                    lines[j] = [v + c * step * b for v, b in zip(line, cosine[k])]
                for y in range(8 if lines else 0):
                    line = [0.0] * 8
                    for j, of_row in lines.items():
                        line = [v + w * cosine[j][y] for v, w in zip(line, of_row)]
                    at = (number // wide * 8 + y) * side + number % wide * 8
                    square[at:at + 8] = line
            planes.append(square)
        known.append(own)
        for rs, ps, qs in (planes[:3], planes[3:]):
            found = []
            for r, p, q, (sx, sy, sz, u, v) in zip(rs, ps, qs, texels):
                t = p * u + q * v
                found.append(((r - t) * sx + p, (r - t) * sy + q, r * sz - (p * sx + q * sy)))
            out += [g[axis] for axis in range(3) for g in found]
    need(values.is_done(), "the code does not end with the values")
    return {"g": struct.pack(f"<{len(out)}f", *out)}


def rows_of_bytes(raw, rows):
    need(len(raw) >= 4 * rows, "lengths of rows are missing")
    lengths = struct.unpack_from(f"<{rows}I", raw)
    need(4 * rows + sum(lengths) == len(raw), "rows of another length")
    return {"lengths": raw[:4 * rows], "bytes": raw[4 * rows:]}


class Bytes:
    """What is left of a row."""

    def __init__(self, raw):
        self.raw, self.at = raw, 0

    def bytes(self, count):
        need(self.at + count <= len(self.raw), "a row ends too early")
        self.at += count
        return self.raw[self.at - count:self.at]

    def take(self, form):
        return struct.unpack(form, self.bytes(struct.calcsize(form)))

    def several(self, form):
        """One to three values after their number."""
        count, = self.take("<B")
        need(1 <= count <= 3, f"{count} mirrors")
        return [self.take(form) for _ in range(count)]

    def texels(self, count):
        """Texels of a cell's window, ascending."""
        listed, = self.take("<H")
        if listed == 0xFFFF:
            square = int.from_bytes(self.bytes(-(-count // 8)), "little")
            return [t for t in range(count) if square >> t & 1]
        texels = [self.take("<H")[0] for _ in range(listed)]
        need(all(a < b for a, b in zip(texels, texels[1:])) and all(t < count for t in texels), "texels do not ascend")
        return texels

    def key(self):
        region, tag, material, *voxel = self.take(">QHH3I")
        voxel = [v - (1 << 31) for v in voxel]
        key = order(voxel, tag, material)
        need(key[0] == region, "a key of another region")
        return key, struct.pack("<bBH3i", (tag >> 8) - 128, tag & 255, material, *voxel)


def mirrors(raw, rows, s, kind, numbers, materials):
    """Arrays of a block of mirrors, and the keys of the cells that are seen."""
    lengths, at = struct.unpack(f"<{rows}I", rows_of_bytes(raw, rows)["lengths"]), 4 * rows
    found, seen = {name: bytearray() for name in ("windows", "bits", "paths")}, []
    side = s["probe"] if kind == "probe-mirror" else s["bounce_sky"]
    for i, length in enumerate(lengths):
        row, at = Bytes(raw[at:at + length]), at + length
        for _ in range(row.take("<I")[0] if length else 0):
            chain = [number for number, in row.several("<H")]
            need(max(chain) < numbers, "a mirror that does not exist")
            found["windows"] += struct.pack(f"<IB{len(chain)}H", i, len(chain), *chain)
            if kind == "mirror":
                place = row.take("<3H")
                need(place[2] >= 1 and max(place[:2]) + place[2] <= s["sky_base"], "a window beyond the sky")
                found["windows"] += struct.pack("<3H", *place)
                texture = row.bytes(row.take("<I")[0])
                found["bits"] += sky(texture, 1, place[2], place[2] * s["sky_fine"] // s["sky_base"])["sky"]
            else:
                texels = row.texels(side * side)
                found["bits"] += struct.pack(f"<I{len(texels)}H", len(texels), *texels)
        while row.at < length:
            form = "<I" if kind == "mirror" else "<B"
            first, (key, packed), steps = *row.take(form), row.key(), row.several("<HB")
            need(first < (s["hit"] ** 2 if kind == "mirror" else 2), "a path of a texel that does not exist")
            need(max(material for material, _ in steps) < materials, "a material that does not exist")
            seen.append(key)
            found["paths"] += struct.pack("<I", i) + struct.pack(form, first) + packed + bytes([len(steps)])
            found["paths"] += b"".join(struct.pack("<HB", *step) for step in steps)
    return found, seen


def planes(row, bits, count):
    """Counts along so many rays, from bit planes."""
    need(bits <= 10, f"counts of {bits} bits")
    blocks = -(-count // 64)
    mask, counts = int.from_bytes(row.bytes(-(-blocks // 8)), "little"), []
    need(mask.bit_length() <= blocks, "a block behind the last ray")
    for block in range(blocks):
        words = row.take(f"<{bits}Q") if mask >> block & 1 else (0,)
        need(any(words) or not mask >> block & 1, "a block without a count")
        counts += [sum((word >> i & 1) << bit for bit, word in enumerate(words)) for i in range(64)]
    need(not any(counts[count:]), "a ray behind the last one")
    need(max(counts).bit_length() == bits, "more bits than the counts have")
    return counts[:count]


def unfolded(z, p):
    """The code whose distance from the prediction p is folded to z."""
    m = max(min(p - 1, 1023 - p), 0)
    d = z - m if z > 2 * m else -(-z // 2)
    code = p + d if (p - 1 <= m if z > 2 * m else z % 2) else p - d
    need(1 <= code <= 1023, f"code {code}")
    return code


def frequencies(counts):
    """Bytes of the frequencies of the symbols of a context."""
    total = sum(counts)
    scaled = [max(512 * count // max(total, 1), count > 0) for count in counts]
    largest = max(range(36), key=lambda symbol: (scaled[symbol], -symbol))
    scaled[largest] += 512 - sum(scaled)
    while not scaled[-1]:
        scaled.pop()
    return b"".join(bytes([f]) if f < 128 else bytes([128 + f % 128, f // 128]) for f in scaled)


def context(first, codes, thresholds, apart):
    """Context of a value among those that begin with `first`, by the codes of the texels around."""
    return first + (2 + sum(apart >= t for t in thresholds) if all(codes) else any(codes))


def coarse_step(side):
    """Texels of a square between two of its coarse grid."""
    step = 2
    while side > 128 * step:
        step *= 2
    return step


def predicted(raw, side):
    """Predicted codes along a square, row-major."""
    step = coarse_step(side)
    n, wide = side // step, -(-side // (8 * step))
    need(side % step == 0, "predicted codes along an odd square")
    size = -(-wide * wide // 8)
    mask = int.from_bytes(raw[:size], "little")
    need(0 < mask < 1 << wide * wide and len(raw) >= 8 * mask.bit_count(), "patches that cannot be")
    values, counts, codes = Values(raw[size:], 19), [[0] * 36 for _ in range(19)], [0] * (side * side)

    def take(context, i):
        z = values.take(context, i % 8)
        counts[context][z if z < 16 else z.bit_length() + 11] += 1
        return z

    def grid(j, i):
        return codes[step * (j * side + i)] if 0 <= j and 0 <= i < n else 0

    def places():
        patch = 8 * n // (side // coarse_step(side))
        return [(j, i) for j in range(n) for i in range(n) if mask >> (j // patch * wide + i // patch) & 1]

    for j, i in places():
        w, n_, x, e = grid(j, i - 1), grid(j - 1, i), grid(j - 1, i - 1), grid(j - 1, i + 1)
        p = max(min(max(w + n_ - x, min(w, n_)), max(w, n_)), 1)
        z = take(context(0, (w, n_, x, e), (4, 12, 40), abs(w - x) + abs(n_ - x) + abs(e - n_)), i)
        codes[step * (j * side + i)] = unfolded(z - 1, p) if z else 0
    while step > 1:
        half = step // 2
        for j, i in places():
            right, below = min(i + 1, n - 1), min(j + 1, n - 1)
            a, b, c, d = grid(j, i), grid(j, right), grid(below, i), grid(below, right)
            others = take(context(6, (a, b, c, d), (10, 18, 32, 64), max(a, b, c, d) - min(a, b, c, d)), i)
            need(others <= 7, f"texels {others} of three")
            for k, (beside, place) in enumerate([((a, b), half), ((a, c), half * side), ((a, b, c, d), half * (side + 1))]):
                lit = [code for code in beside if code]
                code = (2 * sum(lit) + len(lit)) // (2 * len(lit)) if lit else 0
                if others >> k & 1:
                    z = take(context(13, beside, (8, 24, 80), max(beside) - min(beside)), i)
                    need(z or code, "a texel that is as predicted")
                    code = unfolded(z, code) if z else 0
                codes[step * (j * side + i) + place] = code
        step, n = half, 2 * n
    need(values.is_done(), "the code does not end with the values")
    need(raw[size:].startswith(b"".join(map(frequencies, counts))), "frequencies are not those of the values")
    patch = 8 * coarse_step(side)
    coded = {place // side // patch * wide + place % side // patch for place, code in enumerate(codes) if code}
    need(len(coded) == mask.bit_count(), "a patch without a code")
    return codes


def crossings(raw, rows, s, kind):
    """The rows of a block of canopies, the keys of the cells of leaves that are seen, and the materials that are crossed."""
    found, rays_crossed = rows_of_bytes(raw, rows), []
    lengths, at, seen, crossed = struct.unpack(f"<{rows}I", found["lengths"]), 4 * rows, [], set()
    side = max(s["sky_base"], s["sky_fine"] // 2)
    while side > 1024 and side % 2 == 0:
        side //= 2
    rays = {"canopy": (side ** 2, s["hit"] ** 2), "probe-canopy": (s["probe"] ** 2, s["probe_hits"]),
            "bounce-canopy": (s["bounce_sky"] ** 2, s["bounce_hits"])}[kind]
    for number, length in enumerate(lengths):
        row, at, last = Bytes(raw[at:at + length]), at + length, None
        materials = [row.take("<H")[0] for _ in range(row.take("<H")[0] if length else 0)]
        need(all(a < b for a, b in zip(materials, materials[1:])), "canopies do not ascend")
        crossed.update(materials)
        for material, sky, count in [(m, i == 0, c) for m in materials for i, c in enumerate(rays)]:
            form, = row.take("<B")
            counts = []
            if form == 128 and sky and kind == "canopy":
                counts = predicted(row.bytes(*row.take("<I")), side)
            elif form:
                counts = planes(row, form, count)
            if sky:
                rays_crossed += [(number, ray, material, count) for ray, count in enumerate(counts) if count]
        while row.at < length:
            (key, packed), share, before = row.key(), row.take("<f")[0], row.take("<B")[0]
            before = [row.take("<HH") for _ in range(before)]
            need(packed[1] >= LEAF, "no cell of leaves")
            need(0 < share <= 256 and all(a[0] < b[0] for a, b in zip(before, before[1:])), "a share or a list that cannot be")
            need(all(0 < count < 1024 for _, count in before), "nothing is crossed, or too much")
            crossed |= {struct.unpack_from("<H", packed, 2)[0], *(material for material, _ in before)}
            need(last is None or last < (key, before), "leaves do not ascend")
            last = (key, before)
            seen.append(key)
        need(bool(materials or last) == bool(length), "a row without canopies")
    if kind == "canopy":
        found["crossings"] = b"".join(struct.pack("<IIHH", *one) for one in sorted(rays_crossed))
    return found, seen, crossed


def name_of(e):
    return f"{KINDS[e.kind][0] if e.kind in KINDS else e.kind}/{e.tile}"


def end_of(e):
    return e.offset + e.stored


class Archive:
    """Section 4, steps 1 to 8."""

    def __init__(self, path):
        with open(path, "rb") as file:
            need(file.seek(0, 2) >= FIRST_BLOCK, "not an archive: shorter than 8192 bytes")
            self.bytes = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        slots = [self.bytes[at:at + 512] for at in (0, 4096)]
        need(any(s[:8] == MAGIC for s in slots), "not an archive: no magic")
        self.counts = [s[:8] == MAGIC and blake3(s[:504]).digest(8) == s[504:] for s in slots]
        slots = [SLOT(*struct.unpack("<8sHHI9Q32s384s8s", s)) for s, counts in zip(slots, self.counts) if counts]
        need(slots, "the header is damaged: both slots")
        for s in slots:
            need((s.major, s.minor) == (1, 7), f"format {s.major}.{s.minor}, this program reads 1.7")
            need(s.required == 0, f"unknown required features {s.required:#x}")
        slots = [s for s in slots if s.state == 1]
        need(slots, "the archive was not finished")
        s = self.slot = max(slots, key=lambda s: s.generation)  # The first of equal ones: slot A.
        need(s.committed <= len(self.bytes), f"truncated: {len(self.bytes)} of {s.committed} bytes")
        end = s.directory_offset + s.directory_length
        need(s.directory_count <= MAX_ENTRIES and s.directory_length == s.directory_count * ENTRY_SIZE
             and s.directory_offset % ALIGN == 0 and FIRST_BLOCK <= s.directory_offset and end <= s.committed,
             "the directory's place is impossible")
        need(s.manifest_length <= MAX_MANIFEST and s.manifest_offset == up(end)
             and s.manifest_offset + s.manifest_length == s.committed, "the manifest's place is impossible")
        directory, manifest = self.bytes[s.directory_offset:end], self.bytes[s.manifest_offset:s.committed]
        need(blake3(directory + manifest).digest() == s.root, "directory or manifest are damaged: root differs")
        self.entries = [ENTRY(*e) for e in struct.iter_unpack("<IIQIIHHI8s32s8s", directory)]
        self.check_entries()
        try:
            self.manifest = json.loads(manifest.decode(), parse_constant=lambda c: need(False, f"manifest holds {c}"))
        except (ValueError, RecursionError) as error:
            raise Damage(f"manifest: {error}") from error
        self.check_manifest()

    def check_entries(self):
        keys = [(e.kind, e.tile) for e in self.entries]
        need(all(a < b for a, b in zip(keys, keys[1:])), "directory entries are not sorted")
        for e in self.entries:
            need(e.offset % ALIGN == 0 and FIRST_BLOCK <= e.offset and end_of(e) <= self.slot.directory_offset,
                 f"{name_of(e)} has no place between header and directory")
            need(1 <= e.stored <= e.raw <= MAX_RAW, f"{name_of(e)} has lengths {e.stored}, {e.raw}")
            need(e.stored == e.raw or e.codec != 0, f"{name_of(e)}: {e.stored} of {e.raw} bytes without codec")
        self.places = sorted(self.entries, key=lambda e: (e.offset, end_of(e)))
        for a, b in zip(self.places, self.places[1:]):
            equal = (a.offset, a.stored, a.content) == (b.offset, b.stored, b.content)
            need(equal or end_of(a) <= b.offset, f"{name_of(a)} and {name_of(b)} overlap")

    def check_manifest(self):
        conforms(self.manifest, json.loads((Path(__file__).parent.parent / "schema/manifest.schema.json").read_text()))
        rows = {}
        for e in self.entries:
            blocks, raw, stored = rows.get(e.kind, (0, 0, 0))
            rows[e.kind] = (blocks + 1, raw + e.raw, stored + e.stored)
        said = [(r["kind"], (r["blocks"], r["raw_bytes"], r["stored_bytes"])) for r in self.manifest["layers"]]
        need(said == sorted(rows.items()), "layers of manifest and directory differ")
        receivers, tiles = self.manifest["receivers"], self.of("receivers")
        need([e.tile for e in tiles] == list(range(receivers["tiles"])), "receiver tiles are missing")
        need(sum(e.items for e in tiles) == receivers["count"], "number of receivers in manifest and directory differ")
        need(all(e.items <= receivers["tile_size"] for e in tiles), "a receiver tile is too large")

    def of(self, name):
        return [e for e in self.entries if KINDS.get(e.kind, ("",))[0] == name]

    def block(self, e):
        """Raw bytes of a block, section 4, last paragraphs."""
        need(e.kind not in KINDS or e.schema == KINDS[e.kind][1], f"unknown schema {e.schema}")
        stored = self.bytes[e.offset:end_of(e)]
        need(blake3(stored).digest(8) == e.checksum, "checksum of the stored bytes differs")
        need(e.codec in (0, 1), f"unknown codec {e.codec}")
        raw = stored if e.codec == 0 else unzstd(stored, e.raw)
        need(blake3(struct.pack("<IH", e.kind, e.schema) + raw).digest() == e.content, "content id differs")
        return raw


class Checker:
    """Decodes every block and checks what section 3 states."""

    def __init__(self, archive):
        self.archive, self.keys, self.seen, self.first, self.last = archive, {}, [], {}, {}
        self.settings, self.rows, self.problems = archive.manifest["settings"], {}, []
        self.boxes, self.names, self.chunks, self.triangles = {}, set(), {}, {}
        self.materials = sum(e.items for e in archive.of("materials"))
        self.canopies, self.crossed = set(), set()

    def run(self, take):
        archive = self.archive
        for e in archive.entries:
            if e.kind in KINDS:
                self.guard(name_of(e), lambda e=e: take(e, self.decode(e, archive.block(e))))
            elif e.codec in (0, 1):
                self.guard(name_of(e), lambda e=e: archive.block(e))
        for name, counts in zip(("slot A", "slot B"), archive.counts):
            self.guard(name, lambda c=counts: need(c, "no magic or wrong checksum: it does not count"))
        self.guard("cells", self.cells)
        self.guard("names", self.name_index)
        self.guard("padding", self.padding)

    def guard(self, name, work):
        try:
            work()
        except Damage as error:
            self.problems.append(f"{name}: {error}")

    def padding(self):
        s, spans = self.archive.slot, [(0, 512), (4096, 4608), (FIRST_BLOCK, FIRST_BLOCK)]
        spans += [(e.offset, end_of(e)) for e in self.archive.places]
        spans += [(s.directory_offset, s.directory_offset + s.directory_length), (s.manifest_offset, s.committed)]
        for (_, end), (start, _) in zip(spans, spans[1:]):
            need(s.generation > 1 or not any(self.archive.bytes[end:start]), f"not zero between {end} and {start}")

    def cells(self):
        """What chunks say together: seen keys, number of cells, index."""
        chunks, counts = self.archive.of, self.archive.manifest["counts"]
        for tile, (name, count) in enumerate([("probes", "probes"), ("bounce", "bounce_cells")]):
            need([e.tile for e in chunks(name)] == list(range(len(chunks(name)))), f"chunks of {name} are missing")
            need(sum(e.items for e in chunks(name)) == counts[count], f"{count} of the manifest differ")
            if tile in self.first or chunks(name):
                need(self.first.get(tile) == self.first.get(name), f"index of {name} differs")
        known = {of: set(self.keys.get(of, [])) for of in ("probes", "bounce")}
        replay_only = self.archive.manifest.get("replay_only", False)
        for name, of, seen in self.seen:
            need(replay_only or known[of].issuperset(seen), f"{name} sees a cell that is not there")
        need(self.canopies.issuperset(self.crossed), "a material that is crossed is no canopy")

    def name_index(self):
        """What chunks of names say together, and of receivers."""
        if not self.chunks:
            return
        firsts, chunks = self.chunks.pop(0, []), [rows for _, rows in sorted(self.chunks.items())]
        need([row[2] for row in firsts] == list(range(1, len(chunks) + 1)), "chunk 0 names other chunks")
        need([row[:2] for row in firsts] == [rows[0][:2] for rows in chunks], "chunk 0 has other first names")
        rows = sum(chunks, [])
        need(all(len(chunk) == 2048 for chunk in chunks[:-1]), "a chunk of another length")
        need(rows == sorted(self.names), "names are not those of the receivers")

    def decode(self, e, raw):
        kind, _, columns = KINDS[e.kind]
        s = self.settings
        if e.kind in EXTRAS:
            of = next((o.items for o in self.archive.of(EXTRAS[e.kind]) if o.tile == e.tile), None)
            need(of == e.items, f"{e.items} rows, {EXTRAS[e.kind]} have {of}")
            if kind in MIRRORED:
                numbers = sum(o.items for o in self.archive.of("mirrors"))
                found, seen = mirrors(raw, e.items, s, kind, numbers, self.materials)
                self.seen.append((name_of(e), MIRRORED[kind], seen))
                return found
            if kind in CROSSED:
                found, seen, crossed = crossings(raw, e.items, s, kind)
                self.crossed |= crossed
                self.seen.append((name_of(e), CROSSED[kind], seen))
                return found
            return rows_of_bytes(raw, e.items)
        if kind in ("sky", "hit", "response"):
            need(self.rows.get(e.tile, e.items) == e.items, f"{e.items} rows, receivers have {self.rows.get(e.tile)}")
        if kind == "sky":
            return sky(raw, e.items, s["sky_base"], s["sky_fine"])
        if kind == "hit":
            found, palette = hit(raw, e.items, s["hit"])
            self.seen.append((name_of(e), "probes", palette))
            return found
        if kind == "response":
            return response(raw, e.items, s["probe"])
        found = table(raw, columns)
        values = {name: v for name, (_, v) in found.items()}
        per_row = {"bits": 1, "hits": 1}
        if columns is CELLS:
            rays, side = (s["probe_hits"], s["probe"]) if kind == "probes" else (s["bounce_hits"], s["bounce_sky"])
            per_row = {"bits": -(-side * side // 8), "hits": rays}
        for name, v in values.items():
            if not name.startswith("seen_") and name not in ("vertex", "corners", "offset", "text") and (kind != "objects" or name == "row") and (v or name != "clear_year"):
                need(len(v) == e.items * per_row.get(name, 1), f"{len(v)} values of {name}, {e.items} rows")
        if kind == "receivers":
            need(1 <= e.items <= MAX_ROWS, f"{e.items} rows")
            self.rows[e.tile] = e.items
            axes = list(zip(*values["position"]))
            self.boxes[e.tile] = (tuple(map(min, axes)), tuple(map(max, axes)))
            self.names |= {(of, name, e.tile) for of, column in enumerate(("ids", "surface")) for name in values[column] if name}
        elif kind == "materials":
            need(e.tile == 0 and 1 <= e.items <= MAX_MATERIALS, f"{e.items} materials in tile {e.tile}")
            need(len(set(values["name"])) == e.items, "two materials of one name")
            need(all(d + s <= 1 + 1e-9 for d, s in zip(values["diffuse"], values["specular"])), "reflectances above 1")
        elif kind == "optics":
            need(e.tile == 0 and e.items == self.materials, f"optics of {e.items} of {self.materials} materials")
            self.canopies = {row for row, canopy in enumerate(values["canopy"]) if canopy}
        elif kind == "mirrors":
            need(e.tile == 0 and all(m < self.materials for m in values["material"]), "a material that does not exist")
        elif kind == "bands":
            need(e.tile == 0 and all(m < self.materials for m in values["material"]), "a material that does not exist")
            rows = list(zip(values["material"], values["property"], values["band"]))
            need(all(a < b for a, b in zip(rows, rows[1:])), "values of bands do not ascend")
            need(all((p == 3) == (b == 4) for _, p, b in rows), "longwave of another property than an emissivity")
        elif kind == "scene":
            need(1 <= e.items <= 1 << 16, f"{e.items} triangles")
            self.triangles[e.tile] = e.items
            need(len(values["vertex"]) <= 3 * e.items, f"{len(values['vertex'])} vertices of {e.items} triangles")
            need(all(c < len(values["vertex"]) for corners in values["corner"] for c in corners), "a corner without a vertex")
            need(all(m < self.materials for m in values["material"]), "a material that does not exist")
        elif kind == "objects":
            need(e.items == self.triangles.get(e.tile), f"{e.items} rows, {self.triangles.get(e.tile)} triangles")
            need(all(a < b for a, b in zip(values["name"], values["name"][1:])), "names do not ascend")
            need(all(row < len(values["name"]) for row in values["row"]), "an object without a name")
            need(len({len(v) for name, v in values.items() if name != "row"}) == 1, "columns of other lengths")
        elif kind == "overview":
            need(self.rows.get(e.tile) == e.items, f"{e.items} rows, receivers have {self.rows.get(e.tile)}")
            need(len(values["corners"]) == sum(values["polygons"]), f"{len(values['corners'])} polygons")
            need(len(values["offset"]) == sum(values["corners"]), f"{len(values['offset'])} corners")
        elif kind == "parts":
            need(self.rows.get(e.tile) == e.items, f"{e.items} rows, receivers have {self.rows.get(e.tile)}")
            self.names |= {(of, name, e.tile) for of, column in ((2, "object"), (3, "building")) for name in values[column] if name}
        elif kind == "extents":
            held = [self.boxes.get(4096 * e.tile + i) for i in range(e.items)]
            need(held == list(zip(values["low"], values["high"])), "boxes that are not those of the receivers")
            need(e.items == 4096 or 4096 * e.tile + e.items == len(self.boxes), f"{e.items} tiles")
        elif kind == "names":
            self.chunks[e.tile] = self.rows_of_names(values)
        elif kind == "index":
            need(e.tile in (0, 1), f"index {e.tile}")
            self.first[e.tile] = self.key_column(values)
        else:
            self.chunk(e, values)
        return {name: packed for name, (packed, _) in found.items()}

    def rows_of_names(self, v):
        text, name, at, rows = bytes(v["text"]), b"", 0, []
        for of, shared, own, tile in zip(v["of"], v["shared"], v["own"], v["tile"]):
            need(shared <= len(name) and at + own <= len(text), "a name of bytes that are not there")
            name, at = name[:shared] + text[at:at + own], at + own
            need(1 <= len(name) <= MAX_STRING, "a name of another length")
            try:
                name.decode()
            except UnicodeDecodeError as error:
                raise Damage("a name that is not UTF-8") from error
            need(not rows or rows[-1] < (of, name, tile), "names do not ascend")
            rows.append((of, name, tile))
        need(rows and at == len(text), "text of no name")
        return rows

    def key_column(self, v, prefix=""):
        need(len(v[prefix + "voxel"]) == len(v[prefix + "tag"]) == len(v[prefix + "material"]), "lengths of a key")
        keys = list(map(order, v[prefix + "voxel"], v[prefix + "tag"], v[prefix + "material"]))
        need(all(a < b for a, b in zip(keys, keys[1:])), f"{prefix}keys do not ascend")
        need(all(m < self.materials for m in v[prefix + "material"]), "a material that does not exist")
        return keys

    def chunk(self, e, v):
        kind = KINDS[e.kind][0]
        keys, seen = self.key_column(v), self.key_column(v, "seen_")
        need(keys and len(seen) <= MAX_SEEN, f"{len(keys)} cells, {len(seen)} seen")
        need(kind not in self.last or self.last[kind] < keys[0], "keys do not ascend from chunk to chunk")
        need(all(h & NOTHING < len(seen) or h & NOTHING == NOTHING for h in set(v["hits"])), "a hit outside of seen")
        self.last[kind] = keys[-1]
        self.keys.setdefault(kind, []).extend(keys)
        self.first.setdefault(kind, []).append(keys[0])
        self.seen.append((name_of(e), "bounce", seen))


def main(path, mode=""):
    try:
        archive = Archive(path)
    except (Damage, OSError) as error:
        print(f"{path}: {error}", file=sys.stderr)
        return 2

    def take(e, arrays):
        for name, data in arrays.items():
            if mode == "--digests":
                print(KINDS[e.kind][0], e.tile, name, blake3(data).hexdigest())

    checker = Checker(archive)
    checker.run(take)
    if not mode:
        print(f"{path}\n  root       {archive.slot.root.hex()}")
        for row in archive.manifest["layers"]:
            print(f"  {row['name']:10} {row['blocks']:6} blocks {row['raw_bytes']:12} B raw {row['stored_bytes']:12} B")
        print(f"  receivers  {archive.manifest['receivers']['count']}, {len(checker.problems)} problems")
    for problem in checker.problems:
        print(f"{path}: {problem}", file=sys.stderr)
    return 1 if checker.problems else 0


if __name__ == "__main__":
    if len(sys.argv) == 2 or sys.argv[2:] == ["--digests"]:
        sys.exit(main(*sys.argv[1:]))
    sys.exit(__doc__.strip())
