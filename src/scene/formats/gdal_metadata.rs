//! Metadata that GDAL stores for a band. In: the XML of tag 42112 (`GDAL_METADATA`) or of an
//! `.aux.xml` file (`PAMDataset`). Out: scale, offset, unit of heights and nodata of the first
//! band.

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
        let mut notes = BandNotes::default();
        for item in xml.split("<Item").skip(1) {
            let Some((head, rest)) = item.split_once('>') else { continue };
            let value = rest.split('<').next().unwrap_or_default().trim();
            // An item without a sample is a note of the user's own.
            if attribute(head, "sample") != Some("0") {
                continue;
            }
            match attribute(head, "role").unwrap_or_default().to_lowercase().as_str() {
                "scale" => notes.scale = value.parse().ok(),
                "offset" => notes.offset = value.parse().ok(),
                "unittype" => notes.unit = Some(unescaped(value)).filter(|unit| !unit.is_empty()),
                _ => {}
            }
        }
        notes
    }

    /// Returns the notes on the first band of a `PAMDataset` (GDAL, "Persistent Auxiliary
    /// Metadata").
    pub(super) fn of_aux(xml: &str) -> BandNotes {
        let Some((_, band)) = xml.split_once("<PAMRasterBand band=\"1\"") else { return BandNotes::default() };
        let band = band.split("</PAMRasterBand>").next().unwrap_or_default();
        let number = |name| element(band, name).and_then(|text| text.trim().parse().ok());
        BandNotes {
            scale: number("Scale"),
            offset: number("Offset"),
            unit: element(band, "UnitType").map(|unit| unescaped(unit.trim())).filter(|unit| !unit.is_empty()),
            nodata: number("NoDataValue"),
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

/// Returns the text of the first element called `name`, unchanged.
pub(super) fn element<'x>(xml: &'x str, name: &str) -> Option<&'x str> {
    let (_, behind) = xml.split_once(&format!("<{name}"))?;
    let (head, behind) = behind.split_once('>')?;
    // Skips a longer name that begins alike, and an element without content.
    if head.ends_with('/') || head.starts_with(|c: char| c.is_alphanumeric()) {
        return None;
    }
    behind.split_once(&format!("</{name}>")).map(|(text, _)| text)
}

fn attribute<'x>(head: &'x str, name: &str) -> Option<&'x str> {
    let (_, behind) = head.split_once(&format!(" {name}=\""))?;
    behind.split('"').next()
}

/// Returns text with the five entities of XML replaced by their characters.
pub(super) fn unescaped(text: &str) -> String {
    let plain = text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&apos;", "'");
    plain.replace("&amp;", "&")
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
    /// band. Broken items give nothing.
    #[test]
    fn only_items_of_the_first_band_are_read() {
        let xml = "<GDALMetadata>\n<Item name=\"AREA\">7</Item><Item name=\"SCALE\" sample=\"1\" role=\"scale\">9</Item>\
                   <Item name=\"SCALE\" sample=\"0\" role=\"scale\"> 0.1 </Item><Item name=\"OFFSET\" sample=\"0\" role=\"offset\">50</Item>\
                   <Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">US survey foot</Item></GDALMetadata>";
        let notes = BandNotes::of_tag(xml);
        let unit = Some("US survey foot".to_owned());
        assert_eq!(notes, BandNotes { scale: Some(0.1), offset: Some(50.0), unit, nodata: None });
        for broken in [
            "",
            "<Item",
            "<Item name=\"SCALE\" sample=\"0\" role=\"scale\">x</Item>",
            "<Item>",
            "<Item name=\"scale\">7</Item>",
        ] {
            assert_eq!(BandNotes::of_tag(broken), BandNotes::default(), "{broken}");
        }
    }

    /// An `.aux.xml` file states nodata -1, offset 5, scale 2 and feet; the raster's own statement
    /// comes first.
    #[test]
    fn an_aux_xml_file_states_nodata_scale_and_unit() {
        let xml = "<PAMDataset><SRS dataAxisToSRSAxisMapping=\"1,2\">LOCAL</SRS><PAMRasterBand band=\"1\"><NoDataValue>-1</NoDataValue>\
                   <UnitType>ft</UnitType><Offset>5</Offset><Scale>2</Scale></PAMRasterBand></PAMDataset>";
        let notes = BandNotes::of_aux(xml);
        assert_eq!(
            (notes.nodata, notes.offset, notes.scale, notes.unit.as_deref()),
            (Some(-1.0), Some(5.0), Some(2.0), Some("ft"))
        );
        assert_eq!(BandNotes { scale: Some(0.1), ..BandNotes::default() }.or(notes).scale, Some(0.1));
        assert_eq!((element(xml, "SRS"), element(xml, "Unit")), (Some("LOCAL"), None));
        assert_eq!(BandNotes::of_aux("<PAMDataset/>"), BandNotes::default());
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
