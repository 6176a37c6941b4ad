//! The program under the name `genom3`: what the builds of existing components ask of GenoM3's tool,
//! with its options and exit statuses (GenoM3 manual, "Running genom3"). Nothing is generated but
//! headers, skeletons and the files of `genomd/server`: the daemon does at run time what GenoM3's
//! other templates generate.

#![forbid(unsafe_code)]

mod cmake;
mod general;
mod input;
mod mappings;
mod merge_tool;
mod server;
mod skeleton;
mod stop;
mod words;

use std::ffi::OsString;
use std::io::{self, Write as _};
use std::path::Path;
use std::process::ExitCode;

use stop::Stop;

/// Exit status for wrong arguments.
const USAGE: u8 = 2;

/// Whether the program was called by the name `genom3`.
#[must_use]
pub fn is_asked_for(program: Option<&OsString>) -> bool {
    let name = program.map(|path| Path::new(path).file_name().unwrap_or_default().to_os_string());
    name.is_some_and(|name| name == "genom3")
}

/// Runs with the arguments behind the program's name.
#[must_use]
pub fn run(arguments: Vec<OsString>) -> ExitCode {
    let stop = match general::run(arguments) {
        Ok(()) => return ExitCode::SUCCESS,
        Err(stop) => stop,
    };
    let (message, status) = match stop {
        Stop::Answered => return ExitCode::SUCCESS,
        Stop::Errors(count) => {
            return ExitCode::from(u8::try_from(count).unwrap_or(u8::MAX).max(1));
        }
        Stop::Usage(message) => (message, USAGE),
        Stop::Failed(message) => (message, 1),
    };
    // Nothing can be done about a closed standard error.
    let _ = writeln!(io::stderr(), "genom3: {}", message.trim_end());
    ExitCode::from(status)
}
