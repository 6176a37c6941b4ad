//! The types of `viewer.gen` that leave the component.

use std::fmt::Display;
use std::path::Path;

use genom::{BoundedString, Data, Exception};
use images::Time;

/// What arrived since `watch` began.
#[derive(Clone, Copy, Debug, Default, PartialEq, Data)]
#[genom(name = "::viewer::summary")]
#[repr(C)]
pub(crate) struct Summary {
    /// Disparity images.
    pub(crate) images: u32,
    /// Of them per second of the camera's clock.
    pub(crate) rate: f64,
    /// Mean of the last one where it is known, px.
    pub(crate) disparity: f64,
    /// Part of its pixels where it is known.
    pub(crate) known: f64,
    /// Dates of the last images.
    pub(crate) last: Dates,
}

/// A date for each port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Data)]
#[genom(name = "::viewer::summary::dates")]
#[repr(C)]
pub(crate) struct Dates {
    pub(crate) left: Time,
    pub(crate) rectified: Time,
    pub(crate) disparity: Time,
}

/// A file or directory cannot be written.
#[derive(Clone, Copy, Exception)]
#[genom(name = "::viewer::CANNOT_WRITE")]
#[repr(C)]
pub(crate) struct CannotWrite {
    path: BoundedString<256>,
    why: BoundedString<128>,
}

impl CannotWrite {
    pub(crate) fn new(path: &Path, why: &impl Display) -> Self {
        Self {
            path: BoundedString::new(&path.display().to_string()),
            why: BoundedString::new(&why.to_string()),
        }
    }
}
