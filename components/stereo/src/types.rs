//! The types of `stereo.gen`.

use genom::{BoundedString, Data, Exception, Native};

use crate::engine::Engine;

/// The internal data structure.
#[derive(Data)]
#[genom(name = "::stereo::ids")]
#[repr(C)]
pub(crate) struct Ids {
    pub(crate) engine: Native<Engine>,
    /// Side of the blocks that are compared, px.
    pub(crate) block: u32,
}

/// The size of an image is not that of the calibration, or not that of its data.
#[derive(Clone, Copy, Exception)]
#[genom(name = "::stereo::BAD_SIZE")]
#[repr(C)]
pub(crate) struct BadSize {
    port: BoundedString<16>,
    width: u32,
    height: u32,
    bytes: u32,
    expected_width: u32,
    expected_height: u32,
}

impl BadSize {
    pub(crate) fn new(
        port: &str,
        (width, height): (u32, u32),
        bytes: usize,
        (expected_width, expected_height): (u32, u32),
    ) -> Self {
        let bytes = u32::try_from(bytes).unwrap_or(u32::MAX);
        let port = BoundedString::new(port);
        Self { port, width, height, bytes, expected_width, expected_height }
    }
}

/// The pixels of an image are not grey values of one byte.
#[derive(Clone, Copy, Exception)]
#[genom(name = "::stereo::BAD_ENCODING")]
#[repr(C)]
pub(crate) struct BadEncoding {
    port: BoundedString<16>,
    encoding: BoundedString<16>,
}

impl BadEncoding {
    pub(crate) fn new(port: &str, encoding: BoundedString<16>) -> Self {
        Self { port: BoundedString::new(port), encoding }
    }
}

/// There is no such block.
#[derive(Clone, Copy, Exception)]
#[genom(name = "::stereo::BAD_BLOCK")]
#[repr(C)]
pub(crate) struct BadBlock {
    pub(crate) side: u32,
}
