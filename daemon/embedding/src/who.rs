//! Who steps this process.

use std::fmt;

/// Who is at the other end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Who {
    /// The program that started this daemon, which ends with it.
    Program,
    /// The daemon of this cell.
    Daemon,
}

impl fmt::Display for Who {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Program => "program",
            Self::Daemon => "daemon of this cell",
        })
    }
}
