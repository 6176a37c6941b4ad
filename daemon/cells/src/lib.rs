//! Cells: child processes of a daemon that run components, so that a codel that crashes takes
//! nothing down but its own cell.
//!
//! A cell is the same program as the daemon, with a control plane of its own on a private socket
//! and its ports on shared memory: samples go from cell to cell without passing the daemon. The
//! daemon at the front starts cells ([`Cells`]), passes requests on to them ([`Cell::forward`]),
//! joins their lists with its own ([`merge`]) and restarts them when they end ([`policy`]).
//!
//! Each cell writes down what it is to hold in a journal ([`journal`]), which its next process
//! reads. A daemon that takes the place of a dead one finds the cells in their directory
//! ([`place`]) and goes on with them: what they run is not interrupted.

#![forbid(unsafe_code)]

mod asking;
mod bell;
mod blackbox;
mod cell;
mod cells;
mod client;
mod crashes;
mod deploy;
mod diagnosed;
mod done;
mod dying;
mod end;
mod ends;
mod follow;
mod gateway;
pub mod journal;
pub mod kept;
pub mod merge;
mod over;
pub mod own;
pub mod place;
pub mod policy;
mod process;
mod program;
mod react;
pub mod record;
mod remains;
mod round;
mod setup;
mod shelf;
mod snapshots;
mod stat;
mod thaw;
mod theirs;
mod unload;
mod unmatched;
mod wants;
mod wire;

pub use blackbox::{BlackBoxes, Lease, SaveError};
pub use cell::{Cell, Down};
pub use cells::{Cells, OpenError};
pub use client::AskError;
pub use crashes::{Reports, StoreError, read_symbols};
pub use deploy::DeployError;
pub use done::Doing;
pub use kept::{Kept, KeptError};
pub use own::OwnCell;
pub use program::{in_runner, isolate_scripts, lacks_package};
pub use react::{Rules, react};
pub use setup::{Cause, Failure, Setup, Told};
pub use thaw::{FreezeError, ThawError};
pub use wants::Asked;
