//! The live table: its data (`snapshot`), its layout (`draw`), and its screen (`screen`).

mod draw;
mod screen;
mod snapshot;
mod trend;

pub(crate) use draw::text;
pub(crate) use screen::run;
pub(crate) use snapshot::Snapshot;
