//! Why something did not work.

use std::io;

use genom_protocol::Reason;

use crate::ended::Ended;

/// A daemon did not start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// There is no such program, or it cannot be executed.
    #[error("`{program}` does not run: {error}; put genomd on PATH, or name it in $GENOMD")]
    Program {
        /// What was to be run.
        program: String,
        /// What the system said.
        error: io::Error,
    },
    /// It ended before it was ready.
    #[error(transparent)]
    Ended(#[from] Ended),
    /// It refused the first request.
    #[error("{}", sentence(.0))]
    Refused(Reason),
    /// It is of another version.
    #[error("this is genom-client {ours}, and genomd is {theirs}: use the same version of both")]
    Version {
        /// Of this crate.
        ours: &'static str,
        /// Of genomd.
        theirs: String,
    },
    /// No socket or directory could be made for it.
    #[error("no daemon can be started: {0}")]
    Io(#[from] io::Error),
}

/// A daemon did not do what it was asked.
#[derive(Debug, thiserror::Error)]
pub enum AskError {
    /// It refused, and nothing was done.
    #[error("{}", sentence(.0))]
    Refused(Reason),
    /// It has ended.
    #[error(transparent)]
    Ended(#[from] Ended),
}

/// A port cannot be shared.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The daemon did not open it.
    #[error(transparent)]
    Ask(#[from] AskError),
    /// The daemon opened it, but its file did not arrive.
    #[error("{0} is not shared: this program has no file free, see `ulimit -n`")]
    NoFile(String),
    /// It is an in port, where an out port was asked for.
    #[error("{0} is an in port, which this program writes")]
    InPort(String),
    /// It is an out port, where an in port was asked for.
    #[error("{0} is an out port, which codels write")]
    OutPort(String),
    /// Its memory cannot be mapped.
    #[error("{address} cannot be mapped: {error}")]
    Map {
        /// The port.
        address: String,
        /// What the system said.
        error: io::Error,
    },
}

/// The value of a port cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// Its component is gone, or has another type there now.
    #[error("{0} is not there: its component is gone, or has another type there now")]
    Gone(String),
    /// The type that was asked for has another size.
    #[error("{address} has values of {size} bytes, and {type_name} has {asked}")]
    Size {
        /// The port.
        address: String,
        /// Of its type, in bytes.
        size: usize,
        /// The type that was asked for.
        type_name: &'static str,
        /// Of that type, in bytes.
        asked: usize,
    },
    /// The daemon is not the one that the port is of.
    #[error("{0} is a port of another daemon")]
    OtherDaemon(String),
}

/// A reason, and what one can do about it.
fn sentence(reason: &Reason) -> String {
    match &reason.help {
        Some(help) => format!("{} ({help})", reason.message),
        None => reason.message.clone(),
    }
}
