//! Recordings that the daemon keeps, as handlers of the control plane: list, download, end, remove,
//! and which in ports a replay of one publishes to.
//!
//! What they work on is `genom_cells::kept`; the daemon itself begins a recording or a replay, since
//! only it reaches all its processes.

#![forbid(unsafe_code)]

mod chosen;
mod files;
mod refused;
mod under_way;

pub use chosen::choose;
#[doc(hidden)]
pub use files::{__path_file, __path_list, __path_remove};
pub use files::{file, list, remove};
pub use refused::{at_work, refused};
#[doc(hidden)]
pub use under_way::{__path_end, __path_stop_play};
pub use under_way::{PATIENCE, end, end_by_itself, stop_play};
