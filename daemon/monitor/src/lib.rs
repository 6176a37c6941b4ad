//! Heartbeats, orders and formulas over what happens in a component, judged as it happens: each
//! event costs a fixed number of steps and no memory. Dates and names are others' concern:
//! `genom-runtime` judges what happens, `genom-formal` what may happen.

#![forbid(unsafe_code)]

mod ages;
mod beat;
mod happening;
mod judge;
mod literals;
mod needed;
mod order;
mod past;
mod place;
mod program;
mod sequence;
mod step;
mod steps;
mod value;

pub use ages::{Asked, Noted};
pub use beat::{Beat, OffBeat, Pulse};
pub use happening::{Happening, Hearers, Numbers};
pub use judge::Judge;
pub use order::{MOST_STEPS, NoOrder, Order};
pub use past::Bounds;
pub use place::Places;
pub use program::{MOST_PARTS, NoProgram, Part, Program};
pub use sequence::Sequence;
pub use steps::Letter;
