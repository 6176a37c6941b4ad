//! A sandbox holds for codels in Python, and lets their interpreter import what it needs.

use std::fs;

use genom_tests::{Home, path};

use super::{DESCRIPTION, SCRIPT, axis};

#[test]
fn a_codel_in_a_sandbox_imports_and_reads_nothing_else() {
    let script = SCRIPT.replace(
        "    if what == \"refuse\":\n",
        "    if what == \"import\":\n        import colorsys\n    if what == \"read\":\n        \
         open(SECRET)\n    if what == \"refuse\":\n",
    );
    let home = Home::new().configured("[cell.axis]\nread = []\nwrite = []\n");
    // In the directory that the daemon runs in, which is on the path of `python -m`.
    let file = home.path().join("secret");
    fs::write(&file, "secret").unwrap();
    let script =
        script.replace("from axis_types", &format!("SECRET = {:?}\nfrom axis_types", path(&file)));
    let (_scratch, description) = axis(DESCRIPTION, &script);
    let daemon = home.start(&[path(&description)]);
    daemon.ctl(&["call", "axis", "how", "what=import"]).expect_code(0);
    let read = daemon.ctl(&["call", "axis", "how", "what=read"]);
    if daemon.ctl(&["logs"]).out.contains("no Landlock") {
        read.expect_code(0);
        return;
    }
    read.expect_code(1).expect_err("::genom::unkex {\"what\":\"PermissionError: ");
}
