//! `schema/heliotile.ksy` describes the format of the code. It is compared line by line: it writes
//! one field a line.

use std::fs;
use std::path::Path;

use heliotile_core::archive::format;
use heliotile_core::archive::format::{Entry, Slot};

fn text(name: &str) -> String {
    fs::read_to_string(Path::new(crate::ROOT).join("schema").join(name)).expect("a text")
}

/// Returns the trimmed lines of the deeper-indented block under a heading, itself under the heading
/// before it.
fn under<'a>(text: &'a str, path: &[&str]) -> Vec<&'a str> {
    let mut lines: Vec<&str> = text.lines().filter(|line| !line.trim_start().starts_with('#')).collect();
    for heading in path {
        let depth = |line: &str| line.len() - line.trim_start().len();
        let at = lines.iter().position(|line| line.trim() == format!("{heading}:")).expect("a heading");
        let own = depth(lines[at]);
        lines = lines[at + 1..].iter().take_while(|line| depth(line) > own).copied().collect();
    }
    lines.into_iter().map(str::trim).collect()
}

/// Returns the value of a key of `{ key: value, ... }`; a list in brackets is one value.
fn value<'a>(line: &'a str, key: &str) -> Option<&'a str> {
    let rest = line.split_once(&format!(" {key}: "))?.1;
    let end = if rest.starts_with('[') { rest.find(']')? + 1 } else { rest.find([',', '}'])? };
    Some(rest[..end].trim())
}

/// Returns the names and sizes of the fields of a type's sequence.
fn fields(ksy: &str, kind: &str) -> Vec<(String, usize)> {
    let size = |line: &str| match (value(line, "type"), value(line, "size"), value(line, "contents")) {
        (Some(number), _, _) => number[1..].parse().expect("u2, u4 or u8"),
        (_, Some(size), _) => size.parse().expect("a size"),
        (_, _, Some(bytes)) => bytes.split(',').count(),
        _ => panic!("no size: {line}"),
    };
    under(ksy, &["types", kind, "seq"])
        .into_iter()
        .map(|line| (value(line, "id").expect("an id").to_string(), size(line)))
        .collect()
}

/// The 16 fields of a slot and the 11 of an entry have the names, sizes and order of the code, 512
/// and 80 bytes. Magic, both slot offsets and the 23 kinds, 2 states and 2 codecs are those of the
/// code.
#[test]
fn the_container_is_that_of_the_code() {
    let ksy = text("heliotile.ksy");
    let slot = [Slot::FIELDS, &[("reserved", 384), ("checksum", 8)]].concat();
    for (kind, expected, size) in
        [("slot", slot, format::SLOT_SIZE), ("entry", Entry::FIELDS.to_vec(), format::ENTRY_SIZE)]
    {
        let found = fields(&ksy, kind);
        let names: Vec<(&str, usize)> = found.iter().map(|(name, size)| (name.as_str(), *size)).collect();
        assert_eq!(names, expected, "{kind}");
        assert_eq!(found.iter().map(|field| field.1).sum::<usize>(), size);
    }
    let magic: Vec<String> = format::MAGIC.iter().map(|byte| format!("0x{byte:02x}")).collect();
    assert_eq!(value(under(&ksy, &["types", "slot", "seq"])[0], "contents"), Some(&*format!("[{}]", magic.join(", "))));
    for (line, offset) in under(&ksy, &["instances"]).into_iter().zip(format::SLOT_OFFSETS) {
        assert_eq!(value(line, "pos"), Some(&*offset.to_string()));
        assert_eq!(value(line, "size"), Some(&*format::SLOT_SIZE.to_string()));
    }
    let kinds = format::KINDS.map(|(kind, name, _)| format!("{}: {name}", kind.0));
    assert_eq!(under(&ksy, &["enums", "kind"]), kinds);
    let states = [(format::BUILDING, "building"), (format::COMPLETE, "complete")].map(|(n, s)| format!("{n}: {s}"));
    assert_eq!(under(&ksy, &["enums", "state"]), states);
    let codecs = [(format::CODEC_RAW, "raw"), (format::CODEC_ZSTD, "zstd")].map(|(n, s)| format!("{n}: {s}"));
    assert_eq!(under(&ksy, &["enums", "codec"]), codecs);
}

/// The 60 columns of the 11 tables have the names, order and element types of `heliotile-1.md`, and
/// the root states their number.
#[test]
fn columns_are_those_of_the_text() {
    let (ksy, md) = (text("heliotile.ksy"), text("heliotile-1.md"));
    let mut seen = 0;
    for (kind, heading) in [
        ("table_receivers", "### 3.2"),
        ("table_materials", "### 3.3"),
        ("table_cells", "### 3.4"),
        ("table_index", "### 3.5"),
        ("table_parts", "### 3.11"),
        ("table_scene", "### 3.12"),
        ("table_overview", "### 3.13"),
        ("table_extents", "### 3.14"),
        ("table_names", "### 3.15"),
        ("table_objects", "### 3.16"),
        ("table_bands", "### 3.17"),
    ] {
        let section = &md[md.find(heading).expect("a section")..];
        let rows = section.lines().skip_while(|l| !l.starts_with('|')).take_while(|l| l.starts_with('|')).skip(2);
        let expected: Vec<String> = rows
            .flat_map(|row| {
                let cell = |i: usize| row.split('|').nth(i + 1).unwrap_or_default().trim().to_string();
                cell(0).split(", ").map(|name| format!("{name} {}", cell(1))).collect::<Vec<_>>()
            })
            .collect();
        let lines = under(&ksy, &["types", kind, "instances"]);
        let found: Vec<String> = lines[1..]
            .iter()
            .map(|line| {
                let name = line.split(':').next().unwrap_or_default().replace("class_id", "class");
                let threes = if line.contains(".count * 3") { "3 x " } else { "" };
                let element = match value(line, "type") {
                    Some(kind) if kind.starts_with("'string") => "string",
                    Some("f8") => "f64",
                    Some("f4") => "f32",
                    Some("s4") => "i32",
                    Some("u4") => "u32",
                    Some("u2") => "u16",
                    Some("s2") => "i16",
                    Some("u1") | None => "u8",
                    Some(other) => panic!("{other}"),
                };
                format!("{name} {threes}{element}")
            })
            .collect();
        if kind == "table_index" {
            // The text refers to 3.4 for their types.
            assert_eq!(found, ["voxel 3 x i32", "tag u32", "material u16"]);
        } else {
            assert_eq!(found, expected, "{kind}");
        }
        assert_eq!(value(lines[0], "repeat-expr"), Some(&*found.len().to_string()));
        assert!(lines[0].contains(&format!("_io.size - {}", 8 * found.len())), "{}", lines[0]);
        seen += found.len();
    }
    assert_eq!(seen, 60);
}
