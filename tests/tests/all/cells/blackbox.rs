//! The black box: what happened right before a crash is in a file, whatever the crash took.

use std::collections::BTreeMap;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use genom_tests::{Daemon, Home, component, path, request, until};
use serde_json::{Value, json};

use super::{cell, load, signal};

const ON: &str = "[blackbox]\nenabled = true\n";

/// A daemon whose black box is on, with this besides.
fn boxed(more: &str) -> Daemon {
    Home::new().configured(&format!("{ON}{more}")).start(&[])
}

/// Messages by topic.
#[derive(Debug, Default)]
struct File {
    messages: BTreeMap<String, Vec<(u64, Vec<u8>)>>,
    metadata: BTreeMap<String, BTreeMap<String, String>>,
}

#[track_caller]
fn read(file: &Path) -> File {
    let mapped = std::fs::read(file).unwrap();
    let mut read = File::default();
    for message in mcap::MessageStream::new(&mapped).unwrap() {
        let message = message.unwrap();
        let all = read.messages.entry(message.channel.topic.clone()).or_default();
        all.push((message.log_time, message.data.to_vec()));
    }
    let summary = mcap::Summary::read(&mapped).unwrap().expect("it is complete");
    for index in &summary.metadata_indexes {
        let found = mcap::read::metadata(&mapped, index).unwrap();
        read.metadata.insert(found.name, found.metadata);
    }
    read
}

impl File {
    #[track_caller]
    fn json(&self, topic: &str) -> Vec<Value> {
        let all = self.messages.get(topic).unwrap_or_else(|| panic!("{:?}", self.messages.keys()));
        all.iter().map(|(_, text)| serde_json::from_slice(text).unwrap()).collect()
    }

    /// Values of a port of type `long`.
    #[track_caller]
    fn longs(&self, topic: &str) -> Vec<i32> {
        let all = self.messages.get(topic).unwrap_or_else(|| panic!("{:?}", self.messages.keys()));
        let value = |bytes: &[u8]| i32::from_le_bytes(*bytes[4..].first_chunk().unwrap());
        all.iter().map(|(_, bytes)| value(bytes)).collect()
    }
}

/// The file beside the report of the next crash.
#[track_caller]
fn left(daemon: &Daemon, crash: impl FnOnce(&Daemon)) -> (Value, PathBuf) {
    let mut events = daemon.events();
    crash(daemon);
    let told = events.wait_for(|e| e["event"] == "cell_crashed");
    let report = daemon.json(&["crashes", told["report"].as_str().unwrap()]);
    let file = report["blackbox"]["file"].as_str().unwrap_or_else(|| panic!("{report:#}"));
    let file = PathBuf::from(file);
    (report, file)
}

#[test]
fn the_sample_of_the_tick_that_crashed_is_in_the_box() {
    let daemon = boxed("");
    load(&daemon, "falls", &["--cell", "arm"]);
    load(&daemon, "demo", &[]);
    let (report, file) = left(&daemon, |daemon| {
        daemon.ctl(&["call", "falls", "fall", "at=250"]).expect_code(1);
    });
    let read = read(&file);
    let ticks = read.longs("/falls/ticks");
    assert_eq!(ticks, (1..=250).collect::<Vec<_>>(), "each, and the last one too");
    assert_eq!(report["blackbox"]["error"], Value::Null);
    // The request is there, and has no reply.
    let calls = read.json("/genom/calls");
    let of_fall: Vec<_> = calls.iter().filter(|call| call["service"] == "fall").collect();
    assert_eq!(of_fall.len(), 1);
    assert_eq!(
        (&of_fall[0]["phase"], &of_fall[0]["inputs"]),
        (&json!("request"), &json!({"at": 250}))
    );
    let activities = read.json("/genom/activities");
    let event = |kind: &str| activities.iter().filter(|one| one["event"] == kind).count();
    assert_eq!((event("activity_started"), event("activity_ended")), (1, 0), "{activities:?}");
    assert!(activities.iter().any(|one| one["state"] == "tick"), "{activities:?}");
    // What the daemon itself did is there as well.
    let loaded = |one: &Value| one["event"] == "component_loaded" && one["component"] == "demo";
    assert!(read.json("/genom/changes").iter().any(loaded));
    assert!(read.messages.contains_key("/demo/position"));
    let why = &read.metadata["genom.blackbox"];
    assert_eq!((why["reason"].as_str(), why["cell"].as_str()), ("crash", "arm"));
    assert_eq!(why["detail"], "signal 11 (SIGSEGV)");
    assert_eq!(report["name"], why["report"].as_str());
    assert_eq!(std::fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
    // People are told where it is.
    let shown = daemon.ctl(&["crashes", "1"]).expect_code(0).out.clone();
    assert!(shown.contains(&format!("black box: {}", file.display())), "{shown}");
}

#[test]
fn the_file_is_read_by_the_python_package_mcap() {
    let daemon = boxed("");
    load(&daemon, "falls", &["--cell", "arm"]);
    let (_, file) = left(&daemon, |daemon| {
        daemon.ctl(&["call", "falls", "fall", "at=20"]).expect_code(1);
    });
    let topics = crate::control_plane::recording::read(&file);
    let ticks = topics["/falls/ticks"].as_array().unwrap();
    assert_eq!(ticks.last().unwrap()[2], json!({"data": 20}));
    let why = &topics["metadata"]["genom.blackbox"];
    assert_eq!((&why["reason"], &why["cell"]), (&json!("crash"), &json!("arm")));
    // Dates are those of recordings: of the clock on the wall, and the last before the file's.
    let written: u64 = why["date_ns"].as_str().unwrap().parse().unwrap();
    assert!(ticks.last().unwrap()[0].as_u64().unwrap() <= written);
    assert_eq!(topics["metadata"]["genom.lost"]["complete"], "true");
    assert_eq!(topics["attachments"], json!(["deployment.toml"]));
    assert_eq!(topics["/genom/calls"][0][2]["service"], "fall");
}

#[test]
fn samples_up_to_a_kill_are_in_the_box_and_dates_rise() {
    let daemon = boxed("");
    load(&daemon, "falls", &["--cell", "arm"]);
    daemon.ctl(&["start", "falls", "fall", "at=-1"]).expect_code(0);
    let written = || daemon.port("falls", "ticks")["value"].as_i64().unwrap_or(0);
    until("it writes", || written() > 200);
    let before = written();
    let (_, file) = left(&daemon, |daemon| signal(daemon, "arm", "KILL"));
    let read = read(&file);
    let ticks = read.longs("/falls/ticks");
    assert!(i64::from(*ticks.last().unwrap()) >= before, "{before} {:?}", ticks.last());
    assert!(ticks.is_sorted_by(|one, next| one + 1 == *next));
    let dates: Vec<u64> = read.messages["/falls/ticks"].iter().map(|one| one.0).collect();
    assert!(dates.is_sorted());
}

#[test]
fn a_cell_in_a_sandbox_has_a_box_and_a_report_with_its_backtrace() {
    let daemon = boxed("[cells.limits]\nnetwork = false\n");
    load(&daemon, "falls", &["--cell", "arm"]);
    let (report, file) = left(&daemon, |daemon| {
        daemon.ctl(&["call", "falls", "fall", "at=5"]).expect_code(1);
    });
    assert_eq!(read(&file).longs("/falls/ticks"), [1, 2, 3, 4, 5]);
    assert_eq!(report["codel"], "falls_tick");
    let fault = &report["fault"];
    assert_eq!((&fault["cut"], &fault["guessed"]), (&json!(false), &json!(false)));
    let first = fault["frames"][0]["function"].as_str().unwrap_or_default();
    assert!(first.starts_with("falls_tick+0x"), "{fault:#}");
    let frames = fault["frames"].as_array().unwrap();
    let own = |frame: &Value| {
        frame["function"].as_str().is_some_and(|name| name.contains("genom_host::"))
    };
    assert!(frames.iter().any(own), "the daemon's functions have names of Rust: {fault:#}");
}

#[test]
fn a_daemon_that_adopts_a_cell_has_what_it_did_before() {
    let daemon = boxed("");
    load(&daemon, "falls", &["--cell", "arm"]);
    daemon.ctl(&["start", "falls", "fall", "at=-1"]).expect_code(0);
    let home = daemon.abandon();
    let daemon = home.start(&[]);
    let (_, file) = left(&daemon, |daemon| signal(daemon, "arm", "KILL"));
    assert_eq!(read(&file).longs("/falls/ticks")[0], 1);
}

#[test]
fn only_what_is_chosen_is_kept_and_a_pattern_that_matches_nothing_is_told() {
    let daemon = boxed("ports = [\"demo/positon\", \"falls/*\"]\nservices = [\"demo/goto\"]\n");
    for name in ["demo", "falls"] {
        load(&daemon, name, &[]);
    }
    daemon.ctl(&["call", "demo", "set_speed", "velocity=1"]).expect_code(0);
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    daemon.ctl(&["start", "falls", "fall", "at=-1"]).expect_code(0);
    until("it writes", || daemon.port("falls", "ticks")["value"].as_i64().unwrap_or(0) > 3);
    let file = daemon.home().path().join("here.mcap");
    daemon.ctl(&["blackbox", "save", path(&file)]).expect_code(0);
    let read = read(&file);
    assert!(read.longs("/falls/ticks").len() > 3);
    assert!(!read.messages.contains_key("/demo/position"), "{:?}", read.messages.keys());
    let calls = read.json("/genom/calls");
    assert!(calls.iter().all(|call| call["service"] == "goto") && calls.len() == 2, "{calls:?}");
    let told = daemon.json(&["blackbox"]);
    let wanted = "blackbox.ports: `demo/positon` matches nothing that runs; did you mean \
                  `demo/position`?";
    assert_eq!(told["unmatched"], json!([wanted]));
    // A file that is there is not replaced.
    let again = daemon.ctl(&["blackbox", "save", path(&file)]);
    again.expect_code(2).expect_err("--force");
    daemon.ctl(&["blackbox", "save", path(&file), "--force"]).expect_code(0);
}

#[test]
fn a_pattern_that_matches_nothing_is_told_at_the_start() {
    let home = Home::new().configured(&format!("{ON}exceptions = [\"demo/gotoo\"]\n"));
    let daemon = home.start(&[path(&component("demo").library)]);
    let wanted = "blackbox.exceptions: `demo/gotoo` matches nothing that runs; did you mean \
                  `demo/goto`?";
    until("it is told", || daemon.ctl(&["logs"]).out.contains(wanted));
}

#[test]
fn an_exception_of_a_chosen_service_writes_a_file_and_the_next_ones_are_counted() {
    let on = "on = [\"exception\"]\nexceptions = [\"*/goto\"]\nseconds = 3600\n";
    let daemon = boxed(on);
    load(&daemon, "demo", &["--cell", "arm"]);
    let mut events = daemon.events();
    // Not chosen, or asked for.
    daemon.ctl(&["call", "demo", "set_speed", "velocity=99"]).expect_code(1);
    for _ in 0..3 {
        daemon.ctl(&["call", "demo", "goto", "goal=99"]).expect_code(1);
    }
    let told = events.wait_for(|e| e["event"] == "blackbox_saved");
    let file = PathBuf::from(told["file"].as_str().unwrap());
    assert!(told["why"].as_str().unwrap().starts_with("exception: demo/goto: "), "{told}");
    let exceptions = read(&file).json("/genom/exceptions");
    assert!(exceptions.iter().any(|one| one["service"] == "goto"), "{exceptions:?}");
    until("the others are counted", || daemon.json(&["blackbox"])["skipped"] == 2);
    let place = file.parent().unwrap();
    assert_eq!(place, daemon.home().path().join("state/genomd/blackbox"));
    let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
    assert_eq!((mode(place), mode(&file)), (0o700, 0o600));
    assert_eq!(std::fs::read_dir(place).unwrap().count(), 1);
}

#[test]
fn files_on_command_are_limited_and_links_are_not_followed() {
    let daemon = boxed("most = 3\n");
    load(&daemon, "demo", &[]);
    let mut last = Value::Null;
    for _ in 0..6 {
        last = daemon.json(&["blackbox", "save"])["file"].clone();
    }
    let files = daemon.json(&["blackbox"])["files"].as_array().unwrap().clone();
    assert_eq!(files.len(), 3);
    assert!(last.as_str().unwrap().ends_with(files[0]["name"].as_str().unwrap()));
    // A directory that others may write to gets nothing.
    let place = PathBuf::from(last.as_str().unwrap()).parent().unwrap().to_owned();
    let open = |mode| {
        std::fs::set_permissions(&place, std::fs::Permissions::from_mode(mode)).unwrap();
    };
    open(0o777);
    let refused = daemon.ctl(&["blackbox", "save"]);
    refused.expect_code(1).expect_err("set blackbox.directory");
    open(0o700);
    // Nor one that is a link to a file.
    std::fs::remove_dir_all(&place).unwrap();
    let secret = daemon.home().path().join("secret");
    std::fs::write(&secret, "kept").unwrap();
    std::os::unix::fs::symlink(&secret, &place).unwrap();
    daemon.ctl(&["blackbox", "save"]).expect_code(1).expect_err("blackbox");
    assert_eq!(std::fs::read_to_string(&secret).unwrap(), "kept");
    daemon.ctl(&["call", "demo", "get_speed"]).expect_code(0);
}

#[test]
fn a_box_that_is_off_keeps_nothing_and_says_how_to_switch_it_on() {
    let daemon = Home::new().start(&[]);
    load(&daemon, "demo", &["--cell", "arm"]);
    daemon.ctl(&["blackbox"]).expect_code(0);
    assert_eq!(daemon.json(&["blackbox"])["processes"], json!([]));
    let refused = daemon.ctl(&["blackbox", "save"]);
    refused.expect_code(1).expect_err("set blackbox.enabled = true");
    let reply = request(&daemon.home().socket(), "GET", "/blackbox/frames", "");
    assert_eq!(reply.status, 409);
    let pid = cell(&daemon, "arm")["pid"].to_string();
    let maps = std::fs::read_to_string(format!("/proc/{pid}/maps")).unwrap();
    assert!(!maps.contains("genom-blackbox"));
}

#[test]
fn a_disk_that_is_full_leaves_a_file_that_can_be_read_as_far_as_it_goes() {
    let daemon = boxed("");
    load(&daemon, "falls", &[]);
    daemon.ctl(&["start", "falls", "fall", "at=-1"]).expect_code(0);
    until("it has written much", || {
        daemon.port("falls", "ticks")["value"].as_i64().unwrap_or(0) > 2_000
    });
    let pid = daemon.process().id().to_string();
    let mut limit = std::process::Command::new("prlimit");
    assert!(limit.args(["--pid", &pid, "--fsize=40000"]).status().unwrap().success());
    daemon.ctl(&["blackbox", "save"]).expect_code(1).expect_err("it ends there");
    let told = daemon.json(&["blackbox"]);
    let place = PathBuf::from(told["directory"].as_str().unwrap());
    let file = place.join(told["files"][0]["name"].as_str().unwrap());
    assert_eq!(read(&file).longs("/falls/ticks")[0], 1);
}
