//! A typed iceoryx2 program that is not genomd reads a port.

use std::process::Command;

use genom_tests::{Daemon, Running};

#[test]
fn a_typed_iceoryx2_program_reads_the_position_while_the_demo_runs() {
    let daemon = Daemon::demo("shm");
    let memory = daemon.home().memory();
    let mut reader = Command::new(env!("CARGO_BIN_EXE_faults"));
    reader.args(["--peer", "arrive"]).arg(memory.prefix()).arg(memory.root()).arg("0.25");
    let reader = Running::start(&mut reader);
    assert!(reader.line().starts_with("ready "));
    daemon.ctl(&["call", "demo", "goto", "goal=0.25"]).expect_code(0);
    let told = reader.line();
    assert!(told.starts_with("arrived after "), "{told}");
    reader.finish().expect_code(0);
}
