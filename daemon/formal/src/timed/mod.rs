//! What a component can do in the time that its codels take.

mod clocks;
mod dates;
mod explore;
mod follow;
#[cfg(test)]
#[path = "../../tests/unit/golden.rs"]
mod golden;
mod potential;
#[cfg(test)]
#[path = "../../tests/unit/potential.rs"]
mod potential_tests;
mod report;
mod respond;
mod scenes;
mod seek;
mod slack;
mod spent;
mod still;
mod table;
mod times;
mod unit;
mod walks;
#[cfg(test)]
#[path = "../../tests/unit/walks.rs"]
mod walks_tests;

pub(crate) use clocks::{
    Clock, begins, bound, clocks, greatest, guarded, initial, is_urgent, stepped,
};
pub(crate) use dates::{dates, dates_of};
pub use explore::{Overrun, Timed};
pub(crate) use follow::{Follow, Over, accepts, after_into, forget, number, over, running};
pub(crate) use potential::Potential;
pub use report::{Dated, Seen, TaskReport, TimedReport};
pub use respond::{Longest, Response};
pub(crate) use seek::{Steps, seek};
pub use spent::Spent;
pub(crate) use table::Table;
pub use times::{Duration, Times};
pub(crate) use walks::walks;
