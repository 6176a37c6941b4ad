//! Scripts in Lua are exchanged while their component runs.

use std::fs;

use genom_tests::until;

use super::{SCRIPT, started};

#[test]
fn a_changed_script_goes_on_with_the_memory_of_the_one_before() {
    let (daemon, scratch) = started(&[]);
    let how = |tries: &str| {
        daemon.ctl(&["call", "axis", "how", "what=no"]).expect_code(0).expect_out(tries);
    };
    how("tries = 1\n");
    let script = scratch.path().join("axis.lua");
    fs::write(&script, SCRIPT.replace("n.value + 1", "n.value + 10")).unwrap();
    daemon.ctl(&["reload", "axis"]).expect_code(0);
    how("tries = 11\n");
    // One with a mistake is refused, and the other goes on.
    fs::write(&script, SCRIPT.replace("axis_how(what, n", "axis_how(what, m")).unwrap();
    let refused = daemon.ctl(&["reload", "axis"]);
    refused.expect_code(1).expect_err("line 15: the description has no parameter `m`");
    how("tries = 21\n");
}

#[test]
fn a_script_is_watched() {
    let (daemon, scratch) = started(&["--watch"]);
    daemon.ctl(&["call", "axis", "how", "what=no"]).expect_out("tries = 1\n");
    let script = scratch.path().join("axis.lua");
    fs::write(&script, SCRIPT.replace("n.value = n.value + 1", "n.value = 50")).unwrap();
    until("the new one runs", || {
        daemon.ctl(&["call", "axis", "how", "what=no"]).out == "tries = 50\n"
    });
}
