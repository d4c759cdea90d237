//! Coordinate systems in well-known text as programs write them, valid and damaged.

use super::*;

fn of(text: &str) -> TextSystem {
    TextSystem::parse(text).expect(text)
}

/// Returns a system in Esri's dialect with the unit `unit`.
fn esri(name: &str, [geographic, datum, spheroid]: [&str; 3], projection: &str, unit: &str) -> String {
    format!(
        "PROJCS[\"{name}\",GEOGCS[\"{geographic}\",DATUM[\"{datum}\",SPHEROID[{spheroid}]],PRIMEM[\"Greenwich\",0.0],\
         UNIT[\"Degree\",0.0174532925199433]],{projection},UNIT[{unit}]]"
    )
}

const WGS: [&str; 3] = ["GCS_WGS_1984", "D_WGS_1984", "\"WGS_1984\",6378137.0,298.257223563"];
const ETRS: [&str; 3] = ["GCS_ETRS_1989", "D_ETRS_1989", "\"GRS_1980\",6378137.0,298.257222101"];
const NAD: [&str; 3] = ["GCS_North_American_1983", "D_North_American_1983", "\"GRS_1980\",6378137.0,298.257222101"];
const UTM_32: &str = "PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"False_Easting\",500000.0],PARAMETER[\"False_Northing\",0.0],\
                      PARAMETER[\"Central_Meridian\",9.0],PARAMETER[\"Scale_Factor\",0.9996],PARAMETER[\"Latitude_Of_Origin\",0.0]";

/// Eight systems that ArcGIS writes without an EPSG number are found by their parameters: UTM of
/// three datums, state planes in feet, RD New, Lambert-93, LV95 and Web Mercator.
#[test]
fn parameters_find_the_number() {
    let metre = "\"Meter\",1.0";
    let long_island = "PROJECTION[\"Lambert_Conformal_Conic\"],PARAMETER[\"False_Easting\",984250.0],PARAMETER[\"False_Northing\",0.0],\
                       PARAMETER[\"Central_Meridian\",-74.0],PARAMETER[\"Standard_Parallel_1\",40.66666666666666],\
                       PARAMETER[\"Standard_Parallel_2\",41.03333333333333],PARAMETER[\"Latitude_Of_Origin\",40.16666666666666]";
    let rd = "PROJECTION[\"Double_Stereographic\"],PARAMETER[\"False_Easting\",155000.0],PARAMETER[\"False_Northing\",463000.0],\
              PARAMETER[\"Central_Meridian\",5.38763888888889],PARAMETER[\"Scale_Factor\",0.9999079],\
              PARAMETER[\"Latitude_Of_Origin\",52.15616055555555]";
    let lambert = "PROJECTION[\"Lambert_Conformal_Conic\"],PARAMETER[\"False_Easting\",700000.0],PARAMETER[\"False_Northing\",6600000.0],\
                   PARAMETER[\"Central_Meridian\",3.0],PARAMETER[\"Standard_Parallel_1\",44.0],PARAMETER[\"Standard_Parallel_2\",49.0],\
                   PARAMETER[\"Latitude_Of_Origin\",46.5]";
    let swiss = "PROJECTION[\"Hotine_Oblique_Mercator_Azimuth_Center\"],PARAMETER[\"False_Easting\",2600000.0],\
                 PARAMETER[\"False_Northing\",1200000.0],PARAMETER[\"Scale_Factor\",1.0],PARAMETER[\"Azimuth\",90.0],\
                 PARAMETER[\"Longitude_Of_Center\",7.439583333333333],PARAMETER[\"Latitude_Of_Center\",46.95240555555556]";
    let bessel = "\"Bessel_1841\",6377397.155,299.1528128";
    for (text, number, unit) in [
        (esri("WGS_1984_UTM_Zone_32N", WGS, UTM_32, metre), 32632, 1.0),
        (esri("ETRS_1989_UTM_Zone_32N", ETRS, UTM_32, metre), 25832, 1.0),
        (esri("NAD_1983_UTM_Zone_18N", NAD, &UTM_32.replace("9.0", "-75.0"), metre), 26918, 1.0),
        (
            esri(
                "NAD_1983_StatePlane_New_York_Long_Island_FIPS_3104_Feet",
                NAD,
                long_island,
                "\"Foot_US\",0.3048006096012192",
            ),
            2263,
            1200.0 / 3937.0,
        ),
        (esri("RD_New", ["GCS_Amersfoort", "D_Amersfoort", bessel], rd, metre), 28992, 1.0),
        (esri("RGF_1993_Lambert_93", ["GCS_RGF_1993", "D_RGF_1993", NAD[2]], lambert, metre), 2154, 1.0),
        (esri("CH1903+_LV95", ["GCS_CH1903+", "D_CH1903+", bessel], swiss, metre), 2056, 1.0),
        (
            esri("WGS_1984_Web_Mercator_Auxiliary_Sphere", WGS, "PROJECTION[\"Mercator_Auxiliary_Sphere\"]", metre),
            3857,
            1.0,
        ),
    ] {
        let found = of(&text);
        assert_eq!((found.epsg, found.axes), (Some(number), Some(Axes::Plane)), "{text}");
        assert!(found.plane_unit_m.is_some_and(|metres| (metres - unit).abs() < 1e-9), "{found:?}");
    }
}

/// A number in the text is read in three dialects. Vertical systems state 0.3048 m and 1200/3937 m.
/// Degrees and geocentric coordinates are recognised.
#[test]
fn numbers_and_units_are_read() {
    assert_eq!(of("PROJCS[\"ETRS89_UTM_zone_32N\",AUTHORITY[\"EPSG\",\"25832\"]]").epsg, Some(25832));
    let second = "PROJCRS[\"WGS 84 / UTM zone 32N\",BASEGEOGCRS[\"WGS 84\",DATUM[\"World Geodetic System 1984\",\
                  ELLIPSOID[\"WGS 84\",6378137,298.257223563,LENGTHUNIT[\"metre\",1]]]],CONVERSION[\"UTM zone 32N\",\
                  METHOD[\"Transverse Mercator\"],PARAMETER[\"Latitude of natural origin\",0,ANGLEUNIT[\"degree\",0.0174532925199433]],\
                  PARAMETER[\"Longitude of natural origin\",9],PARAMETER[\"Scale factor at natural origin\",0.9996],\
                  PARAMETER[\"False easting\",500000],PARAMETER[\"False northing\",0]],CS[Cartesian,2],AXIS[\"(E)\",east],\
                  LENGTHUNIT[\"metre\",1]";
    assert_eq!(of(&format!("{second},ID[\"EPSG\",32632]]")).epsg, Some(32632));
    assert_eq!(of(&format!("{second}]")).epsg, Some(32632));
    let plane = esri("WGS_1984_UTM_Zone_32N", WGS, UTM_32, "\"Meter\",1.0");
    let heights =
        of(&format!("{plane},VERTCS[\"NAVD_1988_Foot_US\",VDATUM[\"x\"],UNIT[\"Foot_US\",0.3048006096012192]]"));
    assert!(heights.height_unit_m.is_some_and(|metres| (metres - 1200.0 / 3937.0).abs() < 1e-9));
    let compound =
        of(&format!("COMPD_CS[\"both\",{plane},VERT_CS[\"h\",VERT_DATUM[\"h\",2005],UNIT[\"foot\",0.3048]]]"));
    assert_eq!((compound.epsg, compound.height_unit_m), (Some(32632), Some(0.3048)));
    assert_eq!(of("GEOGCS[\"GCS_WGS_1984\",DATUM[\"D_WGS_1984\"]]").axes, Some(Axes::Degrees));
    assert_eq!(of("GEOCCS[\"WGS 84\",DATUM[\"WGS_1984\"]]").axes, Some(Axes::Geocentric));
    assert_eq!(of("GEODCRS[\"WGS 84\",CS[Cartesian,3],ID[\"EPSG\",4978]]").axes, Some(Axes::Geocentric));
    let local = of("LOCAL_CS[\"site\",UNIT[\"Foot\",0.3048]]");
    assert_eq!((local.epsg, local.plane_unit_m), (None, Some(0.3048)));
}

/// Keywords of ArcInfo state UTM zone 11 of NAD83 with heights in decimetres; longitude and
/// latitude are recognised.
#[test]
fn keywords_of_arcinfo_state_a_system() {
    let found = of(
        "Projection    UTM\r\nZone          11\r\nDatum         NAD83\r\nZunits        10\r\nUnits         METERS\r\nParameters\r\n",
    );
    assert_eq!((found.epsg, found.plane_unit_m, found.height_unit_m), (Some(26911), Some(1.0), Some(0.1)));
    assert_eq!(of("Projection GEOGRAPHIC\nDatum WGS84\nUnits DD\n").axes, Some(Axes::Degrees));
}

/// Texts that are cut anywhere, are no system, or have a thousand brackets give no EPSG number;
/// nothing panics.
#[test]
fn hostile_texts_give_no_epsg_code() {
    let whole = esri("WGS_1984_UTM_Zone_32N", WGS, UTM_32, "\"Meter\",1.0");
    assert!((0..whole.len()).all(|end| TextSystem::parse(&whole[..end]).is_none()));
    for text in
        ["", "[", "PROJCS", "PROJCS[", "PROJCS[]", "1,2,3", &"PROJCS[".repeat(1000), "\u{20ac}\u{20ac}\u{20ac}\u{20ac}"]
    {
        assert_eq!(TextSystem::parse(text).and_then(|found| found.epsg), None, "{text}");
    }
    assert_eq!(of("PROJCS[\"x\",UNIT[\"none\",0]]").plane_unit_m, None);
}
