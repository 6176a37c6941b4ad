//! A short `cargo faults`: what becomes of a daemon whose codels misbehave, or that is killed while
//! it uses shared memory.

use std::process::Command;
use std::time::Duration;

use genom_tests::{Finished, Running};
use serde_json::{Value, json};

/// It starts dozens of daemons, one after the other.
const LONGEST: Duration = Duration::from_secs(300);

fn faults(arguments: &[&str]) -> Finished {
    let mut command = Command::new(env!("CARGO_BIN_EXE_faults"));
    command.args(arguments);
    Running::start(&mut command).finish_within(LONGEST)
}

#[test]
fn the_short_list_of_faults_and_ends_of_daemons_goes_as_it_is_to_go() {
    let tried = faults(&["--short", "--json"]);
    tried.expect_code(0).expect_err("1/10: a codel ").expect_err("10/10: SIGKILL in stop");
    let trials: Value = serde_json::from_str(&tried.out).unwrap();
    let trials = trials.as_array().unwrap();
    assert_eq!(trials.len(), 10);
    for trial in trials {
        assert_eq!((&trial["left_behind"], &trial["wrong"]), (&json!("nothing"), &Value::Null));
    }
}

#[test]
fn what_the_command_does_not_know_is_refused_with_what_it_knows() {
    faults(&["--help"]).expect_code(0);
    faults(&["--fast"]).expect_code(2).expect_err("no option --fast").expect_err("--short");
    faults(&["--backend", "dds"]).expect_code(2).expect_err("local, shm, zenoh, ros2");
    faults(&["--place", "robot"]).expect_code(2).expect_err("own or cell");
    faults(&["--times", "0"]).expect_code(2).expect_err("a number from 1");
    faults(&["--every", "0"]).expect_code(2).expect_err("a number from 1");
    faults(&["--peer", "stranger"]).expect_code(2);
    faults(&["no", "such", "fault"]).expect_code(2).expect_err("no fault is called so");
}
