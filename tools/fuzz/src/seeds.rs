//! Valid inputs for every target, from a tiny site: run it after a change of the format.

use std::fs;
use std::path::Path;

use heliotile_core::site::north::North;
use heliotile_archives::Workspace;
use heliotile_builder::pipeline::{Build, Output, Plan, PreparedScene, ReusedArchives};
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::format;
use heliotile_core::archive::format::{FIRST_BLOCK, SLOT_SIZE, TileNumber};
use heliotile_core::archive::{Access, Archive};
use heliotile_core::layers::bits::BitSquare;
use heliotile_core::layers::canopy::{Canopy, SeenLeaf};
use heliotile_core::layers::extras;
use heliotile_core::layers::mirror::{CellMirrors, CellPath, CellWindow, MirrorPath, ReceiverMirrors, Window};
use heliotile_core::layers::sky::SkyTexture;
use heliotile_core::layers::texel_block::TexelBlock;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::Silent;
use heliotile_core::site::cells::CellKey;
use heliotile_core::site::chain::Chain;
use heliotile_core::site::crossing::Crossing;
use heliotile_scene::Scene;
use heliotile_scene::points::receivers::read_receivers;

const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 20 0 0\nv 20 20 0\nv 0 20 0\nv 5 5 0\nv 9 5 0\nv 9 5 6\nv 5 5 6\n\
                   usemtl ground\nf 1 2 3 4\n# steep\nusemtl wall\nf 5/1/1 6//2 7/3 -1\nf 1 3 \\\n 2\n";
const MATERIALS: &str =
    "[ground]\ndiffuse = 0.2\nclass = \"ground\"\n[wall]\ndiffuse = 0.3\nspecular = 0.1\ngroup = \"a\"\n";
const MTL: &str = "# by hand\nnewmtl wall\nKd 0.4 0.5 0.6\nKs 0.1 0.1 0.1\nNs 10\nd 1.0\nillum 2\nmap_Kd \"a b.png\"\n\
                   newmtl roof\nKd 0.2\nTr 0\n";
const RECEIVERS: &str = "receiver,x,y,z,nx,ny,nz,area,surface\nr1,7,3,1,0,0,1,2.5,roof\n\"r,2\",7,4.9,2,0,-1,0,,\n";
const CONDITIONS: &str =
    "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nnoon,180,55.5,800,100\nnight,0,-30,0,0\n";

const CITYGML: &str = r##"<?xml version="1.0"?>
<core:CityModel xmlns:core="c" xmlns:gml="g" xmlns:xlink="x"><gml:boundedBy><gml:Envelope srsName="urn:ogc:def:crs,crs:EPSG::25832,crs:EPSG::7837"/></gml:boundedBy>
<core:cityObjectMember><bldg:Building gml:id="a"><bldg:usage>1000</bldg:usage><gen:intAttribute name="n"><gen:value>3</gen:value></gen:intAttribute>
<bldg:lod2Solid><gml:Solid><gml:exterior><gml:CompositeSurface><gml:surfaceMember xlink:href="#p"/><gml:surfaceMember><gml:OrientableSurface orientation="-">
<gml:baseSurface><gml:Polygon><gml:exterior><gml:LinearRing><gml:pos>0 0 0</gml:pos><gml:pos>9 0 0</gml:pos><gml:pos>9 9 0</gml:pos></gml:LinearRing></gml:exterior>
</gml:Polygon></gml:baseSurface></gml:OrientableSurface></gml:surfaceMember></gml:CompositeSurface></gml:exterior></gml:Solid></bldg:lod2Solid>
<bldg:boundedBy><bldg:RoofSurface><bldg:lod2MultiSurface><gml:MultiSurface><gml:surfaceMember><gml:Polygon gml:id="p"><gml:exterior><gml:LinearRing>
<gml:posList srsDimension="3">0 0 5 9 0 5 9 9 5 0 9 5 0 0 5</gml:posList></gml:LinearRing></gml:exterior><gml:interior><gml:LinearRing><gml:posList>1 1 5 1 2 5 2 2 5</gml:posList>
</gml:LinearRing></gml:interior></gml:Polygon></gml:surfaceMember></gml:MultiSurface></bldg:lod2MultiSurface></bldg:RoofSurface></bldg:boundedBy></bldg:Building></core:cityObjectMember>
<core:cityObjectMember><veg:SolitaryVegetationObject><veg:lod1ImplicitRepresentation><core:ImplicitGeometry><core:transformationMatrix>2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1
</core:transformationMatrix><core:relativeGMLGeometry xlink:href="#p"/><core:referencePoint><gml:Point><gml:pos>20 5 0</gml:pos></gml:Point></core:referencePoint>
</core:ImplicitGeometry></veg:lod1ImplicitRepresentation></veg:SolitaryVegetationObject></core:cityObjectMember></core:CityModel>
"##;
const CITYJSON: &str = r#"{"type":"CityJSON","version":"2.0","transform":{"scale":[0.001,0.001,0.001],"translate":[78000,457000,2]},
"metadata":{"referenceSystem":"https://www.opengis.net/def/crs/EPSG/0/7415"},
"CityObjects":{"house":{"type":"Building","geometry":[{"type":"MultiSurface","lod":"2.2","boundaries":[[[0,1,2,3],[4,5,6]],[[0,1,7]]],
"semantics":{"surfaces":[{"type":"RoofSurface"},{"type":"WallSurface"}],"values":[0,1]}}]},
"tree":{"type":"SolitaryVegetationObject","geometry":[{"type":"GeometryInstance","template":0,"boundaries":[7],
"transformationMatrix":[2,0,0,0,0,2,0,0,0,0,2,0,0,0,0,1]}]}},
"geometry-templates":{"templates":[{"type":"MultiSurface","lod":"1","boundaries":[[[0,1,2]]]}],"vertices-templates":[[0,0,0],[1,0,0],[0,0,1]]},
"vertices":[[0,0,0],[9000,0,0],[9000,9000,0],[0,9000,0],[1000,1000,0],[2000,1000,0],[1000,2000,0],[5000,0,7000]]}"#;
const CITYJSON_SEQ: &str = r#"{"type":"CityJSON","version":"2.0","transform":{"scale":[0.01,0.01,0.01],"translate":[0,0,0]},"CityObjects":{},"vertices":[]}
{"type":"CityJSONFeature","id":"a","CityObjects":{"a":{"type":"Building","geometry":[{"type":"Solid","lod":"1","boundaries":[[[[0,1,2]],[[0,2,3]]]]}]}},"vertices":[[0,0,0],[900,0,0],[900,900,0],[0,0,900]]}
"#;
const ASCII_GRID: &str = "ncols 3\nnrows 3\nxllcorner 500000\nyllcorner 4000000\ncellsize 30\nNODATA_value -9999\n1 2 3\n4 5 6.5\n-9999 7 8\n";
const EPJSON: &str = r#"{"Version":{"Version 1":{"version_identifier":"25.1"}},
"Building":{"b":{"north_axis":30}},"GlobalGeometryRules":{"r":{"coordinate_system":"Relative","starting_vertex_position":"UpperLeftCorner",
"vertex_entry_direction":"Counterclockwise"}},"Zone":{"z":{"x_origin":5,"direction_of_relative_north":10}},
"BuildingSurface:Detailed":{"wall":{"surface_type":"Wall","construction_name":"c","zone_name":"z","outside_boundary_condition":"Outdoors",
"vertices":[{"vertex_x_coordinate":0,"vertex_y_coordinate":0,"vertex_z_coordinate":3},{"vertex_x_coordinate":0,"vertex_y_coordinate":0,
"vertex_z_coordinate":0},{"vertex_x_coordinate":8,"vertex_y_coordinate":0,"vertex_z_coordinate":0},{"vertex_x_coordinate":8,
"vertex_y_coordinate":0,"vertex_z_coordinate":3}]}},"Window":{"w":{"building_surface_name":"wall","construction_name":"c",
"starting_x_coordinate":1,"starting_z_coordinate":1,"length":2,"height":1}},"Shading:Overhang":{"o":{"window_or_door_name":"w",
"height_above_window_or_door":0.1,"depth":1,"tilt_angle_from_window_door":90}}}"#;
const IDF: &str = "Version,25.1;\r\nBuilding,b,30; ! north\nGlobalGeometryRules,UpperLeftCorner,Counterclockwise,Relative;\nZone,z,0,5,0,0;\n\
                   BuildingSurface:Detailed,wall,Wall,c,z,,Outdoors,,SunExposed,WindExposed,,4,0,0,3,0,0,0,8,0,0,8,0,3;\n\
                   Shading:Site:Detailed,s,,3,0,-5,0,9,-5,0,9,-5,9;\n";
const HONEYBEE: &str = r#"{"type":"Model","identifier":"m","units":"Feet","tolerance":0.01,"rooms":[{"identifier":"r","multiplier":2,"faces":[
{"identifier":"wall","face_type":"Wall","boundary_condition":{"type":"Outdoors"},"geometry":{"boundary":[[0,0,0],[9,0,0],[9,0,9],[0,0,9]],
"holes":[[[7,0,7],[8,0,7],[8,0,8]]],"plane":{"n":[0,-1,0],"o":[0,0,0]}},"apertures":[{"identifier":"pane","boundary_condition":{"type":"Outdoors"},
"is_operable":true,"geometry":{"boundary":[[1,0,1],[3,0,1],[3,0,3],[1,0,3]]},"properties":{"energy":{"construction":"double"}}}],
"properties":{"radiance":{"modifier":"paint"}}},
{"identifier":"floor","face_type":"Floor","boundary_condition":{"type":"Ground"},"geometry":{"boundary":[[0,0,0],[0,9,0],[9,9,0],[9,0,0]]}},
{"identifier":"back","face_type":"Wall","boundary_condition":{"type":"Surface"},"geometry":{"boundary":[[9,9,0],[0,9,0],[0,9,9]]}}],
"properties":{"energy":{"construction_set":"set"}}}],
"orphaned_shades":[{"identifier":"s","is_detached":true,"geometry":{"boundary":[[0,-9,0],[9,-9,0],[9,-9,9]]},"properties":{"energy":{"transmittance_schedule":"half"}}}],
"shade_meshes":[{"identifier":"hill","geometry":{"vertices":[[20,0,0],[30,0,0],[30,9,0],[20,9,0],[25,5,4]],"faces":[[0,1,4],[0,1,2,3]]}}],
"properties":{"radiance":{"modifiers":[{"type":"Metal","identifier":"paint","r_reflectance":0.4,"g_reflectance":0.5,"b_reflectance":0.6,"roughness":0.1}]},
"energy":{"construction_sets":[{"identifier":"set","floor_set":{"ground_construction":"slab"}}],
"constructions":[{"type":"OpaqueConstructionAbridged","identifier":"slab","materials":["concrete"]},
{"type":"WindowConstructionAbridged","identifier":"double","materials":["glass","gap","glass"]}],
"materials":[{"type":"EnergyMaterial","identifier":"concrete","solar_absorptance":0.6},{"type":"EnergyWindowMaterialGlazing","identifier":"glass"}],
"schedules":[{"identifier":"half","day_schedules":[{"values":[0.5,0.5]}]}]}}}
"#;
const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"translation":[1,2,3],"name":"n"}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"materials":[{"name":"wall"}],
"buffers":[{"byteLength":42,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA"}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}]}"#;
const STL: &str = "solid house\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
                   property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
const SITE: &str = "[[scene]]\nfile = \"town.obj\"\nmaterials = \"materials.toml\"\n[[scene]]\nfile = \"town.obj\"\noffset = [1, 2, 3]\nscale = 0.5\nup = \"y\"\n";

const ROWS: &str = "[[rows]]\nname = \"a\"\narea = [[0, 0], [9, 0], [9, 9]]\ntilt = 30\nazimuth = 170\npitch = 3\nwidth = 1\nheight = 2\n\
                    setback = 0.2\nclearance = 0.5\n[[rows]]\nname = \"b\"\nsurface = \"roof\"\ntilt = 0\nazimuth = 0\npitch = 2\nwidth = 1\nheight = 2\n";

/// A GeoTIFF of 3 x 2 heights, uncompressed, with its place in UTM zone 11.
fn geotiff() -> Vec<u8> {
    let doubles = |values: &[f64]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let keys: Vec<u8> =
        [1_u16, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32611].iter().flat_map(|key| key.to_le_bytes()).collect();
    let heights: Vec<u8> = [1.0_f32, 2., 3., 4., 5., 6.].iter().flat_map(|height| height.to_le_bytes()).collect();
    // Tag, type, count, and bytes that stand behind the directory.
    let long: [(u16, u16, u32, Vec<u8>); 4] = [
        (273, 4, 1, heights),
        (33550, 12, 3, doubles(&[30., 30., 0.])),
        (33922, 12, 6, doubles(&[0., 0., 0., 5e5, 4e6, 0.])),
        (34735, 3, 12, keys),
    ];
    let short = [(256, 3), (257, 2), (258, 32), (259, 1), (262, 1), (277, 1), (278, 2), (279, 24), (339, 3)];
    let count = short.len() + long.len();
    let mut place = 8 + 2 + 12 * count as u32 + 4;
    let (mut entries, mut behind) = (Vec::new(), Vec::new());
    for (tag, value) in short {
        entries.push((tag, 3_u16, 1_u32, value));
    }
    for (tag, kind, count, bytes) in long {
        entries.push((tag, kind, count, place));
        place += bytes.len() as u32;
        behind.extend(bytes);
    }
    entries.sort_unstable();
    let mut out = b"II*\0\x08\0\0\0".to_vec();
    out.extend((count as u16).to_le_bytes());
    for (tag, kind, count, value) in entries {
        out.extend([&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value.to_le_bytes()].concat());
    }
    out.extend([0; 4]);
    out.extend(behind);
    out
}

/// The glTF seed as one binary file.
fn glb() -> Vec<u8> {
    let uri = GLTF.find(",\"uri\"").expect("a buffer");
    let end = uri + 2 + GLTF[uri + 2..].find("\"}").expect("its end") + 1;
    let mut json = format!("{}{}", &GLTF[..uri], &GLTF[end..]).into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let corners = [[0.0_f32, 0., 0.], [1., 0., 0.], [0., 1., 0.]];
    let mut buffer: Vec<u8> = corners.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    buffer.extend([0, 0, 1, 0, 2, 0, 0, 0]);
    let chunk = |kind: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat();
    let body = [chunk(b"JSON", &json), chunk(b"BIN\0", &buffer)].concat();
    [&b"glTF\x02\0\0\0"[..], &(12 + body.len() as u32).to_le_bytes(), &body].concat()
}

/// Writes `seed-*` into the folders of the corpus.
pub fn write() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let put = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).expect("written");
        path
    };
    let scene = Scene::load(&put("town.obj", OBJ), Some(&put("materials.toml", MATERIALS))).expect("a scene");
    let receivers = read_receivers(&put("receivers.csv", RECEIVERS), North::default()).expect("receivers");
    let settings = BuildSettings {
        sky_base: 8,
        sky_fine: 16,
        hit: 4,
        cell_floor_m: 8.0,
        probe: 8,
        probe_hits: 4,
        closed_m: 16.0,
        bounce_sky: 4,
        bounce_hits: 4,
        ..BuildSettings::default()
    };
    let site = folder.path().join("site.helio");
    let origin = scene.mesh.origin;
    let mut tiles = ReceiverTiles::from_receivers(&receivers, origin, folder.path(), 1 << 20).expect("receivers");
    let workspace = Workspace { folder: folder.path().to_path_buf(), memory: MemoryBudget::new(1 << 27) };
    let prepared = PreparedScene::new(&scene).expect("a tree");
    let mut build = Build { scene: &prepared, receivers: &mut tiles, workspace: &workspace, observer: &Silent };
    build.write(&Plan::new(settings), &Output::new(site.clone()), &ReusedArchives::default()).expect("an archive");
    let bytes = fs::read(&site).expect("read");
    seed("archive", &bytes);
    seed("sealed", &[&bytes[..SLOT_SIZE], &bytes[FIRST_BLOCK as usize..]].concat());

    let archive = Archive::open_with(&site, Access::Read).expect("opened");
    let raw = |kind| archive.block(kind, TileNumber::FIRST).expect("a block");
    for (target, kind) in [
        ("receivers_table", format::RECEIVERS),
        ("cells_table", format::PROBES),
        ("index_table", format::INDEX),
        ("materials_table", format::MATERIALS),
        ("scene_table", format::SCENE),
        ("objects_table", format::OBJECTS),
        ("overview_table", format::OVERVIEW),
        ("extents_table", format::EXTENTS),
        ("names_table", format::NAMES),
    ] {
        seed(target, &[&[raw(kind).items() as u8], raw(kind).bytes()].concat());
    }
    let count = receivers.len() as u8;
    for (target, kind, sides) in
        [("sky", format::SKY, 8 | 1 << 6), ("hit", format::HIT, 4), ("response", format::RESPONSE, 8 | 1 << 6)]
    {
        seed(target, &[&[count, sides], raw(kind).bytes()].concat());
    }
    layers_of_some_scenes();
    for entry in archive.entries() {
        let stored = &bytes[entry.offset as usize..][..entry.stored as usize];
        let head = [&[u8::from(entry.codec == format::CODEC_RAW)], &entry.raw.to_le_bytes()[..]].concat();
        if entry.kind == format::SKY || entry.kind == format::PROBES {
            save("block", &format!("seed-{}", entry.kind.0), &[&head, stored].concat());
        }
    }

    seed("obj", OBJ.as_bytes());
    seed("mtl", MTL.as_bytes());
    for (target, text) in [
        ("citygml", CITYGML),
        ("cityjson", CITYJSON),
        ("cityjson_seq", CITYJSON_SEQ),
        ("ascii_grid", ASCII_GRID),
        ("epjson", EPJSON),
        ("idf", IDF),
        ("honeybee", HONEYBEE),
        ("gltf", GLTF),
        ("stl", STL),
        ("ply", PLY),
        ("site", SITE),
    ] {
        seed(target, text.as_bytes());
    }
    seed("geojson", include_bytes!("../../../tests/data/footprints/town.geojson"));
    seed("geoparquet", include_bytes!("../../../tests/data/footprints/town.parquet"));
    seed("shapefile", include_bytes!("../../../tests/data/footprints/town.shp.zip"));
    seed("geotiff", &geotiff());
    seed("glb", &glb());
    seed("materials", MATERIALS.as_bytes());
    seed("receivers", RECEIVERS.as_bytes());
    seed("pv_points", b"point,x,y,height,tilt,azimuth\nhigh,1,2,0.5,35,180\nlow,3,4,1,90,270.5\n");
    seed("pv_rows", ROWS.as_bytes());
    seed("conditions", CONDITIONS.as_bytes());
    let matrix = "#?RADIANCE\ngendaymtx -s\nNROWS=146\nNCOLS=1\nNCOMP=1\nBigEndian=0\nFORMAT=float\n\n";
    let cells = (0..146_u8).flat_map(|patch| (f32::from(patch) / 200.0).to_le_bytes());
    seed("patches", &matrix.bytes().chain(cells).collect::<Vec<u8>>());
    let weather = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/weather/golden_3_days.epw");
    let epw = fs::read_to_string(weather).expect("weather");
    let day: Vec<&str> = epw.lines().take(8 + 24).collect();
    let day = day.join("\r\n");
    seed("epw", day.as_bytes());
    seed("weather", day.as_bytes());
    let rows = "2021-06-01T10:00+01:00,600,500,100,0.2,20,50\n2021-06-01T11:00+01:00,700,600,,0.2,21,50\n\
                2021-06-01T13:00+01:00,700,600,100,0.2,21,50\n";
    seed("weather_csv", format!("time,ghi,dni,dhi,albedo,temp_air,rh\n{rows}").as_bytes());
}

/// Rows of mirrors and canopies, which the tiny site does not have all of.
fn layers_of_some_scenes() {
    let mut front = BitSquare::new(4);
    (0..16).for_each(|t| front.set(t % 4, t / 4, true));
    let visible = |_: usize, texels: &[(u32, u32)]| texels.iter().map(|t| (t.0 + t.1) % 3 > 0).collect();
    let texture = SkyTexture::pack(&[SkyTexture::trace(front, 8, TexelBlock::by_texels(visible)).0]);
    let chain = Chain::new(&[0, 1]);
    let cell = CellKey { level: 1, facing: 5, material: 2, voxel: [3, 0, -1] };
    let steps = vec![(1, 200), (0, 90)];
    let of_receiver = ReceiverMirrors {
        windows: vec![Window { chain, column: 1, row: 2, side: 4, texture }],
        paths: vec![MirrorPath { texel: 3, cell, steps: steps.clone() }],
    };
    seed("mirror", &[&[4, 8 | 1 << 6][..], &of_receiver.to_bytes()].concat());
    let windows = vec![
        CellWindow { chain, texels: vec![1, 5, 63] },
        CellWindow { chain: Chain::new(&[2]), texels: (0..64).step_by(2).collect() },
    ];
    let of_cell = CellMirrors { windows, paths: vec![CellPath { up: true, cell, steps }] };
    seed("cell_mirror", &[&[8][..], &of_cell.to_bytes(8)].concat());
    let crossing = |ray: u32| Crossing { ray, material: (ray % 2) as u16, count: 1 + (ray * 7) as u16 };
    let [sky, seen] = [0..64, 3..9].map(|rays| rays.map(crossing).collect::<Vec<_>>());
    let leaves = vec![SeenLeaf { cell: CellKey { facing: 133, ..cell }, before: vec![(1, 2)], share: 0.25 }];
    let canopy = Canopy::new([&sky, &seen], [64, 16], leaves);
    seed("canopy", &[&[8, 1][..], &canopy.to_bytes()].concat());
    let length = |ray: u32| Crossing { ray, material: 1, count: 400 + (ray % 32 * ray / 32 % 90) as u16 };
    let lengths: Vec<Crossing> = (0..1024).filter(|ray| ray % 32 > 6).map(length).collect();
    let predicted = Canopy::new([&lengths, &seen], [1024, 16], Vec::new()).with_predicted(|material| material == 1);
    save("canopy", "predicted", &[&[32, 1][..], &predicted.to_bytes()].concat());
    let rows = [of_receiver.to_bytes(), Vec::new(), canopy.to_bytes()];
    seed("extras", &[&[3][..], &extras::pack(rows.iter().map(Vec::as_slice)).expect("rows")].concat());
}

fn seed(target: &str, bytes: &[u8]) {
    save(target, "seed", bytes);
}

fn save(target: &str, name: &str, bytes: &[u8]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/corpus").join(target);
    fs::create_dir_all(&folder).expect("a folder");
    fs::write(folder.join(name), bytes).expect("written");
}
