//! What a component can do in the time that its codels take.

mod clocks;
mod dates;
mod explore;
#[cfg(test)]
mod golden;
mod potential;
mod report;
mod respond;
mod seek;
mod slack;
mod table;
mod times;
mod zone;

pub(crate) use clocks::{Clock, begins, clocks, greatest, is_urgent};
pub(crate) use dates::dates;
pub use explore::{Overrun, Timed};
pub(crate) use potential::Potential;
pub use report::{Dated, Seen, TaskReport, TimedReport};
pub use respond::{Longest, Response};
pub(crate) use seek::seek;
pub use times::{Duration, Times};
