//! Plots of numbers of ports in a terminal: which numbers (`chosen`), their samples (`samples`, with
//! the types that `types` reads), and the screen.

mod chosen;
mod samples;
mod screen;
mod types;

pub(crate) use chosen::choose;
pub(crate) use samples::Samples;
pub(crate) use screen::run;
