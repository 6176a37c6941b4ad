//! Images as PNG files. A file is replaced as a whole, so that nobody reads half of one.

use std::ffi::OsString;
use std::fs::File;
use std::io::{BufWriter, Error, Result, Write as _};
use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::imageops::{self, FilterType as Sampling};
use image::{ExtendedColorType, GrayImage, ImageEncoder as _, Luma, Rgb, RgbImage};
use images::Frame;

/// Gap between the images of a sheet, px.
const GAP: u32 = 4;
/// The greatest disparity that gets a colour of its own, in quarters of a pixel.
const NEAREST: f32 = 200.0;

/// Writes a grey image.
///
/// # Errors
/// The frame is no grey image, or the file cannot be written.
pub(crate) fn write(frame: &Frame, file: &Path) -> Result<()> {
    let pixels = pixels(frame)?;
    encode(file, pixels, (frame.width, frame.height), ExtendedColorType::L8, CompressionType::Fast)
}

/// Writes images side by side at half their size, and the disparities beside them in colours.
///
/// # Errors
/// One is no grey image, or the file cannot be written.
pub(crate) fn write_sheet(images: [&Frame; 2], disparity: &Frame, file: &Path) -> Result<()> {
    let mut parts = Vec::new();
    for image in images {
        let small = half(image, Sampling::Triangle)?;
        parts.push(coloured(&small, |Luma([grey])| Rgb([grey; 3])));
    }
    // Disparities are not averaged: between near and far there is nothing.
    parts.push(coloured(&half(disparity, Sampling::Nearest)?, colour));
    let height = parts.iter().map(RgbImage::height).max().unwrap_or_default();
    let width = parts.iter().map(|part| part.width() + GAP).sum::<u32>() - GAP;
    let mut sheet = RgbImage::from_pixel(width, height, Rgb([255; 3]));
    let mut left = 0;
    for part in &parts {
        imageops::replace(&mut sheet, part, left, 0);
        left += i64::from(part.width() + GAP);
    }
    encode(file, &sheet, (width, height), ExtendedColorType::Rgb8, CompressionType::Best)
}

fn half(frame: &Frame, sampling: Sampling) -> Result<GrayImage> {
    let image = GrayImage::from_raw(frame.width, frame.height, pixels(frame)?.to_owned());
    let image = image.ok_or_else(not_grey)?;
    Ok(imageops::resize(&image, frame.width.div_ceil(2), frame.height.div_ceil(2), sampling))
}

fn not_grey() -> Error {
    Error::other("an image has no grey values, or not as many as its size says")
}

fn pixels(frame: &Frame) -> Result<&[u8]> {
    let pixels = frame.pixels().filter(|pixels| frame.is_mono8() && !pixels.is_empty());
    pixels.ok_or_else(not_grey)
}

fn coloured(image: &GrayImage, colour: impl Fn(Luma<u8>) -> Rgb<u8>) -> RgbImage {
    RgbImage::from_fn(image.width(), image.height(), |u, v| colour(*image.get_pixel(u, v)))
}

/// Blue for what is far, over green to red for what is near, black for what is unknown.
fn colour(Luma([disparity]): Luma<u8>) -> Rgb<u8> {
    if disparity == 0 {
        return Rgb([0; 3]);
    }
    let near = (f32::from(disparity) / NEAREST).min(1.0);
    // Each colour is a bump around its place.
    let bump = |place: f32| (255.0 * (1.5 - 4.0 * (near - place).abs()).clamp(0.0, 1.0)) as u8;
    Rgb([bump(0.75), bump(0.5), bump(0.25)])
}

fn encode(
    file: &Path,
    pixels: &[u8],
    (width, height): (u32, u32),
    colours: ExtendedColorType,
    compression: CompressionType,
) -> Result<()> {
    let mut fresh = OsString::from(file);
    fresh.push(".part");
    let mut to = BufWriter::new(File::create(&fresh)?);
    PngEncoder::new_with_quality(&mut to, compression, FilterType::Adaptive)
        .write_image(pixels, width, height, colours)
        .map_err(Error::other)?;
    to.flush()?;
    std::fs::rename(&fresh, file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_is_red_far_is_blue_and_unknown_is_black() {
        assert_eq!(colour(Luma([0])), Rgb([0; 3]));
        let Rgb([red, _, blue]) = colour(Luma([180]));
        assert!(red > 200 && blue < 50, "{red} {blue}");
        let Rgb([red, _, blue]) = colour(Luma([50]));
        assert!(blue > 200 && red < 50, "{red} {blue}");
    }
}
