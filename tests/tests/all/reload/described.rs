//! A description that changed: what has a place in both stays, by name.

use genom_tests::{Daemon, until};
use serde_json::json;

use super::{Author, C, GEN, count, listed, text};

/// Codels for a description with other IDS.
pub(super) fn wider() -> (String, String) {
    let gen_text = GEN
        .replace(
            "ids { long count; long more; string note; };",
            "ids { string note; long long count; long extra; };",
        )
        .replace(
            "codel<main> edit_step(inout count, in more,",
            "codel<main> edit_step(inout count, in extra,",
        )
        .replace("attribute set_more(in more);", "attribute set_extra(in extra);");
    let c = C
        .replace("int32_t *count, int32_t more,", "int64_t *count, int32_t more,")
        .replace("  ids->more = 0;\n", "  ids->extra = 7;\n");
    (gen_text, c)
}

#[test]
fn ids_go_on_by_name_and_what_is_new_gone_or_converted_is_listed() {
    let author = Author::new();
    let library = author.save(1);
    let daemon = Daemon::start(&[text(&library)]);
    daemon.ctl(&["load", text(&library), "--name", "other"]).expect_code(0);
    daemon.ctl(&["connect", "other/given", "edit/sum"]).expect_code(0);
    daemon.ctl(&["call", "edit", "set_note", "note=as it was"]).expect_code(0);
    let activity = daemon.json(&["start", "edit", "run"])["activity"].clone();
    until("it counts", || count(&daemon) > 5);
    let (gen_text, c) = wider();
    author.describe(&gen_text);
    author.make("edit.so", &c, 1_000_000);
    let told = daemon.json(&["reload", "edit"]);
    assert_eq!(told["restarted"], true, "{told}");
    let notes = told["notes"].to_string();
    for note in ["ids: extra is new", "ids: more is gone"] {
        assert!(notes.contains(note), "{notes}");
    }
    until("it counts by the new step", || count(&daemon) > 1_000_000);
    let now = daemon.json(&["call", "edit", "get"])["result"].clone();
    assert!(now["count"].as_i64().unwrap() % 1_000_000 > 5, "what was counted before is kept");
    assert_eq!(now["note"], "as it was");
    let running = daemon.json(&["activities", "edit"])["activities"][0].clone();
    assert_eq!((&running["activity"], &running["state"]), (&activity, &json!("main")));
    let connection = daemon.json(&["connections"])["connections"][0].clone();
    assert_eq!(
        (&connection["in"], &connection["out"]),
        (&json!("other/given"), &json!("edit/sum"))
    );
}

#[test]
fn an_activity_that_is_no_more_is_told_and_a_port_that_is_connected_stays_what_it_is() {
    let author = Author::new();
    let library = author.save(1);
    let daemon = Daemon::start(&[text(&library)]);
    daemon.ctl(&["load", text(&library), "--name", "other"]).expect_code(0);
    daemon.ctl(&["connect", "other/given", "edit/sum"]).expect_code(0);
    daemon.ctl(&["start", "edit", "run"]).expect_code(0);
    until("it counts", || count(&daemon) > 5);
    // Another type of a port that is read.
    let other = GEN.replace("typedef long total;", "typedef long total; typedef double mean;");
    author.describe(&other.replace("port out total sum", "port out mean sum"));
    author.make("edit.so", C, 1_000_000);
    let refused = daemon.ctl(&["reload", "edit"]);
    refused.expect_err("another type of it: disconnect it first").expect_code(1);
    assert_eq!(listed(&daemon, "edit")["activities"], 1, "it goes on");
    assert!(count(&daemon) < 1_000_000);
    // Without its activity.
    let start = GEN.find("  activity run(").unwrap();
    let end = GEN.find("  activity hang(").unwrap();
    author.describe(&format!("{}{}", &GEN[..start], &GEN[end..]));
    author.make("edit.so", C, 1_000_000);
    let mut events = daemon.events();
    let told = daemon.json(&["reload", "edit"]);
    let ended = events.wait_for(|change| change["event"] == "activity_ended");
    // Its stop codel ended it in order.
    assert_eq!((&ended["service"], &ended["exception"]), (&json!("run"), &json!(null)));
    let notes = told["notes"].to_string();
    assert!(notes.contains("run does not go on: the description has no such activity"), "{notes}");
    until("it counts by the new step", || count(&daemon) > 1_000_000);
}

#[test]
fn one_that_does_not_start_gives_its_place_back() {
    let author = Author::new();
    let library = author.save(1);
    let daemon = Daemon::start(&[text(&library)]);
    until("it counts", || count(&daemon) > 5);
    let activity = daemon.json(&["start", "edit", "run"])["activity"].clone();
    let (gen_text, c) = wider();
    author.describe(&gen_text);
    author.make(
        "edit.so",
        &c.replace("ids->count = 0;", "return \"::edit::nonsense\";"),
        1_000_000,
    );
    // Beside the running one, which is not touched, and in its place.
    daemon.ctl(&["reload", "edit"]).expect_err("edit does not start").expect_code(1);
    let before = count(&daemon);
    assert!(before > 5 && before < 1_000_000, "{before}");
    let refused = daemon.ctl(&["reload", "edit", "--stop-first"]);
    refused.expect_err("it runs again as it was before").expect_code(1);
    let before = count(&daemon);
    assert!(before > 5 && before < 1_000_000, "{before}");
    until("it counts on", || count(&daemon) > before);
    let running = daemon.json(&["activities", "edit"])["activities"][0].clone();
    assert_eq!(running["activity"], activity);
}

#[test]
fn who_waits_for_an_activity_goes_on_to_wait_and_hears_how_it_ended() {
    for cell in [&[][..], &["--cell", "arm"]] {
        let author = Author::new();
        let library = author.save(1);
        let daemon = Daemon::start(&[]);
        daemon.ctl(&[&["load", text(&library)][..], cell].concat()).expect_code(0);
        let waiting = daemon.spawn(&["--json", "call", "edit", "run"]);
        let running = || daemon.json(&["activities", "edit"])["activities"][0].clone();
        until("it runs", || running()["state"] == "main");
        let activity = running()["activity"].clone();
        let mut events = daemon.events();
        let (gen_text, c) = wider();
        author.describe(&gen_text);
        author.make("edit.so", &c, 1_000_000);
        daemon.ctl(&["reload", "edit"]).expect_code(0);
        until("it counts by the new step", || count(&daemon) > 1_000_000);
        assert_eq!(running()["activity"], activity);
        // Those that begin now have other numbers.
        let another = daemon.json(&["start", "edit", "run"])["activity"].clone();
        assert!(another.as_u64() > activity.as_u64(), "{another} {activity}");
        daemon.ctl(&["abort", "edit", &activity.to_string()]).expect_code(0);
        let told = waiting.finish();
        told.expect_code(0);
        let outcome: serde_json::Value = serde_json::from_str(&told.out).unwrap();
        assert!(outcome["result"]["periods"].as_i64() > Some(1), "{outcome}");
        let ended = events.wait_for(|change| change["event"] == "activity_ended");
        assert_eq!((&ended["activity"], &ended["exception"]), (&activity, &json!(null)));
        let before = daemon.port("edit", "sum")["value"].clone();
        until("its port goes on", || daemon.port("edit", "sum")["value"] != before);
    }
}

#[test]
fn a_port_that_another_cell_reads_does_not_get_another_type() {
    let author = Author::new();
    let library = author.save(1);
    let daemon = Daemon::start(&["--backend", "shm"]);
    daemon.ctl(&["load", text(&library), "--cell", "arm"]).expect_code(0);
    daemon.ctl(&["load", text(&library), "--name", "other", "--cell", "eye"]).expect_code(0);
    daemon.ctl(&["connect", "other/given", "edit/sum"]).expect_code(0);
    let value = || daemon.port("other", "given")["value"].clone();
    until("it reads", || value().as_i64() > Some(5));
    let other = GEN.replace("typedef long total;", "typedef long total; typedef double mean;");
    author.describe(&other.replace("port out total sum", "port out mean sum"));
    author.make("edit.so", C, 1_000_000);
    let refused = daemon.ctl(&["reload", "edit"]);
    refused.expect_err("is connected (a reader in another process, on shm)").expect_code(1);
    let before = value();
    until("it reads on", || value() != before);
    daemon.ctl(&["disconnect", "other/given"]).expect_code(0);
    daemon.ctl(&["reload", "edit"]).expect_code(0);
    until("it counts by the new step", || count(&daemon) > 1_000_000);
    assert_eq!(daemon.port("edit", "sum")["type"], "::edit::mean");
}
