//! What cells refuse, and what cannot be done to them.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;

use genom_tests::{Daemon, component, path};
use serde_json::json;

use super::{files, load};

#[test]
fn names_that_are_none_or_are_taken_are_refused() {
    let demo = component("demo");
    let daemon = Daemon::demo("local");
    let into = |cell: &str, name: &str| {
        daemon.ctl(&["load", path(&demo.library), "--name", name, "--cell", cell])
    };
    into("../up", "far").expect_code(1).expect_err("is no name of a cell");
    into("arm", "demo").expect_code(1).expect_err("a component named demo runs");
    into("arm", "far").expect_code(0);
    daemon
        .ctl(&["load", path(&demo.library), "--name", "far"])
        .expect_code(1)
        .expect_err("a component named far runs");
    daemon.ctl(&["cells", "--end", "amr"]).expect_code(1).expect_err("did you mean `arm`?");
}

#[test]
fn a_component_that_is_refused_leaves_no_cell() {
    let daemon = Daemon::start(&[]);
    daemon.ctl(&["load", "nothing", "--cell", "arm"]).expect_code(1).expect_err("no library");
    assert_eq!(daemon.json(&["cells"])["cells"], json!([]));
    assert!(!files(&daemon).exists());
}

#[test]
fn nobody_else_gets_at_the_sockets_of_cells() {
    let daemon = Daemon::start(&[]);
    load(&daemon, "demo", &["--isolated"]);
    let all = files(&daemon);
    for directory in [all.clone(), all.join("demo")] {
        assert_eq!(fs::metadata(directory).unwrap().permissions().mode() & 0o777, 0o700);
    }
    let socket = fs::metadata(all.join("demo/socket")).unwrap();
    assert_eq!(socket.permissions().mode() & 0o777, 0o600);
}
