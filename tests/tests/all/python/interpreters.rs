//! Interpreters of components: each cell has one of its own, of whatever version is named.

use std::collections::BTreeSet;
use std::env;
use std::fs::{self, OpenOptions};
use std::path::{Path, PathBuf};
use std::process::Command;

use genom_tests::{Daemon, Home, component, path};

use super::{DESCRIPTION, SCRIPT, axis, how};

/// Which process a codel runs in, and which minor version of Python runs it.
const ASKED: &str = "    if what == \"process\":
        tries.value = os.getpid()
    if what == \"version\":
        tries.value = sys.version_info.minor
";

/// What a codel says.
#[track_caller]
fn asked(daemon: &Daemon, component: &str, what: &str) -> u32 {
    let called = daemon.ctl(&["call", component, "how", &format!("what={what}")]);
    called.expect_code(0);
    let told = called.out.trim().strip_prefix("tries = ").expect("a number");
    told.parse().expect("a number")
}

#[test]
fn each_component_has_an_interpreter_of_its_own_unless_they_name_one_cell() {
    let (_scratch, file) = axis(DESCRIPTION, &how(ASKED));
    let daemon = Home::new().start(&[path(&file)]);
    for more in [&["--name", "other"][..], &["--name", "both", "--cell", "other"]] {
        daemon.ctl(&[&["load", path(&file)], more].concat()).expect_code(0);
    }
    let process = |component| asked(&daemon, component, "process");
    let (own, other) = (process("axis"), process("other"));
    assert_ne!(own, other);
    assert_eq!(process("both"), other);
    assert!(![own, other].contains(&daemon.process().id()));
}

#[test]
fn native_code_that_keeps_the_interpreter_is_told_and_keeps_no_other_component() {
    // To open a pipe waits until somebody opens its other end; `PyDLL` keeps the lock meanwhile.
    let script = SCRIPT.replace(
        "    if what == \"block\":\n",
        "    if what == \"hold\":\n        \
         os.close(ctypes.PyDLL(None).open(GATE, os.O_RDONLY))\n        \
         return \"ether\"\n    if what == \"block\":\n",
    );
    let (scratch, file) = axis(DESCRIPTION, &script);
    let gate = scratch.path().join("gate");
    assert!(Command::new("mkfifo").arg(&gate).status().unwrap().success());
    let gated = format!("GATE = {:?}.encode()\n{script}", path(&gate));
    fs::write(scratch.path().join("axis.py"), gated).unwrap();
    let demo = component("demo");
    let options = ["--set", "stuck_after=1", path(&demo.library), path(&file)];
    let daemon = Home::new().start(&options);
    daemon.ctl(&["load", path(&file), "--name", "other"]).expect_code(0);
    let holding = daemon.spawn(&["start", "--wait", "axis", "run", "what=hold"]);
    let told = "codel axis_run: native code keeps the interpreter (its global lock), so the lines \
                where it is are not known";
    assert!(daemon.process().error_line_where(|line| line.contains(told)).is_some());
    // Another interpreter has another lock, and C has none.
    daemon.ctl(&["call", "other", "how", "what=no"]).expect_code(0).expect_out("tries = 1\n");
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    let running = daemon.json(&["activities", "axis"])["activities"][0]["status"].clone();
    assert_eq!(running, "running", "it does not return meanwhile");
    drop(OpenOptions::new().write(true).open(&gate).unwrap());
    holding.finish().expect_code(0);
    daemon.ctl(&["call", "axis", "how", "what=no"]).expect_code(0).expect_out("tries = 1\n");
}

/// The interpreter that a command starts, and its minor version, if it is CPython 3 and runs: pyenv
/// has commands for versions that are not chosen.
fn interpreter(command: &Path) -> Option<(u32, PathBuf)> {
    let asks = "import sys; print(sys.implementation.name, *sys.version_info[:2], sys.executable)";
    let output = Command::new(command).args(["-I", "-c", asks]).output().ok()?;
    let told = String::from_utf8(output.stdout).ok().filter(|_| output.status.success())?;
    let words = told.trim().strip_prefix("cpython 3 ")?;
    let (minor, executable) = words.split_once(' ')?;
    Some((minor.parse().ok()?, executable.into()))
}

/// An interpreter of this version: on `PATH`, or of pyenv.
fn found(minor: u32) -> Option<PathBuf> {
    let name = format!("python3.{minor}");
    let path = env::var_os("PATH").unwrap_or_default();
    let mut places: Vec<PathBuf> = env::split_paths(&path).collect();
    if let Some(root) = env::var_os("PYENV_ROOT") {
        let versions = fs::read_dir(Path::new(&root).join("versions")).into_iter().flatten();
        places.extend(versions.flatten().map(|version| version.path().join("bin")));
    }
    let all = places.into_iter().map(|place| place.join(&name)).filter(|file| file.is_file());
    let mut right = all.filter_map(|file| interpreter(&file)).filter(|(own, _)| *own == minor);
    right.next().map(|(_, executable)| executable)
}

/// Runs the component there.
#[track_caller]
fn runs_by(interpreter: &Path, minor: u32) {
    let (_scratch, file) = axis(DESCRIPTION, &how(ASKED));
    let config = format!("[cells]\npython = {:?}\n", path(interpreter));
    let daemon = Home::new().configured(&config).start(&[path(&file)]);
    assert_eq!(asked(&daemon, "axis", "version"), minor, "{}", interpreter.display());
    daemon.ctl(&["call", "axis", "run", "what=keep"]).expect_code(0);
    let (finished, _) = daemon.stop("TERM");
    finished.expect_code(0).expect_err("keeps a view of `at` in `kept` after its call");
}

#[test]
#[allow(clippy::print_stdout, reason = "versions are for whoever runs the test")]
fn a_component_runs_by_each_version_of_python_that_is_found() {
    let mut ran = BTreeSet::new();
    for minor in 10..=14 {
        match found(minor) {
            Some(interpreter) => {
                runs_by(&interpreter, minor);
                ran.insert(minor);
            }
            None => println!("Python 3.{minor} is absent here, and was not tried"),
        }
    }
    let (own, default) = interpreter(Path::new("python3")).expect("python3 runs");
    if !ran.contains(&own) {
        runs_by(&default, own);
    }
}
