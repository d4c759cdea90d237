//! What is fuzzed: readers of foreign bytes, by name. Each takes any bytes and must come back, with an error or without, from
//! bounded time and memory. The fuzzer calls them, and a test with the corpus that is kept.

use std::fs;
use std::path::{Path, PathBuf};

use heliotile_archives::writing::{Job, Writer};
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_core::archive::format;
use heliotile_core::archive::format::{
    BlockKind, CODEC_RAW, CODEC_ZSTD, ENTRY_SIZE, Entry, FIRST_BLOCK, SLOT_SIZE, Slot, TileNumber,
};
use heliotile_core::archive::tables::{
    CellsTable, ExtentsTable, GeometryTable, IndexTable, MaterialsTable, NamesTable, ObjectsTable, OverviewTable,
    ReceiversTable,
};
use heliotile_core::archive::{Access, Archive, Block, Manifest, encode, manifest, verify};
use heliotile_core::layers::canopy::{Canopy, Powers, RayLists, SEEN, SKY};
use heliotile_core::layers::extras;
use heliotile_core::layers::hit::HitTile;
use heliotile_core::layers::mirror::{CellMirrors, ReceiverMirrors};
use heliotile_core::layers::response;
use heliotile_core::layers::sky::SkyTexture;
use heliotile_core::layers::sky_bitmap::SkyBitmap;
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::light::scratch::InMemory;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::ComponentSet;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::site::north::North;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::conditions::parse_conditions;
use heliotile_core::weather::emission::Emission;
use heliotile_core::weather::options::{TimeShift, WeatherOptions};
use heliotile_core::weather::time::clock_zone::ClockZone;
use heliotile_scene::Scene;
use heliotile_scene::points::places::{PointDefaults, read_points};
use heliotile_scene::points::receivers::{ReceiverRows, read_receivers_with_warnings};
use heliotile_scene::pv::layout::{Outline, lay};
use heliotile_scene::pv::rows::{RowsGround, read_rows};
use heliotile_scene::site::SceneFiles;
use heliotile_weather::formats::epw::{parse_epw, parse_epw_with_air};
use heliotile_weather::formats::weather_file::parse_weather_as;
use heliotile_weather::skies::{PatchQuantity, parse_patch_file};
use heliotile_weather::temperatures::emissions;

/// A reader of foreign bytes.
pub type Target = fn(&[u8]);

/// All targets by name, which is that of their folder in tests/data/corpus.
pub const TARGETS: [(&str, Target); 46] = [
    ("archive", archive),
    ("sealed", sealed),
    ("block", block),
    ("receivers_table", receivers_table),
    ("cells_table", cells_table),
    ("index_table", index_table),
    ("materials_table", materials_table),
    ("scene_table", scene_table),
    ("objects_table", objects_table),
    ("overview_table", overview_table),
    ("extents_table", extents_table),
    ("names_table", names_table),
    ("sky", sky),
    ("hit", hit),
    ("response", response),
    ("extras", extras),
    ("mirror", mirror),
    ("cell_mirror", cell_mirror),
    ("canopy", canopy),
    ("obj", obj),
    ("mtl", mtl),
    ("citygml", citygml),
    ("cityjson", cityjson),
    ("cityjson_seq", cityjson_seq),
    ("geojson", geojson),
    ("geoparquet", geoparquet),
    ("shapefile", shapefile),
    ("geotiff", geotiff),
    ("ascii_grid", ascii_grid),
    ("epjson", epjson),
    ("idf", idf),
    ("honeybee", honeybee),
    ("gltf", gltf),
    ("glb", glb),
    ("stl", stl),
    ("ply", ply),
    ("site", site),
    ("materials", materials),
    ("receivers", receivers),
    ("pv_points", pv_points),
    ("pv_rows", pv_rows),
    ("conditions", conditions),
    ("patches", patches),
    ("epw", epw),
    ("weather", weather),
    ("weather_csv", weather_csv),
];

thread_local! {
    static FOLDER: tempfile::TempDir = tempfile::tempdir().expect("a scratch folder");
}

/// A file of this thread that holds the bytes.
fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = FOLDER.with(|folder| folder.path().join(name));
    fs::write(&path, bytes).expect("written");
    path
}

/// A whole file as it is: most changes end at a checksum.
fn archive(data: &[u8]) {
    read_all(&file("site.helio", data));
}

/// Bytes of a slot and of a file from its first block on, with all checksums mended: changes reach what is behind them.
fn sealed(data: &[u8]) {
    read_all(&file("site.helio", &seal(data)));
}

/// The file that `sealed` reads.
pub fn seal(data: &[u8]) -> Vec<u8> {
    let (slot, rest) = data.split_at(data.len().min(SLOT_SIZE));
    let mut bytes = slot.to_vec();
    bytes.resize(FIRST_BLOCK as usize, 0);
    bytes.extend_from_slice(rest);
    let sum = format::checksum(&bytes[..SLOT_SIZE - 8]);
    bytes[SLOT_SIZE - 8..SLOT_SIZE].copy_from_slice(&sum);
    let Some(mut slot) = Slot::decode(&bytes) else { return bytes };
    let range = |offset: u64, length: u64| {
        let end = offset.checked_add(length).filter(|end| *end <= bytes.len() as u64)?;
        (offset >= FIRST_BLOCK).then_some(offset as usize..end as usize)
    };
    let (Some(directory), Some(json)) =
        (range(slot.directory_offset, slot.directory_length), range(slot.manifest_offset, slot.manifest_length))
    else {
        return bytes;
    };
    let mut entries = Vec::new();
    for chunk in bytes[directory.clone()].chunks(ENTRY_SIZE) {
        match Entry::decode(chunk) {
            Some(mut entry) => {
                if let Some(stored) = range(entry.offset, u64::from(entry.stored)) {
                    entry.checksum = format::checksum(&bytes[stored]);
                }
                entry.encode(&mut entries);
            }
            None => entries.extend_from_slice(chunk),
        }
    }
    bytes[directory.clone()].copy_from_slice(&entries);
    slot.root = format::root_hash(&bytes[directory], &bytes[json]);
    bytes[..SLOT_SIZE].copy_from_slice(&slot.encode());
    bytes
}

/// Checks an archive, reads its blocks and replays two tiles, from the stored responses and from what they derive from.
fn read_all(path: &Path) {
    let report = verify(path, Access::Read, true);
    let Ok(archive) = Archive::open_with(path, Access::Read) else { return };
    report.expect("what can be opened can be verified");
    for entry in archive.entries() {
        if let Ok(block) = archive.block(entry.kind, entry.tile) {
            assert_eq!(block.bytes().len(), entry.raw as usize);
        }
    }
    let sunny = b"condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nnoon,180,40,700,100\n";
    let conditions = parse_conditions(Path::new("conditions.csv"), sunny).expect("a condition").conditions;
    let Ok(site) = OpenSite::open(&archive) else { return };
    for depth in [MaxBounces::All, MaxBounces::Count(1)] {
        let settings = ReplaySettings {
            sky: SkyModel::Perez,
            patches: 145,
            paths: depth.into(),
            components: ComponentSet::ALL,
            memory: MemoryBudget::new(1 << 27),
            storage: &InMemory,
        };
        let Ok(replay) = Replay::new(&site, &conditions, settings) else { continue };
        let _ = replay.run(0..replay.tiles().min(2));
    }
}

/// Stored bytes of one block, behind five bytes that give its codec and its raw length.
fn block(data: &[u8]) {
    let Some((&[codec, a, b, c, d], stored)) = data.split_first_chunk() else { return };
    let entry = Entry {
        kind: BlockKind(77),
        tile: TileNumber::FIRST,
        offset: FIRST_BLOCK,
        stored: stored.len() as u32,
        raw: u32::from_le_bytes([a, b, c, d]),
        codec: if codec & 1 == 0 { CODEC_ZSTD } else { CODEC_RAW },
        schema: 1,
        items: 1,
        checksum: format::checksum(stored),
        content: [0; 32],
        reserved: [0; 8],
    };
    let mut manifest = Manifest::new();
    manifest.receivers.tile_size = 1;
    manifest.layers = manifest::summarize([&entry]);
    let json = manifest.to_json().expect("a manifest");
    let mut directory = Vec::new();
    entry.encode(&mut directory);
    let mut bytes = vec![0; FIRST_BLOCK as usize];
    let mut put = |part: &[u8]| {
        bytes.resize(format::align(bytes.len() as u64).expect("small") as usize, 0);
        bytes.extend_from_slice(part);
        (bytes.len() - part.len()) as u64
    };
    put(stored);
    let (directory_offset, manifest_offset) = (put(&directory), put(&json));
    let slot = Slot {
        state: format::COMPLETE,
        generation: 1,
        committed: bytes.len() as u64,
        directory_offset,
        directory_length: directory.len() as u64,
        directory_count: 1,
        manifest_offset,
        manifest_length: json.len() as u64,
        root: format::root_hash(&directory, &json),
        ..Slot::building()
    };
    bytes[..SLOT_SIZE].copy_from_slice(&slot.encode());
    read_all(&file("site.helio", &bytes));
}

/// A block of a kind that holds the bytes behind the first one, which is its number of rows.
fn with_block<T>(kind: BlockKind, data: &[u8], read: impl Fn(&Block) -> T) {
    let Some((&items, raw)) = data.split_first() else { return };
    let schema = format::schema_of(kind).expect("a known kind");
    let Ok(encoded) = encode(kind, TileNumber::FIRST, schema, u32::from(items), raw, 1) else { return };
    let path = FOLDER.with(|folder| folder.path().join("table.helio"));
    let mut writer =
        Writer::create(&path, &Job { scene: [0; 32], receivers: [0; 32], settings: [0; 32] }).expect("created");
    writer.append(encoded).expect("written");
    read(&writer.read_back(kind, TileNumber::FIRST).expect("read"));
}

fn receivers_table(data: &[u8]) {
    with_block(format::RECEIVERS, data, |block| {
        ReceiversTable::from_block(block).map(|table| table.to_bytes().expect("checked"))
    });
}

fn cells_table(data: &[u8]) {
    with_block(format::PROBES, data, |block| {
        CellsTable::from_block(block).map(|table| {
            let bytes = table.to_bytes().expect("checked");
            assert!(CellsTable::new(&table.into_cells()).to_bytes().expect("checked") == bytes);
        })
    });
}

fn index_table(data: &[u8]) {
    with_block(format::INDEX, data, |block| {
        IndexTable::from_block(block).map(|table| table.to_bytes().expect("checked"))
    });
}

fn materials_table(data: &[u8]) {
    with_block(format::MATERIALS, data, |block| {
        MaterialsTable::from_block(block).map(|table| table.to_bytes().expect("checked"))
    });
}

fn scene_table(data: &[u8]) {
    with_block(format::SCENE, data, |block| {
        GeometryTable::from_block(block).map(|table| table.to_bytes().expect("checked"))
    });
}

fn objects_table(data: &[u8]) {
    with_block(format::OBJECTS, data, |block| {
        ObjectsTable::from_block(block).map(|table| table.to_bytes().expect("checked"))
    });
}

fn overview_table(data: &[u8]) {
    with_block(format::OVERVIEW, data, |block| {
        OverviewTable::from_block(block).map(|table| {
            assert_eq!(table.patches().len(), table.rows());
            table.to_bytes().expect("checked")
        })
    });
}

fn extents_table(data: &[u8]) {
    with_block(format::EXTENTS, data, |block| {
        ExtentsTable::from_block(block).map(|table| {
            assert_eq!(table.boxes().count(), table.rows());
            table.to_bytes().expect("checked")
        })
    });
}

fn names_table(data: &[u8]) {
    with_block(format::NAMES, data, |block| {
        NamesTable::from_block(block).map(|table| {
            // What shares less than it could comes back with all that is shared.
            assert_eq!(NamesTable::new(&table.names()).names(), table.names());
            table.to_bytes().expect("checked")
        })
    });
}

/// Two bytes that say how many receivers and how many texels: 0 to 255 receivers, sides of 0 to 64 and thrice doubled.
fn shape(data: &[u8]) -> Option<(usize, usize, usize, &[u8])> {
    let (&[count, sides], raw) = data.split_first_chunk()?;
    let base = usize::from(sides & 63) + usize::from(sides & 63 == 63);
    Some((usize::from(count), base, base << (sides >> 6), raw))
}

fn sky(data: &[u8]) {
    let Some((count, base, fine, raw)) = shape(data) else { return };
    let squares = SkyTexture::unpack(raw, count, base, fine);
    // Both ways to read a block agree.
    let bitmaps = SkyBitmap::unpack(raw, count, base, fine);
    assert_eq!(bitmaps, squares.map(|all| all.iter().map(|square| SkyBitmap::new(square, base)).collect()));
    assert!(bitmaps.is_none_or(|bitmaps| bitmaps.len() == count));
}

fn hit(data: &[u8]) {
    let Some((count, side, _, raw)) = shape(data) else { return };
    if let Some(tile) = HitTile::unpack(raw, count * side * side) {
        assert_eq!(tile.pack(), raw);
    }
}

fn response(data: &[u8]) {
    let Some((count, side, _, raw)) = shape(data) else { return };
    let tile = response::unpack(raw, count, side);
    assert!(tile.is_none_or(|tile| tile.iter().all(|r| r.values.iter().all(|v| v.is_finite()))));
}

/// Rows of a layer that only some scenes call for, behind their number.
fn extras(data: &[u8]) {
    let Some((&count, raw)) = data.split_first() else { return };
    if let Some(rows) = extras::unpack(raw, usize::from(count)) {
        assert_eq!(rows.len(), usize::from(count));
        assert!(extras::pack(rows.iter().map(Vec::as_slice)).is_none_or(|again| again == raw));
    }
}

/// What a receiver sees in mirrors, behind a byte that is nothing and one for the sides: what is read can be written and read again, and
/// lies within its textures.
fn mirror(data: &[u8]) {
    let Some((hit, base, fine, row)) = shape(data) else { return };
    let Some(found) = ReceiverMirrors::from_bytes(row, base, hit) else { return };
    assert_eq!(ReceiverMirrors::from_bytes(&found.to_bytes(), base, hit).as_ref(), Some(&found));
    assert!(found.paths.iter().all(|path| (path.texel as usize) < hit * hit && !path.steps.is_empty()));
    for window in &found.windows {
        let side = usize::from(window.side);
        assert!(usize::from(window.column.max(window.row)) + side <= base && !window.chain.is_empty());
        let sky = SkyBitmap::unpack(&window.texture, 1, side, side * fine / base.max(1));
        assert!(sky.is_none_or(|sky| sky.len() == 1));
    }
}

/// What a cell sees in mirrors, behind the number of bytes of its sky.
fn cell_mirror(data: &[u8]) {
    let Some((&bits, row)) = data.split_first() else { return };
    let bits = usize::from(bits);
    let Some(found) = CellMirrors::from_bytes(row, bits) else { return };
    assert_eq!(CellMirrors::from_bytes(&found.to_bytes(bits), bits).as_ref(), Some(&found));
    assert!(found.windows.iter().flat_map(|window| &window.texels).all(|&texel| usize::from(texel) < 8 * bits));
    assert!(found.paths.iter().all(|path| !path.steps.is_empty()));
}

/// What a receiver's rays cross, behind two bytes: the side of its square, and a sixteenth of the number of its rays to surfaces. Shares are from 0 to
/// 1 along each of them, and rows without leaves are written as they were.
fn canopy(data: &[u8]) {
    let Some((&sizes, row)) = data.split_first_chunk::<2>() else { return };
    let [side, sixteenths] = sizes.map(usize::from);
    let (rays, numbers) = (RayLists::of_receiver(side, 16 * sixteenths), [side * side, 16 * sixteenths]);
    let is_canopy = |material: u16| material < 4;
    let Some(found) = Canopy::from_bytes(row, rays, is_canopy) else { return };
    assert_eq!(Canopy::from_bytes(&found.to_bytes(), rays, is_canopy).as_ref(), Some(&found));
    assert!(!found.seen_leaves().is_empty() || found.to_bytes() == row);
    let powers: Powers = (0..4).map(|material| (material, std::array::from_fn(|k| 0.5_f32.powi(k as i32)))).collect();
    for (list, rays) in [SKY, SEEN].into_iter().zip(numbers) {
        let shares = found.through(list, &powers);
        assert!(shares.is_none_or(|s| s.len() == rays && s.iter().all(|share| (0.0..=1.0).contains(share))));
    }
}

const OBJ: &[u8] = b"mtllib a.mtl\nv 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nusemtl wall\nf 1 2 3\nusemtl roof\nf 1 2 4\n";
const MATERIALS: &[u8] = b"[default]\ndiffuse = 0.2\n[wall]\ndiffuse = 0.3\n[roof]\ndiffuse = 0.4\n";

fn obj(data: &[u8]) {
    let _ = Scene::load(&file("town.obj", data), Some(&file("materials.toml", MATERIALS)));
}

fn mtl(data: &[u8]) {
    file("a.mtl", data);
    let _ = Scene::load(&file("town.obj", OBJ), None);
}

/// A scene file of any format: what comes out is finite.
fn scene(name: &str, data: &[u8]) {
    if let Ok(scene) = Scene::load(&file(name, data), None) {
        assert!(scene.mesh.vertices.iter().all(|v| v.is_finite()) && scene.mesh.origin.is_finite());
        assert!((0..scene.mesh.triangles.len()).all(|i| scene.mesh.normal(i).is_normalized()));
    }
}

fn citygml(data: &[u8]) {
    scene("town.gml", data);
}

fn cityjson(data: &[u8]) {
    scene("town.city.json", data);
}

fn cityjson_seq(data: &[u8]) {
    scene("town.city.jsonl", data);
}

fn geojson(data: &[u8]) {
    scene("town.geojson", data);
}

fn geoparquet(data: &[u8]) {
    scene("town.parquet", data);
}

/// The zip of one, whose parts are read as they are without a zip.
fn shapefile(data: &[u8]) {
    scene("town.zip", data);
}

fn geotiff(data: &[u8]) {
    scene("hills.tif", data);
}

fn ascii_grid(data: &[u8]) {
    scene("hills.asc", data);
}

fn epjson(data: &[u8]) {
    scene("office.epJSON", data);
}

fn idf(data: &[u8]) {
    scene("office.idf", data);
}

fn honeybee(data: &[u8]) {
    scene("house.hbjson", data);
}

fn gltf(data: &[u8]) {
    scene("house.gltf", data);
}

fn glb(data: &[u8]) {
    scene("house.glb", data);
}

fn stl(data: &[u8]) {
    scene("house.stl", data);
}

fn ply(data: &[u8]) {
    scene("house.ply", data);
}

/// Files that it names are there.
fn site(data: &[u8]) {
    file("town.obj", OBJ);
    file("materials.toml", MATERIALS);
    if let Ok(site) = SceneFiles::new(&[file("site.toml", data)], None)
        && site.files().all(|file| file.ends_with("town.obj") || file.ends_with("materials.toml"))
    {
        let _ = Scene::load_site(&site);
    }
}

fn materials(data: &[u8]) {
    let _ = Scene::load(&file("town.obj", OBJ), Some(&file("materials.toml", data)));
}

/// Both ways of reading give the same.
fn receivers(data: &[u8]) {
    let path = file("receivers.csv", data);
    let (mut warnings, mut others) = (Vec::new(), Vec::new());
    let plain = read_receivers_with_warnings(&path, North::default(), &mut warnings);
    let folder = path.parent().expect("a folder");
    let tiles = ReceiverRows::open(path.as_path(), North::default(), &mut others);
    let tiles = tiles.and_then(|rows| ReceiverTiles::open(rows, [1.0, 2.0, 3.0].into(), folder, 0));
    assert_eq!(warnings, others);
    match (plain, tiles) {
        (Ok(plain), Ok(mut tiles)) => {
            let count: usize = tiles.tiles().expect("rewound").map(|tile| tile.expect("read").len()).sum();
            assert_eq!((plain.len(), plain.len()), (count, tiles.count()));
        }
        (plain, tiles) => {
            let (plain, tiles) = (plain.err().map(|e| e.to_string()), tiles.err().map(|e| e.to_string()));
            assert_eq!(plain, tiles);
        }
    }
}

fn pv_points(data: &[u8]) {
    let path = file("points.csv", data);
    for needs_turns in [false, true] {
        let mut warnings = Vec::new();
        if let Ok(points) = read_points(&path, PointDefaults { needs_turns, height_m: None }, &mut warnings) {
            assert!(points.iter().all(|point| point.name.len() < 4096));
        }
    }
}

/// Rows on an area of their own are laid out where that is done at all in little time.
fn pv_rows(data: &[u8]) {
    for rows in read_rows(&file("rows.toml", data)).unwrap_or_default() {
        let RowsGround::Area(corners) = &rows.ground else { continue };
        let outline = Outline::of_polygon(corners);
        if outline.places(rows.pitch_m) < 1e5 {
            let laid = lay(&rows, North::default(), &outline, |p| (p.x < 5.0).then_some(1.0));
            assert!(laid.modules.len() <= 100_000);
        }
    }
}

fn patches(data: &[u8]) {
    for quantity in [PatchQuantity::Radiance, PatchQuantity::Transmittance] {
        if let Ok(file) = parse_patch_file(Path::new("sky.mtx"), data, quantity) {
            assert!(file.series.rows() > 0 && file.series.row(0).len() == file.series.grid().len());
        }
    }
}

fn conditions(data: &[u8]) {
    let _ = parse_conditions(Path::new("conditions.csv"), data);
}

fn epw(data: &[u8]) {
    let path = Path::new("year.epw");
    let light = parse_epw(path, data);
    let Ok(weather) = parse_epw_with_air(path, data) else { return };
    // Air takes nothing of the light away.
    assert!(light.is_ok_and(|light| light.rows == weather.rows) && weather.air.len() == weather.rows.len());
    if let Ok(emissions) = emissions(&weather, path, &vec![true; weather.rows.len()], &[], &no_file) {
        let finite =
            |e: &Emission| [e.sky_w_m2, e.ground_w_m2, e.obstruction_w_m2].iter().all(|x| x.is_finite() && *x > 0.0);
        assert!(emissions.len() == weather.rows.len() && emissions.iter().all(finite));
    }
}

/// No schedule is given.
fn no_file(name: &Path) -> heliotile_core::error::Result<Vec<u8>> {
    panic!("{} is asked for", name.display())
}

/// Weather as it is replayed: with the sun's places within each interval.
fn weather(data: &[u8]) {
    if let Ok(weather) = parse_epw(Path::new("year.epw"), data) {
        assert_eq!(weather.conditions(2).len(), weather.rows.len());
    }
}

/// Weather of every kind that has no name of its own, with all that the user can say about it.
fn weather_csv(data: &[u8]) {
    let options = WeatherOptions {
        latitude_deg: Some(52.0),
        longitude_deg: Some(4.0),
        zone: Some(ClockZone::Hours(1.0)),
        shift: TimeShift::Auto,
        stamped_at: None,
        date_order: None,
        with_air: true,
    };
    if let Ok(weather) = parse_weather_as(Path::new("year.csv"), data, &options, &mut || Ok(None)) {
        assert!(weather.conditions(2).len() == weather.rows.len() && weather.air.len() == weather.rows.len());
        assert!(
            weather.rows.iter().all(|row| row.dni_w_m2.is_finite() && row.dhi_w_m2.is_finite() && row.sun.is_finite())
        );
    }
}
