//! Runs the conformance suite on every middleware and prints a table: `cargo conformance`.

#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, reason = "standard output is the table")]

use std::process::{Command, ExitCode, Stdio};

use genom_tests::conformance::Table;

/// Selects every crate of the workspace that has a `tests/conformance.rs`.
const SUITES: [&str; 5] = ["test", "--workspace", "--test", "conformance", "--no-fail-fast"];

fn main() -> ExitCode {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let run = match Command::new(&cargo).args(SUITES).stderr(Stdio::inherit()).output() {
        Ok(run) => run,
        Err(error) => {
            eprintln!("cannot run cargo: {error}");
            return ExitCode::FAILURE;
        }
    };
    let printed = String::from_utf8_lossy(&run.stdout);
    let mut table = Table::default();
    table.read(&printed);
    if !run.status.success() {
        // Messages of the tests that failed.
        eprintln!("{printed}");
    }
    println!("{table}");
    if table.is_green() && run.status.success() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
