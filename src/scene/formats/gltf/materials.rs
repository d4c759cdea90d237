//! In: the materials of a glTF file. Out: their names and, if wanted, their reflectances.
//!
//! They were made for pictures, so they are a fallback, as for OBJ files. Diffuse is the plain mean
//! of the three channels of `baseColorFactor`, which are linear, times 1 - `metallicFactor`
//! (specification, section 3.9.2 and appendix B). Where a texture gives the colour, the factor says
//! nothing of it, and the material counts as not described; so does a white one.

use crate::materials::assumed::{WHITE_WORDS, is_white, undescribed};
use crate::materials::select::class_of_name;
use heliotile_core::text::message;
use std::path::Path;

use crate::formats::ReadOptions;
use crate::formats::gltf::json::{Material as Json, Root};
use crate::formats::obj::DEFAULT_MATERIAL;
use crate::geometry::Geometry;
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::material::Material;

/// Materials of a file, with the numbers that the geometry gives them when they are first used.
pub(super) struct Materials<'r> {
    root: &'r Root,
    file: &'r Path,
    asked: &'r ReadOptions,
    known: Vec<Option<u32>>,
    /// Names of materials with properties that are ignored, by kind.
    textured: Vec<String>,
    see_through: Vec<String>,
    metallic: Vec<String>,
    white: Vec<String>,
}

impl<'r> Materials<'r> {
    pub(super) fn new(root: &'r Root, asked: &'r ReadOptions, file: &'r Path) -> Self {
        Materials {
            root,
            file,
            asked,
            known: vec![None; root.materials.len()],
            textured: Vec::new(),
            see_through: Vec::new(),
            metallic: Vec::new(),
            white: Vec::new(),
        }
    }

    /// Returns the number of a material in `geometry`.
    pub(super) fn id(&mut self, index: Option<usize>, geometry: &mut Geometry) -> Result<u32> {
        let Some(index) = index else { return Ok(geometry.materials.id(DEFAULT_MATERIAL)) };
        let (Some(material), Some(known)) = (self.root.materials.get(index), self.known.get(index)) else {
            let what =
                format!("material {index} is used but does not exist; the file has {} materials", self.known.len());
            return Err(Error::input(self.file, None, what, "export it again"));
        };
        if let Some(id) = known {
            return Ok(*id);
        }
        let mut name = match material.name.as_deref().unwrap_or_default() {
            "" => format!("material_{index}"),
            name => name.to_owned(),
        };
        if self.asked.wants(&name)
            && let Some(optics) = self.optics(material, &name)?
        {
            // Names need not be unique.
            if geometry.stated.get(&name).is_some_and(|other| other.diffuse != optics.diffuse) {
                name = format!("{name}_{index}");
            }
            geometry.stated.insert(name.clone(), Material { name: name.clone(), ..optics });
        }
        let id = geometry.materials.id(&name);
        if let Some(known) = self.known.get_mut(index) {
            *known = Some(id);
        }
        Ok(id)
    }

    fn optics(&mut self, material: &Json, name: &str) -> Result<Option<Material>> {
        if material.alpha_mode.as_deref().is_some_and(|mode| mode != "OPAQUE") {
            self.see_through.push(name.to_owned());
        }
        let Some(surface) = &material.pbr_metallic_roughness else { return Ok(None) };
        if surface.base_color_texture.is_some() {
            self.textured.push(name.to_owned());
            return Ok(None);
        }
        let [red, green, blue, _] = surface.base_color_factor.unwrap_or([1.0; 4]);
        // The default of 1 is a black mirror, which hardly anyone means: a material without the
        // factor counts as not described.
        let Some(metal) = surface.metallic_factor else { return Ok(None) };
        if ![red, green, blue, metal].iter().all(|share| (0.0..=1.0).contains(share)) {
            let what =
                format!("material `{}` has a colour or metallic factor outside 0 to 1", excerpt(name.as_bytes()));
            return Err(Error::input(self.file, None, what, "give reflectances in materials.toml ({materials})"));
        }
        // White is also the default of the colour factor.
        if is_white((red + green + blue) / 3.0) {
            self.white.push(name.to_owned());
            return Ok(None);
        }
        if metal > 0.0 {
            self.metallic.push(name.to_owned());
        }
        let diffuse = (red + green + blue) / 3.0 * (1.0 - metal);
        Ok(Some(Material::matt(name, diffuse, class_of_name(name))))
    }

    /// Adds one warning for each kind of ignored property.
    pub(super) fn warn(self, geometry: &mut Geometry) {
        geometry.warnings.extend(undescribed(self.file, &self.white, WHITE_WORDS));
        for (names, what) in [
            (&self.textured, "have a texture, which is ignored: their reflectance is assumed from their name"),
            (&self.see_through, "are transparent (alphaMode), which is ignored: they count as opaque"),
            (
                &self.metallic,
                "are metallic: only the part of their colour that is not metallic counts, as diffuse reflectance",
            ),
        ] {
            if let Some(first) = names.first() {
                let (file, count, first) = (self.file.display(), names.len(), excerpt(first.as_bytes()));
                geometry.warnings.push(message!(
                    "{file}: {count} materials (`{first}` is the first) {what}; give their reflectances in materials.toml ({{materials}})"
                ));
            }
        }
    }
}
