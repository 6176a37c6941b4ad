//! What the configuration requests from the system: locked memory, processors, real-time priority.
//!
//! Whether the system grants it depends on who runs the tests, so these check that the daemon
//! reports it truthfully. That it continues when everything is refused is checked by giving up all
//! privileges.

use std::fs;
use std::time::{Duration, Instant};

use genom_tests::{Daemon, Home, WATCHDOG, component, path};
use serde_json::Value;

/// Value of a field in `/proc/<pid>/status`.
fn field(status: &str, name: &str) -> String {
    let mut lines = status.lines();
    let value = lines.find_map(|line| line.strip_prefix(name)?.strip_prefix(':'));
    value.unwrap_or_else(|| panic!("no {name} in {status}")).trim().to_owned()
}

fn status(process: &str) -> String {
    fs::read_to_string(format!("/proc/{process}/status")).unwrap()
}

/// A processor that this process may use.
fn some_cpu() -> usize {
    let all = field(&status("self"), "Cpus_allowed_list");
    let last = all.rsplit([',', '-']).next().unwrap();
    last.parse().unwrap()
}

/// The demo with real-time settings for its task and memory.
fn demo(prefix: &[&str], cpu: usize) -> Daemon {
    let demo = component("demo");
    let config = format!(
        "lock_memory = true\n[[component]]\nlibrary = {:?}\n[component.tasks.main]\n\
         real_time = true\npriority = 20\ncpus = [{cpu}]\n",
        path(&demo.library)
    );
    Home::new().configured(&config).start_by(prefix, &[])
}

/// Allowed processors, priority and scheduling policy of the demo's task thread.
fn thread_of_task(daemon: &Daemon) -> (String, u32, i32) {
    let tasks = format!("/proc/{}/task", daemon.process().id());
    for entry in fs::read_dir(tasks).unwrap() {
        let directory = entry.unwrap().path();
        let status = fs::read_to_string(directory.join("status")).unwrap_or_default();
        if status.starts_with("Name:\tdemo:main\n") {
            let stat = fs::read_to_string(directory.join("stat")).unwrap();
            // proc(5): fields 40 and 41, counted from 1; the text after the name begins with field
            // 3.
            let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
            let priority = fields[40 - 3].parse().unwrap();
            return (
                field(&status, "Cpus_allowed_list"),
                priority,
                fields[41 - 3].parse().unwrap(),
            );
        }
    }
    panic!("the task has no thread");
}

const FIFO: i32 = 1;

#[test]
fn the_daemon_says_truly_what_the_system_granted() {
    let cpu = some_cpu();
    let daemon = demo(&[], cpu);
    // genom3.md 7.4: 0 is the highest priority, 255 the lowest, which is 1 for the system.
    let (cpus, priority, policy) = thread_of_task(&daemon);
    let locked = field(&status(&daemon.process().id().to_string()), "VmLck") != "0 kB";
    let real_time = daemon.json(&["stats", "demo"])["tasks"][0]["real_time"] == true;
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    let (stopped, _) = daemon.stop("TERM");
    stopped.expect_code(0);
    assert_eq!(cpus, cpu.to_string());
    assert_eq!(real_time, policy == FIFO);
    assert_eq!(real_time, !stopped.err.contains("no real-time scheduling"), "{}", stopped.err);
    assert_eq!(priority, if real_time { 84 } else { 0 });
    assert_eq!(locked, stopped.err.contains("memory is locked"), "{}", stopped.err);
    assert_eq!(locked, !stopped.err.contains("memory is not locked"), "{}", stopped.err);
}

#[test]
fn what_is_refused_is_said_and_done_without() {
    let limits = ["prlimit", "--memlock=65536", "--rtprio=0"];
    // A privileged user gives up the privileges first.
    let given_away = ["setpriv", "--bounding-set", "-sys_nice,-ipc_lock,-sys_resource"];
    let mighty = field(&status("self"), "CapEff").contains(|digit| digit != '0');
    let prefix: Vec<&str> =
        if mighty { limits.into_iter().chain(given_away).collect() } else { limits.to_vec() };
    // The last possible processor does not exist.
    let daemon = demo(&prefix, 1023);
    let (_, _, policy) = thread_of_task(&daemon);
    assert_ne!(policy, FIFO);
    assert_eq!(daemon.json(&["stats", "demo"])["tasks"][0]["real_time"], false);
    // It works nevertheless.
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    let (stopped, _) = daemon.stop("TERM");
    stopped.expect_code(0);
    stopped.expect_err("memory is not locked").expect_err("RLIMIT_MEMLOCK");
    stopped.expect_err("no real-time scheduling").expect_err("RLIMIT_RTPRIO");
    stopped.expect_err("cannot run on [1023]");
}

#[test]
fn the_command_line_asks_for_memory_that_stays() {
    let home = Home::new();
    let dumped = home.refused(&["--set", "lock_memory=true", "--dump-config"]);
    dumped.expect_code(0);
    assert!(dumped.out.contains("lock_memory = true"), "{}", dumped.out);
}

#[test]
fn the_state_port_tells_when_the_library_was_built() {
    // genom3.md 4.8: `genom_state` has the date of the component.
    let daemon = Daemon::demo("local");
    let date = daemon.port("demo", "genom_state")["value"]["date"].as_str().unwrap().to_owned();
    let is_date = date.len() == 20 && date.starts_with("20") && date.ends_with('Z');
    assert!(is_date, "{date}");
}

/// Statistics of the demo's task.
fn figures(daemon: &Daemon) -> Value {
    daemon.json(&["stats", "demo"])["tasks"][0].clone()
}

#[test]
fn ticks_missed_while_the_system_gave_no_processor_are_counted() {
    // genom3.md 7.4: ticks beyond the one that is latched are lost, also while the process was
    // stopped.
    let daemon = Daemon::demo("local");
    let overruns = |figures: &Value| figures["overruns"].as_u64().unwrap();
    let passes = |figures: &Value| figures["lateness"]["count"].as_u64().unwrap();
    let before = figures(&daemon);
    let begin = Instant::now();
    let process = daemon.process().id().to_string();
    daemon.process().signal("STOP");
    while !field(&status(&process), "State").starts_with('T') {
        assert!(begin.elapsed() < WATCHDOG, "it does not stop");
        std::thread::yield_now();
    }
    let stopped = Instant::now();
    while stopped.elapsed() < Duration::from_millis(100) {
        std::thread::park_timeout(Duration::from_millis(10));
    }
    let period = Duration::from_nanos(before["period_ns"].as_u64().unwrap());
    let ticks = stopped.elapsed().as_nanos() / period.as_nanos();
    daemon.process().signal("CONT");
    // The pass after the stop has been counted once two more passes have been made.
    let first = figures(&daemon);
    let after = loop {
        let after = figures(&daemon);
        if passes(&after) >= passes(&first) + 2 {
            break after;
        }
        assert!(begin.elapsed() < WATCHDOG, "the task stands still: {after}");
    };
    let missed = u128::from(overruns(&after) - overruns(&before));
    assert!(missed + 1 >= ticks, "{missed} of {ticks} ticks are counted as missed");
}
