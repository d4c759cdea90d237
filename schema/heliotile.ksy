# The container of heliotile-1.md for Kaitai Struct. Tests compare ids, sizes, order and numbers with src/core/archive/format.rs.
# Kaitai computes no BLAKE3 and decodes no zstd: checksums are shown but not checked, and `raw_bytes` of a block with codec
# zstd are the compressed ones. Apply the types of the tables and layers below to decoded bytes. `class_id` is the column `class`,
# a word that target languages keep for themselves.
meta:
  id: heliotile
  title: heliotile archive, format 1
  file-extension: helio
  license: MIT OR Apache-2.0
  ks-version: '0.10'
  endian: le
doc-ref: heliotile-1.md
instances:
  slot_a: { pos: 0, size: 512, type: slot }
  slot_b: { pos: 4096, size: 512, type: slot }
  # Section 4, step 4, for slots whose checksums are right.
  slot_a_counts: { value: 'slot_a.state == state::complete and (slot_b.state != state::complete or slot_a.generation >= slot_b.generation)' }
  directory_offset: { value: 'slot_a_counts ? slot_a.directory_offset : slot_b.directory_offset' }
  directory_count: { value: 'slot_a_counts ? slot_a.directory_count : slot_b.directory_count' }
  manifest_offset: { value: 'slot_a_counts ? slot_a.manifest_offset : slot_b.manifest_offset' }
  manifest_length: { value: 'slot_a_counts ? slot_a.manifest_length : slot_b.manifest_length' }
  directory: { pos: directory_offset, type: entry, repeat: expr, repeat-expr: directory_count }
  manifest: { pos: manifest_offset, size: manifest_length, type: str, encoding: UTF-8 }
enums:
  state:
    0: building
    1: complete
  codec:
    0: raw
    1: zstd
  kind:
    1: receivers
    2: sky
    3: hit
    4: response
    5: probes
    6: bounce
    7: index
    8: mirror
    9: canopy
    10: materials
    11: optics
    12: probe-mirror
    13: bounce-mirror
    14: probe-canopy
    15: bounce-canopy
    16: mirrors
    17: parts
    18: scene
    19: overview
    20: extents
    21: names
    22: objects
    23: bands
types:
  slot:
    seq:
      - { id: magic, contents: [0x89, 0x48, 0x4c, 0x4f, 0x0d, 0x0a, 0x1a, 0x0a] }
      - { id: major, type: u2 }
      - { id: minor, type: u2 }
      - { id: state, type: u4, enum: state }
      - { id: required, type: u8 }
      - { id: optional, type: u8 }
      - { id: generation, type: u8 }
      - { id: committed, type: u8 }
      - { id: directory_offset, type: u8 }
      - { id: directory_length, type: u8 }
      - { id: directory_count, type: u8 }
      - { id: manifest_offset, type: u8 }
      - { id: manifest_length, type: u8 }
      - { id: root, size: 32 }
      - { id: reserved, size: 384 }
      - { id: checksum, size: 8 }
  entry:
    seq:
      - { id: kind, type: u4, enum: kind }
      - { id: tile, type: u4 }
      - { id: offset, type: u8 }
      - { id: stored, type: u4 }
      - { id: raw, type: u4 }
      - { id: codec, type: u2, enum: codec }
      - { id: schema, type: u2 }
      - { id: items, type: u4 }
      - { id: checksum, size: 8 }
      - { id: content, size: 32 }
      - { id: reserved, size: 8 }
    instances:
      raw_bytes: { io: _root._io, pos: offset, size: stored }
  # Section 3.1. `at` is the position of a reference in the decoded bytes.
  column:
    params:
      - { id: at, type: u4 }
    seq:
      - { id: distance, type: s4 }
      - { id: count, type: u4 }
    instances:
      start: { value: at + distance }
  string:
    params:
      - { id: at, type: u4 }
    instances:
      first: { pos: at, type: u1 }
      word: { pos: at, type: u4 }
      distance: { pos: at + 4, type: s4 }
      is_inline: { value: (first & 0xc0) != 0x80 }
      length: { value: (word & 0x3f) | ((word & 0xffffff00) >> 2) }
      near: { pos: at, size: 8, type: inline_text, if: is_inline }
      far: { pos: at + distance, size: length, type: str, encoding: UTF-8, if: not is_inline }
  inline_text:
    seq:
      - { id: text, type: str, encoding: UTF-8, terminator: 0xff, eos-error: false }
  table_receivers:
    instances:
      columns: { pos: _io.size - 64, type: 'column(_io.size - 64 + 8 * _index)', repeat: expr, repeat-expr: 8 }
      ids: { pos: 0, type: 'string(columns[0].start + 8 * _index)', repeat: expr, repeat-expr: 'columns[0].count' }
      position: { pos: 'columns[1].start', type: f8, repeat: expr, repeat-expr: 'columns[1].count * 3' }
      normal: { pos: 'columns[2].start', type: f8, repeat: expr, repeat-expr: 'columns[2].count * 3' }
      area: { pos: 'columns[3].start', type: f8, repeat: expr, repeat-expr: 'columns[3].count' }
      surface: { pos: 0, type: 'string(columns[4].start + 8 * _index)', repeat: expr, repeat-expr: 'columns[4].count' }
      sky_view: { pos: 'columns[5].start', type: f4, repeat: expr, repeat-expr: 'columns[5].count' }
      ground_view: { pos: 'columns[6].start', type: f4, repeat: expr, repeat-expr: 'columns[6].count' }
      obstruction_view: { pos: 'columns[7].start', type: f4, repeat: expr, repeat-expr: 'columns[7].count' }
  table_materials:
    instances:
      columns: { pos: _io.size - 40, type: 'column(_io.size - 40 + 8 * _index)', repeat: expr, repeat-expr: 5 }
      name: { pos: 0, type: 'string(columns[0].start + 8 * _index)', repeat: expr, repeat-expr: 'columns[0].count' }
      diffuse: { pos: 'columns[1].start', type: f8, repeat: expr, repeat-expr: 'columns[1].count' }
      specular: { pos: 'columns[2].start', type: f8, repeat: expr, repeat-expr: 'columns[2].count' }
      class_id: { pos: 'columns[3].start', type: u1, repeat: expr, repeat-expr: 'columns[3].count' }
      group: { pos: 0, type: 'string(columns[4].start + 8 * _index)', repeat: expr, repeat-expr: 'columns[4].count' }
  table_cells:
    doc: Of probes and bounce.
    instances:
      columns: { pos: _io.size - 80, type: 'column(_io.size - 80 + 8 * _index)', repeat: expr, repeat-expr: 10 }
      voxel: { pos: 'columns[0].start', type: s4, repeat: expr, repeat-expr: 'columns[0].count * 3' }
      tag: { pos: 'columns[1].start', type: u4, repeat: expr, repeat-expr: 'columns[1].count' }
      material: { pos: 'columns[2].start', type: u2, repeat: expr, repeat-expr: 'columns[2].count' }
      normal: { pos: 'columns[3].start', type: f4, repeat: expr, repeat-expr: 'columns[3].count * 3' }
      bits: { pos: 'columns[4].start', size: 'columns[4].count' }
      seen_voxel: { pos: 'columns[5].start', type: s4, repeat: expr, repeat-expr: 'columns[5].count * 3' }
      seen_tag: { pos: 'columns[6].start', type: u4, repeat: expr, repeat-expr: 'columns[6].count' }
      seen_material: { pos: 'columns[7].start', type: u2, repeat: expr, repeat-expr: 'columns[7].count' }
      hits: { pos: 'columns[8].start', type: u2, repeat: expr, repeat-expr: 'columns[8].count' }
      doubtful: { pos: 'columns[9].start', size: 'columns[9].count' }
  table_index:
    instances:
      columns: { pos: _io.size - 24, type: 'column(_io.size - 24 + 8 * _index)', repeat: expr, repeat-expr: 3 }
      voxel: { pos: 'columns[0].start', type: s4, repeat: expr, repeat-expr: 'columns[0].count * 3' }
      tag: { pos: 'columns[1].start', type: u4, repeat: expr, repeat-expr: 'columns[1].count' }
      material: { pos: 'columns[2].start', type: u2, repeat: expr, repeat-expr: 'columns[2].count' }
  table_optics:
    instances:
      columns: { pos: _io.size - 24, type: 'column(_io.size - 24 + 8 * _index)', repeat: expr, repeat-expr: 3 }
      panes: { pos: 'columns[0].start', type: u1, repeat: expr, repeat-expr: 'columns[0].count' }
      canopy: { pos: 'columns[1].start', type: u1, repeat: expr, repeat-expr: 'columns[1].count' }
      transmittance: { pos: 'columns[2].start', type: f8, repeat: expr, repeat-expr: 'columns[2].count' }
  table_mirrors:
    instances:
      columns: { pos: _io.size - 16, type: 'column(_io.size - 16 + 8 * _index)', repeat: expr, repeat-expr: 2 }
      normal: { pos: 'columns[0].start', type: f8, repeat: expr, repeat-expr: 'columns[0].count * 3' }
      material: { pos: 'columns[1].start', type: u2, repeat: expr, repeat-expr: 'columns[1].count' }
  table_parts:
    instances:
      columns: { pos: _io.size - 40, type: 'column(_io.size - 40 + 8 * _index)', repeat: expr, repeat-expr: 5 }
      object: { pos: 0, type: 'string(columns[0].start + 8 * _index)', repeat: expr, repeat-expr: 'columns[0].count' }
      building: { pos: 0, type: 'string(columns[1].start + 8 * _index)', repeat: expr, repeat-expr: 'columns[1].count' }
      kind: { pos: 0, type: 'string(columns[2].start + 8 * _index)', repeat: expr, repeat-expr: 'columns[2].count' }
      object_type: { pos: 0, type: 'string(columns[3].start + 8 * _index)', repeat: expr, repeat-expr: 'columns[3].count' }
      face: { pos: 0, type: 'string(columns[4].start + 8 * _index)', repeat: expr, repeat-expr: 'columns[4].count' }
  table_scene:
    instances:
      columns: { pos: _io.size - 24, type: 'column(_io.size - 24 + 8 * _index)', repeat: expr, repeat-expr: 3 }
      vertex: { pos: 'columns[0].start', type: f4, repeat: expr, repeat-expr: 'columns[0].count * 3' }
      corner: { pos: 'columns[1].start', type: u4, repeat: expr, repeat-expr: 'columns[1].count * 3' }
      material: { pos: 'columns[2].start', type: u2, repeat: expr, repeat-expr: 'columns[2].count' }
  table_overview:
    instances:
      columns: { pos: _io.size - 64, type: 'column(_io.size - 64 + 8 * _index)', repeat: expr, repeat-expr: 8 }
      position: { pos: 'columns[0].start', type: f4, repeat: expr, repeat-expr: 'columns[0].count * 3' }
      normal: { pos: 'columns[1].start', type: s2, repeat: expr, repeat-expr: 'columns[1].count * 3' }
      area: { pos: 'columns[2].start', type: f4, repeat: expr, repeat-expr: 'columns[2].count' }
      sky_view: { pos: 'columns[3].start', type: u1, repeat: expr, repeat-expr: 'columns[3].count' }
      clear_year: { pos: 'columns[4].start', type: f4, repeat: expr, repeat-expr: 'columns[4].count' }
      polygons: { pos: 'columns[5].start', type: u1, repeat: expr, repeat-expr: 'columns[5].count' }
      corners: { pos: 'columns[6].start', type: u1, repeat: expr, repeat-expr: 'columns[6].count' }
      offset: { pos: 'columns[7].start', type: s4, repeat: expr, repeat-expr: 'columns[7].count * 3' }
  table_extents:
    instances:
      columns: { pos: _io.size - 16, type: 'column(_io.size - 16 + 8 * _index)', repeat: expr, repeat-expr: 2 }
      low: { pos: 'columns[0].start', type: f8, repeat: expr, repeat-expr: 'columns[0].count * 3' }
      high: { pos: 'columns[1].start', type: f8, repeat: expr, repeat-expr: 'columns[1].count * 3' }
  table_names:
    instances:
      columns: { pos: _io.size - 40, type: 'column(_io.size - 40 + 8 * _index)', repeat: expr, repeat-expr: 5 }
      of: { pos: 'columns[0].start', type: u1, repeat: expr, repeat-expr: 'columns[0].count' }
      shared: { pos: 'columns[1].start', type: u2, repeat: expr, repeat-expr: 'columns[1].count' }
      own: { pos: 'columns[2].start', type: u2, repeat: expr, repeat-expr: 'columns[2].count' }
      text: { pos: 'columns[3].start', size: 'columns[3].count' }
      tile: { pos: 'columns[4].start', type: u4, repeat: expr, repeat-expr: 'columns[4].count' }
  table_objects:
    instances:
      columns: { pos: _io.size - 56, type: 'column(_io.size - 56 + 8 * _index)', repeat: expr, repeat-expr: 7 }
      name: { pos: 0, type: 'string(columns[0].start + 8 * _index)', repeat: expr, repeat-expr: 'columns[0].count' }
      object: { pos: 0, type: 'string(columns[1].start + 8 * _index)', repeat: expr, repeat-expr: 'columns[1].count' }
      building: { pos: 0, type: 'string(columns[2].start + 8 * _index)', repeat: expr, repeat-expr: 'columns[2].count' }
      object_type: { pos: 0, type: 'string(columns[3].start + 8 * _index)', repeat: expr, repeat-expr: 'columns[3].count' }
      beside: { pos: 'columns[4].start', type: u1, repeat: expr, repeat-expr: 'columns[4].count' }
      row: { pos: 'columns[5].start', type: u2, repeat: expr, repeat-expr: 'columns[5].count' }
      attributes: { pos: 0, type: 'string(columns[6].start + 8 * _index)', repeat: expr, repeat-expr: 'columns[6].count' }
  table_bands:
    instances:
      columns: { pos: _io.size - 32, type: 'column(_io.size - 32 + 8 * _index)', repeat: expr, repeat-expr: 4 }
      material: { pos: 'columns[0].start', type: u2, repeat: expr, repeat-expr: 'columns[0].count' }
      property: { pos: 'columns[1].start', type: u1, repeat: expr, repeat-expr: 'columns[1].count' }
      band: { pos: 'columns[2].start', type: u1, repeat: expr, repeat-expr: 'columns[2].count' }
      value: { pos: 'columns[3].start', type: f8, repeat: expr, repeat-expr: 'columns[3].count' }
  layer_hit:
    doc: The rest is four byte planes of the texels, lowest first.
    seq:
      - { id: keys, type: u4 }
      - { id: level, type: s1, repeat: expr, repeat-expr: keys }
      - { id: facing, type: u1, repeat: expr, repeat-expr: keys }
      - { id: material, type: u2, repeat: expr, repeat-expr: keys }
      - { id: voxel_x, type: s4, repeat: expr, repeat-expr: keys }
      - { id: voxel_y, type: s4, repeat: expr, repeat-expr: keys }
      - { id: voxel_z, type: s4, repeat: expr, repeat-expr: keys }
      - { id: planes, size-eos: true }
