//! `execution = "single"`: one thread for all tasks and requests of a process.

use std::fs;
use std::path::PathBuf;

use genom_tests::{Footprint, Home, Many, component, path};

/// Name of the thread.
const THREAD: &str = "genomd-tasks";

/// Names of the threads of a process.
fn threads(process: u32) -> Vec<String> {
    let tasks = fs::read_dir(format!("/proc/{process}/task")).expect("the process runs");
    let comm = |task: PathBuf| fs::read_to_string(task.join("comm")).unwrap_or_default();
    tasks.map(|task| comm(task.unwrap().path()).trim().to_owned()).collect()
}

/// A daemon with this many components in a chain, when values go through all of them.
fn chained(components: usize, execution: &str) -> (Footprint, Vec<String>) {
    let made = tempfile::tempdir().unwrap();
    let text = Many { components, chained: true, cells: 0 }.configuration("local", made.path());
    let daemon = Home::new().configured(&text).start(&["--execution", execution]);
    daemon.ctl(&["wait-ready", "--deployed"]).expect_code(0);
    daemon.ctl(&["start", "--wait", "m0", "hear", "steps=3"]).expect_code(0);
    let steps = daemon.json(&["call", "m1", "count"]);
    assert!(steps["result"]["steps"].as_u64().is_some_and(|steps| steps >= 1), "{steps}");
    let task = &daemon.json(&["stats", "m1"])["tasks"][0];
    assert!(task["cycles"]["count"].as_u64().is_some_and(|cycles| cycles >= 1), "{task}");
    assert_eq!(
        (&task["real_time"], task["period_ns"].as_u64()),
        (&false.into(), Some(100_000_000))
    );
    daemon.ctl(&["unload", "m0"]).expect_code(0);
    daemon.ctl(&["load", path(&made.path().join("many.so")), "--name", "m0"]).expect_code(0);
    let process = daemon.process().id();
    let found = (Footprint::of(process), threads(process));
    daemon.stop("TERM").0.expect_code(0);
    found
}

#[test]
fn thirty_components_in_one_thread_have_one_and_their_values_go_through_all_of_them() {
    let (_, single) = chained(30, "single");
    assert_eq!(single.iter().filter(|name| *name == THREAD).count(), 1, "{single:?}");
    let own = |names: &[String]| names.iter().filter(|name| name.starts_with('m')).count();
    assert_eq!(own(&single), 0, "none has a thread of its own: {single:?}");
    let (_, threads) = chained(30, "threads");
    assert!(own(&threads) >= 30 && !threads.iter().any(|name| name == THREAD), "{threads:?}");
}

#[test]
fn a_cell_executes_its_components_as_its_daemon_does() {
    let demo = component("demo");
    let text = format!(
        "execution = \"single\"\n[[component]]\nlibrary = {:?}\ncell = \"apart\"\n",
        demo.library
    );
    let daemon = Home::new().configured(&text).start(&[]);
    daemon.ctl(&["wait-ready", "--deployed"]).expect_code(0);
    daemon.ctl(&["call", "demo", "goto", "goal=0.1"]).expect_code(0);
    let cells = daemon.json(&["cells"]);
    let process = cells["cells"][0]["pid"].as_u64().and_then(|pid| u32::try_from(pid).ok());
    let names = threads(process.expect("it runs"));
    assert_eq!(names.iter().filter(|name| *name == THREAD).count(), 1, "{names:?}");
    assert!(!names.iter().any(|name| name.starts_with("demo:")), "{names:?}");
}

#[test]
fn what_tasks_ask_for_and_cannot_have_on_one_thread_is_told_once_at_load() {
    let demo = component("demo");
    let text = format!(
        "execution = \"single\"\n[[component]]\nlibrary = {:?}\n[component.tasks.main]\n\
         priority = 3\ncpus = [0]\n",
        demo.library
    );
    let daemon = Home::new().configured(&text).start(&[]);
    let (stopped, _) = daemon.stop("TERM");
    let told: Vec<&str> =
        stopped.err.lines().filter(|line| line.contains("not applied: ")).collect();
    assert_eq!(told.len(), 1, "{}", stopped.err);
    assert!(told[0].contains("priority, cpus of task main"), "{told:?}");
}
