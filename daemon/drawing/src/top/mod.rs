//! The table of what goes on: its data (`snapshot`), the rates that ports had lately (`trend`), and
//! its layout (`draw`).

mod draw;
mod snapshot;
mod trend;

pub use draw::{draw, text};
pub use snapshot::{Data, Seen, Snapshot};
pub use trend::Trends;
