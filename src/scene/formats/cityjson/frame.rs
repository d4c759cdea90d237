//! In: transform and reference system of a CityJSON object. Out: positions in metres, and their
//! coordinate system.

use std::path::Path;

use glam::DVec3;

use crate::formats::cityjson::document::Document;
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::Message;
use heliotile_place::epsg_numbers::{Axes, axes_of, epsg_numbers_in};
use heliotile_place::reference::Reference;

/// Conversion of the file's numbers to metres.
#[derive(Clone, Copy, Debug)]
pub(in crate::formats) struct Frame {
    scale: DVec3,
    translate: DVec3,
}

impl Frame {
    /// Frame of numbers that are metres already.
    pub(in crate::formats) const METRES: Frame = Frame { scale: DVec3::ONE, translate: DVec3::ZERO };

    /// Returns the transform of a document. It is required from version 1.1 on (CityJSON 1.1,
    /// section 4); in version 1.0 positions may be plain metres.
    pub(super) fn new(document: &Document, file: &Path) -> Result<Frame> {
        let Some(transform) = &document.transform else {
            if document.version.0.starts_with("1.0") {
                return Ok(Frame { scale: DVec3::ONE, translate: DVec3::ZERO });
            }
            let what =
                format!("`transform` is missing, which CityJSON {} requires", excerpt(document.version.0.as_bytes()));
            let hint = "add `\"transform\": {\"scale\": [0.001, 0.001, 0.001], \"translate\": [0, 0, 0]}` with the values \
                        that the vertices were written with";
            return Err(Error::input(file, None, what, hint));
        };
        let [scale, translate] = [transform.scale, transform.translate].map(DVec3::from);
        // serde_json yields no infinite numbers, but the type `f64` does not promise that.
        if !(scale.is_finite() && translate.is_finite() && scale.min_element() > 0.0) {
            let what = format!("`transform` has the scale {scale} and the translation {translate}");
            return Err(Error::input(file, None, what, "write scales in metres per step, above 0 on every axis"));
        }
        Ok(Frame { scale, translate })
    }

    pub(super) fn place(&self, [x, y, z]: [f64; 3]) -> DVec3 {
        DVec3::new(x, y, z) * self.scale + self.translate
    }
}

/// Returns the coordinate system of `metadata.referenceSystem`; refuses degrees and geocentric
/// coordinates.
pub(super) fn reference(text: &str, file: &Path, warnings: &mut Vec<Message>) -> Result<Option<Reference>> {
    let number = epsg_numbers_in(text).first().copied();
    let axes = number.and_then(axes_of);
    if axes == Some(Axes::Geocentric) {
        let what = format!("coordinates are geocentric: `metadata.referenceSystem` is `{}`", excerpt(text.as_bytes()));
        let hint = "reproject the file to a system in metres with z up, such as the national grid or UTM, or correct the metadata";
        return Err(Error::input(file, None, what, hint));
    }
    if axes == Some(Axes::Degrees) || text.contains("CRS84") {
        let what = format!("coordinates are degrees: `metadata.referenceSystem` is `{}`", excerpt(text.as_bytes()));
        let hint =
            "reproject the file to a system in metres, such as the national grid or UTM, or correct the metadata";
        return Err(Error::input(file, None, what, hint));
    }
    if number.is_none() {
        warnings.push(format!(
            "{}: `metadata.referenceSystem` is `{}`, which has no known EPSG code; the place on Earth stays unknown",
            file.display(),
            excerpt(text.as_bytes())
        ).into());
    }
    Ok(number.map(Reference::Epsg))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seven spellings of reference systems give their number, three others none.
    #[test]
    fn spellings_of_a_system_give_its_epsg_code() {
        for (text, expected) in [
            ("https://www.opengis.net/def/crs/EPSG/0/7415", Some(7415)),
            ("http://www.opengis.net/def/crs/EPSG/9.8.5/28992/", Some(28992)),
            ("urn:ogc:def:crs:EPSG::7415", Some(7415)),
            ("urn:ogc:def:crs:EPSG:9.9:25832", Some(25832)),
            ("EPSG:28992", Some(28992)),
            ("epsg:2056", Some(2056)),
            ("urn:ogc:def:crs,crs:EPSG::28992,crs:EPSG::5709", Some(28992)),
            ("https://www.opengis.net/def/crs/OGC/1.3/CRS84", None),
            ("EPSG", None),
            ("Amersfoort / RD New", None),
        ] {
            assert_eq!(epsg_numbers_in(text).first().copied(), expected, "{text}");
        }
    }

    /// Degrees are refused under 6 names and geocentric coordinates under 2. Metres are accepted,
    /// and a name without a number gives 1 warning.
    #[test]
    fn degrees_and_geocentric_systems_are_refused() {
        let mut warnings = Vec::new();
        let mut of = |text: &str| reference(text, Path::new("town.city.json"), &mut warnings);
        for text in [
            "EPSG:4326",
            "urn:ogc:def:crs:EPSG::4979",
            "http://www.opengis.net/def/crs/EPSG/0/6697",
            "OGC:CRS84",
            "EPSG:9518",
            "EPSG:6668",
        ] {
            let message = of(text).expect_err(text).to_string();
            assert!(message.contains("coordinates are degrees") && message.contains("reproject"), "{message}");
        }
        for text in ["EPSG:4978", "urn:ogc:def:crs:EPSG::4936"] {
            assert!(of(text).expect_err(text).to_string().contains("coordinates are geocentric"), "{text}");
        }
        assert_eq!(of("EPSG:7415").expect("metres"), Some(Reference::Epsg(7415)));
        assert_eq!(of("the local grid").expect("unknown"), None);
        assert_eq!(warnings.len(), 1);
    }
}
