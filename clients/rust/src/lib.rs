//! A daemon as a part of a program: a simulator, a plugin of one, a test. The program steps its clock,
//! and shares the memory of ports with it.
//!
//! ```no_run
//! use std::time::Duration;
//!
//! use genom_client::{Daemon, In, Options, Out};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut daemon = Daemon::start(&Options::new().argument("arm.so"))?;
//! let mut goal = In::open(&mut daemon, "arm/goal")?;
//! let torque = Out::open(&mut daemon, "arm/torque")?;
//! for _ in 0..1000 {
//!     *goal.value_mut::<f64>()? = 0.5;
//!     goal.write()?;
//!     daemon.step(Duration::from_millis(1))?;
//!     println!("{}", torque.value::<f64>(&daemon)?);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! Of a struct in a description, the value is a `#[repr(C)]` struct with the same members in the same
//! order: `genomctl header FILE.gen` prints it for C. Everything else that can be asked of a daemon goes
//! over its control plane, at [`Daemon::socket`]: `genomctl --socket SOCKET call arm track`.

mod daemon;
mod door;
mod ended;
mod error;
mod memory;
mod options;
mod port;
mod shared;

pub use daemon::Daemon;
pub use ended::Ended;
pub use error::{AskError, OpenError, PortError, StartError};
pub use genom_protocol::Reason;
pub use options::Options;
pub use port::{In, Out};
