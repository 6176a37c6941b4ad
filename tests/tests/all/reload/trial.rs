//! A library that ends the process of its cell soon after a reload is taken back.

use std::fs;

use genom_tests::{Daemon, Home, signal, until};
use serde_json::json;

use super::described::wider;
use super::{Author, C, GEN, count, listed, text};

/// A store to an address that nothing has.
const CRASH: &str = "*(volatile int *)8 = 0; ";

/// Whether the component runs with the description that [`wider`] changes.
fn has_first_description(daemon: &Daemon) -> bool {
    daemon.ctl(&["call", "edit", "set_more", "more=7"]).code == Some(0)
}

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

#[test]
fn one_that_crashes_while_it_is_loaded_changes_nothing_in_its_cell() {
    let author = Author::new();
    let library = author.save(1);
    let daemon = Daemon::start(&[]);
    daemon.ctl(&["load", text(&library), "--cell", "arm"]).expect_code(0);
    let activity = daemon.json(&["start", "edit", "run"])["activity"].clone();
    let process = || daemon.json(&["cells"])["cells"][0]["pid"].clone();
    let before = process();
    assert!(before.is_number(), "{before}");
    until("it counts", || count(&daemon) > 20);
    let crashes = "__attribute__((constructor)) static void begins(void) \
                   { *(volatile int *)8 = 0; }\n";
    author.make("edit.so", &format!("{C}{crashes}"), 1_000_000);
    let refused = daemon.ctl(&["reload", "edit"]);
    refused.expect_err("ends the process that loads it").expect_code(1);
    assert_eq!(process(), before);
    let running = daemon.json(&["activities", "edit"])["activities"][0].clone();
    assert_eq!((&running["activity"], &running["state"]), (&activity, &json!("main")));
    let now = count(&daemon);
    assert!(now < 1_000_000, "{now}");
    until("it goes on", || count(&daemon) > now + 20);
}

#[test]
fn where_it_is_asked_for_one_whose_activities_throw_is_taken_back_between_two_ticks() {
    for cell in [&[][..], &["--cell", "arm"]] {
        let author = Author::new();
        let library = author.save(1);
        let daemon = Home::new().configured("[reload]\nexceptions = true\n").start(&[]);
        daemon.ctl(&[&["load", text(&library)][..], cell].concat()).expect_code(0);
        daemon.ctl(&["start", "edit", "run"]).expect_code(0);
        let other = author.make(
            "other.so",
            &C.replace("*periods = *seen += 1;", "return \"::edit::nonsense\";"),
            1_000_000,
        );
        let mut events = daemon.events();
        daemon.ctl(&["reload", "edit", text(&other)]).expect_code(0);
        let ended = events.wait_for(|change| change["event"] == "activity_ended");
        assert!(ended["exception"].is_string(), "{ended}");
        events.wait_for(|change| change["event"] == "component_rolled_back");
        assert_eq!(listed(&daemon, "edit")["library"], text(&library));
        let before = count(&daemon);
        assert!(before > 1_000_000, "what it counted meanwhile is kept");
        until("it goes on", || count(&daemon) > before + 5);
        assert!(count(&daemon) < before + 1_000_000, "by the step from before");
        // It can be reloaded again, and what does not throw stays.
        let mended = author.make("mended.so", C, 1_000_000);
        daemon.ctl(&["reload", "edit", text(&mended)]).expect_code(0);
        until("it counts by the new step", || count(&daemon) > before + 1_000_000);
    }
}

#[test]
fn one_with_another_description_is_rolled_back_with_its_description() {
    let (gen_text, c) = wider();
    let first = format!("#include \"included.gen\"\n{gen_text}");
    for crashing in ["*count += STEP", "ids->count = 0;"] {
        let author = Author::new();
        // In two files, both of which change.
        let at = GEN.find("  attribute").unwrap();
        fs::write(author.at("included.gen"), &GEN[at..]).unwrap();
        author.describe(&format!("{}#include \"included.gen\"\n", &GEN[..at]));
        let library = author.save(1);
        let daemon = Daemon::start(&[]);
        daemon.ctl(&["load", text(&library), "--name", "other"]).expect_code(0);
        daemon.ctl(&["load", text(&library), "--cell", "arm"]).expect_code(0);
        daemon.ctl(&["connect", "edit/given", "other/sum"]).expect_code(0);
        daemon.ctl(&["call", "edit", "set_note", "note=as it was"]).expect_code(0);
        daemon.ctl(&["call", "edit", "set_more", "more=7"]).expect_code(0);
        let activity = daemon.json(&["start", "edit", "run"])["activity"].clone();
        fs::write(author.at("included.gen"), "/* moved */\n").unwrap();
        author.describe(&first);
        author.make("edit.so", &c.replace(crashing, &format!("{CRASH}{crashing}")), 100_000);
        let mut events = daemon.events();
        let before = count(&daemon);
        // Its caller hears of the crash, or of the reload before it.
        let _ = daemon.ctl(&["reload", "edit"]);
        events.wait_for(|change| change["event"] == "component_rolled_back");
        let get = || daemon.ctl(&["--json", "call", "edit", "get"]);
        until("it is back", || get().out.contains("count"));
        let now = count(&daemon);
        assert!(now >= before, "what was counted before the reload is kept: {before} {now}");
        until("it counts by the first steps", || count(&daemon) > now);
        let later = count(&daemon);
        assert_eq!((later - now) % 8, 0, "`more` is as it was: {now} {later}");
        assert_eq!(daemon.json(&["call", "edit", "get"])["result"]["note"], "as it was");
        let running = daemon.json(&["activities", "edit"])["activities"][0].clone();
        assert_eq!((&running["activity"], &running["state"]), (&activity, &json!("main")));
        let connected = || daemon.json(&["connections"])["connections"][0].clone();
        until("it is connected", || connected()["in"] == "edit/given");
        assert_eq!(connected()["out"], "other/sum");
        assert_eq!(listed(&daemon, "edit")["library"], text(&library));
        // Also in the process that comes after this one.
        assert!(signal(&daemon.json(&["cells"])["cells"][0]["pid"], "KILL"));
        events.wait_for(|change| change["event"] == "cell_runs");
        until("its description is as it was", || has_first_description(&daemon));
        // What is mended stays, and nothing of the trial is left.
        author.make("edit.so", &c, 100_000);
        daemon.ctl(&["reload", "edit"]).expect_code(0);
        until("it counts by the new step", || count(&daemon) > now + 100_000);
        assert!(!has_first_description(&daemon));
        let trials = format!("{}.cells/arm/trials", text(&daemon.home().socket()));
        until("the trial is over", || fs::read_dir(&trials).unwrap().count() == 0);
    }
}

#[test]
fn where_it_is_asked_for_one_with_another_description_is_taken_back_when_its_activities_throw() {
    let (gen_text, c) = wider();
    for cell in [&[][..], &["--cell", "arm"]] {
        let author = Author::new();
        let library = author.save(1);
        let daemon = Home::new().configured("[reload]\nexceptions = true\n").start(&[]);
        daemon.ctl(&[&["load", text(&library)][..], cell].concat()).expect_code(0);
        daemon.ctl(&["call", "edit", "set_more", "more=7"]).expect_code(0);
        daemon.ctl(&["start", "edit", "run"]).expect_code(0);
        author.describe(&gen_text);
        let throws = c.replace("*periods = *seen += 1;", "return \"::edit::nonsense\";");
        let other = author.make("other.so", &throws, 100_000);
        let before = count(&daemon);
        let mut events = daemon.events();
        daemon.ctl(&["reload", "edit", text(&other)]).expect_code(0);
        events.wait_for(|change| change["event"] == "component_rolled_back");
        assert_eq!(listed(&daemon, "edit")["library"], text(&library));
        let now = count(&daemon);
        assert!(now > before + 100_000, "what it counted meanwhile is kept: {before} {now}");
        until("it goes on", || count(&daemon) > now);
        let later = count(&daemon);
        assert_eq!((later - now) % 8, 0, "`more` is as it was before: {now} {later}");
        assert!(has_first_description(&daemon));
        let dumped = daemon.ctl(&["dump"]).out;
        assert!(dumped.contains("set_more") && !dumped.contains("set_extra"), "{dumped}");
        // It can be reloaded again, and what does not throw stays.
        let mended = author.make("mended.so", &c, 100_000);
        daemon.ctl(&["reload", "edit", text(&mended)]).expect_code(0);
        until("it counts by the new step", || count(&daemon) > now + 100_000);
        assert!(!has_first_description(&daemon));
    }
}
