//! The types of `images.idl`, for components in Rust.

#![forbid(unsafe_code)]

use genom::{BoundedSequence, BoundedString, Data};

/// Bytes of the largest image: 640 x 480, one byte per pixel.
pub const BYTES: usize = 307_200;

/// The only encoding of these components: one byte per pixel.
const MONO8: &str = "mono8";

/// A date of the camera's clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Data)]
#[genom(name = "::images::time")]
#[repr(C)]
pub struct Time {
    /// Whole seconds.
    pub sec: i32,
    /// The rest.
    pub nanosec: u32,
}

impl Time {
    /// In seconds.
    #[must_use]
    pub fn seconds(self) -> f64 {
        f64::from(self.sec) + f64::from(self.nanosec) * 1e-9
    }
}

/// An image, row by row.
#[derive(Data)]
#[genom(name = "::images::frame")]
#[repr(C)]
pub struct Frame {
    /// When it was taken.
    pub stamp: Time,
    /// The lens that saw it.
    pub frame_id: BoundedString<32>,
    /// Rows.
    pub height: u32,
    /// Pixels per row.
    pub width: u32,
    /// Content of a pixel.
    pub encoding: BoundedString<16>,
    /// Order of the bytes of a pixel.
    pub is_bigendian: u8,
    /// Bytes per row.
    pub step: u32,
    /// All rows.
    pub data: BoundedSequence<u8, BYTES>,
}

impl Frame {
    /// Whether each pixel is one byte.
    #[must_use]
    pub fn is_mono8(&self) -> bool {
        self.encoding.as_bytes() == MONO8.as_bytes()
    }

    /// The pixels of an image of one byte per pixel; `None` if there are not as many as its width
    /// and height say.
    #[must_use]
    pub fn pixels(&self) -> Option<&[u8]> {
        let wanted = self.width as usize * self.height as usize;
        (self.data.len() == wanted && self.step == self.width).then_some(&self.data[..])
    }

    /// Makes it an image of one byte per pixel that shows what `lens` saw at `stamp`.
    ///
    /// # Errors
    /// The number of pixels, if it is not width times height or more than [`BYTES`]; nothing was
    /// changed.
    pub fn set(
        &mut self,
        stamp: Time,
        lens: &str,
        (width, height): (u32, u32),
        pixels: &[u8],
    ) -> Result<(), usize> {
        if pixels.len() != width as usize * height as usize {
            return Err(pixels.len());
        }
        self.data.resize(pixels.len(), 0)?;
        self.data.copy_from_slice(pixels);
        self.stamp = stamp;
        self.frame_id.set(lens);
        self.encoding.set(MONO8);
        (self.width, self.height, self.step) = (width, height, width);
        self.is_bigendian = 0;
        Ok(())
    }
}

/// A lens with radial distortion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Data)]
#[genom(name = "::images::lens")]
#[repr(C)]
pub struct Lens {
    /// Focal length, px.
    pub focal: f64,
    /// The centre, px.
    pub cx: f64,
    /// The centre, px.
    pub cy: f64,
    /// Coefficient of r².
    pub k1: f64,
    /// Coefficient of r⁴.
    pub k2: f64,
}

/// Two lenses side by side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Data)]
#[genom(name = "::images::rig")]
#[repr(C)]
pub struct Rig {
    /// Rows of the images.
    pub height: u32,
    /// Pixels per row.
    pub width: u32,
    /// The left lens.
    pub left: Lens,
    /// The right lens.
    pub right: Lens,
    /// From the left lens to the right one, m.
    pub baseline: f64,
}
