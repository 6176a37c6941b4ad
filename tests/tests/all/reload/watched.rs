//! Files that change while a daemon watches them.

use std::fs;

use genom_tests::{Daemon, until};
use serde_json::Value;

use super::{Author, C, count, text};

fn is(change: &Value, kind: &str) -> bool {
    change["event"] == kind && change["component"] == "edit"
}

/// Whether it says that a library was refused for this reason. While a slow linker writes a file,
/// states of it that are incomplete may be refused before.
fn is_refused(change: &Value, why: &str) -> bool {
    is(change, "component_not_reloaded") && change["why"].as_str().unwrap().contains(why)
}

#[test]
fn what_was_saved_and_made_runs_and_what_is_half_written_or_wrong_is_told() {
    let author = Author::new();
    let library = author.save(1);
    let daemon = Daemon::start(&["--watch", text(&library)]);
    let mut events = daemon.events();
    until("it counts", || count(&daemon) > 5);
    author.save(1_000_000);
    events.wait_for(|change| is(change, "component_reloaded"));
    until("it counts by the new step", || count(&daemon) > 1_000_000);
    assert!(count(&daemon) % 1_000_000 > 5, "what was counted before is kept");
    // A linker writes a file in several steps.
    let whole = fs::read(author.make("aside.so", C, -2_000_000)).unwrap();
    fs::write(&library, &whole[..whole.len() / 2]).unwrap();
    events.wait_for(|change| is_refused(change, "truncated"));
    fs::write(&library, &whole).unwrap();
    events.wait_for(|change| is(change, "component_reloaded"));
    until("it counts by the last step", || count(&daemon) < 0);
    // One that does not fit is told, and the component goes on.
    author.make("edit.so", &C.replace("edit_run(", "edit_ran("), 1);
    events.wait_for(|change| is_refused(change, "codel `edit_run`"));
    let before = count(&daemon);
    until("it goes on", || count(&daemon) < before);
}

#[test]
fn a_component_in_a_cell_is_watched_there() {
    let author = Author::new();
    let library = author.save(1);
    let daemon = Daemon::start(&["--watch"]);
    daemon.ctl(&["load", text(&library), "--cell", "arm"]).expect_code(0);
    let mut events = daemon.events();
    until("it counts", || count(&daemon) > 5);
    author.save(1_000_000);
    events.wait_for(|change| is(change, "component_reloaded"));
    until("it counts by the new step", || count(&daemon) > 1_000_000);
}
