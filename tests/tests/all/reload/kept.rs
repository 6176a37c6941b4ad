//! What stays as it is when a library is exchanged.

use std::fs;

use genom_tests::{Daemon, until};

use super::{Author, count, listed, mapped, text};

#[test]
fn an_edited_library_goes_on_with_ids_ports_activities_and_connections() {
    let author = Author::new();
    let library = author.save(1);
    let daemon = Daemon::start(&["--clock", "virtual", text(&library)]);
    daemon.ctl(&["load", text(&library), "--name", "other"]).expect_code(0);
    daemon.ctl(&["connect", "edit/given", "other/sum"]).expect_code(0);
    daemon.ctl(&["call", "edit", "set_note", "note=as it was"]).expect_code(0);
    let activity = daemon.json(&["start", "edit", "run"])["activity"].to_string();
    daemon.step(50);
    let before = (count(&daemon), daemon.port("edit", "sum"));
    assert_eq!(before.1["value"], before.0);
    author.save(1000);
    let reloaded = daemon.json(&["reload", "edit"]);
    assert_eq!(reloaded["component"], "edit");
    assert_eq!(reloaded["library"], text(&library));
    assert_eq!(reloaded["old_stays"], serde_json::Value::Null);
    assert_eq!(mapped(daemon.process().id(), "edit.so"), 2, "that of the other, and the new one");
    // Nothing has run since: all is as it was.
    assert_eq!((count(&daemon), daemon.port("edit", "sum")), before);
    daemon.step(50);
    assert_eq!(count(&daemon), before.0 + 10 * 1000);
    let note = daemon.json(&["call", "edit", "get"])["result"]["note"].clone();
    assert_eq!(note, "as it was");
    let running = daemon.json(&["activities", "edit"])["activities"][0].clone();
    assert_eq!((running["activity"].to_string(), &running["state"]), (activity, &"main".into()));
    daemon.ctl(&["abort", "edit", "run"]).expect_code(0);
    daemon.step(5);
    let ended = daemon.json(&["activities", "edit"])["activities"][0].clone();
    assert!(ended["result"]["periods"].as_i64() >= Some(20), "{ended}");
    let connection = daemon.json(&["connections"])["connections"][0].clone();
    assert_eq!(
        (&connection["in"], &connection["out"]),
        (&"edit/given".into(), &"other/sum".into())
    );
    assert_eq!((daemon.missed("edit"), daemon.missed("other")), (0, 0));
}

#[test]
fn while_time_goes_on_the_new_code_goes_on_in_the_state_of_the_old() {
    let author = Author::new();
    let library = author.save(1);
    let daemon = Daemon::start(&[text(&library)]);
    let mut events = daemon.events();
    let activity = daemon.json(&["start", "edit", "run"])["activity"].clone();
    until("it counts", || count(&daemon) > 5);
    let other = author.make("better.so", super::C, 1_000_000);
    let said = format!("edit runs {} now\n", text(&other));
    daemon.ctl(&["reload", "edit", text(&other)]).expect_out(&said);
    let told = events.wait_for(|change| change["event"] == "component_reloaded");
    assert_eq!((&told["component"], &told["library"]), (&"edit".into(), &text(&other).into()));
    until("it counts by the new step", || count(&daemon) > 1_000_000);
    assert!(count(&daemon) % 1_000_000 > 5, "what was counted before is kept");
    assert_eq!(daemon.json(&["activities", "edit"])["activities"][0]["activity"], activity);
    assert_eq!(listed(&daemon, "edit")["library"], text(&other));
    let dumped = daemon.ctl(&["dump"]);
    assert!(dumped.out.contains("better.so"), "{}", dumped.out);
    let said = format!("runs {} now", text(&other));
    assert!(daemon.ctl(&["logs"]).out.contains(&said));
}

#[test]
fn a_component_in_a_cell_is_reloaded_there_and_comes_back_with_the_library_it_had() {
    let author = Author::new();
    let library = author.save(1);
    let daemon = Daemon::start(&[]);
    daemon.ctl(&["load", text(&library), "--cell", "arm", "--restart", "always"]).expect_code(0);
    until("it counts", || count(&daemon) > 5);
    let better = author.make("better.so", super::C, 1_000_000);
    daemon.ctl(&["reload", "edit", text(&better)]).expect_code(0);
    until("it counts by the new step", || count(&daemon) > 1_000_000);
    assert!(count(&daemon) % 1_000_000 > 5, "what was counted before is kept");
    assert_eq!(listed(&daemon, "edit")["library"], text(&better));
    // Until it has run for a while, a fault would bring the library before it back.
    let trials = format!("{}.cells/arm/trials", text(&daemon.home().socket()));
    until("the trial is over", || fs::read_dir(&trials).unwrap().count() == 0);
    // The file it was loaded from first is not needed any more.
    fs::remove_file(&library).unwrap();
    daemon.ctl(&["cells", "--restart", "arm"]).expect_code(0);
    until("it is back", || daemon.ctl(&["--json", "call", "edit", "get"]).out.contains("count"));
    assert_eq!(listed(&daemon, "edit")["library"], text(&better));
}
