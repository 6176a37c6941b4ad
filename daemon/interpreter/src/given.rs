//! Codels of a script: functions with the C interface that an interpreter in this process made.

use std::any::Any;
use std::collections::HashMap;
use std::fmt;
use std::ops::Range;

/// What an interpreter has made of a script.
pub struct Given {
    /// Address of the C function of each codel, by its name in the description.
    pub functions: HashMap<String, usize>,
    /// Memory with the events that these functions return: strings that never change.
    pub events: Range<usize>,
    /// Dropped when nothing calls the functions any more.
    pub kept: Box<dyn Any + Send + Sync>,
}

impl Given {
    /// Address of the C function of a codel.
    #[must_use]
    pub fn function(&self, name: &str) -> Option<usize> {
        self.functions.get(name).copied()
    }

    /// Whether one of its events is there.
    #[must_use]
    pub fn has_event(&self, address: usize) -> bool {
        self.events.contains(&address)
    }
}

impl fmt::Debug for Given {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Given").field("functions", &self.functions).finish_non_exhaustive()
    }
}
