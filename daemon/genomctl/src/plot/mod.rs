//! Plots of numbers of ports in a terminal: which numbers (`chosen`), their samples (`samples`, with
//! the types that `types` reads), what is kept of them (`columns`), and the drawing (`draw`).

mod chosen;
mod columns;
mod draw;
mod samples;
mod screen;
mod types;

pub(crate) use chosen::choose;
pub(crate) use draw::text;
pub(crate) use samples::Samples;
pub(crate) use screen::run;
