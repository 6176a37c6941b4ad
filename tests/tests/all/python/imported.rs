//! Scripts that do wrong already when they are loaded: the line is told, the daemon goes on, and nothing
//! of them is left behind.

use std::fs;
use std::os::unix::ffi::OsStrExt as _;
use std::path::PathBuf;

use genom_tests::{Daemon, Finished, Home, component, path, until};
use tempfile::TempDir;

use super::{DESCRIPTION, SCRIPT, axis};

/// Time that a script has to run through.
const LIMIT: [&str; 2] = ["--set", "start_timeout=3"];

/// Loads the component, whose script has this line as its third, into a daemon that runs the demo;
/// the file is that of its description.
fn loaded(line: &str) -> (Daemon, Finished, (TempDir, PathBuf)) {
    let script = format!("\nimport os\n{line}\n{SCRIPT}");
    let (scratch, file) = axis(DESCRIPTION, &script);
    let demo = component("demo");
    let daemon = Home::new().start(&[LIMIT[0], LIMIT[1], path(&demo.library)]);
    let loaded = daemon.ctl(&["load", path(&file)]);
    (daemon, loaded, (scratch, file))
}

/// Processes that have the directory of the cell in their environment, as all that it starts.
fn processes_of(daemon: &Daemon) -> Vec<String> {
    let socket = daemon.home().socket();
    let mark = [socket.as_os_str().as_bytes(), b".cells/axis"].concat();
    let mut found = Vec::new();
    for entry in fs::read_dir("/proc").unwrap().flatten() {
        let environment = fs::read(entry.path().join("environ")).unwrap_or_default();
        if environment.windows(mark.len()).any(|part| part == mark) {
            found.push(entry.file_name().to_string_lossy().into_owned());
        }
    }
    found
}

/// It was refused with these words; the daemon goes on without it, and the log has these lines.
#[track_caller]
fn refused(line: &str, why: &[&str], logged: &[&str]) {
    let (daemon, loaded, (_scratch, file)) = loaded(line);
    loaded.expect_code(1);
    for told in why {
        loaded.expect_err(told);
    }
    assert_eq!(processes_of(&daemon), Vec::<String>::new());
    assert_eq!(daemon.json(&["cells"])["cells"], serde_json::json!([]));
    let mut cells = daemon.home().socket().into_os_string();
    cells.push(".cells/axis");
    assert!(fs::symlink_metadata(cells).is_err());
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    // One without that line runs in its place.
    fs::write(file.with_extension("py"), SCRIPT).unwrap();
    daemon.ctl(&["load", path(&file)]).expect_code(0);
    daemon.ctl(&["call", "axis", "how", "what=no"]).expect_code(0).expect_out("tries = 1\n");
    let (finished, home) = daemon.stop("TERM");
    finished.expect_code(0);
    for told in logged {
        finished.expect_err(told);
    }
    assert!(!finished.err.contains("threading.py"), "{}", finished.err);
    assert_eq!(home.memory().files(), Vec::<PathBuf>::new());
}

#[test]
fn a_script_that_does_not_run_through_is_refused_with_its_line() {
    let why = "axis.py: line 3: the script is here after 3 s (start_timeout)";
    refused("while True: pass", &[why], &[]);
}

#[test]
fn a_script_that_ends_its_process_is_told_with_its_line() {
    let lines = ["os._exit(3) ends this cell", "axis.py\", line 3, in <module>"];
    refused("os._exit(3)", &["its process ended: exit status 3"], &lines);
}

#[test]
fn a_child_that_a_script_forks_ends_with_it_and_is_told_with_its_line() {
    let (daemon, loaded, _file) = loaded("os.fork()");
    loaded.expect_code(0);
    until("the child has ended", || processes_of(&daemon).len() == 1);
    daemon.ctl(&["call", "axis", "how", "what=no"]).expect_code(0).expect_out("tries = 1\n");
    let (finished, home) = daemon.stop("TERM");
    finished.expect_code(0).expect_err("or from the script").expect_err("line 3, in <module>");
    // It ends by itself, and not because Python finds no thread of its own there.
    assert!(!finished.err.contains("Fatal Python error"), "{}", finished.err);
    assert_eq!(home.memory().files(), Vec::<PathBuf>::new());
}

#[test]
fn megabytes_that_a_script_prints_are_told_with_their_line() {
    let (daemon, loaded, _file) = loaded("print(\"x\" * 3_000_000)");
    loaded.expect_code(0);
    daemon.ctl(&["call", "axis", "how", "what=no"]).expect_code(0).expect_out("tries = 1\n");
    let (finished, _) = daemon.stop("TERM");
    finished.expect_code(0).expect_err("more than 1 MiB is printed in a second");
    finished.expect_err("line 3, in <module>");
}

#[test]
fn a_check_refuses_a_script_that_does_not_run_through_or_ends_its_process() {
    for (line, told) in [
        ("while True: pass", "axis.py: line 3: the script is here after 3 s (start_timeout)"),
        ("os._exit(3)", "axis.py\", line 3, in <module>"),
    ] {
        let (_scratch, file) = axis(DESCRIPTION, &format!("\nimport os\n{line}\n{SCRIPT}"));
        let options = ["--check", LIMIT[0], LIMIT[1], path(&file)];
        let refused = Home::new().refused(&options);
        assert_ne!(refused.code, Some(0));
        refused.expect_err(told);
    }
}
