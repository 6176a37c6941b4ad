//! What a component can do in the time that its codels take.

mod clocks;
mod dates;
mod explore;
mod report;
mod slack;
mod times;
mod walk;
mod zone;

pub(crate) use clocks::{Clock, begins, clocks, greatest, is_urgent};
pub(crate) use dates::dates;
pub use explore::{Overrun, Timed};
pub use report::{Dated, TaskReport, TimedReport};
pub use times::{Duration, Times};
pub(crate) use walk::walk;
