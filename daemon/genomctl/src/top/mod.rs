//! The live table: its data (`snapshot`) and its screen (`screen`).

mod screen;
mod snapshot;

pub(crate) use screen::run;
pub(crate) use snapshot::take;
