//! Plots of numbers in a terminal: which numbers a value has (`numbers`), what is kept of their
//! samples (`columns`), and the drawing (`draw`).

mod columns;
mod draw;
mod numbers;

pub use draw::{Curve, Plot, text};
pub use numbers::{number, numbers};
