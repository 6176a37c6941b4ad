//! Runs the conformance suite on every middleware and prints the table: `cargo conformance`.

#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, reason = "standard output is the table")]

use std::process::{Command, ExitCode, Stdio};

use genom_tests::conformance::Table;

const CRATES: [&str; 5] =
    ["genom-local", "genom-shm", "genom-zenoh", "genom-ros2", "genom-example"];

fn main() -> ExitCode {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let (mut table, mut failed) = (Table::default(), false);
    for name in CRATES {
        eprintln!("{name} ...");
        let mut command = Command::new(&cargo);
        command.args(["test", "--package", name, "--test", "conformance"]);
        let run = command.stderr(Stdio::inherit()).output();
        match run {
            Ok(run) => {
                let printed = String::from_utf8_lossy(&run.stdout);
                table.read(&printed);
                if !run.status.success() {
                    failed = true;
                    // What its tests say of their failure.
                    eprintln!("{printed}");
                }
            }
            Err(error) => {
                eprintln!("cannot run cargo: {error}");
                return ExitCode::FAILURE;
            }
        }
    }
    println!("{table}");
    if table.is_green() && !failed { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
