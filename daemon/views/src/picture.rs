//! Pixels of values that have the members of a ROS 2 `sensor_msgs/Image` or `CompressedImage`,
//! whatever their type is called.

use genom_types::{DataType, Record};

/// Most pixels of an image, and most bytes of a compressed one: greater ones are not shown.
const PIXELS: u64 = 1 << 26;
const COMPRESSED: usize = 8 << 20;

/// Whether values of this type are images.
pub(crate) fn is_image(ty: &DataType) -> bool {
    let has = |members: &[&str]| members.iter().all(|name| ty.member_index(name).is_some());
    has(&["height", "width", "encoding", "step", "data"]) || has(&["format", "data"])
}

/// An image as browsers take it.
#[derive(Debug, PartialEq)]
pub(crate) enum Picture {
    /// Red, green and blue of each pixel, row by row.
    Pixels {
        width: u32,
        height: u32,
        /// Size as it was published.
        whole: (u32, u32),
        rgb: Vec<u8>,
    },
    /// A JPEG or PNG as it was published.
    Compressed { media: &'static str, bytes: Vec<u8> },
}

/// Why a value is not shown.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum NoPicture {
    #[error("its type is no image: it has the members of neither Image nor CompressedImage")]
    Type,
    #[error("`{0}` is no encoding that is shown: rgb8, bgr8, rgba8, bgra8, mono8 and mono16 are")]
    Encoding(String),
    #[error("`{0}` is no format that is shown: jpeg and png are")]
    Format(String),
    #[error("{width} × {height} pixels of {step} bytes a row are not {bytes} bytes")]
    Size { width: u64, height: u64, step: u64, bytes: usize },
    #[error("it is too large to be shown")]
    Large,
}

/// How the bytes of a pixel lie.
#[derive(Clone, Copy, Debug)]
struct Layout {
    /// Bytes of a pixel.
    size: usize,
    /// Places of red, green and blue.
    at: [usize; 3],
}

fn layout(encoding: &str, big_endian: bool) -> Option<Layout> {
    let (size, at) = match encoding {
        "rgb8" => (3, [0, 1, 2]),
        "bgr8" => (3, [2, 1, 0]),
        "rgba8" => (4, [0, 1, 2]),
        "bgra8" => (4, [2, 1, 0]),
        "mono8" | "8UC1" => (1, [0; 3]),
        // The more significant byte.
        "mono16" | "16UC1" => (2, [usize::from(!big_endian); 3]),
        _ => return None,
    };
    Some(Layout { size, at })
}

/// The image that a value is, at most `widest` pixels wide.
pub(crate) fn picture(value: &Record, widest: u32) -> Result<Picture, NoPicture> {
    let text = |member| value.text(member).map(|text| String::from_utf8_lossy(text).into_owned());
    let Some(data) = value.octets("data") else { return Err(NoPicture::Type) };
    let Some(encoding) = text("encoding") else {
        return match text("format") {
            Some(format) => compressed(&format, data),
            None => Err(NoPicture::Type),
        };
    };
    let number = |member| value.unsigned(member).ok_or(NoPicture::Type);
    let (width, height, step) = (number("width")?, number("height")?, number("step")?);
    let big_endian = value.unsigned("is_bigendian").unwrap_or_default() != 0;
    let Some(layout) = layout(&encoding, big_endian) else {
        return Err(NoPicture::Encoding(shortened(encoding)));
    };
    let bytes = data.len();
    let wrong = NoPicture::Size { width, height, step, bytes };
    if width.checked_mul(height).is_none_or(|pixels| pixels > PIXELS) {
        return Err(NoPicture::Large);
    }
    let fits = step >= width.saturating_mul(layout.size as u64)
        && step.checked_mul(height).is_some_and(|needed| needed <= bytes as u64);
    let small = |number: u64| u32::try_from(number).ok();
    match (small(width), small(height), usize::try_from(step)) {
        (Some(width), Some(height), Ok(step)) if fits => {
            Ok(smaller(data, layout, step, (width, height), widest))
        }
        _ => Err(wrong),
    }
}

fn compressed(format: &str, data: &[u8]) -> Result<Picture, NoPicture> {
    // What it is, and not what it is said to be: `jpeg`, `rgb8; jpeg compressed bgr8`.
    let media = if data.starts_with(&[0xFF, 0xD8, 0xFF]) {
        "image/jpeg"
    } else if data.starts_with(b"\x89PNG\r\n\x1a\n") {
        "image/png"
    } else {
        return Err(NoPicture::Format(shortened(format.to_owned())));
    };
    if data.len() > COMPRESSED {
        return Err(NoPicture::Large);
    }
    Ok(Picture::Compressed { media, bytes: data.to_vec() })
}

fn shortened(text: String) -> String {
    if text.chars().count() > 40 { text.chars().take(40).chain(['…']).collect() } else { text }
}

/// Makes an image smaller by a whole factor: each pixel is the mean of those that it stands for.
fn smaller(
    data: &[u8],
    Layout { size, at }: Layout,
    step: usize,
    whole: (u32, u32),
    widest: u32,
) -> Picture {
    let factor = whole.0.div_ceil(widest.max(1)).max(1);
    let (width, height) = (whole.0.div_ceil(factor), whole.1.div_ceil(factor));
    let (columns, rows, factor) = (whole.0 as usize, whole.1 as usize, factor as usize);
    let mut rgb = Vec::with_capacity(3 * width as usize * height as usize);
    let mut sums = vec![[0_u64; 3]; width as usize];
    for top in (0..rows).step_by(factor) {
        sums.fill([0; 3]);
        let bottom = (top + factor).min(rows);
        for row in top..bottom {
            let Some(line) = data.get(row * step..row * step + columns * size) else { continue };
            for (sum, pixels) in sums.iter_mut().zip(line.chunks(size * factor)) {
                for pixel in pixels.chunks_exact(size) {
                    for (sum, place) in sum.iter_mut().zip(at) {
                        *sum += u64::from(pixel[place]);
                    }
                }
            }
        }
        for (left, sum) in (0..columns).step_by(factor).zip(&sums) {
            let right = (left + factor).min(columns);
            let count = ((bottom - top) * (right - left)) as u64;
            // The mean of bytes is one.
            rgb.extend(sum.iter().map(|sum| u8::try_from(sum / count).unwrap_or(u8::MAX)));
        }
    }
    Picture::Pixels { width, height, whole, rgb }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use genom_types::{Kind, Member, ScopedName, TypeTable};
    use serde_json::{Value, json};

    use super::*;

    fn value(names: &[(&str, &str)], json: &Value) -> Record {
        let mut table = TypeTable::default();
        let octet = table.add(Kind::Octet);
        let mut members = Vec::new();
        for (name, kind) in names {
            let ty = match *kind {
                "bytes" => table.add(Kind::Sequence { element: octet, bound: None }),
                "text" => table.add(Kind::String { bound: None }),
                _ => table.add(Kind::UnsignedLong),
            };
            members.push(Member { name: (*name).into(), ty });
        }
        let id = table.add(Kind::Struct { name: ScopedName::new(["image"]), members });
        let ty = DataType::new(&Arc::new(table), id).unwrap();
        let mut value = Record::new(&ty);
        value.merge_json(json).unwrap();
        value
    }

    fn image(encoding: &str, width: u32, height: u32, step: u32, data: &[u8]) -> Record {
        let names = [
            ("height", ""),
            ("width", ""),
            ("encoding", "text"),
            ("is_bigendian", ""),
            ("step", ""),
            ("data", "bytes"),
        ];
        value(
            &names,
            &json!({
                "height": height, "width": width, "encoding": encoding, "step": step, "data": data,
            }),
        )
    }

    fn pixels(of: &Record, widest: u32) -> (u32, u32, Vec<u8>) {
        match picture(of, widest).unwrap() {
            Picture::Pixels { width, height, rgb, .. } => (width, height, rgb),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn each_encoding_becomes_red_green_and_blue() {
        assert!(is_image(image("mono8", 0, 0, 0, &[]).ty()));
        let shown = |encoding, step, data: &[u8]| pixels(&image(encoding, 1, 2, step, data), 640).2;
        assert_eq!(shown("rgb8", 3, &[1, 2, 3, 4, 5, 6]), [1, 2, 3, 4, 5, 6]);
        // Rows may be longer than their pixels.
        assert_eq!(shown("bgr8", 4, &[1, 2, 3, 0, 4, 5, 6, 0]), [3, 2, 1, 6, 5, 4]);
        assert_eq!(shown("bgra8", 4, &[1, 2, 3, 9, 4, 5, 6, 9]), [3, 2, 1, 6, 5, 4]);
        assert_eq!(shown("mono8", 1, &[7, 8]), [7, 7, 7, 8, 8, 8]);
        assert_eq!(shown("mono16", 2, &[1, 7, 2, 8]), [7, 7, 7, 8, 8, 8]);
    }

    #[test]
    fn a_large_image_is_made_smaller_by_means() {
        let data = [10, 30, 50, 20, 40, 60, 100, 100, 100];
        assert_eq!(pixels(&image("mono8", 3, 3, 3, &data), 3).0, 3);
        let (width, height, rgb) = pixels(&image("mono8", 3, 3, 3, &data), 2);
        assert_eq!((width, height), (2, 2));
        // Pixels at the edges are means of fewer.
        assert_eq!(rgb, [25, 55, 100, 100].iter().flat_map(|grey| [*grey; 3]).collect::<Vec<u8>>());
        assert_eq!(pixels(&image("mono8", 3, 3, 3, &data), 1), (1, 1, vec![56; 3]));
    }

    #[test]
    fn sizes_that_are_not_true_are_refused() {
        let of = |width, height, step, data: &[u8]| {
            picture(&image("rgb8", width, height, step, data), 640).unwrap_err()
        };
        assert!(matches!(of(2, 2, 6, &[0; 11]), NoPicture::Size { .. }));
        assert!(matches!(of(2, 2, 5, &[0; 12]), NoPicture::Size { .. }));
        assert!(matches!(of(2, 2, u32::MAX, &[0; 12]), NoPicture::Size { .. }));
        assert_eq!(of(u32::MAX, u32::MAX, 0, &[]), NoPicture::Large);
        let odd = picture(&image("bayer_rggb8", 0, 0, 0, &[]), 640).unwrap_err();
        assert!(matches!(odd, NoPicture::Encoding(_)), "{odd}");
        assert_eq!(pixels(&image("rgb8", 0, 0, 0, &[]), 640), (0, 0, vec![]));
    }

    #[test]
    fn a_compressed_image_is_what_its_bytes_say() {
        let of = |format: &str, data: &[u8]| {
            let names = [("format", "text"), ("data", "bytes")];
            picture(&value(&names, &json!({"format": format, "data": data})), 640)
        };
        let jpeg = [0xFF, 0xD8, 0xFF, 0xE0];
        let shown = of("rgb8; jpeg compressed bgr8", &jpeg).unwrap();
        assert_eq!(shown, Picture::Compressed { media: "image/jpeg", bytes: jpeg.to_vec() });
        assert!(matches!(of("jpeg", b"<svg/>"), Err(NoPicture::Format(_))));
        let none = value(&[("data", "bytes")], &json!({}));
        assert_eq!(picture(&none, 640), Err(NoPicture::Type));
        assert!(!is_image(none.ty()));
    }
}
