//! `genomctl`, the command line of supervisors.
//!
//! It is a client of the daemon's control plane, with additional verbs on descriptions that need no
//! daemon. It has no state of its own but contexts.

#![forbid(unsafe_code)]

mod agreement;
mod apart;
mod args;
mod bench;
mod body;
mod chosen;
mod client;
mod complete;
mod connection;
mod contexts;
mod doctor;
mod escape;
mod failure;
mod far;
mod frames;
mod http;
mod inputs;
mod keys;
mod names;
mod patience;
mod picture;
mod plot;
mod private;
mod process;
mod prompt;
mod reading;
mod session;
mod sse;
mod table;
mod target;
mod terminal;
mod times;
mod top;
mod traffic;
mod verbs;

use std::process::ExitCode;

use clap::{CommandFactory as _, Parser as _};

use crate::args::Cli;
use crate::failure::Failure;
use crate::session::Session;

/// Whether `--json` was given, for a command line that cannot be parsed.
fn json_wanted() -> bool {
    std::env::args_os().skip(1).take_while(|word| word != "--").any(|word| word == "--json")
}

fn main() -> ExitCode {
    let mut arguments = std::env::args_os();
    if genom_genom3::is_asked_for(arguments.next().as_ref()) {
        return genom_genom3::run(arguments.collect());
    }
    // A shell asks for completions: they are printed and the process exits.
    complete::answer(Cli::command, verbs::COMPLETE);
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if error.use_stderr() && json_wanted() => {
            return Failure::typed(&error.to_string()).report(true);
        }
        Err(error) => {
            let code = if error.use_stderr() { 2 } else { 0 };
            // A closed pipe is not a failure.
            let _ = error.print();
            return ExitCode::from(code);
        }
    };
    let json = cli.json;
    let session = Session::new(cli.verb.connection(cli.connection), json);
    // One thread is enough for one request; starting a thread pool would take longer than the
    // request.
    let outcome = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(failure::Failure::Io)
        .and_then(|runtime| runtime.block_on(verbs::run(cli.verb, &session, Cli::command)));
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(json),
    }
}
