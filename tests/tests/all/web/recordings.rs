//! The page of recordings in a real browser: make, end, list, download, replay, remove.

use std::path::PathBuf;

use genom_tests::browser::Browser;
use genom_tests::{Daemon, Home, component, path, until};
use serde_json::{Value, json};

use super::visitor::{Visitor, link, set_speed};

const ENTER: &str = "\u{E007}";

/// A daemon with an axis and a mission that keeps recordings in its own directory.
fn daemon(more: &str) -> (Daemon, PathBuf) {
    let home = Home::new();
    let directory = home.path().join("kept");
    let (demo, mission) = (component("demo"), component("mission"));
    let text = format!("[recordings]\ndirectory = \"{}\"\n{more}", path(&directory));
    let daemon =
        home.configured(&text).start(&["--web", path(&demo.library), path(&mission.library)]);
    (daemon, directory)
}

fn shown(daemon: &Daemon, rights: &[&str]) -> Browser {
    let browser = Browser::start(1280, 900, &[]);
    browser.open(&link(daemon, rights));
    browser.click("a[href='/recordings']");
    browser.until("the list is there", "document.getElementById('room')?.innerText");
    browser
}

#[test]
fn a_recording_is_made_ended_downloaded_replayed_and_removed() {
    let (daemon, directory) = daemon("");
    let browser = shown(&daemon, &[]);
    browser.until_shown("No recording is kept.");
    daemon.ctl(&["connect", "mission/position", "demo/position"]).expect_code(0);
    browser.until(
        "ports are offered",
        "document.querySelector('#what option[value=\"mission/position\"]')",
    );
    browser.with(
        "for (const one of document.querySelectorAll('#what option')) one.selected = arguments[0].includes(one.value)",
        vec![json!(["mission", "demo/position"])],
    );
    browser.write("#name", "drive");
    browser.click("#begin");
    let state =
        "document.querySelector('[data-file=\"drive.mcap\"] [data-label=State]')?.innerText";
    browser.until("it is made", &format!("{state} === 'recording'"));
    set_speed(&daemon, "2");
    daemon.ctl(&["connect", "mission/goto", "demo/goto"]).expect_code(0);
    daemon.ctl(&["start", "--wait", "mission", "patrol", "rounds=1"]).expect_code(0);
    browser.press("[data-file='drive.mcap'] [data-act=End]", ENTER);
    browser.until("it is whole", &format!("{state} === 'whole'"));
    let messages = "Number(document.querySelector('[data-file=\"drive.mcap\"] [data-label=Messages]').innerText.replaceAll(',', ''))";
    browser.until("it has samples", &format!("{messages} > 10"));
    let size = browser.ask(
        "return document.querySelector('[data-file=\"drive.mcap\"] [data-label=Size]').innerText",
    );
    assert!(
        size.as_str().is_some_and(|size| size.ends_with("kB") || size.ends_with("MB")),
        "{size}"
    );
    // What is downloaded is the file, and a recording.
    let kept = std::fs::read(directory.join("drive.mcap")).unwrap();
    let got = browser.ask(
        "return fetch(document.querySelector('[data-file=\"drive.mcap\"] a[download]').href) \
         .then(async (reply) => [(await reply.arrayBuffer()).byteLength, reply.headers.get('content-disposition')])",
    );
    assert_eq!(got, json!([kept.len(), "attachment; filename=\"drive.mcap\""]));
    let positions = mcap::MessageStream::new(&kept).unwrap().filter(|message| {
        message.as_ref().is_ok_and(|message| message.channel.topic == "/mission/position")
    });
    let read = positions.count();
    assert!(read > 0, "the mission read its position");
    // A port that is connected is left out; when it is not, it gets what it read then.
    browser.press("[data-file='drive.mcap'] [data-act=Replay]", ENTER);
    browser.until_shown("mission/position reads demo/position");
    daemon.ctl(&["disconnect", "mission/position"]).expect_code(0);
    browser.press("[data-file='drive.mcap'] [data-act=Replay]", ENTER);
    browser.until(
        "it is over",
        "document.querySelector('[data-file=\"drive.mcap\"] [data-replay=over]')",
    );
    let told = daemon.home().get("/recordings/kept");
    let replay = &told["recordings"][0]["replay"];
    assert_eq!(
        (&replay["ports"], &replay["published"]),
        (&json!(["mission/position"]), &json!(read))
    );
    assert_eq!(replay["problem"], Value::Null);
    browser.press("[data-file='drive.mcap'] [data-act=Remove]", ENTER);
    browser.until_shown("Press again to remove");
    browser.press("[data-file='drive.mcap'] [data-act=Remove]", ENTER);
    browser.until_shown("No recording is kept.");
    assert!(!directory.join("drive.mcap").exists());
}

#[test]
fn a_component_in_a_cell_is_recorded_and_gets_its_samples_again() {
    let home = Home::new();
    let text = format!("[recordings]\ndirectory = \"{}\"\n", path(&home.path().join("kept")));
    let (demo, mission) = (component("demo"), component("mission"));
    let daemon =
        home.configured(&text).start(&["--web", "--backend", "shm", path(&mission.library)]);
    daemon.ctl(&["load", path(&demo.library), "--cell", "arm"]).expect_code(0);
    daemon.ctl(&["connect", "demo/parameter", "mission/gain"]).expect_code(0);
    let owner = Visitor::with_link(&link(&daemon, &[]));
    let kept = "/api/recordings/kept";
    let begun = owner.posts(kept, "{\"name\":\"far\",\"ports\":[\"demo\"]}");
    assert_eq!(begun.status, 200, "{begun:?}");
    daemon.ctl(&["start", "--wait", "demo", "goto", "goal=0.2"]).expect_code(0);
    assert_eq!(owner.posts(&format!("{kept}/far.mcap/end"), "").json()["state"], "whole");
    daemon.ctl(&["disconnect", "demo/parameter"]).expect_code(0);
    let replayed = owner.posts(&format!("{kept}/far.mcap/replay"), "{\"rate\":10}");
    assert_eq!(replayed.json()["ports"], json!(["demo/parameter"]), "{replayed:?}");
    let replay = || owner.gets(kept).json()["recordings"][0]["replay"].clone();
    until("it is over", || replay()["goes_on"] == false);
    let told = replay();
    assert!(told["published"].as_u64().unwrap() > 0 && told["problem"].is_null(), "{told}");
}

#[test]
fn a_recording_ends_by_itself_after_its_time_and_with_its_daemon() {
    let (daemon, directory) = daemon("");
    let owner = Visitor::with_link(&link(&daemon, &[]));
    let timed = owner.posts("/api/recordings/kept", "{\"name\":\"timed\",\"seconds\":0.2}").json();
    assert_eq!(timed["file"], "timed.mcap");
    let state = |file: &str| {
        let all = owner.gets("/api/recordings/kept").json()["recordings"].clone();
        let one = all.as_array().unwrap().iter().find(|one| one["file"] == file).cloned();
        one.map(|one| one["state"].clone())
    };
    until("it ends by itself", || state("timed.mcap") == Some(json!("whole")));
    assert_eq!(owner.posts("/api/recordings/kept", "{\"name\":\"last\"}").status, 200);
    daemon.ctl(&["call", "demo", "get_speed"]).expect_code(0);
    let (stopped, _home) = daemon.stop("TERM");
    stopped.expect_code(0);
    let last = std::fs::read(directory.join("last.mcap")).unwrap();
    let summary = mcap::Summary::read(&last).unwrap().expect("it has its end");
    assert!(summary.stats.unwrap().message_count >= 2, "the call is in it");
}

#[test]
fn a_directory_has_limits_and_a_recording_ends_at_them() {
    let (daemon, directory) = daemon("most = 2\nmost_bytes = 60000\n");
    let owner = Visitor::with_link(&link(&daemon, &[]));
    let begin =
        |name: &str| owner.posts("/api/recordings/kept", &json!({"name": name}).to_string());
    assert_eq!(begin("first").status, 200);
    let whole = || owner.gets("/api/recordings/kept").json()["recordings"][0]["state"] == "whole";
    until("it ends at the limit", || {
        daemon.ctl(&["call", "demo", "get_speed"]).expect_code(0);
        whole()
    });
    let told = owner.gets("/api/recordings/kept").json()["recordings"][0].clone();
    assert!(told["why"].as_str().unwrap().contains("the limit of bytes is reached"), "{told}");
    let size = std::fs::metadata(directory.join("first.mcap")).unwrap().len();
    assert!(size <= 60_000, "{size} bytes");
    // It is a file that ends well: everything until then can be read.
    let first = std::fs::read(directory.join("first.mcap")).unwrap();
    assert!(mcap::Summary::read(&first).unwrap().unwrap().stats.unwrap().message_count > 10);
    std::fs::write(directory.join("other.mcap"), [0; 100]).unwrap();
    let refused = begin("third");
    assert_eq!((refused.status, refused.code().as_str()), (409, "recordings_full"), "{refused:?}");
    let same = begin("first");
    assert_eq!(same.status, 409, "{same:?}");
    assert_eq!(owner.sends("DELETE", "/api/recordings/kept/other.mcap", "").status, 200);
    std::fs::write(directory.join("large.mcap"), vec![0; 60_000]).unwrap();
    std::fs::remove_file(directory.join("first.mcap")).unwrap();
    assert_eq!(begin("fourth").code(), "recordings_full");
}

#[test]
fn no_name_leads_out_of_the_directory() {
    let (daemon, directory) = daemon("");
    let owner = Visitor::with_link(&link(&daemon, &[]));
    let secret = directory.with_file_name("secret.mcap");
    std::fs::write(&secret, "TOP-7391").unwrap();
    for name in [
        "../x",
        "../secret",
        "/etc/passwd",
        ".",
        "..",
        "a/b",
        ".hidden",
        "-rf",
        "a\0b",
        "a b",
        "ä",
        "a\nlog line",
        "<img src=x>",
        &"x".repeat(1_000),
        &"x".repeat(900_000),
    ] {
        let refused = owner.posts("/api/recordings/kept", &json!({"name": name}).to_string());
        assert_eq!((refused.status, refused.code().as_str()), (422, "bad_input"), "{name:.40}");
    }
    // As a file that is there, in a directory that is.
    assert_eq!(owner.posts("/api/recordings/kept", "{\"name\":\"own\",\"seconds\":0}").status, 200);
    let link_to = directory.join("link.mcap");
    std::os::unix::fs::symlink(&secret, &link_to).unwrap();
    std::fs::create_dir(directory.join("folder.mcap")).unwrap();
    for file in [
        "..%2Fsecret.mcap",
        "%2E%2E%2Fsecret.mcap",
        "..%252Fsecret.mcap",
        "%2Fetc%2Fpasswd",
        "link.mcap",
        "folder.mcap",
        "secret.mcap",
        "own",
        "own.mcap%00",
        "own.mcap%2F",
        ".",
        "%00",
        "..%5Csecret.mcap",
        "nothing.mcap",
    ] {
        let at = format!("/api/recordings/kept/{file}");
        for (method, path, body) in [
            ("GET", at.clone(), ""),
            ("DELETE", at.clone(), ""),
            ("POST", format!("{at}/end"), ""),
            ("POST", format!("{at}/replay"), "{}"),
            ("DELETE", format!("{at}/replay"), ""),
        ] {
            let refused = owner.sends(method, &path, body);
            assert!(matches!(refused.status, 400 | 404 | 405), "{method} {path}: {refused:?}");
            assert!(!refused.body.contains("TOP-7391"), "{refused:?}");
        }
    }
    assert_eq!(std::fs::read_to_string(&secret).unwrap(), "TOP-7391");
    assert!(link_to.exists(), "what is no recording is left alone");
    let listed = owner.gets("/api/recordings/kept").json();
    let files: Vec<_> =
        listed["recordings"].as_array().unwrap().iter().map(|one| one["file"].clone()).collect();
    assert_eq!(files, [json!("own.mcap")]);
    let (stopped, _home) = daemon.stop("TERM");
    stopped.expect_err("recordings: refused: `../x` is no name for a recording");
}

#[test]
fn a_file_that_is_no_recording_is_told_as_damaged_and_not_replayed() {
    let (daemon, directory) = daemon("");
    let owner = Visitor::with_link(&link(&daemon, &[]));
    assert_eq!(owner.posts("/api/recordings/kept", "{\"name\":\"own\"}").status, 200);
    daemon.ctl(&["call", "demo", "get_speed"]).expect_code(0);
    let ended = owner.posts("/api/recordings/kept/own.mcap/end", "").json();
    assert_eq!((&ended["state"], &ended["why"]), (&json!("whole"), &json!("asked")), "{ended}");
    let whole = std::fs::read(directory.join("own.mcap")).unwrap();
    // A daemon that is killed leaves no end.
    std::fs::write(directory.join("cut.mcap"), &whole[..whole.len() / 2]).unwrap();
    std::fs::write(directory.join("text.mcap"), "<script>").unwrap();
    std::fs::write(directory.join("none.mcap"), "").unwrap();
    let mut flipped = whole.clone();
    for at in (whole.len() / 2..whole.len() - 20).step_by(7) {
        flipped[at] = !flipped[at];
    }
    std::fs::write(directory.join("flipped.mcap"), flipped).unwrap();
    let listed = owner.gets("/api/recordings/kept").json();
    let state = |file: &str| {
        let all = listed["recordings"].as_array().unwrap();
        all.iter().find(|one| one["file"] == file).unwrap()["state"].clone()
    };
    assert_eq!((state("own.mcap"), state("cut.mcap")), (json!("whole"), json!("cut")));
    assert_eq!((state("text.mcap"), state("none.mcap")), (json!("damaged"), json!("damaged")));
    let replay =
        |file: &str| owner.posts(&format!("/api/recordings/kept/{file}.mcap/replay"), "{}");
    for file in ["text", "none"] {
        let refused = replay(file);
        assert_eq!((refused.status, refused.code().as_str()), (409, "unreadable"), "{refused:?}");
    }
    // What can be read of these is published, or they are refused.
    for file in ["flipped", "cut", "own"] {
        let reply = replay(file);
        assert!(matches!(reply.status, 200 | 409), "{file}: {reply:?}");
    }
    for body in ["{\"rate\":0}", "{\"rate\":1e9}", "{\"rate\":\"x\"}", "{\"to\":1}", "\u{0}"] {
        let refused = owner.posts("/api/recordings/kept/own.mcap/replay", body);
        assert!(matches!(refused.status, 400 | 422), "{body}: {refused:?}");
    }
    for body in [
        "{\"seconds\":-1}",
        "{\"seconds\":1e300}",
        "{\"ports\":[\"no/such\"]}",
        "{\"ports\":\"x\"}",
    ] {
        let refused = owner.posts("/api/recordings/kept", body);
        assert!(matches!(refused.status, 400 | 404 | 422), "{body}: {refused:?}");
    }
    assert_eq!(daemon.json(&["list"])["components"].as_array().unwrap().len(), 2);
}

#[test]
fn whoever_may_only_read_lists_and_downloads_and_nothing_else() {
    let (daemon, _) = daemon("");
    let owner = Visitor::with_link(&link(&daemon, &[]));
    assert_eq!(
        owner.posts("/api/recordings/kept", "{\"name\":\"whole\",\"seconds\":0}").status,
        200
    );
    assert_eq!(owner.posts("/api/recordings/kept", "{\"name\":\"going\"}").status, 200);
    let browser = shown(&daemon, &["--rights", "read"]);
    browser.until_shown("Your rights do not allow to record or to replay.");
    browser.until("both are listed", "document.querySelectorAll('[data-file]').length === 2");
    assert_eq!(browser.ask("return document.querySelectorAll('main form, [data-act]').length"), 0);
    let reader = Visitor::with_link(&link(&daemon, &["--rights", "read"]));
    let kept = "/api/recordings/kept";
    for (method, path, body) in [
        ("POST", kept.to_owned(), "{}"),
        ("POST", format!("{kept}/going.mcap/end"), ""),
        ("POST", format!("{kept}/whole.mcap/replay"), "{}"),
        ("DELETE", format!("{kept}/whole.mcap/replay"), ""),
        ("DELETE", format!("{kept}/whole.mcap"), ""),
    ] {
        let refused = reader.sends(method, &path, body);
        assert_eq!((refused.status, refused.code().as_str()), (403, "right_missing"), "{path}");
    }
    // What somebody with more rights began is not ended by its number either.
    for number in 0..20 {
        assert_eq!(reader.sends("DELETE", &format!("/api/recordings/{number}"), "").status, 404);
    }
    // To call does not mean to remove.
    let caller = Visitor::with_link(&link(&daemon, &["--rights", "read,call"]));
    assert_eq!(caller.sends("DELETE", &format!("{kept}/whole.mcap"), "").status, 403);
    assert_eq!(caller.posts(&format!("{kept}/going.mcap/end"), "").status, 200);
    let whole = reader.gets(&format!("{kept}/going.mcap"));
    assert_eq!(whole.header("content-type"), Some("application/octet-stream"));
    assert!(whole.body.contains("MCAP0"), "{:.100}", whole.body);
}
