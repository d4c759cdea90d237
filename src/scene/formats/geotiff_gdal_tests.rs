//! Rasters that GDAL wrote, in `tests/data/rasters`: heights are 100 + column / 2 + row / 4 metres.

use std::path::PathBuf;

use super::*;
use crate::Scene;
use crate::placing::frame::SiteFrame;
use crate::site::SceneFiles;
use heliotile_place::reference::Reference;

const COLUMNS: i64 = 40;
const ROWS: i64 = 36;

fn at(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/rasters").join(name)
}

fn read(name: &str) -> Raster {
    let path = at(name);
    parse(&std::fs::read(&path).expect(name), &path).expect(name)
}

/// Returns the largest difference from the heights that were written, and the number of nodata
/// samples.
fn compared(raster: &Raster, written: impl Fn(f64) -> f64) -> (f64, usize) {
    let (mut most, mut nodata) = (0.0_f64, 0);
    for (row, column) in (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (row, column))) {
        let found = f64::from(raster.height(column, row));
        if found.is_nan() {
            nodata += 1;
        } else {
            most = most.max((found - written(100.0 + column as f64 * 0.5 + row as f64 * 0.25)).abs());
        }
    }
    (most, nodata)
}

/// Four rasters of four number types, LZW in tiles or Deflate, are read to 0.01 mm. The LZW tiles
/// reach beyond the raster, which the decoder alone takes for a cut file.
#[test]
fn rasters_packed_by_gdal_keep_their_heights() {
    for (name, times) in [("int16_lzw_tiles.tif", 4.0), ("float32_lzw_tiles.tif", 1.0), ("float64_deflate.tif", 1.0)] {
        let raster = read(name);
        assert_eq!((raster.grid.columns, raster.grid.rows), (40, 36));
        let (most, nodata) = compared(&raster, |metres| metres * times);
        assert!(most < 1e-5 && nodata == 0, "{name}: {most} {nodata}");
        assert_eq!((raster.reference, raster.plane_unit_m), (Some(Reference::Epsg(25832)), Some(1.0)));
        assert!(raster.warnings.is_empty(), "{:?}", raster.warnings);
    }
    assert_eq!(compared(&read("uint8_lzw_tiles.tif"), f64::trunc), (0.0, 0));
}

/// Stored whole numbers become (0.01 n + 5) feet. Nodata is the stored value 11900, which stands
/// for 124 ft and occurs in 14 places. Whole numbers with a scale of 0.1 lie 0.1 m apart.
#[test]
fn stored_numbers_in_scaled_feet_become_metres() {
    let raster = read("int32_scaled_ft.tif");
    let (most, nodata) = compared(&raster, |stored| (stored + 5.0) * 0.3048);
    assert!(most < 1e-4, "{most}");
    let expected = (0..ROWS * COLUMNS).filter(|i| 2 * (i % COLUMNS) + i / COLUMNS == 76).count();
    assert_eq!(nodata, expected);
    let raster = read("scale_offset.tif");
    let [low, high] = raster.extent();
    assert!((low.z - 150.0).abs() < 1e-4 && (high.z - 170.0).abs() < 1e-4, "{low} {high}");
    assert!((raster.quantum_m - 0.1).abs() < 1e-9, "{}", raster.quantum_m);
}

/// Half of the samples, 720 of 1440, are nodata: by a mask in strips, in big-endian BigTIFF, in a
/// COG with overviews, or by an opacity band in planes or beside each height. No band gets a
/// warning. A mask that is not packed hides 200 of 400.
#[test]
fn masks_and_opacity_make_samples_nodata() {
    for (name, times) in [
        ("mask_strips.tif", 1.0),
        ("mask_big_endian.tif", 1.0),
        ("mask_cog.tif", 1.0),
        ("alpha_bands.tif", 4.0),
        ("alpha_pixels.tif", 1.0),
    ] {
        let raster = read(name);
        let (most, nodata) = compared(&raster, |metres| metres * times);
        assert!(most < 1e-5 && nodata == 720, "{name}: {most} {nodata}");
        assert!(raster.height(19, 0) > 0.0 && raster.height(20, 0).is_nan(), "{name}");
        assert!(raster.warnings.is_empty(), "{:?}", raster.warnings);
    }
    let raster = read("internal_mask.tif");
    assert_eq!((0..400).filter(|i| raster.height(i % 20, i / 20).is_nan()).count(), 200);
}

/// Units of feet that follow only from the system numbers become metres: a raster is 57.9 m wide
/// and starts at 304.80 m, and heights of 100 US feet are 30.48 m.
#[test]
fn feet_of_an_epsg_code_become_metres() {
    let raster = read("gdal_6839_like.tif");
    let [low, high] = raster.extent();
    assert!((high.x - low.x - 190.0 * 1200.0 / 3937.0).abs() < 1e-6 && (low.z - 304.8006).abs() < 1e-3, "{low} {high}");
    let raster = read("feet_heights_in_us_feet.tif");
    let (most, _) = compared(&raster, |feet| feet * 1200.0 / 3937.0);
    assert!(most < 1e-4 && raster.warnings.is_empty(), "{most} {:?}", raster.warnings);
    assert!((raster.grid.step.x - 10.0 * 1200.0 / 3937.0).abs() < 1e-9);
}

fn load(names: &[&str], frame: SiteFrame) -> Result<Scene> {
    let files: Vec<PathBuf> = names.iter().map(|name| at(name)).collect();
    Scene::load_site(&SceneFiles::new(&files, None)?.framed(&frame))
}

/// A city model and a raster in feet without a height unit meet in New York with a scale of
/// 0.3048006: 118.9 m wide, 8 m high from 9.14 m on. Alone, the raster's heights are read as
/// metres, a warning names the scale, and stating its system again changes nothing.
#[test]
fn model_and_raster_in_feet_meet_in_new_york() {
    let feet = SiteFrame { scale: Some(0.3048006), ..SiteFrame::default() };
    let scene = load(&["feet_2263.city.json", "dem_2263_ft_nounit.tif"], feet).expect("a scene");
    let (low, high) = scene.mesh.bounds();
    let size = high - low;
    assert!((size.x - 118.87).abs() < 0.02 && (size.z - 8.0).abs() < 0.01, "{size}");
    assert!((low.z + scene.mesh.origin.z - 9.144).abs() < 0.01, "{low}");
    let place = scene.place.expect("New York");
    assert!((place.latitude_deg - 40.743).abs() < 0.001 && (place.longitude_deg + 73.99).abs() < 0.001, "{place}");
    assert!(!scene.report.warnings.iter().any(|said| said.contains("km")), "{:?}", scene.report.warnings);
    for epsg in [None, Some(2263)] {
        let scene = load(&["dem_2263_ft_nounit.tif"], SiteFrame { epsg, ..SiteFrame::default() }).expect("a scene");
        assert!((scene.place.expect("New York").latitude_deg - 40.743).abs() < 0.001);
        let said = scene.report.warnings.iter().find(|said| said.contains("states no unit of its heights"));
        assert!(said.is_some_and(|said| said.contains("give scale 0.3048006")), "{:?}", scene.report.warnings);
    }
}

/// UTM metres stay at 51.45 N 9.00 E, where the file says, although the user asks for a system in
/// feet; one warning says so.
#[test]
fn a_raster_in_metres_ignores_a_system_in_feet() {
    let scene = load(&["scale_offset.tif"], SiteFrame { epsg: Some(2263), ..SiteFrame::default() }).expect("a scene");
    let place = scene.place.expect("Germany");
    assert!((place.latitude_deg - 51.4503).abs() < 1e-3 && (place.longitude_deg - 9.0014).abs() < 1e-3, "{place}");
    let said: Vec<_> = scene.report.warnings.iter().filter(|said| said.contains("EPSG:2263")).collect();
    assert!(said.len() == 1 && said[0].contains("the place of the files is used"), "{said:?}");
}

/// Files beside a raster say where it lies: a world file and a `.prj` of Esri (first sample 500005
/// 5699995, EPSG:25832), an `.aux.xml` with a scale of 0.1 and nodata, and a `.prj` beside an ASCII
/// grid. A `.prj` in degrees and a world file of five numbers are refused.
#[test]
fn files_beside_a_raster_state_its_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let bare: Vec<u8> = {
        let mut bytes = Cursor::new(Vec::new());
        let mut encoder = tiff::encoder::TiffEncoder::new(&mut bytes).expect("an encoder");
        encoder.write_image::<tiff::encoder::colortype::GrayI16>(3, 2, &[10, 20, 30, 40, 50, 60]).expect("a picture");
        bytes.into_inner()
    };
    let utm = "PROJCS[\"ETRS_1989_UTM_Zone_32N\",GEOGCS[\"GCS_ETRS_1989\",DATUM[\"D_ETRS_1989\",SPHEROID[\"GRS_1980\",6378137.0,\
               298.257222101]],PRIMEM[\"Greenwich\",0.0],UNIT[\"Degree\",0.0174532925199433]],PROJECTION[\"Transverse_Mercator\"],\
               PARAMETER[\"False_Easting\",500000.0],PARAMETER[\"False_Northing\",0.0],PARAMETER[\"Central_Meridian\",9.0],\
               PARAMETER[\"Scale_Factor\",0.9996],PARAMETER[\"Latitude_Of_Origin\",0.0],UNIT[\"Meter\",1.0]]";
    let write = |name: &str, text: &[u8]| std::fs::write(at(name), text).expect("written");
    let read = |name: &str| parse(&bare, &at(name));
    assert!(read("a.tif").expect_err("nowhere").to_string().contains("ModelPixelScale"));
    write("a.tfw", b"10\r\n0\r\n0\r\n-10\r\n500005\r\n5699995\r\n");
    write("a.PRJ", utm.as_bytes());
    for name in ["a.tif", "a.tif.gz"] {
        let raster = read(name).expect("a raster");
        assert_eq!((raster.grid.first, raster.grid.step), (DVec2::new(500_005.0, 5_699_995.0), DVec2::splat(10.0)));
        assert_eq!((raster.reference, raster.height(2, 1)), (Some(Reference::Epsg(25832)), 60.0));
    }
    let srs = utm.replace('"', "&quot;");
    let aux = format!(
        "<PAMDataset><SRS>{srs}</SRS><GeoTransform> 5.0e+05, 10, 0, 5700000, 0, -10</GeoTransform><PAMRasterBand band=\"1\">\
         <NoDataValue>50</NoDataValue><Scale>0.1</Scale></PAMRasterBand></PAMDataset>"
    );
    write("b.tif.aux.xml", aux.as_bytes());
    let raster = read("b.tif").expect("a raster");
    assert_eq!(
        (raster.grid.first.to_array(), raster.reference),
        ([500_005.0, 5_699_995.0], Some(Reference::Epsg(25832)))
    );
    assert!((raster.height(2, 1) - 6.0).abs() < 1e-6 && raster.height(1, 1).is_nan());
    write("c.tfw", b"10 0 0 -10 5");
    assert!(
        read("c.tif")
            .expect_err("five numbers")
            .to_string()
            .contains("c.tfw: the world file holds `10 0 0 -10 5`, not six numbers")
    );
    write("d.tfw", b"10 0 0 -10 5 5");
    write("d.prj", b"GEOGCS[\"GCS_WGS_1984\",DATUM[\"D_WGS_1984\"]]");
    assert!(read("d.tif").expect_err("degrees").to_string().contains("the raster is in degrees"));
    let place = load(&["flat_prj.asc"], SiteFrame::default()).expect("a scene").place.expect("a place");
    assert!((place.latitude_deg - 51.4513).abs() < 1e-3 && place.epsg == Some(25832), "{place}");
}

/// Four rasters of a street, 60 x 60 samples each, have the right range: Int16 with a scale,
/// Float32 in Zstandard with predictor 3, and UInt8 with and without a scale. The surface is 79.79
/// to 92.73 m, the ground 79.87 to 81.13 m, crowns reach 8 m, and codes run from 1 to 5.
#[test]
fn rasters_of_a_street_have_the_right_range() {
    for (name, least, most) in [
        ("street_dsm.tif", 79.79, 92.73),
        ("street_dem.tif", 79.8698, 81.1302),
        ("street_canopy.tif", 0.0, 8.0),
        ("street_landcover.tif", 1.0, 5.0),
    ] {
        let raster = read(name);
        let [low, high] = raster.extent();
        assert!((low.z - least).abs() < 1e-4 && (high.z - most).abs() < 1e-4, "{name}: {low} {high}");
        assert!(raster.warnings.is_empty(), "{name}: {:?}", raster.warnings);
    }
}
