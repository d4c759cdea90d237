//! GeoTIFF files of a few samples, valid and damaged, written by the crate's encoder with tags
//! added.

use super::*;
use heliotile_place::reference::Reference;
use tiff::encoder::colortype::{ColorType, Gray16, Gray32Float, Gray64Float, GrayI16, GrayI32, RGB8};
use tiff::encoder::compression::DeflateLevel;
use tiff::encoder::{Compression, TiffEncoder, TiffValue};
use tiff::tags::Predictor;

const SCALE: [f64; 3] = [10.0, 20.0, 0.0];
const TIE: [f64; 6] = [0.0, 0.0, 0.0, 100.0, 500.0, 0.0];
const UTM: [u16; 20] = [1, 1, 0, 4, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32611, 3076, 0, 1, 9001];

/// Tags beside the samples; empty ones are left out.
#[derive(Clone, Copy)]
struct Tags<'t> {
    scale: &'t [f64],
    tie: &'t [f64],
    transformation: &'t [f64],
    keys: &'t [u16],
    nodata: &'t str,
}

const PLAIN: Tags = Tags { scale: &SCALE, tie: &TIE, transformation: &[], keys: &UTM, nodata: "" };

fn encode<C: ColorType>(
    size: [u32; 2],
    data: &[C::Inner],
    tags: &Tags,
    compression: Compression,
    predictor: Predictor,
) -> Vec<u8>
where
    [C::Inner]: TiffValue,
{
    let mut bytes = Cursor::new(Vec::new());
    let encoder = TiffEncoder::new(&mut bytes).expect("an encoder");
    let mut encoder = encoder.with_compression(compression).with_predictor(predictor);
    let mut image = encoder.new_image::<C>(size[0], size[1]).expect("an image");
    let directory = image.encoder();
    for (tag, numbers) in [
        (Tag::ModelPixelScaleTag, tags.scale),
        (Tag::ModelTiepointTag, tags.tie),
        (Tag::ModelTransformationTag, tags.transformation),
    ] {
        if !numbers.is_empty() {
            directory.write_tag(tag, numbers).expect("a tag");
        }
    }
    if !tags.keys.is_empty() {
        directory.write_tag(Tag::GeoKeyDirectoryTag, tags.keys).expect("a tag");
    }
    if !tags.nodata.is_empty() {
        directory.write_tag(Tag::GdalNodata, tags.nodata).expect("a tag");
    }
    image.write_data(data).expect("samples");
    bytes.into_inner()
}

fn plain<C: ColorType>(data: &[C::Inner], tags: &Tags) -> Vec<u8>
where
    [C::Inner]: TiffValue,
{
    encode::<C>([3, 2], data, tags, Compression::Uncompressed, Predictor::None)
}

fn read(bytes: &[u8]) -> Result<Raster> {
    parse(bytes, Path::new("r.tif"))
}

fn heights(raster: &Raster) -> Vec<f32> {
    (0..6).map(|i| raster.height(i % 3, i / 3)).collect()
}

/// Four number formats and three packings give the same six heights; the first sample is at the
/// centre of its cell: 105, 490. Unsigned 16 bit numbers are read too.
#[test]
fn formats_and_packings_give_the_same_heights() {
    const DEFLATE: Compression = Compression::Deflate(DeflateLevel::Balanced);
    let files = [
        plain::<GrayI16>(&[1, -2, 3, 4, 5, 6], &PLAIN),
        plain::<GrayI32>(&[1, -2, 3, 4, 5, 6], &PLAIN),
        plain::<Gray32Float>(&[1., -2., 3., 4., 5., 6.], &PLAIN),
        plain::<Gray64Float>(&[1., -2., 3., 4., 5., 6.], &PLAIN),
        encode::<GrayI16>([3, 2], &[1, -2, 3, 4, 5, 6], &PLAIN, DEFLATE, Predictor::Horizontal),
        encode::<Gray32Float>([3, 2], &[1., -2., 3., 4., 5., 6.], &PLAIN, Compression::Lzw, Predictor::None),
        encode::<Gray32Float>([3, 2], &[1., -2., 3., 4., 5., 6.], &PLAIN, DEFLATE, Predictor::None),
    ];
    for bytes in &files {
        let raster = read(bytes).expect("a raster");
        assert_eq!((heights(&raster), raster.quantum_m), (vec![1.0, -2.0, 3.0, 4.0, 5.0, 6.0], 1.0));
        assert_eq!((raster.grid.first, raster.grid.step), (DVec2::new(105.0, 490.0), DVec2::new(10.0, 20.0)));
        assert_eq!((raster.reference, raster.warnings.len()), (Some(Reference::Epsg(32611)), 0));
    }
    let unsigned = read(&plain::<Gray16>(&[1, 2, 3, 4, 5, 6000], &PLAIN)).expect("a raster");
    assert_eq!(unsigned.height(2, 1), 6000.0);
}

/// Samples that are points lie 5 m west and 10 m north of the centres of cells. A transformation
/// gives the same place as scale and tie point, and so does a tie point at sample 2, 1.
#[test]
fn scale_and_transformation_give_the_same_place() {
    let points: Vec<u16> = UTM.iter().enumerate().map(|(i, &key)| if i == 11 { 2 } else { key }).collect();
    let matrix = [10.0, 0.0, 0.0, 100.0, 0.0, -20.0, 0.0, 500.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    for (tags, first) in [
        (Tags { keys: &points, ..PLAIN }, [100.0, 500.0]),
        (Tags { scale: &[], tie: &[], transformation: &matrix, ..PLAIN }, [105.0, 490.0]),
        (Tags { tie: &[2.0, 1.0, 0.0, 120.0, 480.0, 0.0], ..PLAIN }, [105.0, 490.0]),
    ] {
        let raster = read(&plain::<GrayI16>(&[1, 2, 3, 4, 5, 6], &tags)).expect("a raster");
        assert_eq!(raster.grid.first.to_array(), first);
    }
}

/// The first of three bands is read, with one warning. A nodata value of 32768, which an int16
/// cannot hold, gives no warning.
#[test]
fn only_the_first_band_is_read() {
    let data: Vec<u8> = (0..18).collect();
    let raster = read(&plain::<RGB8>(&data, &PLAIN)).expect("a raster");
    assert_eq!(heights(&raster), [0.0, 3.0, 6.0, 9.0, 12.0, 15.0]);
    assert!(raster.warnings.len() == 1 && raster.warnings[0].contains("first of 3 bands"), "{:?}", raster.warnings);
    let tags = Tags { nodata: "32768", ..PLAIN };
    assert_eq!(read(&plain::<GrayI16>(&[1, 2, 3, 4, 5, 6], &tags)).expect("a raster").warnings.len(), 0);
}

/// 17 unusable files are refused, each with a message of what was found and what to do.
#[test]
fn unusable_files_are_refused_with_a_reason() {
    let data = [1_i16, 2, 3, 4, 5, 6];
    let good = plain::<GrayI16>(&data, &PLAIN);
    let with = |tags: Tags| plain::<GrayI16>(&data, &tags);
    let turned = [7.0, 7.0, 0.0, 100.0, 7.0, -7.0, 0.0, 500.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let float = |data: [f32; 6], nodata| plain::<Gray32Float>(&data, &Tags { nodata, ..PLAIN });
    // Width and height stand in the first entries of the directory; a TIFF is patched where its tag
    // number is found.
    let patched = |tag: u16, kind: u16, value: u32| {
        let mut bytes = good.clone();
        let find: Vec<u8> = tag.to_le_bytes().into();
        let start = u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]) as usize + 2;
        let at = (start..).step_by(12).find(|&at| bytes[at..at + 2] == find).expect("the tag");
        bytes[at + 2..at + 4].copy_from_slice(&kind.to_le_bytes());
        bytes[at + 8..at + 12].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    let sized = |wide: u32, high: u32| {
        let mut bytes = patched(256, 4, wide);
        for other in [patched(257, 4, high), patched(278, 4, high.max(1))] {
            let changed = (0..good.len()).filter(|&i| other[i] != good[i]);
            changed.for_each(|i| bytes[i] = other[i]);
        }
        bytes
    };
    let geographic = [1, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, 4326];
    let cases: Vec<(Vec<u8>, &str)> = vec![
        (Vec::new(), "its header cannot be read"),
        (b"ncols 3".to_vec(), "its header cannot be read"),
        (good[..good.len() / 2].to_vec(), "the file ends within"),
        (sized(0, 0), "dimensions: 0x0"),
        (sized(1_000_000, 1_000_000), "1000000 x 1000000"),
        (sized(16_000, 16_000), "16000 x 16000 samples, more than"),
        (with(Tags { scale: &[], ..PLAIN }), "ModelPixelScale (tag 33550)"),
        (with(Tags { tie: &[], ..PLAIN }), "ModelTiepoint (tag 33922)"),
        (with(Tags { scale: &[], tie: &[], transformation: &turned, ..PLAIN }), "rotated or mirrored (tag 34264"),
        (with(Tags { scale: &[f64::NAN, 1.0, 0.0], ..PLAIN }), "georeference it in metres"),
        (with(Tags { scale: &[-10.0, 10.0, 0.0], ..PLAIN }), "steps above 0"),
        (with(Tags { keys: &geographic, ..PLAIN }), "in degrees: its coordinate system is EPSG:4326"),
        (with(Tags { keys: &[], scale: &[0.0001, 0.0001, 0.0], ..PLAIN }), "in degrees: its cells are 0.0001 wide"),
        (float([7.0; 6], "7"), "none of the 6 samples is a height"),
        (float([f32::INFINITY; 6], ""), "none of the 6 samples is a height"),
        // SampleFormat 6 is complex floats.
        (patched(339, 3, 6), "this release supports 8, 16, 32"),
        (patched(259, 3, 34_887), "found the compression LERC (code 34887), this release supports samples without"),
        (patched(259, 3, 34_712), "the compression JPEG 2000 (code 34712)"),
        (patched(259, 3, 7), "the compression JPEG (code 7)"),
        (patched(259, 3, 50_001), "the compression WebP (code 50001)"),
        (patched(259, 3, 50_002), "the compression JPEG XL (code 50002)"),
        (patched(259, 3, 60_001), "the unknown compression 60001"),
    ];
    for (bytes, expected) in cases {
        let found = read(&bytes).expect_err(expected).to_string();
        assert!(found.contains(expected), "{found}\nin place of {expected}");
    }
    let odd = read(&float([1.0, 2.0, 3.0, 4.0, f32::NAN, f32::INFINITY], "none")).expect("four heights");
    assert_eq!(heights(&odd).iter().filter(|h| h.is_finite()).count(), 4);
    assert!(odd.warnings.iter().any(|w| w.contains("the nodata value `none` is not a number")), "{:?}", odd.warnings);
}

/// A file cut after any byte, or with any byte inverted, is refused or read; nothing panics.
#[test]
fn damaged_files_cause_no_panic() {
    let good = encode::<GrayI16>([3, 2], &[1, 2, 3, 4, 5, 6], &PLAIN, Compression::Lzw, Predictor::Horizontal);
    let mut refused = 0;
    for at in 0..good.len() {
        refused += usize::from(read(&good[..at]).is_err());
        let mut bytes = good.clone();
        bytes[at] ^= 0xff;
        refused += usize::from(read(&bytes).is_err());
    }
    assert!(refused > good.len() / 2, "{refused} of {}", 2 * good.len());
}
