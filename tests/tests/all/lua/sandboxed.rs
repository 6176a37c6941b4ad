//! A sandbox holds for codels in Lua, and lets them load modules from beside their script.

use std::fs;

use genom_tests::{Home, path};

use super::{DESCRIPTION, SCRIPT, axis};

#[test]
fn a_codel_in_a_sandbox_loads_modules_and_reads_nothing_else() {
    let home = Home::new().configured("[cell.axis]\nread = []\nwrite = []\n");
    let file = home.path().join("secret");
    fs::write(&file, "secret").unwrap();
    let script = SCRIPT.replace(
        "    if what == \"refuse\"",
        &format!(
            "    if what == \"import\" then assert(require \"beside\" == 5) end\n    \
             if what == \"read\" then assert(io.open {:?}) end\n    if what == \"refuse\"",
            path(&file)
        ),
    );
    let (scratch, description) = axis(DESCRIPTION, &script);
    fs::write(scratch.path().join("beside.lua"), "return 5\n").unwrap();
    let daemon = home.start(&[path(&description)]);
    daemon.ctl(&["call", "axis", "how", "what=import"]).expect_code(0);
    let read = daemon.ctl(&["call", "axis", "how", "what=read"]);
    if daemon.ctl(&["logs"]).out.contains("no Landlock") {
        read.expect_code(0);
        return;
    }
    read.expect_code(1).expect_err("secret: Permission denied");
}
