//! The types of the `.gen` file.

use genom::{Bool, BoundedString, Data, Exception};

/// Where the axis is (m), and how fast it moves (m/s).
#[derive(Clone, Copy, Data)]
#[genom(name = "::demo::state")]
#[repr(C)]
pub(crate) struct State {
    pub(crate) position: f64,
    pub(crate) velocity: f64,
}

/// Factor applied to the speed, 0 to stand still.
pub(crate) type Gain = f64;

/// The IDS.
#[derive(Data)]
#[genom(name = "::demo::ids")]
#[repr(C)]
pub(crate) struct Ids {
    /// Greatest speed, m/s.
    pub(crate) velocity: f64,
    pub(crate) current: State,
    /// An emergency happened during the current motion.
    pub(crate) halted: Bool,
}

/// A request that the axis cannot follow.
#[derive(Clone, Copy, Exception)]
#[genom(name = "::demo::OUT_OF_RANGE")]
#[repr(C)]
pub(crate) struct OutOfRange {
    pub(crate) value: f64,
    pub(crate) lower: f64,
    pub(crate) upper: f64,
    pub(crate) what: BoundedString<64>,
}

/// The axis moves.
#[derive(Clone, Copy, Exception)]
#[genom(name = "::demo::MOVING")]
pub(crate) struct Moving;

/// The axis was stopped by an emergency.
#[derive(Clone, Copy, Exception)]
#[genom(name = "::demo::HALTED")]
pub(crate) struct Halted;
