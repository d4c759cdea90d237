//! Bands of sunlight. In: the values that a material states for some bands. Out: the limits of the
//! bands, their shares of the light of sun and sky, and the values of the material in each.
//!
//! The shares are integrals of ASTM G173-03 (2012), "Standard tables for reference solar spectral
//! irradiances: direct normal and hemispherical on 37 degree tilted surface", from 280 to 4000 nm,
//! by the trapezoidal rule on its 2002 wavelengths as pvlib 0.16 has them
//! (`pvlib.spectrum.get_reference_spectra`). The sun's share is that of the direct normal spectrum,
//! 900.14 W/m2. The sky's share is that of the part of the hemispherical spectrum beyond the direct
//! one on the tilted plane, 117.34 W/m2. `tools/peers/bands.py` computes them. That sky is clear,
//! of an air mass of 1.5; under clouds the light of the sky is less blue.

/// Band of sunlight, a range of wavelengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Band {
    /// Ultraviolet, 280 to 380 nm.
    Uv,
    /// Visible light, 380 to 780 nm.
    Visible,
    /// Photosynthetically active radiation, 400 to 700 nm: a part of the visible light.
    Par,
    /// Near infrared, 780 to 4000 nm.
    Nir,
}

/// Factors that scale the light of the sun and the light of the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SourceScale {
    /// Factor of the sun's disc.
    pub sun: f64,
    /// Factor of the sky.
    pub sky: f64,
}

impl SourceScale {
    /// Factors that leave the light as it is: 1 and 1.
    pub const WHOLE: SourceScale = SourceScale { sun: 1.0, sky: 1.0 };

    /// Returns the two factors multiplied by a number.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        SourceScale { sun: self.sun * factor, sky: self.sky * factor }
    }
}

impl Band {
    /// All bands, in the order of their codes. Ultraviolet, visible and near infrared together are
    /// the whole of the light.
    pub const ALL: [Band; 4] = [Band::Uv, Band::Visible, Band::Par, Band::Nir];

    /// Returns the name of the band, as users write it.
    pub const fn name(self) -> &'static str {
        match self {
            Band::Uv => "uv",
            Band::Visible => "visible",
            Band::Par => "par",
            Band::Nir => "nir",
        }
    }

    /// Returns the band of a name.
    pub fn of_name(name: &str) -> Option<Self> {
        Band::ALL.into_iter().find(|band| band.name() == name)
    }

    /// Returns the code of the band in archives.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// Returns the band of a [`Band::code`]; `None` for any other number.
    pub fn of_code(code: u8) -> Option<Self> {
        Band::ALL.get(usize::from(code)).copied()
    }

    /// Returns the shares of the light of the sun and of the sky that lie in the band.
    pub const fn shares(self) -> SourceScale {
        match self {
            Band::Uv => SourceScale { sun: 0.0226, sky: 0.1047 },
            Band::Visible => SourceScale { sun: 0.5197, sky: 0.6436 },
            Band::Par => SourceScale { sun: 0.4164, sky: 0.5296 },
            Band::Nir => SourceScale { sun: 0.4577, sky: 0.2517 },
        }
    }
}

/// A property of a material that may have values by band.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BandProperty {
    /// Diffuse reflectance.
    Diffuse,
    /// Specular reflectance at any angle.
    Specular,
    /// Share of the light that goes straight on at each crossing of a canopy.
    Transmittance,
}

impl BandProperty {
    /// All properties, in the order of their codes.
    pub const ALL: [BandProperty; 3] = [BandProperty::Diffuse, BandProperty::Specular, BandProperty::Transmittance];

    /// Returns the key of the property in descriptions of materials.
    pub const fn name(self) -> &'static str {
        match self {
            BandProperty::Diffuse => "diffuse",
            BandProperty::Specular => "specular",
            BandProperty::Transmittance => "transmittance",
        }
    }

    /// Returns the code of the property in archives.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// Returns the property of a [`BandProperty::code`]; `None` for any other number.
    pub fn of_code(code: u8) -> Option<Self> {
        BandProperty::ALL.get(usize::from(code)).copied()
    }
}

/// Stated values of one property by band; `None` for a band without one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BandValues([Option<f64>; 4]);

impl BandValues {
    /// Returns values that state one band.
    pub fn new(band: Band, value: f64) -> Self {
        BandValues::default().with(band, value)
    }

    /// Returns the values with one more band stated.
    #[must_use]
    pub fn with(mut self, band: Band, value: f64) -> Self {
        if let Some(place) = self.0.get_mut(usize::from(band.code())) {
            *place = Some(value);
        }
        self
    }

    /// Returns the stated value of a band.
    pub fn stated(&self, band: Band) -> Option<f64> {
        self.0.get(usize::from(band.code())).copied().flatten()
    }

    /// Iterates over bands with a value, in the order of their codes.
    pub fn all(&self) -> impl Iterator<Item = (Band, f64)> {
        Band::ALL.into_iter().zip(self.0).filter_map(|(band, value)| Some((band, value?)))
    }

    /// Returns the value in a band of a property that has the value `solar` for all light. A value
    /// that is not stated follows from the others:
    ///
    /// - visible and PAR stand for one another, and are `solar` if neither is stated;
    /// - ultraviolet is as visible;
    /// - near infrared is the rest of `solar`, so that the three bands add up to it under the sun's
    ///   own shares: solar = the sum of share x value. It may lie outside 0..=1 where the numbers
    ///   do not fit.
    pub fn value(&self, band: Band, solar: f64) -> f64 {
        let either = |one, other| self.stated(one).or_else(|| self.stated(other));
        let visible = either(Band::Visible, Band::Par);
        match band {
            Band::Visible => visible.unwrap_or(solar),
            Band::Par => either(Band::Par, Band::Visible).unwrap_or(solar),
            Band::Uv => self.stated(Band::Uv).or(visible).unwrap_or(solar),
            Band::Nir => match (self.stated(Band::Nir), visible) {
                (Some(stated), _) => stated,
                (None, None) => solar,
                (None, Some(visible)) => {
                    let [uv, seen, nir] = [Band::Uv, Band::Visible, Band::Nir].map(|band| band.shares().sun);
                    (solar - uv * self.value(Band::Uv, solar) - seen * visible) / nir
                }
            },
        }
    }
}

/// Stated values of a material by band, besides its values for all light; empty for most materials.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BandOptics {
    /// Diffuse reflectances.
    pub diffuse: BandValues,
    /// Specular reflectances.
    pub specular: BandValues,
    /// Transmittances of a canopy.
    pub transmittance: BandValues,
    /// Longwave emissivity, beyond 4000 nm. No sunlight lies there, so it is no band.
    pub emissivity: Option<f64>,
}

impl BandOptics {
    /// Returns the stated values of a property.
    pub fn of(&self, property: BandProperty) -> &BandValues {
        match property {
            BandProperty::Diffuse => &self.diffuse,
            BandProperty::Specular => &self.specular,
            BandProperty::Transmittance => &self.transmittance,
        }
    }

    /// Returns the stated values of a property, to be changed.
    pub fn of_mut(&mut self, property: BandProperty) -> &mut BandValues {
        match property {
            BandProperty::Diffuse => &mut self.diffuse,
            BandProperty::Specular => &mut self.specular,
            BandProperty::Transmittance => &mut self.transmittance,
        }
    }

    /// Returns true if nothing is stated for bands of the light.
    pub fn is_empty(&self) -> bool {
        self.all().next().is_none()
    }

    /// Iterates over all stated values of bands of the light: property, band, value; in the order
    /// of archives.
    pub fn all(&self) -> impl Iterator<Item = (BandProperty, Band, f64)> {
        let of = |property: BandProperty| self.of(property).all().map(move |(band, value)| (property, band, value));
        BandProperty::ALL.into_iter().flat_map(of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ultraviolet, visible and near infrared shares add up to 1, for the sun and for the sky, to
    /// 1e-12. The 4 bands and 3 properties come back from their codes and names.
    #[test]
    fn shares_of_bands_add_up_to_1() {
        let of = |part: fn(SourceScale) -> f64| [Band::Uv, Band::Visible, Band::Nir].map(|band| part(band.shares()));
        for shares in [of(|scale| scale.sun), of(|scale| scale.sky)] {
            assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{shares:?}");
        }
        for band in Band::ALL {
            assert_eq!((Band::of_code(band.code()), Band::of_name(band.name())), (Some(band), Some(band)));
        }
        for property in BandProperty::ALL {
            assert_eq!(BandProperty::of_code(property.code()), Some(property));
        }
        assert_eq!((Band::of_code(4), BandProperty::of_code(3), Band::of_name("red")), (None, None, None));
    }

    /// The diffuse share of a day's PAR agrees with Spitters et al. 1986 (pvlib 0.16.1,
    /// `diffuse_par_spitters`, zenith angle 50 degrees) within 0.03 for diffuse shares of all light
    /// of 0.1 to 1: 7 of 7.
    #[test]
    fn the_diffuse_share_of_par_agrees_with_spitters() {
        let SourceScale { sun, sky } = Band::Par.shares();
        for (diffuse, expected) in
            [(0.1, 0.110), (0.2, 0.219), (0.3, 0.327), (0.5, 0.538), (0.7, 0.737), (0.9, 0.919), (1.0, 1.0)]
        {
            let found = sky * diffuse / (sky * diffuse + sun * (1.0 - diffuse));
            assert!((found - expected).abs() < 0.03, "{diffuse}: {found}");
        }
    }

    /// A leaf of 0.25 that reflects 0.08 of the visible light reflects 0.4514 of the near infrared,
    /// so that the three bands make 0.25 again, to 1e-12. With nothing stated every band has 0.25.
    /// PAR stands for visible and the other way. A stated near infrared stays 0.45. A visible value
    /// of 0.9 makes the near infrared negative.
    #[test]
    fn unstated_bands_follow_from_stated_ones() {
        let leaf = BandValues::new(Band::Visible, 0.08);
        let [uv, visible, par, nir] = Band::ALL.map(|band| leaf.value(band, 0.25));
        assert_eq!((uv, visible, par), (0.08, 0.08, 0.08));
        let whole = Band::Uv.shares().sun * uv + Band::Visible.shares().sun * visible + Band::Nir.shares().sun * nir;
        assert!((nir - 0.4514).abs() < 1e-4 && (whole - 0.25).abs() < 1e-12, "{nir} {whole}");
        assert_eq!(Band::ALL.map(|band| BandValues::default().value(band, 0.25)), [0.25; 4]);
        let two = BandValues::new(Band::Par, 0.07).with(Band::Nir, 0.45);
        assert_eq!(Band::ALL.map(|band| two.value(band, 0.25)), [0.07, 0.07, 0.07, 0.45]);
        assert!(BandValues::new(Band::Visible, 0.9).value(Band::Nir, 0.25) < 0.0);
    }
}
