//! In: the JSON of a glTF file. Out: its properties that describe surfaces and their materials,
//! unchecked.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use heliotile_core::error::{Error, Result};

/// Root of a glTF file. Names and defaults are those of the glTF 2.0 specification (Khronos, 2021,
/// section 5); other properties are skipped.
#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Root {
    pub scene: Option<usize>,
    pub scenes: Vec<Scene>,
    pub nodes: Vec<Node>,
    pub meshes: Vec<Mesh>,
    pub accessors: Vec<Accessor>,
    pub buffer_views: Vec<BufferView>,
    pub buffers: Vec<Buffer>,
    pub materials: Vec<Material>,
    pub extensions_used: Vec<String>,
    pub extensions_required: Vec<String>,
    pub extensions: RootExtensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct RootExtensions {
    #[serde(rename = "CESIUM_RTC")]
    pub relative_to_center: Option<RelativeToCenter>,
}

/// Position of the origin, z up (Khronos, vendor extension CESIUM_RTC).
#[derive(Deserialize)]
pub(super) struct RelativeToCenter {
    pub center: [f64; 3],
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Scene {
    pub nodes: Vec<usize>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Node {
    pub name: Option<String>,
    pub children: Vec<usize>,
    pub mesh: Option<usize>,
    pub skin: Option<usize>,
    /// Transformation, column by column.
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    /// Quaternion x, y, z, w.
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    pub extensions: NodeExtensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instancing: Option<Instancing>,
}

/// Accessors of the instances of a mesh (Khronos, vendor extension EXT_mesh_gpu_instancing).
#[derive(Deserialize)]
pub(super) struct Instancing {
    pub attributes: InstanceAttributes,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "UPPERCASE")]
pub(super) struct InstanceAttributes {
    pub translation: Option<usize>,
    pub rotation: Option<usize>,
    pub scale: Option<usize>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Mesh {
    pub name: Option<String>,
    pub primitives: Vec<Primitive>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Primitive {
    pub attributes: Attributes,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    pub mode: Option<u32>,
    pub targets: Vec<serde::de::IgnoredAny>,
    pub extensions: BTreeMap<String, serde::de::IgnoredAny>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Attributes {
    #[serde(rename = "POSITION")]
    pub position: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: u32,
    #[serde(default)]
    pub normalized: bool,
    pub count: u64,
    #[serde(rename = "type")]
    pub shape: String,
    pub sparse: Option<Sparse>,
}

/// Values that replace some values of an accessor.
#[derive(Deserialize)]
pub(super) struct Sparse {
    pub count: u64,
    pub indices: SparsePart,
    pub values: SparsePart,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparsePart {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: u64,
    /// Component type of indices; absent for values.
    pub component_type: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: Option<u64>,
    #[serde(default)]
    pub extensions: BTreeMap<String, serde::de::IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub uri: Option<String>,
    pub byte_length: u64,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Material {
    pub name: Option<String>,
    pub pbr_metallic_roughness: Option<Metallic>,
    pub alpha_mode: Option<String>,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Metallic {
    /// Linear red, green, blue, and opacity.
    pub base_color_factor: Option<[f64; 4]>,
    pub base_color_texture: Option<serde::de::IgnoredAny>,
    pub metallic_factor: Option<f64>,
}

#[derive(Deserialize)]
struct Versioned {
    asset: Asset,
}

#[derive(Deserialize)]
struct Asset {
    version: String,
}

/// Extensions that a file may use without loss: they change nothing that is read, or are read.
const HARMLESS: [&str; 18] = [
    "CESIUM_RTC",
    "CESIUM_primitive_outline",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_mesh_gpu_instancing",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
    "MSFT_lod",
];

/// Prefixes of names of extensions that do not affect the geometry.
const OF_LOOKS: [&str; 8] = [
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_animation_",
    "KHR_audio",
];

impl Root {
    /// Parses the JSON. `lines` is true if the file is all JSON, so that line numbers in messages
    /// are right; in a .glb file they are not.
    pub(super) fn parse(json: &[u8], file: &Path, lines: bool) -> Result<Root> {
        let refuse = |error: serde_json::Error| {
            let line = Some(error.line()).filter(|line| lines && *line > 0);
            Error::input(file, line, format!("the JSON is not valid glTF: {error}"), "export it again")
        };
        // The version is checked first: in other versions the lists have another shape.
        let version = serde_json::from_slice::<Versioned>(json).map_err(refuse)?.asset.version;
        if !version.starts_with("2.") {
            return Err(Error::Unsupported {
                what: format!("the scene {}", file.display()).into(),
                found: format!("glTF {}", crate::text::excerpt(version.as_bytes())),
                supported: "glTF 2.0".into(),
            });
        }
        serde_json::from_slice(json).map_err(refuse)
    }

    /// Refuses a file that requires an unreadable extension; returns a warning about other
    /// extensions that are ignored.
    pub(super) fn check_extensions(&self, file: &Path) -> Result<Option<String>> {
        let ignored = |name: &&String| !HARMLESS.contains(&name.as_str());
        let shown = |name: &String| crate::text::excerpt(name.as_bytes());
        // An unknown material extension is no reason to refuse a file; an extension that may hold
        // geometry is.
        let needed = |name: &&String| ignored(name) && !name.starts_with("KHR_materials_");
        if let Some(name) = self.extensions_required.iter().find(needed) {
            return Err(unreadable(file, &format!("the required extension {}", shown(name)), name));
        }
        let mut names: Vec<String> = self.extensions_used.iter().filter(ignored).map(shown).collect();
        names.sort();
        names.dedup();
        names.truncate(8);
        let geometry: Vec<&str> = names.iter().map(String::as_str).filter(|name| may_hold_geometry(name)).collect();
        let missing = match geometry.as_slice() {
            [] => String::new(),
            names => format!("; geometry is missing if {} holds any", names.join(" or ")),
        };
        Ok((!names.is_empty())
            .then(|| format!("{}: extensions not read: {}{missing}", file.display(), names.join(", "))))
    }
}

/// Returns true if an extension may hold geometry.
pub(super) fn may_hold_geometry(extension: &str) -> bool {
    !HARMLESS.contains(&extension) && !OF_LOOKS.iter().any(|begin| extension.starts_with(begin))
}

/// Returns the error for a file whose geometry stands in an extension.
pub(super) fn unreadable(file: &Path, found: &str, extension: &str) -> Error {
    let compressed = ["draco", "meshopt"].iter().any(|word| extension.contains(word));
    let supported = if compressed {
        "meshes without compression: switch it off in the export, or unpack the file with `gltf-transform copy in.glb out.glb`"
    } else {
        "glTF 2.0 without it: switch it off in the export"
    };
    Error::Unsupported {
        what: format!("the scene {}", file.display()).into(),
        found: format!("{found}, without which geometry is missing"),
        supported: supported.into(),
    }
}
