//! Events: the values that state-machine codels return.

use std::ffi::CStr;
use std::fmt;

/// An event, identified by its full name, such as `::demo::pause::main`.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Event(&'static CStr);

impl Event {
    /// The event of this full name. [`event!`](crate::event) is more convenient.
    #[must_use]
    pub const fn new(name: &'static CStr) -> Self {
        Self(name)
    }

    /// Its full name.
    #[must_use]
    pub const fn name(self) -> &'static CStr {
        self.0
    }
}

impl fmt::Debug for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.to_string_lossy())
    }
}

/// The [`Event`] of a full name, as a constant. With `pause::` before the name of the state, the
/// next codel runs at the next tick of the task.
///
/// ```
/// use genom::{Event, event};
///
/// const AGAIN: Event = event!("::demo::pause::main");
/// assert_eq!(AGAIN.name(), c"::demo::pause::main");
/// ```
#[macro_export]
macro_rules! event {
    ($name:literal) => {
        const { $crate::Event::new($crate::rt::c_str(concat!($name, "\0"))) }
    };
}
