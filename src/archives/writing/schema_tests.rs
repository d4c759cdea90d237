//! The texts of `schema/` agree with the code: tables, limits, kinds, example and JSON Schema are
//! compared.

use serde_json::Value;

use crate::writing::{Writer, journal, test_site, writer};
use heliotile_core::archive::accuracy::{Accuracy, GroupError, HoursError, TileError};
use heliotile_core::archive::format;
use heliotile_core::archive::format::{Entry, Slot, TileNumber};
use heliotile_core::archive::negligible::Negligible;
use heliotile_core::archive::{Archive, EncodedBlock, manifest};
use heliotile_core::site::ground::MonthlyGround;
use heliotile_core::site::place::Place;

fn text(name: &str) -> String {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../schema").join(name);
    std::fs::read_to_string(path).unwrap()
}

/// Returns the cells of the rows of the first table after a heading.
fn table(text: &str, heading: &str) -> Vec<Vec<String>> {
    let start = text.find(heading).unwrap_or_else(|| panic!("no heading {heading}"));
    let rows = text[start..].lines().skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|'));
    rows.skip(2).map(|row| row.trim_matches('|').split('|').map(|cell| cell.trim().to_string()).collect()).collect()
}

/// Offset, size and name of each of the 14 + 2 fields of a slot and the 11 of a directory entry are
/// those of the text.
#[test]
fn byte_tables_are_those_of_the_code() {
    let text = text("heliotile-1.md");
    let slot = [Slot::FIELDS, &[("reserved", 384), ("checksum", 8)]].concat();
    for (heading, fields, size) in [
        ("### 1.1 Slot", slot, format::SLOT_SIZE),
        ("### 1.2 Directory entry", Entry::FIELDS.to_vec(), format::ENTRY_SIZE),
    ] {
        let mut offset = 0;
        let mut expected = Vec::new();
        for (name, size) in fields {
            expected.push([offset.to_string(), size.to_string(), name.to_string()]);
            offset += size;
        }
        assert_eq!(offset, size);
        let found: Vec<[String; 3]> =
            table(&text, heading).into_iter().map(|row| [row[0].clone(), row[1].clone(), row[2].clone()]).collect();
        assert_eq!(found, expected, "{heading}");
    }
}

/// Offset, size and name of the 9 fields and the checksum of a journal's header, and of the 4 parts
/// of a batch, are those of the text. So are its magic and version, and the conditions for a
/// checkpoint.
#[test]
fn the_journal_is_that_of_the_code() {
    let text = text("heliotile-1.md");
    let text = &text[text.find("### 7.1").unwrap()..];
    let rows = |heading: &str| -> Vec<[String; 3]> {
        table(text, heading).into_iter().map(|row| [0, 1, 2].map(|i| row[i].clone())).collect()
    };
    let mut expected = Vec::new();
    let mut offset = 0;
    for (name, size) in [journal::Header::FIELDS, &[("checksum", journal::SUM_SIZE)]].concat() {
        expected.push([offset.to_string(), size.to_string(), name.to_string()]);
        offset += size;
    }
    assert_eq!((rows("### 7.1"), offset), (expected, journal::HEADER_SIZE));
    let [count, committed, entries, sum] = rows("Then batches").try_into().unwrap();
    assert_eq!(journal::Batch::FIELDS, [(&*count[2], 8), (&*committed[2], 8)]);
    assert_eq!([&*count[0], &*committed[0], &*entries[0]], ["0", "8", &journal::BATCH_SIZE.to_string()]);
    assert_eq!(entries[1], format!("count x {}", format::ENTRY_SIZE));
    assert_eq!((&*sum[0], &*sum[1]), (&*format!("{} + {}", entries[0], entries[1]), &*journal::SUM_SIZE.to_string()));
    let magic: Vec<String> = journal::MAGIC.iter().map(|byte| format!("{byte:02X}")).collect();
    assert!(text.contains(&format!("`{}`", magic.join(" "))));
    assert!(text.contains(&format!("layout of the batches: {}", journal::VERSION)));
    let due = format!("due after {} s or {} MiB", writer::CHECKPOINT_EVERY.as_secs(), writer::CHECKPOINT_BYTES >> 20);
    assert!(text.split_whitespace().collect::<Vec<_>>().join(" ").contains(&due), "{due}");
}

/// The 10 limits, 23 kinds and 1 required bit of the text are those of the code.
#[test]
fn limits_and_kinds_are_those_of_the_code() {
    let text = text("heliotile-1.md");
    let limits: Vec<u64> = table(&text, "## 2. Limits").iter().map(|row| row[1].parse().unwrap()).collect();
    let expected = [
        format::SLOT_SIZE as u64,
        format::ENTRY_SIZE as u64,
        format::FIRST_BLOCK,
        format::ALIGNMENT,
        format::MAX_RAW as u64,
        format::MAX_ENTRIES,
        format::MAX_MANIFEST,
        u64::from(format::MAX_TILE_RECEIVERS),
        format::MAX_STRING as u64,
        format::MAX_MATERIALS as u64,
    ];
    assert_eq!(limits, expected);
    let kinds: Vec<[String; 3]> = table(&text, "## 3. Kinds").iter().map(|r| [0, 1, 2].map(|i| r[i].clone())).collect();
    let known = format::KINDS.map(|(kind, name, schema)| [kind.0.to_string(), name.to_string(), schema.to_string()]);
    assert_eq!(kinds, known);
    let bits: Vec<String> = table(&text, "## 5. Compatibility").iter().map(|row| row[1].clone()).collect();
    assert_eq!(bits, format::RETIRED_BITS);
}

/// Formats 16 bytes a line with their offset.
fn dump(offset: usize, bytes: &[u8]) -> String {
    let line = |(i, row): (usize, &[u8])| {
        let words: Vec<String> = row.iter().map(|byte| format!("{byte:02x}")).collect();
        format!("{:06x}  {}\n", offset + i * 16, words.join(" "))
    };
    bytes.chunks(16).enumerate().map(line).collect()
}

/// The worked example of the text is the file that this release writes, byte by byte.
#[test]
fn the_example_is_a_real_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("example.helio");
    let mut writer = Writer::create(&path, &test_site::JOB).unwrap();
    // Stored raw, so that the example does not depend on the version of zstd.
    let stored = test_site::materials().to_bytes().unwrap();
    let mut entry = *test_site::materials().encode(format::MATERIALS, TileNumber::FIRST, 9).unwrap().entry();
    (entry.codec, entry.stored, entry.checksum) = (format::CODEC_RAW, entry.raw, format::checksum(&stored));
    writer.append(EncodedBlock { entry, stored }).unwrap();
    let mut manifest = manifest::Manifest::new();
    manifest.creator.version = "0.1.0".to_string();
    manifest.receivers.tile_size = 64;
    manifest.layers = writer.layers();
    writer.finish(&manifest).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let archive = Archive::open(&path).unwrap();
    let entry = archive.entries()[0];
    let slot = Slot::decode(&bytes).unwrap();
    let part = |name: &str, start: usize, end: usize| format!("{name}\n{}", dump(start, &bytes[start..end]));
    let (block, directory) = (entry.offset as usize, slot.directory_offset as usize);
    let example = [
        part("slot A", 0, 120),
        part("its checksum", 504, 512),
        part("block materials/0", block, entry.end().unwrap() as usize),
        part("directory", directory, directory + 80),
    ]
    .concat();
    let expected = format!("<!-- example -->\n```text\n{example}```\n<!-- end -->");
    assert!(text("heliotile-1.md").contains(&expected), "put this into schema/heliotile-1.md:\n{expected}");
}

/// Checks a value against a schema (type, required, properties, items, const), and returns the
/// number of properties seen.
fn follow(schema: &Value, value: &Value, at: &str) -> usize {
    let kind = match value {
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(n) if n.is_f64() => "number",
        Value::Number(_) => "integer",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "object",
    };
    let stated = schema["type"].as_str().unwrap_or_else(|| panic!("{at}: no type"));
    assert!(stated == kind || (stated, kind) == ("number", "integer"), "{at}: {kind} is not {stated}");
    let mut seen = 0;
    if let Value::Object(members) = value {
        for name in schema["required"].as_array().into_iter().flatten() {
            assert!(members.contains_key(name.as_str().unwrap()), "{at}: {name} is missing");
        }
        for (name, member) in members {
            match schema["properties"].get(name).or(schema.get("additionalProperties").filter(|s| s.is_object())) {
                Some(inner) => seen += 1 + follow(inner, member, &format!("{at}/{name}")),
                None => panic!("{at}: {name} is not in the schema"),
            }
        }
    }
    for item in value.as_array().into_iter().flatten() {
        seen += follow(&schema["items"], item, at);
    }
    if let Some(right) = schema.get("const") {
        assert_eq!(right, value, "{at}");
    }
    seen
}

/// A real manifest holds only keys that the JSON Schema describes, all that it requires, and of its
/// types. The schema requires every key but `accuracy`, `ground`, `negligible`, `place`,
/// `replay_only` and, further down, `left_out`.
#[test]
fn manifests_follow_the_json_schema() {
    let schema: Value = serde_json::from_str(&text("manifest.schema.json")).unwrap();
    let mut manifest = test_site::manifest();
    manifest.settings.left_out = vec!["mirrors".to_string()];
    manifest.accuracy = Some(Accuracy {
        components_percent: [("sun_direct".to_string(), 0.5)].into(),
        groups: vec![GroupError::default()],
        hours: vec![HoursError::default()],
        tiles: vec![TileError::default()],
        ..Accuracy::default()
    });
    manifest.negligible =
        Some(Negligible { bound_percent: [("mirrors".to_string(), 0.5)].into(), ..Negligible::default() });
    (manifest.settings.steps, manifest.settings.tracing, manifest.replay_only) = (12, 1, true);
    manifest.place = Some(Place { latitude_deg: 52.1, longitude_deg: 4.3, convergence_deg: -0.9, epsg: Some(28992) });
    manifest.ground = Some(MonthlyGround { material: "plane".into(), reflectance: [0.25; 12], snow_modifier: 1.5 });
    let value: Value = serde_json::from_slice(&manifest.to_json().unwrap()).unwrap();
    assert!(follow(&schema, &value, "manifest") > 66);
    assert_eq!(schema["required"].as_array().unwrap().len(), schema["properties"].as_object().unwrap().len() - 5);
    for part in ["creator", "scene", "receivers", "settings", "counts"] {
        let part = &schema["properties"][part];
        let optional = usize::from(!part["properties"]["left_out"].is_null());
        let all = part["properties"].as_object().unwrap().len();
        assert_eq!(part["required"].as_array().unwrap().len(), all - optional);
    }
}

/// The newest entry of the changelog is this format version.
#[test]
fn the_changelog_names_this_version() {
    let version = format!("## {}.{}", format::MAJOR, format::MINOR);
    let log = text("CHANGELOG.md");
    assert_eq!(log.lines().find(|line| line.starts_with("## ")).map(|line| line.starts_with(&version)), Some(true));
}
