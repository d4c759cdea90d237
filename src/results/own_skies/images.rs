//! Pictures of the sky. In: the bytes of a PNG, a Radiance picture (.hdr, .pic) or an OpenEXR file.
//! Out: one checked number a pixel, as a [`DomeImage`].
//!
//! Red, green and blue become one number with the weights of Radiance's luminance. Levels of a PNG
//! are encoded as sRGB, unless its chunk gAMA states another exponent; levels of a cloud picture
//! are shares without encoding. Radiance pictures are divided by their EXPOSURE.

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{ReadChannels, ReadLayers, read};

use super::hdr;
use super::hdr::{Pixels, check_sides};
use heliotile_core::dome::image::DomeImage;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_weather::skies::{PatchQuantity, luminance};

/// Meaning of the levels of a picture.
#[derive(Clone, Copy, Debug)]
pub(super) enum Levels {
    /// Radiances of a sky.
    Radiances {
        /// Radiance of level 1, W/m2/sr; `None`: levels are radiances.
        white_w_m2_sr: Option<f64>,
        /// True if only ratios of levels count.
        are_relative: bool,
    },
    /// Transmittances of clouds, 0 to 1.
    Shares,
}

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
const EXR: &[u8] = b"\x76\x2f\x31\x01";

/// First bytes of pictures in formats that are not supported.
const OTHERS: [(&[u8], &str); 5] =
    [(b"\xff\xd8\xff", "JPEG"), (b"II*\0", "TIFF"), (b"MM\0*", "TIFF"), (b"GIF8", "GIF"), (b"BM", "BMP")];

/// Returns true if bytes are a picture; fails for a picture in a format that is not supported.
pub(super) fn is_picture(path: &Path, bytes: &[u8]) -> Result<bool> {
    if let Some((_, kind)) = OTHERS.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return Err(Error::input(
            path,
            None,
            format!("it is a {kind}"),
            "save the picture as PNG, Radiance HDR or OpenEXR",
        ));
    }
    Ok(bytes.starts_with(PNG) || bytes.starts_with(EXR) || hdr::is_hdr(bytes))
}

/// Reads a picture; `top_azimuth_deg` is the azimuth of its top.
pub(super) fn read_image(path: &Path, bytes: &[u8], levels: Levels, top_azimuth_deg: f64) -> Result<DomeImage> {
    let pixels = match bytes {
        bytes if bytes.starts_with(PNG) => png(path, bytes, levels)?,
        bytes if bytes.starts_with(EXR) => exr(path, bytes)?,
        bytes => hdr::read_hdr(path, bytes)?,
    };
    let Pixels { width, height, .. } = pixels;
    if width != height {
        let hint = "crop it to the square around the circle of the horizon, whose middle is the zenith";
        return Err(Error::input(path, None, format!("{width} x {height} pixels are not a square"), hint));
    }
    let (factor, quantity) = match levels {
        Levels::Shares => (1.0, PatchQuantity::Transmittance),
        Levels::Radiances { white_w_m2_sr: Some(white), .. } => (white, PatchQuantity::Radiance),
        Levels::Radiances { are_relative, .. } if are_relative || !pixels.are_coded => (1.0, PatchQuantity::Radiance),
        Levels::Radiances { .. } => {
            let hint = "state the radiance of white with {sky_white}, or scale the sky to the diffuse irradiance: {sky_scale} dhi";
            return Err(Error::input(path, None, "the levels of a PNG are not radiances", hint)
                .because(Problem::Lacks("white")));
        }
    };
    let numbers = pixels.levels.iter().map(|level| (level * factor) as f32).collect();
    let square = || Error::input(path, None, "the picture has no pixels", "give a square picture");
    let image = DomeImage::new(width, numbers, top_azimuth_deg).ok_or_else(square)?;
    let mut is_black = true;
    for (column, row, number) in image.inside() {
        if !quantity.holds(f64::from(number)) {
            let what = format!("pixel {column}, {row} from the top left is {number}");
            return Err(Error::input(path, None, what, format!("{}: correct the picture", quantity.range())));
        }
        is_black &= number == 0.0;
    }
    if is_black && matches!(levels, Levels::Radiances { .. }) {
        return Err(Error::input(path, None, "the sky is black", "give a photograph that is exposed"));
    }
    Ok(image)
}

fn png(path: &Path, bytes: &[u8], levels: Levels) -> Result<Pixels> {
    let broken =
        |error: png::DecodingError| Error::input(path, None, error.to_string(), "save the picture as PNG again");
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: 1 << 30 });
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(broken)?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    check_sides(path, width, height)?;
    let exponent = reader.info().gamma().map(|gamma| f64::from(gamma.into_value())).filter(|gamma| *gamma > 0.0);
    let mut buffer = vec![0; reader.output_buffer_size().unwrap_or_default()];
    let frame = reader.next_frame(&mut buffer).map_err(broken)?;
    let wide = frame.bit_depth == png::BitDepth::Sixteen;
    let sample = |bytes: &[u8]| match bytes {
        [high, low] => f64::from(u16::from_be_bytes([*high, *low])) / f64::from(u16::MAX),
        bytes => f64::from(bytes.first().copied().unwrap_or_default()) / f64::from(u8::MAX),
    };
    let linear = |coded: f64| match (levels, exponent) {
        (Levels::Shares, _) => coded,
        (_, Some(exponent)) => coded.powf(1.0 / exponent),
        // Formula: IEC 61966-2-1:1999, equations 5 and 6.
        (_, None) if coded <= 0.04045 => coded / 12.92,
        (_, None) => ((coded + 0.055) / 1.055).powf(2.4),
    };
    let size = if wide { 2 } else { 1 };
    let level = |pixel: &[u8]| {
        let mut samples = pixel.chunks(size).map(|bytes| linear(sample(bytes)));
        let first = samples.next().unwrap_or_default();
        // Pixels with one sample, or with one and an opacity, are grey.
        match (frame.color_type.samples(), samples.next(), samples.next()) {
            (3.., Some(green), Some(blue)) => luminance([first, green, blue]),
            _ => first,
        }
    };
    let whole = buffer.get(..frame.buffer_size()).unwrap_or_default();
    let found = whole.chunks_exact(size * frame.color_type.samples()).map(level).collect();
    Ok(Pixels { width, height, levels: found, are_coded: true })
}

fn exr(path: &Path, bytes: &[u8]) -> Result<Pixels> {
    let broken =
        |error: exr::error::Error| Error::input(path, None, error.to_string(), "save the picture as OpenEXR again");
    let reader = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = reader.from_buffered(Cursor::new(bytes)).map_err(broken)?;
    let layer = &image.layer_data;
    let (width, height) = (layer.size.width(), layer.size.height());
    check_sides(path, width, height)?;
    let channels = &layer.channel_data.list;
    let named = |name: &str| channels.iter().find(|channel| channel.name.eq_case_insensitive(name));
    let numbers = |channel: &exr::image::AnyChannel<exr::image::FlatSamples>| -> Vec<f64> {
        channel.sample_data.values_as_f32().map(f64::from).collect()
    };
    let levels = match (named("R"), named("G"), named("B"), named("Y"), channels.as_slice()) {
        (Some(red), Some(green), Some(blue), ..) => {
            let rest = numbers(green).into_iter().zip(numbers(blue));
            numbers(red).into_iter().zip(rest).map(|(r, (g, b))| luminance([r, g, b])).collect()
        }
        (.., Some(one), _) | (.., [one]) => numbers(one),
        _ => {
            let names = channels.iter().map(|channel| channel.name.to_string()).collect::<Vec<_>>().join(", ");
            let what = format!("its channels are {names}");
            return Err(Error::input(path, None, what, "give R, G and B, or Y, or one channel alone"));
        }
    };
    Ok(Pixels { width, height, levels, are_coded: false })
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{Image, SpecificChannels, WritableImage};

    const PATH: &str = "sky.png";
    const RATIOS: Levels = Levels::Radiances { white_w_m2_sr: None, are_relative: true };

    fn png_of(color: png::ColorType, width: u32, height: u32, data: &[u8], gamma: Option<f32>) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(color);
        encoder.set_depth(png::BitDepth::Eight);
        if let Some(gamma) = gamma {
            encoder.set_source_gamma(png::ScaledFloat::new(gamma));
        }
        encoder.write_header().and_then(|mut writer| writer.write_image_data(data)).expect("a PNG");
        bytes
    }

    fn level(bytes: &[u8], levels: Levels) -> Result<f32> {
        let image = read_image(Path::new(PATH), bytes, levels, 0.0)?;
        Ok(image.at(glam::DVec3::Z))
    }

    /// Grey 188 of a PNG is 0.5029 as sRGB, 0.7373 with a gAMA of 1 and as a cloud; pure green is
    /// 0.67; white is the stated radiance.
    #[test]
    fn levels_of_png_follow_srgb_or_gama() {
        let grey = png_of(png::ColorType::Grayscale, 1, 1, &[188], None);
        let is = |found: Result<f32>, expected: f32| assert!((found.expect("a level") - expected).abs() < 1e-4);
        is(level(&grey, RATIOS), 0.5029);
        is(level(&grey, Levels::Shares), 0.7373);
        is(level(&png_of(png::ColorType::Grayscale, 1, 1, &[188], Some(1.0)), RATIOS), 0.7373);
        is(level(&png_of(png::ColorType::Rgb, 1, 1, &[0, 255, 0], None), RATIOS), 0.67);
        is(level(&png_of(png::ColorType::Rgba, 1, 1, &[0, 255, 0, 9], None), RATIOS), 0.67);
        let white = Levels::Radiances { white_w_m2_sr: Some(40.0), are_relative: false };
        is(level(&png_of(png::ColorType::Grayscale, 1, 1, &[255], None), white), 40.0);
    }

    /// Radiances of an EXR file are its floats; NaN and a negative one are refused with the pixel
    /// named.
    #[test]
    fn levels_of_exr_are_its_floats() {
        let file = |level: f32| {
            let mut bytes = Cursor::new(Vec::new());
            let channels = SpecificChannels::rgb(move |_| (level, level, level));
            Image::from_channels((3, 3), channels).write().to_buffered(&mut bytes).expect("an EXR file");
            bytes.into_inner()
        };
        let given = Levels::Radiances { white_w_m2_sr: None, are_relative: false };
        assert!((level(&file(123.5), given).expect("a level") - 123.5).abs() < 1e-3);
        for (bad, shown) in [(f32::NAN, "is NaN"), (-1.0, "is -1")] {
            let text = level(&file(bad), given).expect_err(shown).to_string();
            assert!(text.contains("pixel 0, 0 from the top left") && text.contains(shown), "{text}");
        }
    }

    /// Six pictures are refused: not square, black, a PNG whose levels count as radiances, half a
    /// PNG, half an EXR file, a JPEG.
    #[test]
    fn unusable_pictures_are_refused() {
        let given = Levels::Radiances { white_w_m2_sr: None, are_relative: false };
        let wide = png_of(png::ColorType::Grayscale, 2, 1, &[9, 9], None);
        let grey = png_of(png::ColorType::Grayscale, 1, 1, &[9], None);
        let black = png_of(png::ColorType::Grayscale, 1, 1, &[0], None);
        for (bytes, levels, expected) in [
            (&wide[..], RATIOS, "2 x 1 pixels are not a square"),
            (&black, RATIOS, "the sky is black"),
            (&grey, given, "levels of a PNG are not radiances"),
            (&grey[..40], RATIOS, PATH),
            (EXR, RATIOS, PATH),
        ] {
            let text = level(bytes, levels).expect_err(expected).to_string();
            assert!(text.contains(expected), "{text}");
        }
        let text = is_picture(Path::new(PATH), b"\xff\xd8\xff\xe0").expect_err("a JPEG").to_string();
        assert!(text.contains("it is a JPEG"), "{text}");
    }
}
