//! Names of coordinate systems as GML spells them. In: the text of `srsName`. Out: EPSG numbers,
//! the unit of heights, and whether the axes follow the register.

use heliotile_place::epsg_numbers::{epsg_numbers_in, height_unit_m};

/// Coordinate system as a file names it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SrsName {
    /// EPSG number of the horizontal or compound system.
    pub epsg: Option<u32>,
    /// Unit of heights, metres, if the name has a vertical system whose unit is known.
    pub height_unit_m: Option<f64>,
    /// True for a URN or address of the OGC: axes are in the order of the register (OGC 07-092r3,
    /// section 7).
    pub is_formal: bool,
    /// True if longitude comes first: `CRS84`.
    pub longitude_first: bool,
}

impl SrsName {
    /// Reads `EPSG:25832`, `urn:ogc:def:crs:EPSG::25832`,
    /// `http://www.opengis.net/def/crs/EPSG/0/25832`, and compound systems such as
    /// `urn:ogc:def:crs,crs:EPSG::25832,crs:EPSG::5783` or `EPSG:25832+5783`. Reads the names of
    /// German surveys, too: `urn:adv:crs:ETRS89_UTM32*DE_DHHN92_NH`.
    pub(super) fn parse(text: &str) -> SrsName {
        let upper = text.to_ascii_uppercase();
        if upper.contains("CRS84") {
            return SrsName { epsg: Some(4326), longitude_first: true, ..SrsName::default() };
        }
        if let Some(epsg) = of_german_surveys(&upper) {
            return SrsName { epsg: Some(epsg), ..SrsName::default() };
        }
        let mut numbers = epsg_numbers_in(&upper).into_iter();
        SrsName {
            epsg: numbers.next(),
            height_unit_m: numbers.next().and_then(height_unit_m),
            is_formal: upper.starts_with("URN:") || upper.starts_with("HTTP"),
            longitude_first: false,
        }
    }
}

/// Returns the EPSG number for a name of the working group of German surveys (AdV, GeoInfoDok 7.1,
/// annex on coordinate reference systems): UTM of ETRS89, Gauss-Krueger zones of DHDN, latitude and
/// longitude.
fn of_german_surveys(upper: &str) -> Option<u32> {
    let name = upper.strip_prefix("URN:ADV:CRS:")?;
    let plane = name.split('*').next().unwrap_or_default();
    let digits = |text: &str| text.chars().take_while(char::is_ascii_digit).collect::<String>().parse::<u32>().ok();
    if let Some(zone) = plane.strip_prefix("ETRS89_UTM").and_then(digits) {
        // EPSG:25828 to 25838, ETRS89 / UTM.
        return (28..=38).contains(&zone).then_some(25_800 + zone);
    }
    if let Some(zone) = plane.strip_prefix("DE_DHDN_3GK").and_then(digits) {
        // EPSG:31466 to 31469, DHDN / 3-degree Gauss-Krueger.
        return (2..=5).contains(&zone).then_some(31_464 + zone);
    }
    plane.starts_with("ETRS89_LAT").then_some(4258)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fourteen spellings give their number. Heights in feet give 0.3048 m, and a plain name does
    /// not follow the register's axes.
    #[test]
    fn spellings_of_a_system_give_its_epsg_code() {
        for (text, epsg) in [
            ("http://www.opengis.net/def/crs/EPSG/0/6697", Some(6697)),
            ("https://www.opengis.net/def/crs/EPSG/9.9/25832/", Some(25832)),
            ("urn:ogc:def:crs:EPSG::25833", Some(25833)),
            ("urn:ogc:def:crs:EPSG:6.12:3068", Some(3068)),
            ("EPSG:25832", Some(25832)),
            ("epsg:31256", Some(31256)),
            ("urn:ogc:def:crs,crs:EPSG::25832,crs:EPSG::5783", Some(25832)),
            ("http://www.opengis.net/gml/srs/epsg.xml#7423", Some(7423)),
            ("urn:adv:crs:ETRS89_UTM32*DE_DHHN92_NH", Some(25832)),
            ("urn:adv:crs:ETRS89_UTM33*DE_DHHN2016_NH", Some(25833)),
            ("urn:adv:crs:DE_DHDN_3GK3*DE_DHHN92_NH", Some(31467)),
            ("urn:adv:crs:ETRS89_Lat-Lon-h", Some(4258)),
            ("local", None),
            ("EPSG", None),
        ] {
            assert_eq!(SrsName::parse(text).epsg, epsg, "{text}");
        }
        let compound = "http://www.opengis.net/def/crs-compound?1=http://www.opengis.net/def/crs/EPSG/0/2263&2=http://www.opengis.net/def/crs/EPSG/0/8228";
        let found = SrsName::parse(compound);
        assert_eq!((found.epsg, found.height_unit_m, found.is_formal), (Some(2263), Some(0.3048), true));
        assert_eq!(SrsName::parse("EPSG:2263+5703").height_unit_m, Some(1.0));
        assert!(
            !SrsName::parse("EPSG:25832").is_formal && SrsName::parse("urn:ogc:def:crs:OGC:1.3:CRS84").longitude_first
        );
    }
}
