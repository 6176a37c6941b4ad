//! The types of the `.gen` file.

use genom::{Bool, BoundedString, Data, Exception};

/// Position (m) and speed (m/s) of the axis.
#[derive(Clone, Copy, Data)]
#[genom(name = "::demo::state")]
#[repr(C)]
pub(crate) struct State {
    pub(crate) position: f64,
    pub(crate) velocity: f64,
}

/// Factor applied to the speed; 0 stops the axis.
pub(crate) type Gain = f64;

/// The internal data structure.
#[derive(Data)]
#[genom(name = "::demo::ids")]
#[repr(C)]
pub(crate) struct Ids {
    /// Maximum speed, m/s.
    pub(crate) velocity: f64,
    pub(crate) current: State,
    /// Whether an emergency happened during the current motion.
    pub(crate) halted: Bool,
}

/// The request is outside the limits of the axis.
#[derive(Clone, Copy, Exception)]
#[genom(name = "::demo::OUT_OF_RANGE")]
#[repr(C)]
pub(crate) struct OutOfRange {
    pub(crate) value: f64,
    pub(crate) lower: f64,
    pub(crate) upper: f64,
    pub(crate) what: BoundedString<64>,
}

/// The axis is moving.
#[derive(Clone, Copy, Exception)]
#[genom(name = "::demo::MOVING")]
pub(crate) struct Moving;

/// The axis was stopped by an emergency.
#[derive(Clone, Copy, Exception)]
#[genom(name = "::demo::HALTED")]
pub(crate) struct Halted;
