//! A library that ends the process of its cell soon after a reload is taken back.

use genom_tests::{Daemon, until};
use serde_json::json;

use super::{Author, C, count, listed, text};

#[test]
fn a_library_that_crashes_at_once_is_rolled_back_with_the_ids_and_activities_from_before() {
    let author = Author::new();
    let library = author.save(1);
    let daemon = Daemon::start(&["--watch"]);
    daemon.ctl(&["load", text(&library), "--cell", "arm"]).expect_code(0);
    let mut events = daemon.events();
    daemon.ctl(&["call", "edit", "set_note", "note=as it was"]).expect_code(0);
    let activity = daemon.json(&["start", "edit", "run"])["activity"].clone();
    until("it counts", || count(&daemon) > 20);
    author.make(
        "edit.so",
        &C.replace("*count += STEP", "*(volatile int *)8 = 0; *count += STEP"),
        1,
    );
    events.wait_for(|change| change["event"] == "component_rolled_back");
    let get = || daemon.ctl(&["--json", "call", "edit", "get"]);
    until("it is back", || get().out.contains("count"));
    assert!(count(&daemon) > 20, "what was counted before the reload is kept");
    assert_eq!(daemon.json(&["call", "edit", "get"])["result"]["note"], "as it was");
    let running = daemon.json(&["activities", "edit"])["activities"][0].clone();
    assert_eq!((&running["activity"], &running["state"]), (&activity, &json!("main")));
    assert_eq!(listed(&daemon, "edit")["library"], text(&library));
    // What crashed is not tried again, and what is mended is.
    let before = count(&daemon);
    until("it goes on", || count(&daemon) > before + 100);
    author.save(1_000_000);
    events.wait_for(|change| change["event"] == "component_reloaded");
    until("it counts by the new step", || count(&daemon) > 1_000_000);
}
