//! Plays a run of a component on the real runtime without its library: codels take the time that a
//! script says, on a clock that the script moves, and yield what it says.
//!
//! A [`Script`] says at which date which thread goes on. The threads are those of the runtime, with
//! its exclusion, its passes and its ticks; a [`Theatre`] lets them go on one after another, so that a
//! script has the same effect each time. What the script says must be possible: if a task is not where
//! the script has it go on, the run ends there, and says so.

#![forbid(unsafe_code)]

mod body;
mod error;
mod play;
mod script;
mod theatre;

pub use error::NotPlayed;
pub use play::{Component, play};
pub use script::{Move, Script, Step};
