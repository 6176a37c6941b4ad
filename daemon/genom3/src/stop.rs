//! How the program ends, and what it prints.

use std::io::{self, Write as _};

/// Why the program ends without having done what was asked.
#[derive(Debug)]
pub(crate) enum Stop {
    /// Help or a version was asked for and printed.
    Answered,
    /// Wrong arguments.
    Usage(String),
    /// The description has this many errors, which were printed.
    Errors(usize),
    /// Something failed.
    Failed(String),
}

impl From<io::Error> for Stop {
    fn from(error: io::Error) -> Self {
        Self::Failed(error.to_string())
    }
}

impl Stop {
    /// Help, a version, or wrong arguments, as clap tells them.
    pub(crate) fn told(error: &clap::Error) -> Self {
        if error.use_stderr() {
            return Self::Usage(error.to_string().trim_start_matches("error: ").to_owned());
        }
        // A closed pipe is not a failure.
        let _ = error.print();
        Self::Answered
    }
}

/// Writes to standard output.
pub(crate) fn print(text: &str) -> Result<(), Stop> {
    match io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}
