//! The types of %NAME%.gen: genomd compares them with it when it loads the library.

use genom::{Data, Exception};

/// What others read of the component.
#[derive(Clone, Copy, Data)]
#[genom(name = "::%NAME%::place")]
#[repr(C)]
pub(crate) struct Place {
    /// Metres.
    pub(crate) position: f64,
}

/// What the component remembers between two codels.
#[derive(Data)]
#[genom(name = "::%NAME%::ids")]
#[repr(C)]
pub(crate) struct Ids {
    /// Metres.
    pub(crate) position: f64,
    /// Metres per second.
    pub(crate) speed: f64,
}

/// The speed is not one that the axis can have.
#[derive(Clone, Copy, Exception)]
#[genom(name = "::%NAME%::e_out_of_range")]
#[repr(C)]
pub(crate) struct OutOfRange {
    pub(crate) greatest: f64,
}
