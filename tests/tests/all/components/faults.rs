//! Components that misbehave (`components/faults`): for each, what must still work. Codels that
//! never return are in `hangs.rs`.

use genom_tests::{Daemon, Home, component, path};
use serde_json::{Value, json};

/// Starts a daemon with the demo and a component that misbehaves.
fn beside_the_demo(name: &str) -> Daemon {
    let daemon = Daemon::demo("local");
    daemon.ctl(&["load", path(&component(name).library)]).expect_code(0);
    daemon
}

/// Checks that the demo moves and that the daemon ends normally.
#[track_caller]
fn goes_on_and_ends_well(daemon: Daemon) {
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    let (stopped, home) = daemon.stop("TERM");
    stopped.expect_code(0);
    assert!(!home.socket().exists());
}

fn number(reply: &Value) -> u64 {
    reply.as_u64().unwrap()
}

#[test]
fn a_service_that_blocks_holds_up_only_those_that_wait_for_it() {
    // genom3.md 7.3, 7.10.
    let daemon = beside_the_demo("blocks");
    let counted = || number(&daemon.json(&["call", "blocks", "get_count"])["result"]["count"]);
    daemon.ctl(&["start", "blocks", "count"]).expect_code(0);
    let blocked = [
        daemon.spawn(&["call", "blocks", "wait"]),
        daemon.spawn(&["call", "blocks", "wait_validate"]),
        daemon.spawn(&["call", "blocks", "hang_async"]),
    ];
    // Attributes are served, and the periodic task continues.
    let before = counted();
    let end = std::time::Instant::now() + genom_tests::WATCHDOG;
    while counted() < before + 3 {
        assert!(std::time::Instant::now() < end, "the task stands still");
    }
    // Whether or not each of them has reached its gate by now.
    for _ in &blocked {
        daemon.ctl(&["call", "blocks", "release"]).expect_code(0);
    }
    for call in blocked {
        call.finish().expect_code(0);
    }
    goes_on_and_ends_well(daemon);
}

#[test]
fn a_codel_beyond_its_period_is_counted_and_disturbs_no_other_task() {
    // genom3.md 7.4: missed ticks are latched as one.
    let daemon = beside_the_demo("overruns");
    let mut events = daemon.events();
    let steady = || number(&daemon.json(&["call", "overruns", "get_steady"])["result"]["steady"]);
    let before = steady();
    let done = daemon.json(&["call", "overruns", "work", "calls=10", "duration=0.015"]);
    assert_eq!(done["result"]["done"], 10);
    assert!(steady() > before, "task steady stands still");
    let told = events.wait_for(|e| e["event"] == "overrun" && e["task"] == "main");
    assert!(number(&told["ticks"]) >= 1, "{told}");
    let stats = daemon.json(&["stats", "overruns"]);
    let all = stats["tasks"].as_array().unwrap();
    let main = all.iter().find(|task| task["name"] == "main").unwrap();
    // Ten calls of three periods each cause at least ten overruns.
    assert!(number(&main["overruns"]) >= 10, "{main}");
    let codels = stats["codels"].as_array().unwrap();
    let work = codels.iter().find(|codel| codel["name"] == "overruns_work").unwrap();
    assert_eq!(work["durations"]["count"], 10, "{work}");
    goes_on_and_ends_well(daemon);
}

#[test]
fn what_is_written_past_a_period_arrives_whole() {
    // genom3.md 7.8: a port keeps the value of its last write.
    let daemon = beside_the_demo("overruns");
    let echo = daemon.spawn(&["echo", "overruns/progress", "--rate", "1000"]);
    daemon.ctl(&["call", "overruns", "work", "calls=8", "duration=0.012"]).expect_code(0);
    let mut last = 0;
    while last < 8 {
        let report: Value = serde_json::from_str(&echo.line()).unwrap();
        let calls = number(&report["calls"]);
        assert!(calls > last, "{report} after {last}");
        assert_eq!(report["again"], Value::from(vec![calls as f64; 8]), "half a report");
        last = calls;
    }
    assert_eq!(daemon.port("overruns", "progress")["value"]["calls"], 8);
    goes_on_and_ends_well(daemon);
}

#[test]
fn what_a_codel_may_not_return_ends_its_service_and_nothing_else() {
    // genom3.md 7.5 for activities, 7.3.7 for functions, 7.3.5 for validation.
    let daemon = beside_the_demo("strays");
    let ends = |service: &str, told: &str| {
        let ended = daemon.ctl(&["call", "strays", service]);
        ended.expect_code(1).expect_err(told);
    };
    for (service, to) in [
        ("unknown", "::strays::nowhere"),
        ("nothing", "genom_ok"),
        ("elsewhere", "::strays::other"),
        ("undeclared", "::strays::UNDECLARED"),
    ] {
        let told = json!({ "from": "::strays::start", "to": to });
        ends(service, &format!("::genom::bad_transition {told}"));
    }
    ends("declared", r#"::strays::DECLARED {"code":42,"what":"as declared"}"#);
    ends("unraised", "::strays::DECLARED");
    ends("undeclared_function", r#"::genom::unkex {"what":"::strays::UNDECLARED"}"#);
    ends("system_error", r#"::genom::unkex {"what":"::genom::syserr"}"#);
    ends("second_fails", r#"::strays::DECLARED {"code":2"#);
    ends("refused", "::strays::nowhere");
    // Twice, to show that nothing was used up.
    ends("declared", r#"::strays::DECLARED {"code":42,"what":"as declared"}"#);
    goes_on_and_ends_well(daemon);
}

#[test]
fn a_crash_takes_its_own_daemon_only_and_leaves_nothing_in_the_way() {
    let crashes = component("crashes");
    for (service, signal) in [("segfault", "SIGSEGV"), ("abort", "SIGABRT")] {
        let demo = Daemon::demo("shm");
        let memory = std::sync::Arc::clone(demo.home().memory());
        let start = || Home::with(&memory).start(&["--backend", "shm", path(&crashes.library)]);
        let daemon = start();
        daemon.ctl(&["call", "crashes", "divide", "by=3"]).expect_code(0);
        // The client notices, sooner or later, that the daemon is gone.
        let told = daemon.ctl(&["start", "crashes", service]);
        assert!(told.code == Some(0) || told.code == Some(3), "{told:?}");
        let ended = daemon.finish().0;
        assert_eq!(ended.code, None, "a signal ends it");
        ended.expect_err(&format!("{signal} in codel `crashes_{service}` of "));
        demo.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
        // The name and its shared memory are free again.
        let daemon = start();
        daemon.ctl(&["call", "crashes", "divide", "by=3"]).expect_code(0);
        daemon.stop("TERM").0.expect_code(0);
        demo.stop("TERM").0.expect_code(0);
        assert_eq!(memory.files(), Vec::<std::path::PathBuf>::new());
    }
}

#[test]
fn a_codel_that_calls_exit_is_named_and_is_no_success() {
    let daemon = Daemon::start(&[path(&component("crashes").library)]);
    daemon.ctl(&["call", "crashes", "leave"]).expect_code(3);
    let ended = daemon.finish().0;
    ended.expect_code(1).expect_err("exit called by codel `crashes_leave` of ");
}

#[test]
fn what_codels_allocate_is_released_and_a_leak_harms_nobody() {
    // genom3.md 7.9: the host releases allocations in outputs.
    let daemon = beside_the_demo("allocates");
    let call = |service: &str, inputs: &[&str]| {
        daemon.json(&[&["call", "allocates", service], inputs].concat())["result"].clone()
    };
    assert_eq!(call("text", &["length=5"])["text"], "xxxxx");
    assert_eq!(call("numbers", &["count=3"])["values"], json!([0.0, 1.0, 2.0]));
    assert_eq!(call("borrowed", &[])["values"], json!([1, 2, 3, 5, 8]));
    for count in ["0", "1", "1000", "7"] {
        let owned = call("owned", &[&format!("count={count}")]);
        assert_eq!(owned["values"].as_array().unwrap().len().to_string(), count);
    }
    // Only buffers kept for the next request have not been given back.
    let held = call("balance", &[])["buffers"].as_i64().unwrap();
    assert!((0..=2).contains(&held), "{held} buffers are held");
    for count in ["5", "2", "0", "3"] {
        call("nested", &[&format!("count={count}")]);
    }
    daemon.ctl(&["call", "allocates", "set_text", "text=kept"]).expect_code(0);
    let ids = call("get", &[]);
    assert_eq!((&ids["text"], ids["items"].as_array().unwrap().len()), (&json!("kept"), 3));
    assert_eq!(ids["items"][2], json!({ "name": "item of 2 bytes", "data": [0, 1] }));
    call("publish", &["times=20"]);
    let latest = daemon.port("allocates", "latest")["value"].clone();
    assert_eq!(latest["name"], "item of 19 bytes");
    assert_eq!(latest["data"].as_array().unwrap().len(), 19);
    (0..3).for_each(|_| drop(call("leak", &["bytes=1000000"])));
    goes_on_and_ends_well(daemon);
}

#[test]
fn a_library_that_lies_about_its_types_is_refused_and_nothing_of_it_runs() {
    let daemon = Daemon::demo("local");
    let refused = daemon.ctl(&["load", path(&component("lies").library)]);
    refused.expect_code(1);
    for codel in ["lies_layout", "lies_scalar", "lies_address", "lies_count"] {
        refused.expect_err(codel);
    }
    assert!(!refused.err.contains("lies_honest"), "{}", refused.err);
    refused.expect_err("lies.gen:");
    assert_eq!(daemon.json(&["list"])["components"].as_array().unwrap().len(), 1);
    goes_on_and_ends_well(daemon);
}

#[test]
fn a_library_that_lacks_a_codel_is_refused_beside_one_that_runs() {
    let daemon = Daemon::demo("local");
    let refused = daemon.ctl(&["load", path(&component("misses").library)]);
    refused.expect_code(1).expect_err("misses_absent").expect_err("misses.gen:");
    assert!(!refused.err.contains("misses_present"), "{}", refused.err);
    goes_on_and_ends_well(daemon);
}

#[test]
fn an_exception_of_cpp_that_escapes_becomes_unkex_with_what_it_says() {
    let daemon = beside_the_demo("escapes");
    let ends = |service: &str, told: &str| {
        daemon.ctl(&["call", "escapes", service]).expect_code(1).expect_err(told);
    };
    ends("fail", r#"::genom::unkex {"what":"the motor is on fire"}"#);
    ends("strange", "::genom::unkex");
    let later = daemon.ctl(&["call", "escapes", "fail_later", "after=2"]);
    later.expect_code(1);
    later.expect_err(r#"::genom::unkex {"what":"stalled after 2 periods"}"#);
    // Destructors ran, the native object is intact, and codels continue.
    let turned = daemon.json(&["call", "escapes", "revolutions"]);
    assert_eq!(turned["result"]["revolutions"], 3);
    ends("fail", "the motor is on fire");
    goes_on_and_ends_well(daemon);
}

#[test]
fn codels_that_treat_the_process_as_their_own_do_not_end_it() {
    let daemon = beside_the_demo("unruly");
    let call = |service: &str| daemon.json(&["call", "unruly", service])["result"].clone();
    assert_eq!(call("constructed")["constructed"], 1);
    assert_eq!(call("fork")["status"], 3);
    assert_eq!(call("shell")["status"], 4);
    // A thread that the library started.
    let before = number(&call("turns")["turns"]);
    let end = std::time::Instant::now() + genom_tests::WATCHDOG;
    while number(&call("turns")["turns"]) == before {
        assert!(std::time::Instant::now() < end, "the library's thread stands still");
    }
    for service in ["block_signals", "ignore_signals", "speak", "change_world"] {
        call(service);
    }
    let put_back = |line: &str| line.contains("SIGTERM") && line.contains("put back");
    assert!(daemon.process().error_line_where(put_back).is_some());
    // Numbers are parsed as before, files are found, and other components can be loaded.
    let speed = daemon.ctl(&["call", "demo", "set_speed", "velocity=0.25"]);
    speed.expect_code(0);
    assert_eq!(daemon.json(&["call", "demo", "get_speed"])["result"]["velocity"], 0.25);
    let second = component("demo-rs");
    daemon.ctl(&["load", path(&second.library), "--name", "second"]).expect_code(0);
    daemon.ctl(&["call", "second", "goto", "goal=0.01"]).expect_code(0);
    goes_on_and_ends_well(daemon);
}
