//! What a cell may use: codels that take more are refused, or end their cell alone; the demo beside
//! them goes on.

use std::net::{TcpListener, UdpSocket};
use std::os::unix::fs::MetadataExt as _;
use std::path::PathBuf;

use genom_tests::{Daemon, Home, component, path, until};
use serde_json::{Value, json};

use super::{cell, load};

const EACCES: i64 = 13;
const EPERM: i64 = 1;

/// A daemon with the demo, and with `trespasses` in a cell of its own with these limits.
#[track_caller]
fn limited(limits: &str) -> Daemon {
    limited_by(&[], limits)
}

/// The same, started through a program that executes it.
#[track_caller]
fn limited_by(prefix: &[&str], limits: &str) -> Daemon {
    let home = Home::new().configured(&format!("[cell.trespasses]\n{limits}\n"));
    let demo = component("demo");
    let daemon = home.start_by(prefix, &[path(&demo.library)]);
    load(&daemon, "trespasses", &["--isolated"]);
    daemon
}

/// What a function of `trespasses` says.
#[track_caller]
fn tried(daemon: &Daemon, call: &[&str]) -> Value {
    daemon.json(&[&["call", "trespasses"], call].concat())["result"].clone()
}

#[track_caller]
fn goes_on(daemon: &Daemon) {
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
}

/// What the daemon logged, its cells' lines among it.
fn log(daemon: &Daemon) -> String {
    daemon.ctl(&["logs"]).out
}

/// Directories that a test looks at from inside: one granted, one not.
fn directories(daemon: &Daemon) -> [PathBuf; 2] {
    ["granted", "secret"].map(|name| daemon.home().path().join(name))
}

#[test]
fn files_are_denied_to_a_cell_unless_granted() {
    let home = Home::new();
    let [granted, secret] = ["granted", "secret"].map(|name| home.path().join(name));
    for directory in [&granted, &secret] {
        std::fs::create_dir(directory).unwrap();
        std::fs::write(directory.join("file"), "x").unwrap();
    }
    let limits = format!("[cell.trespasses]\nread = [{:?}]\n", granted);
    let daemon = home.configured(&limits).start(&[path(&component("demo").library)]);
    load(&daemon, "trespasses", &["--isolated"]);
    let [granted, secret] = directories(&daemon);
    let file = |directory: &PathBuf, name: &str| format!("path={}", directory.join(name).display());
    let error = |call: &[&str]| tried(&daemon, call)["error"].clone();
    assert_eq!(error(&["read_file", &file(&granted, "file")]), 0);
    let has = !log(&daemon).contains("no Landlock");
    let denied = if has { EACCES } else { 0 };
    assert_eq!(error(&["read_file", &file(&secret, "file")]), denied);
    assert_eq!(error(&["write_file", &file(&secret, "new")]), denied);
    // What the daemon was started with, such as a token, is not to be read either.
    let environment = format!("path=/proc/{}/environ", daemon.process().id());
    assert_eq!(error(&["read_file", &environment]), denied);
    // Read, and no more.
    assert_eq!(error(&["write_file", &file(&granted, "new")]), denied);
    assert_eq!(secret.join("new").exists(), !has);
    // It has temporary files of its own, and ports: the demo reads and is read all the same.
    goes_on(&daemon);
    daemon.ctl(&["unload", "trespasses"]).expect_code(0);
    until("the cell ends", || daemon.json(&["cells"])["cells"] == json!([]));
    assert!(!super::files(&daemon).exists(), "nothing is left");
}

#[test]
fn the_network_is_denied_to_a_cell_unless_granted() {
    let tcp = TcpListener::bind("127.0.0.1:0").unwrap();
    let udp = UdpSocket::bind("127.0.0.1:0").unwrap();
    let ports = [tcp.local_addr().unwrap().port(), udp.local_addr().unwrap().port()];
    let [tcp_port, udp_port] = ports.map(|port| format!("port={port}"));
    for (limits, expected) in
        [("network = false", EACCES), ("write = []", EACCES), ("network = true", 0)]
    {
        let daemon = limited(limits);
        let error = |call: &[&str]| tried(&daemon, call)["error"].clone();
        assert_eq!(error(&["connect_tcp", &tcp_port]), expected, "{limits}");
        assert_eq!(error(&["send_udp", &udp_port]), expected, "{limits}");
        goes_on(&daemon);
    }
}

#[test]
fn a_cell_in_a_sandbox_does_not_reach_the_control_plane_of_its_daemon() {
    let daemon = limited("network = false");
    let socket = format!("path={}", daemon.home().socket().display());
    assert_eq!(tried(&daemon, &["connect_unix", &socket])["error"], EACCES);
    let open = limited("nice = 1");
    let socket = format!("path={}", open.home().socket().display());
    assert_eq!(tried(&open, &["connect_unix", &socket])["error"], 0, "without a sandbox");
}

#[test]
fn a_cell_that_takes_too_much_memory_ends_alone_and_comes_back() {
    let daemon = limited("memory = 128");
    let mut events = daemon.events();
    let asked = daemon.ctl(&["call", "trespasses", "allocate"]);
    asked.expect_code(1);
    let ended = events.wait_for(|e| e["event"] == "cell_ended");
    let why = ended["why"].as_str().unwrap();
    assert!(why.ends_with("its memory is limited to 128 MiB"), "{why}");
    events.wait_for(|e| e["event"] == "cell_runs");
    assert!(tried(&daemon, &["lift_limit"])["error"].is_i64(), "it is back");
    goes_on(&daemon);
}

#[test]
fn a_cell_has_no_more_files_than_it_may_and_cannot_allow_itself_more() {
    let daemon = limited("files = 200");
    let opened = tried(&daemon, &["open_files"])["opened"].as_i64().unwrap();
    assert!((1..200).contains(&opened), "{opened}");
    assert_eq!(tried(&daemon, &["lift_limit"])["error"], EPERM, "root neither");
    assert_eq!(cell(&daemon, "trespasses")["starts"], json!(1));
    goes_on(&daemon);
}

#[test]
fn a_cell_without_processes_starts_none() {
    let daemon = limited("processes = 0");
    assert_eq!(tried(&daemon, &["fork_children", "most=50"])["made"], 0);
    assert_eq!(tried(&daemon, &["leave_daemon"])["pid"], 0);
    goes_on(&daemon);
}

#[test]
fn a_number_of_processes_that_does_not_hold_for_root_is_told() {
    let daemon = limited("processes = 100000");
    let root = std::fs::metadata("/proc/self").unwrap().uid() == 0;
    assert_eq!(log(&daemon).contains("processes = 100000 has no effect"), root);
}

#[test]
fn what_codels_of_a_cell_started_ends_with_it_wherever_it_went() {
    let daemon = limited("nice = 1");
    let mut events = daemon.events();
    assert_eq!(tried(&daemon, &["fork_children", "most=20"])["made"], 20);
    let pid = tried(&daemon, &["leave_daemon"])["pid"].to_string();
    let of_cell = || {
        let all = std::fs::read_dir("/proc").unwrap().flatten();
        let mark = format!("GENOMD_CELL={}", super::files(&daemon).join("trespasses").display());
        let has = |path: PathBuf| {
            let text = std::fs::read(path.join("environ")).unwrap_or_default();
            text.split(|byte| *byte == 0).any(|one| one == mark.as_bytes())
        };
        all.filter(|entry| has(entry.path())).count()
    };
    assert_eq!(of_cell(), 22, "the cell, twenty children, and one of another session");
    super::signal(&daemon, "trespasses", "KILL");
    events.wait_for(|e| e["event"] == "cell_runs");
    assert_eq!(of_cell(), 1, "the cell that was started anew");
    assert!(!PathBuf::from(format!("/proc/{pid}/exe")).exists());
    // The same when the daemon stops it.
    assert_eq!(tried(&daemon, &["fork_children", "most=20"])["made"], 20);
    daemon.ctl(&["cells", "--end", "trespasses"]).expect_code(0);
    assert_eq!(of_cell(), 0);
}

#[test]
fn a_real_time_thread_that_never_waits_ends_its_cell_and_one_that_may_not_is_refused() {
    let daemon = limited("rttime = 50");
    let mut events = daemon.events();
    let spun = daemon.ctl(&["--json", "call", "trespasses", "spin_real_time"]);
    if spun.code == Some(0) {
        // This user may not have real-time threads at all.
        assert!(
            spun.out.contains("\"error\":1") || spun.out.contains("\"error\": 1"),
            "{}",
            spun.out
        );
    } else {
        let ended = events.wait_for(|e| e["event"] == "cell_ended");
        let why = ended["why"].as_str().unwrap();
        let told = "signal 24 (SIGXCPU): a real-time thread ran for rttime = 50 ms without waiting";
        assert_eq!(why, told);
        events.wait_for(|e| e["event"] == "cell_runs");
    }
    goes_on(&daemon);
    let daemon = limited("real_time = false");
    assert_eq!(tried(&daemon, &["go_real_time"])["error"], EPERM, "root neither");
    goes_on(&daemon);
}

#[test]
fn a_cell_runs_on_its_processors_with_its_niceness() {
    let allowed = std::fs::read_to_string("/proc/self/status").unwrap();
    let list = allowed.lines().find_map(|line| line.strip_prefix("Cpus_allowed_list:")).unwrap();
    let first = list.trim().split([',', '-']).next().unwrap();
    let daemon = limited(&format!("cpus = [{first}]\nnice = 7\noom_score_adj = 300"));
    let pid = cell(&daemon, "trespasses")["pid"].to_string();
    for task in std::fs::read_dir(format!("/proc/{pid}/task")).unwrap().flatten() {
        let status = std::fs::read_to_string(task.path().join("status")).unwrap();
        assert!(status.contains(&format!("Cpus_allowed_list:\t{first}\n")), "{status}");
        let stat = std::fs::read_to_string(task.path().join("stat")).unwrap();
        let fields: Vec<_> = stat.rsplit_once(") ").unwrap().1.split(' ').collect();
        assert_eq!(fields[16], "7", "{stat}");
    }
    let score = std::fs::read_to_string(format!("/proc/{pid}/oom_score_adj")).unwrap();
    assert_eq!(score.trim(), "300");
}

#[test]
fn a_limit_that_cannot_be_had_is_told_and_refused_where_that_is_wanted() {
    let daemon = limited("cpus = [1000]");
    let told = || log(&daemon).matches("limits of this cell: cpus = [1000]").count();
    assert_eq!(told(), 1, "{}", log(&daemon));
    // Not again at each start.
    daemon.ctl(&["cells", "--restart", "trespasses"]).expect_code(0);
    until("the next process has logged", || log(&daemon).matches("runs on shm").count() > 1);
    assert_eq!(told(), 1, "{}", log(&daemon));
    let home = Home::new().configured("[cell.trespasses]\ncpus = [1000]\nstrict = true\n");
    let daemon = home.start(&[path(&component("demo").library)]);
    let library = component("trespasses").library;
    let refused = daemon.ctl(&["load", path(&library), "--isolated"]);
    refused.expect_code(1).expect_err("cpus = [1000]").expect_err("take `strict = true` away");
    goes_on(&daemon);
    let home = Home::new().configured("[cell.trespasses]\nnice = 30\n");
    home.refused(&[]).expect_code(2).expect_err("cell.trespasses.nice = 30: -20 to 19");
}

#[test]
fn a_cell_that_refuses_to_start_again_is_told_with_the_reason_and_starts_once_that_is_mended() {
    let home = Home::new();
    let maps = home.path().join("maps");
    std::fs::create_dir(&maps).unwrap();
    let limits = format!("[cell.trespasses]\nread = [{maps:?}]\nstrict = true\n");
    let daemon = home.configured(&limits).start(&[path(&component("demo").library)]);
    load(&daemon, "trespasses", &["--isolated"]);
    let mut events = daemon.events();
    std::fs::remove_dir(&maps).unwrap();
    super::signal(&daemon, "trespasses", "KILL");
    events.wait_for(|e| e["event"] == "cell_ended" && e["restarts"] == true);
    let ended = events.wait_for(|e| e["event"] == "cell_ended");
    let why = ended["why"].as_str().unwrap();
    assert!(why.starts_with("refused: ") && why.contains(path(&maps)), "{why}");
    // It would refuse again.
    assert_eq!(ended["restarts"], false);
    assert_eq!(cell(&daemon, "trespasses")["state"], "failed");
    goes_on(&daemon);
    std::fs::create_dir(&maps).unwrap();
    daemon.ctl(&["cells", "--restart", "trespasses"]).expect_code(0);
    assert_eq!(cell(&daemon, "trespasses")["state"], "running");
    assert_eq!(cell(&daemon, "trespasses")["components"], json!(["trespasses"]));
}

#[test]
fn a_kernel_without_landlock_is_told_and_what_does_not_need_it_holds() {
    let filter = genom_tests::repository().join("tests/fixtures/without_landlock.py");
    let by = ["python3", path(&filter)];
    let daemon = limited_by(&by, "network = false");
    assert!(log(&daemon).contains("this kernel has no Landlock: files are not denied"));
    let tcp = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("port={}", tcp.local_addr().unwrap().port());
    assert_eq!(tried(&daemon, &["connect_tcp", &port])["error"], EACCES);
    goes_on(&daemon);
    let home = Home::new().configured("[cell.trespasses]\nread = []\nstrict = true\n");
    let daemon = home.start_by(&by, &[path(&component("demo").library)]);
    let library = component("trespasses").library;
    let refused = daemon.ctl(&["load", path(&library), "--isolated"]);
    refused.expect_code(1).expect_err("no Landlock");
}
