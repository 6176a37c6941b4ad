//! A daemon that is a part of a program in Rust or C, which steps it (`clients/rust`, `clients/c`). Of
//! programs in Python: `python::embedded`.

mod c;
mod rust;

use std::path::Path;
use std::process::Command;

use genom_client::Options;
use genom_tests::{Running, program};

/// How genomd is started.
fn options() -> Options {
    Options::new().program(program("genomd"))
}

/// Has genomctl do something at a socket.
#[track_caller]
fn ctl(socket: &Path, arguments: &[&str]) {
    said(socket, arguments);
}

/// The same, and what it prints.
#[track_caller]
fn said(socket: &Path, arguments: &[&str]) -> String {
    let mut command = Command::new(program("genomctl"));
    command.arg("--socket").arg(socket).args(arguments);
    let finished = Running::start(&mut command).finish();
    finished.expect_code(0);
    finished.out
}
