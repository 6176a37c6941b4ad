//! The live table: what it shows (`snapshot`), how it is drawn (`draw`), and its screen
//! (`screen`).

mod draw;
mod screen;
mod snapshot;

pub(crate) use draw::text;
pub(crate) use screen::run;
pub(crate) use snapshot::Snapshot;
