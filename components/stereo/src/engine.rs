//! What is kept between two pairs of images: maps, buffers, and the date of the last pair.

use genom::NativeType;
use images::{Rig, Time};

use crate::matching::Matcher;
use crate::rectify::Rectifier;

/// The pixels of two images, row by row.
pub(crate) struct Pair<'p> {
    pub(crate) left: &'p [u8],
    pub(crate) right: &'p [u8],
}

/// What was computed of a pair.
pub(crate) struct Seen<'e> {
    pub(crate) rectified: &'e [u8],
    pub(crate) disparity: &'e [u8],
}

/// Compares the images of one rig.
#[derive(NativeType)]
#[genom(name = "::stereo::engine")]
pub(crate) struct Engine {
    rig: Rig,
    left: Rectifier,
    right: Rectifier,
    matcher: Matcher,
    last: Option<Time>,
}

impl Engine {
    /// Both images become those of the pinhole that the left lens would be without distortion:
    /// then what both lenses see is in the same row.
    pub(crate) fn new(rig: &Rig) -> Self {
        let size = (rig.width, rig.height);
        Self {
            rig: *rig,
            left: Rectifier::new(size, &rig.left, &rig.left),
            right: Rectifier::new(size, &rig.left, &rig.right),
            matcher: Matcher::new(size),
            last: None,
        }
    }

    pub(crate) fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Date of the last pair.
    pub(crate) fn last(&self) -> Option<Time> {
        self.last
    }

    /// Compares the images of a pair, each of the size of the rig.
    pub(crate) fn compare(&mut self, stamp: Time, pair: &Pair<'_>, block: u32) -> Seen<'_> {
        self.last = Some(stamp);
        let left = self.left.rectify(pair.left);
        let right = self.right.rectify(pair.right);
        let disparity = self.matcher.compare(left.as_raw(), right.as_raw(), block);
        Seen { rectified: left.as_raw(), disparity }
    }
}
