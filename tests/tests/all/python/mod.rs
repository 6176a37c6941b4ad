//! Components with codels in Python: what they may do, and what they are told.

mod embedded;
mod ends;
mod errors;
mod imported;
mod interpreters;
mod made;
mod neighbours;
mod refused;
mod reloaded;
mod remotes;
mod sandboxed;

use std::fs;
use std::path::PathBuf;

use genom_tests::{Daemon, Home, path};
use tempfile::TempDir;

/// A component with a function and an activity, each of which does what its input says.
const DESCRIPTION: &str = r#"component axis {
  lang "python";
  exception REFUSED { long code; };
  struct pose { double x; double y; };
  ids { pose at; long n; };
  port out pose where;
  task main {
    period 10 ms;
    codel<start> axis_start(out ::ids, out where) yield ether;
  };
  function how(in string<16> what, out long tries) {
    codel axis_how(in what, inout n, out tries);
    throw REFUSED;
  };
  activity run(in string<16> what) {
    task main;
    codel<start> axis_run(in what, inout at) yield pause::start, ether;
    codel<stop> axis_stop(in what) yield ether;
    throw REFUSED;
  };
};
"#;

/// Its codels, without what each of them does.
const SCRIPT: &str = r#"
import ctypes, os, sys, time
from axis_types import REFUSED


def axis_start(ids, where):
    ids.at.x = 1
    where.write(ids.at)
    return "ether"


def axis_how(what, n, tries):
    n.value += 1
    tries.value = n.value
    if what == "refuse":
        raise REFUSED(code=7)
    if what == "divide":
        n.value = divided(1, 0)
    if what == "exit":
        os._exit(3)
    if what == "sys.exit":
        sys.exit(3)
    if what == "crash":
        ctypes.string_at(8)
    if what == "print":
        print("x" * 3_000_000)
    if what == "fork" and os.fork() == 0:
        return


def divided(a, b):
    return a // b


def axis_run(what, at):
    if what == "type":
        return len(what)
    if what == "block":
        time.sleep(3600)
    if what == "divide":
        divided(1, 0)
    if what == "keep":
        kept.append(at)
        return "ether"
    return "pause::start"


kept = []


def axis_stop(what):
    if what == "stop":
        raise ValueError("it does not stop")
    return "ether"
"#;

/// The script, with more that `axis_how` does.
fn how(more: &str) -> String {
    let first = "    if what == \"refuse\":\n";
    assert!(SCRIPT.contains(first));
    SCRIPT.replace(first, &format!("{more}{first}"))
}

/// A directory with the component.
fn axis(description: &str, script: &str) -> (TempDir, PathBuf) {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("axis.gen");
    fs::write(&file, description).unwrap();
    fs::write(scratch.path().join("axis.py"), script).unwrap();
    (scratch, file)
}

/// A daemon with the component, and a directory that it needs.
fn started(options: &[&str]) -> (Daemon, TempDir) {
    started_with(SCRIPT, options)
}

/// The same with another script.
fn started_with(script: &str, options: &[&str]) -> (Daemon, TempDir) {
    let (scratch, file) = axis(DESCRIPTION, script);
    let daemon = Home::new().start(&[options, &[path(&file)]].concat());
    (daemon, scratch)
}
