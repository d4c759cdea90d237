//! Metadata that GDAL stores for a band. In: the XML of tag 42112 (`GDAL_METADATA`) or of an
//! `.aux.xml` file (`PAMDataset`). Out: scale, offset, unit of heights and nodata of the first
//! band.

use std::path::Path;

use super::xml::{Element, Xml};
use heliotile_place::epsg_numbers::{FOOT_M, US_FOOT_M};

/// Metadata of a band: how its stored numbers become heights.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct BandNotes {
    pub scale: Option<f64>,
    pub offset: Option<f64>,
    /// Name of the unit of the heights, which are stored value times `scale` plus `offset`.
    pub unit: Option<String>,
    pub nodata: Option<f64>,
}

impl BandNotes {
    /// Returns the items of the first band in the XML of the tag (GDAL, "GTiff driver", metadata of
    /// bands: `sample` counts from 0).
    pub(super) fn of_tag(xml: &str) -> BandNotes {
        let (mut notes, mut reader) = (BandNotes::default(), reader(xml));
        let Ok(Some(_)) = reader.child() else { return notes };
        children(&mut reader, |item, value| {
            // An item without a sample is a note of the user's own.
            if item.attribute("sample") == Some("0") {
                notes.take(&item.attribute("role").unwrap_or_default().to_lowercase(), value);
            }
        });
        notes
    }

    fn take(&mut self, name: &str, value: &str) {
        match name {
            "scale" => self.scale = value.parse().ok(),
            "offset" => self.offset = value.parse().ok(),
            "unittype" => self.unit = Some(value.to_owned()).filter(|unit| !unit.is_empty()),
            "nodatavalue" => self.nodata = value.parse().ok(),
            _ => {}
        }
    }

    /// Returns these notes, completed by `other`.
    pub(super) fn or(self, other: BandNotes) -> BandNotes {
        BandNotes {
            scale: self.scale.or(other.scale),
            offset: self.offset.or(other.offset),
            unit: self.unit.or(other.unit),
            nodata: self.nodata.or(other.nodata),
        }
    }
}

/// Statements of a `.aux.xml` file about a raster (GDAL, "Persistent Auxiliary Metadata").
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct AuxNotes {
    /// Coordinate system, in well-known text.
    pub srs: Option<String>,
    /// The six numbers of the geotransform, separated by commas.
    pub transform: Option<String>,
    /// Notes on the first band.
    pub band: BandNotes,
}

impl AuxNotes {
    /// Returns what the `PAMDataset` states; of broken XML, what stands before the break.
    pub(super) fn parse(xml: &str) -> AuxNotes {
        let (mut notes, mut reader) = (AuxNotes::default(), reader(xml));
        let Ok(Some(_)) = reader.child() else { return notes };
        while let Ok(Some(element)) = reader.child() {
            let is_first = element.name == "PAMRasterBand" && element.attribute("band") == Some("1");
            let done = match element.name.as_str() {
                "SRS" => reader.words().map(|text| notes.srs = Some(text)),
                "GeoTransform" => reader.words().map(|text| notes.transform = Some(text)),
                _ if is_first => {
                    children(&mut reader, |part, value| notes.band.take(&part.name.to_lowercase(), value));
                    Ok(())
                }
                _ => reader.skip(),
            };
            if done.is_err() {
                break;
            }
        }
        notes
    }
}

fn reader(xml: &str) -> Xml<'_> {
    Xml::new(Box::new(xml.as_bytes()), Path::new(""))
}

/// Calls `take` with each child of the current element, and the child's text.
fn children(reader: &mut Xml, mut take: impl FnMut(&Element, &str)) {
    while let Ok(Some(element)) = reader.child() {
        let Ok(text) = reader.words() else { return };
        take(&element, &text);
    }
}

/// Returns the length in metres of a unit, by its name as GIS programs write it.
pub(super) fn metres_of_unit(name: &str) -> Option<f64> {
    let letters: String = name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect();
    Some(match letters.as_str() {
        "m" | "meter" | "meters" | "metre" | "metres" => 1.0,
        "ft" | "foot" | "feet" | "footintl" | "internationalfoot" | "internationalfeet" | "footinternational" => FOOT_M,
        "usft" | "ftus" | "sft" | "footus" | "ussurveyfoot" | "ussurveyfeet" | "usfoot" | "usfeet" | "surveyfoot"
        | "surveyfeet" => US_FOOT_M,
        "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => 0.001,
        "cm" | "centimeter" | "centimeters" | "centimetre" | "centimetres" => 0.01,
        "dm" | "decimeter" | "decimeters" | "decimetre" | "decimetres" => 0.1,
        "km" | "kilometer" | "kilometers" | "kilometre" | "kilometres" => 1000.0,
        "yd" | "yard" | "yards" => 0.9144,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tag with items of two bands gives the scale 0.1, the offset 50 and the unit of the first
    /// band, in quotes of either kind. Broken items give nothing.
    #[test]
    fn only_items_of_the_first_band_are_read() {
        let xml = "<GDALMetadata>\n<Item name=\"AREA\">7</Item><Item name=\"SCALE\" sample=\"1\" role=\"scale\">9</Item>\
                   <Item name='SCALE' sample='0' role='scale'> 0.1 </Item><Item name=\"OFFSET\" sample=\"0\" role=\"offset\">50</Item>\
                   <Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">US survey foot</Item></GDALMetadata>";
        let notes = BandNotes::of_tag(xml);
        let unit = Some("US survey foot".to_owned());
        assert_eq!(notes, BandNotes { scale: Some(0.1), offset: Some(50.0), unit, nodata: None });
        for broken in [
            "",
            "<Item",
            "<GDALMetadata><Item name=\"SCALE\" sample=\"0\" role=\"scale\">x</Item></GDALMetadata>",
            "<Item>",
            "<Item name=\"scale\">7</Item>",
        ] {
            assert_eq!(BandNotes::of_tag(broken), BandNotes::default(), "{broken}");
        }
    }

    /// An `.aux.xml` file states nodata -1, offset 5, scale 2 and feet, behind elements whose names
    /// begin alike; the raster's own statement comes first. What stands before a break counts.
    #[test]
    fn an_aux_xml_file_states_nodata_scale_and_unit() {
        let xml = "<PAMDataset><SRSOther>x</SRSOther><SRS dataAxisToSRSAxisMapping=\"1,2\">LOCAL&lt;</SRS>\
                   <PAMRasterBand band='2'><Scale>9</Scale></PAMRasterBand>\
                   <PAMRasterBand band='1'><NoDataValueOther>7</NoDataValueOther><NoDataValue>-1</NoDataValue>\
                   <UnitType>ft</UnitType><Offset>5</Offset><Scale>2</Scale></PAMRasterBand></PAMDataset>";
        let AuxNotes { srs, transform, band: notes } = AuxNotes::parse(xml);
        assert_eq!(
            (notes.nodata, notes.offset, notes.scale, notes.unit.as_deref()),
            (Some(-1.0), Some(5.0), Some(2.0), Some("ft"))
        );
        assert_eq!(BandNotes { scale: Some(0.1), ..BandNotes::default() }.or(notes).scale, Some(0.1));
        assert_eq!((srs.as_deref(), transform), (Some("LOCAL<"), None));
        for (end, xml) in (0..xml.len()).filter_map(|end| Some((end, xml.get(..end)?))) {
            let cut = AuxNotes::parse(xml);
            assert!(cut.srs.is_none() || end > 80, "{xml}");
        }
        assert_eq!(AuxNotes::parse("<PAMDataset/>"), AuxNotes::default());
    }

    /// Six spellings of units give their metres; a name that is no length gives `None`.
    #[test]
    fn unit_names_become_metres() {
        for (name, metres) in [
            ("metre", Some(1.0)),
            ("US survey foot", Some(1200.0 / 3937.0)),
            ("Foot_US", Some(1200.0 / 3937.0)),
            ("ft", Some(0.3048)),
            ("US-ft", Some(1200.0 / 3937.0)),
            ("cm", Some(0.01)),
            ("kelvin", None),
        ] {
            assert_eq!(metres_of_unit(name), metres, "{name}");
        }
    }
}
