//! The steps that encode and decode a type, as data; `plan` makes them.

use crate::ix::Ix;

/// Steps of one type, in wire order.
pub(crate) struct CdrPlan {
    pub(crate) steps: Vec<Step>,
}

/// One step: align the wire, then do what `what` says with the memory at `offset`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// Offset from the start of the value in memory.
    pub(crate) offset: usize,
    /// Alignment relative to the start of the payload; 1 when the position is known to be aligned.
    pub(crate) align: usize,
    pub(crate) what: What,
    /// The type, for error messages.
    pub(crate) ix: Ix,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum What {
    /// `bytes` bytes that are equal in memory and on the wire; in the other byte order, units of
    /// `unit` bytes are reversed.
    Copy {
        bytes: usize,
        unit: usize,
    },
    Booleans {
        count: usize,
    },
    Enums {
        count: usize,
        limit: u32,
    },
    Text {
        bound: Option<usize>,
    },
    Sequence {
        element: Ix,
        bound: Option<usize>,
        run: Option<Run>,
    },
    /// An array whose elements have plans of their own.
    Repeat {
        element: Ix,
        count: usize,
    },
    /// `value`: offset of the value from the start of the optional.
    Optional {
        element: Ix,
        value: usize,
    },
    Union,
    Native,
}

/// Elements of a sequence that one step handles all at once.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Run {
    /// As [`What::Copy`], aligned.
    Copy {
        align: usize,
        unit: usize,
    },
    Booleans,
    Enums {
        limit: u32,
    },
}

impl CdrPlan {
    /// Whether any bytes of sufficient number are a valid value.
    pub(crate) fn is_plain(&self) -> bool {
        self.steps.iter().all(|step| matches!(step.what, What::Copy { .. }))
    }
}
