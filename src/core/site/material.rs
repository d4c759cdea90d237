//! Optical properties of a surface. In: shares of the light. Out: one checked material.

use crate::site::bands::{Band, BandOptics, BandProperty};

/// First-hit class of a surface (the five EnergyPlus factors need the two apart).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Ground: terrain, streets, water.
    Ground,
    /// Objects on the ground: buildings, trees.
    Obstruction,
}

impl Class {
    /// The classes in the order of their codes.
    pub const ALL: [Class; 2] = [Class::Ground, Class::Obstruction];

    /// Returns the code of the class: in archives, in hashes, and as the index in arrays that have
    /// one value a class.
    pub const fn code(self) -> u8 {
        match self {
            Class::Ground => 0,
            Class::Obstruction => 1,
        }
    }

    /// Returns the class of a [`Class::code`]; `None` for any other number.
    pub fn of_code(code: u8) -> Option<Self> {
        Class::ALL.get(usize::from(code)).copied()
    }

    /// Returns the name of the class, as users write it.
    pub const fn name(self) -> &'static str {
        match self {
            Class::Ground => "ground",
            Class::Obstruction => "obstruction",
        }
    }

    /// Returns the class of a name.
    pub fn of_name(name: &str) -> Option<Self> {
        Class::ALL.into_iter().find(|class| class.name() == name)
    }

    /// Returns the index in arrays that have one value a class.
    pub const fn index(self) -> usize {
        self.code() as usize
    }
}

/// Panes of clear glass, whose specular reflectance follows from the angle of incidence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Glass {
    /// One pane: two surfaces of glass.
    Single,
    /// Two panes: four surfaces of glass.
    Double,
}

impl Glass {
    /// Returns the glass of `panes` panes, or `None` for 0 or more than 2.
    pub fn of_panes(panes: u8) -> Option<Self> {
        match panes {
            1 => Some(Glass::Single),
            2 => Some(Glass::Double),
            _ => None,
        }
    }

    /// Returns the number of panes.
    pub fn panes(self) -> u8 {
        match self {
            Glass::Single => 1,
            Glass::Double => 2,
        }
    }
}

/// Mean projection of leaves on a plane across a ray, per area of one side (Ross's G): 0.5 where
/// leaves face all ways alike (Ross 1981, "The radiation regime and architecture of plant stands").
/// Flat leaves have more under high suns, upright ones less.
pub const LEAF_PROJECTION: f64 = 0.5;

/// Share of sunlight on a leaf of broadleaved trees that it reflects or lets through: half of the
/// sun's energy is visible, of which leaves scatter 0.10 + 0.05, half near infrared, 0.45 + 0.25
/// (Dorman and Sellers 1989, as in table 3.1 of the Community Land Model 4.5, Oleson et al. 2013).
pub const BROADLEAF_DIFFUSE: f64 = 0.425;
/// Share of sunlight on needles of evergreen conifers that they scatter: 0.07 + 0.05 of the
/// visible, 0.35 + 0.10 of the near infrared (same source).
pub const NEEDLE_DIFFUSE: f64 = 0.285;

/// Leaf area density of street trees in leaf where nothing is stated, m2/m3. Light of the sun that
/// goes 5.5 to 8.5 m through a crown is then 1.5 to 6 % (Konarska et al. 2014 measured 1 to 5 %).
pub const LEAF_AREA_DENSITY: f64 = 1.0;

/// Largest leaf area density, m2/m3. Crowns of street trees have 0.5 to 2, clipped hedges up to 10.
pub const MAX_LEAF_AREA_DENSITY: f64 = 20.0;

/// Checked optical properties of one material, each in 0..=1; `diffuse + specular <= 1`, and
/// `diffuse + transmittance <= 1` but for volumes of leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the files of the scene.
    pub name: String,
    /// Diffuse reflectance of the two sides, 0 to 1. For a canopy, the share of the light that its
    /// leaves scatter, half of it to each side. For a volume of leaves, the share of the light that
    /// falls on a leaf: its reflectance and its own transmittance together.
    pub diffuse: f64,
    /// Specular reflectance at any angle; 0 for glass.
    pub specular: f64,
    /// Clear glass, whose specular reflectance follows from the angle; `None` for other materials.
    pub glass: Option<Glass>,
    /// Share of the light that goes straight on at each crossing of a canopy or a screen, or along
    /// each metre of a volume of leaves. `None` is opaque.
    pub transmittance: Option<f64>,
    /// True if its closed surfaces bound volumes of leaves, which dim light by the length of its
    /// way inside.
    pub volume: bool,
    /// First-hit class that its light counts for.
    pub class: Class,
    /// Group of materials that may follow one schedule at replay.
    pub group: Option<String>,
    /// Values for bands of the light, beside those for all of it, and for longwave radiation.
    pub bands: BandOptics,
}

impl Material {
    /// Returns a material without mirrors, panes or gaps.
    pub fn matt(name: impl Into<String>, diffuse: f64, class: Class) -> Self {
        let (name, bands) = (name.into(), BandOptics::default());
        Material {
            name,
            diffuse,
            specular: 0.0,
            glass: None,
            transmittance: None,
            volume: false,
            class,
            group: None,
            bands,
        }
    }

    /// Returns a volume of leaves of a density (m2 of one side per m3) which scatter a share
    /// `diffuse` of the light that falls on them.
    pub fn of_leaves(name: impl Into<String>, density: f64, diffuse: f64) -> Self {
        let transmittance = Some(left_after_metre(density));
        Material { transmittance, volume: true, ..Material::matt(name, diffuse, Class::Obstruction) }
    }

    /// Returns the leaf area density of a volume of leaves, m2/m3; `None` for other materials.
    pub fn leaf_area_density(&self) -> Option<f64> {
        self.transmittance.filter(|_| self.volume).map(density_of)
    }

    /// Returns true if rays that meet it go on as from a mirror.
    pub fn mirrors(&self) -> bool {
        self.specular > 0.0 || self.glass.is_some()
    }

    /// Returns true if it is a canopy whose leaves scatter light.
    pub fn scatters(&self) -> bool {
        self.transmittance.is_some() && self.diffuse > 0.0
    }

    /// Returns the optical properties in words.
    pub fn optics(&self) -> String {
        let diffuse = rounded(self.diffuse);
        if let Some(density) = self.leaf_area_density() {
            return format!("leaf area density {} m2/m3, diffuse {diffuse}", rounded(density));
        }
        match (self.transmittance, self.glass) {
            (Some(transmittance), _) if self.diffuse > 0.0 => {
                format!("transmittance {}, diffuse {diffuse}", rounded(transmittance))
            }
            (Some(transmittance), _) => format!("transmittance {}", rounded(transmittance)),
            (None, Some(Glass::Single)) => format!("diffuse {diffuse}, glass"),
            (None, Some(Glass::Double)) => format!("diffuse {diffuse}, double glass"),
            (None, None) if self.specular > 0.0 => format!("diffuse {diffuse}, specular {}", rounded(self.specular)),
            (None, None) => format!("diffuse {diffuse}"),
        }
    }

    /// Returns the value of a property for all light, or `None` if the material lacks the property.
    /// Only a material traced as a mirror has a specular reflectance, only a canopy or screen a
    /// transmittance, and among canopies only one that scatters a diffuse reflectance.
    fn solar(&self, property: BandProperty) -> Option<f64> {
        match property {
            BandProperty::Diffuse => {
                Some(self.diffuse).filter(|diffuse| self.transmittance.is_none() || *diffuse > 0.0)
            }
            BandProperty::Specular => Some(self.specular).filter(|specular| *specular > 0.0),
            // Leaves of a volume stop light of all bands alike.
            BandProperty::Transmittance => self.transmittance.filter(|_| !self.volume),
        }
    }

    /// Returns the material in a band without a check. Values that follow from those of other bands
    /// may be outside 0..=1 or add up to more than 1.
    fn unclipped(&self, band: Band) -> Material {
        let value = |property| Some(self.bands.of(property).value(band, self.solar(property)?));
        Material {
            diffuse: value(BandProperty::Diffuse).unwrap_or_default(),
            specular: value(BandProperty::Specular).unwrap_or_default(),
            transmittance: value(BandProperty::Transmittance).or(self.transmittance.filter(|_| self.volume)),
            bands: BandOptics::default(),
            ..self.clone()
        }
    }

    /// Returns the material in a band of the light: its values for all light are those of the band.
    /// A derived value outside 0..=1 is clamped, and values that together give back more than
    /// arrives are scaled down to 1.
    #[must_use]
    pub fn in_band(&self, band: Band) -> Material {
        if self.bands.is_empty() {
            return self.clone();
        }
        let mut material = self.unclipped(band);
        let share = |value: f64| value.clamp(0.0, 1.0);
        (material.diffuse, material.specular) = (share(material.diffuse), share(material.specular));
        material.transmittance = material.transmittance.map(share);
        let whole = material.given_back().max(1.0);
        (material.diffuse, material.specular) = (material.diffuse / whole, material.specular / whole);
        if !material.volume {
            material.transmittance = material.transmittance.map(|through| through / whole);
        }
        material
    }

    /// Returns the share of the light that is reflected or goes on.
    fn given_back(&self) -> f64 {
        self.diffuse + self.specular + self.transmittance.filter(|_| !self.volume).unwrap_or_default()
    }

    /// Describes a value that follows from those of other bands and is no share of the light;
    /// `None` if all are. [`Material::in_band`] clamps it.
    pub fn misfit(&self, band: Band) -> Option<String> {
        let value = |property| Some((property, self.bands.of(property).value(band, self.solar(property)?)));
        let mut values = BandProperty::ALL.into_iter().filter_map(value);
        // The rest of 0.25 after 0.25 is 0 but for the last digit.
        let outside = values.find(|(_, value)| !(-1e-9..=1.0 + 1e-9).contains(value));
        let outside = outside.map(|(property, value)| format!("`{}` would be {}", property.name(), rounded(value)));
        let all = self.unclipped(band).given_back();
        outside.or_else(|| {
            (all > 1.0 + 1e-9)
                .then(|| format!("`diffuse`, `specular` and `transmittance` would add up to {}", rounded(all)))
        })
    }

    /// Checks the values by band; the error says what is wrong.
    fn check_bands(&self) -> std::result::Result<(), String> {
        if let Some(emissivity) = self.bands.emissivity.filter(|share| !(0.0..=1.0).contains(share)) {
            return Err(format!("`emissivity` is {emissivity}, not from 0 to 1"));
        }
        for (property, band, value) in self.bands.all() {
            let (key, name) = (property.name(), band.name());
            if !(0.0..=1.0).contains(&value) {
                return Err(format!("`{key}` is {value} for `{name}`, not from 0 to 1"));
            }
            if self.solar(property).is_none() {
                return Err(format!(
                    "`{key}` is {value} for `{name}`, but 0 for all light, which decides what is traced: give a \
                     value for all light, too"
                ));
            }
            let given_back = self.unclipped(band).given_back();
            if given_back > 1.0 + 1e-12 {
                let (sum, names) = (rounded(given_back), "`diffuse`, `specular` and `transmittance`");
                return Err(format!("{names} add up to {sum} for `{name}`: more light than arrives"));
            }
        }
        Ok(())
    }

    /// Checks the properties; the error says what is wrong.
    pub fn check(&self) -> std::result::Result<(), String> {
        let Material { diffuse, specular, .. } = *self;
        let transmittance = self.transmittance.unwrap_or(0.0);
        for (key, value) in [("diffuse", diffuse), ("specular", specular), ("transmittance", transmittance)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(format!("`{key}` is {value}, not from 0 to 1"));
            }
        }
        if self.glass.is_some() && specular > 0.0 {
            return Err(format!("`glass` excludes `specular` ({specular}): its reflectance is that of its panes"));
        }
        if self.transmittance.is_some() && self.mirrors() {
            return Err("a material with `transmittance` cannot be a mirror: leave out `specular` and `glass`".into());
        }
        // Rounded decimal shares may add up to the next number after 1.
        if !self.volume && diffuse + transmittance > 1.0 + 1e-12 {
            return Err(format!(
                "`diffuse` {diffuse} and `transmittance` {transmittance} add up to more than 1: more light than arrives"
            ));
        }
        // 0.7 + 0.3 may be the next number after 1.
        if diffuse + specular > 1.0 + 1e-12 {
            return Err(format!(
                "`diffuse` {diffuse} and `specular` {specular} add up to more than 1: more light than arrives"
            ));
        }
        self.check_bands()
    }
}

/// Returns the share of light that is left after a metre among leaves of a density (m2/m3), by the
/// law of Beer and Lambert (Ross 1981).
pub fn left_after_metre(density: f64) -> f64 {
    (-LEAF_PROJECTION * density).exp()
}

/// Returns the density of leaves, m2/m3, among which a share of light is left after a metre.
pub fn density_of(left: f64) -> f64 {
    // Where all is left, 0 and not -0.
    (-left.ln() / LEAF_PROJECTION).max(0.0)
}

/// Returns a share of light rounded to four digits behind the point, for display.
pub fn rounded(share: f64) -> f64 {
    (share * 1e4).round() / 1e4
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::site::bands::BandValues;

    /// 0.2, 0.0625 and 0.12345678 are shown as 0.2, 0.0625 and 0.1235.
    #[test]
    fn properties_are_shown_with_four_decimals() {
        let shown = [0.2, 0.0625, 0.123_456_78].map(|diffuse| Material::matt("m", diffuse, Class::Ground).optics());
        assert_eq!(shown, ["diffuse 0.2", "diffuse 0.0625", "diffuse 0.1235"]);
    }

    /// A mirror of 0.2 + 0.5 with `visible` values of 0.1 and 0.3 has 0.3185 + 0.7370 of the near
    /// infrared, more than arrives: `misfit` reports 1.0555, and `in_band` scales it down to 1. The
    /// other 3 bands fit. 6 of 6 statements that no material can have are refused.
    #[test]
    fn a_band_that_reflects_too_much_is_scaled_down() {
        let mut mirror = Material { specular: 0.5, ..Material::matt("m", 0.2, Class::Obstruction) };
        mirror.bands.diffuse = BandValues::new(Band::Visible, 0.1);
        mirror.bands.specular = BandValues::new(Band::Visible, 0.3);
        assert_eq!(mirror.check(), Ok(()));
        let nir = mirror.in_band(Band::Nir);
        assert!((nir.diffuse + nir.specular - 1.0).abs() < 1e-12 && nir.check() == Ok(()), "{nir:?}");
        assert_eq!(
            mirror.misfit(Band::Nir).as_deref(),
            Some("`diffuse`, `specular` and `transmittance` would add up to 1.0555")
        );
        let seen = mirror.in_band(Band::Par);
        assert_eq!((seen.diffuse, seen.specular, seen.bands.is_empty()), (0.1, 0.3, true));
        assert!([Band::Uv, Band::Visible, Band::Par].iter().all(|band| mirror.misfit(*band).is_none()));
        let matt = Material::matt("w", 0.2, Class::Obstruction);
        assert_eq!(matt.in_band(Band::Nir), matt);
        let dark = Material { transmittance: Some(0.5), ..Material::matt("leaf", 0.0, Class::Obstruction) };
        let pane = Material { glass: Some(Glass::Single), ..matt.clone() };
        let of = |property: BandProperty, value, of: &Material| {
            let mut material = of.clone();
            *material.bands.of_mut(property) = BandValues::new(Band::Visible, value);
            material.check()
        };
        for (refused, words) in [
            (of(BandProperty::Diffuse, 1.2, &matt), "1.2 for `visible`, not from 0 to 1"),
            (of(BandProperty::Specular, 0.1, &matt), "0 for all light"),
            (of(BandProperty::Transmittance, 0.1, &matt), "0 for all light"),
            (of(BandProperty::Specular, 0.1, &pane), "0 for all light"),
            (of(BandProperty::Diffuse, 0.8, &mirror), "add up to 1.1 for `visible`"),
            (of(BandProperty::Diffuse, 0.1, &dark), "0 for all light"),
        ] {
            assert!(refused.as_ref().is_err_and(|text| text.contains(words)), "{refused:?}");
        }
    }

    /// The two classes come back from their codes 0 and 1, which are their indices in arrays. The
    /// other 254 numbers are no class.
    #[test]
    fn classes_come_back_from_their_codes() {
        assert_eq!([Class::Ground, Class::Obstruction].map(Class::code), [0, 1]);
        for (i, class) in Class::ALL.into_iter().enumerate() {
            assert_eq!((Class::of_code(class.code()), class.index()), (Some(class), i));
        }
        assert_eq!((0..=u8::MAX).filter(|&code| Class::of_code(code).is_none()).count(), 254);
    }
}
