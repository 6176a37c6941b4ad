//! The library of a running component is exchanged, in the daemon's own process and in a cell.

mod described;
mod growth;
mod kept;
mod native;
mod refused;
mod ruled;
mod trial;
mod watched;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use genom_tests::{Daemon, Running, path, program, repository};
use serde_json::Value;

/// What an author of codels has: a description, sources, and a compiler.
struct Author(tempfile::TempDir);

/// Counts at each period, by what `STEP` is; `run` counts its periods in a local variable.
const GEN: &str = "component edit {
  typedef long total;
  ids { long count; long more; string note; };
  port out total sum;
  port in total given;
  task main {
    period 5 ms;
    codel<start> edit_start(out ::ids, out sum) yield main;
    codel<main> edit_step(inout count, in more, in given, out sum) yield pause::main;
  };
  attribute get(out count, out note);
  attribute set_note(in note);
  attribute set_more(in more);
  activity run(out long periods) {
    task main;
    local long seen;
    codel<start> edit_begin(out seen) yield main;
    codel<main> edit_run(inout seen, out periods) yield pause::main, ether;
    codel<stop> edit_end(in seen, out periods) yield ether;
  };
  activity hang() { task main; codel<start> edit_hang() yield ether; };
  function release() { codel edit_release(); };
};
";

const C: &str = r#"
#include <unistd.h>
#include "edit_c_types.h"

static volatile int released = 0;

genom_event
edit_start(edit_ids *ids, const edit_sum *sum, const genom_context self)
{
  (void)sum; (void)self;
  ids->count = 0;
  ids->more = 0;
  return edit_main;
}

genom_event
edit_step(int32_t *count, int32_t more, const edit_given *given, const edit_sum *sum,
          const genom_context self)
{
  *count += STEP + more;
  if (given->read(self) == genom_ok && given->data(self)) *count += *given->data(self) * 0;
  *sum->data(self) = *count;
  sum->write(self);
  return edit_pause_main;
}

genom_event
edit_begin(int32_t *seen, const genom_context self)
{
  (void)self;
  *seen = 0;
  return edit_main;
}

genom_event
edit_run(int32_t *seen, int32_t *periods, const genom_context self)
{
  (void)self;
  *periods = *seen += 1;
  return edit_pause_main;
}

genom_event
edit_end(int32_t seen, int32_t *periods, const genom_context self)
{
  (void)self;
  *periods = seen;
  return edit_ether;
}

genom_event
edit_hang(const genom_context self)
{
  (void)self;
  while (!released) usleep(1000);
  return edit_ether;
}

genom_event
edit_release(const genom_context self)
{
  (void)self;
  released = 1;
  return genom_ok;
}
"#;

impl Author {
    fn new() -> Self {
        let author = Self(tempfile::tempdir().unwrap());
        author.describe(GEN);
        author
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Saves a description, and the header of it.
    fn describe(&self, text: &str) {
        fs::write(self.at("edit.gen"), text).unwrap();
        let mut header = Command::new(program("genomctl"));
        let header = Running::start(header.arg("header").arg(self.at("edit.gen"))).finish();
        header.expect_code(0);
        fs::write(self.at("edit_c_types.h"), &header.out).unwrap();
    }

    /// Compiles the codels into a file.
    fn make(&self, name: &str, text: &str, step: i32) -> PathBuf {
        let source = self.at(&format!("{name}.c"));
        fs::write(&source, text).unwrap();
        let mut compiler = Command::new("cc");
        compiler.args(["-std=gnu99", "-Wall", "-g", "-fPIC", "-shared"]);
        compiler.arg(format!("-DSTEP={step}"));
        compiler
            .arg("-I")
            .arg(repository().join("plugin-api/include"))
            .arg("-I")
            .arg(self.0.path());
        compiler.arg(&source).arg("-o").arg(self.at(name));
        Running::start(&mut compiler).finish().expect_code(0);
        self.at(name)
    }

    /// Compiles the codels as they are, with this step, into `edit.so`.
    fn save(&self, step: i32) -> PathBuf {
        self.make("edit.so", C, step)
    }
}

/// What the component counted so far.
#[track_caller]
fn count(daemon: &Daemon) -> i64 {
    daemon.json(&["call", "edit", "get"])["result"]["count"].as_i64().unwrap()
}

/// A component as it is listed.
#[track_caller]
fn listed(daemon: &Daemon, name: &str) -> Value {
    let all = daemon.json(&["list"]);
    let mut all = all["components"].as_array().unwrap().iter();
    all.find(|one| one["name"] == name).unwrap().clone()
}

/// Whether a mapping of a process is a copy of a library of this name.
fn mapped(pid: u32, name: &str) -> usize {
    let maps = fs::read_to_string(format!("/proc/{pid}/maps")).unwrap();
    let of = maps.lines().filter(|line| line.contains(name) && line.contains("r-xp"));
    of.count()
}

/// Open files and threads of a process.
fn held(pid: u32) -> (usize, usize) {
    let count = |what: &str| fs::read_dir(Path::new("/proc").join(pid.to_string()).join(what));
    (count("fd").unwrap().count(), count("task").unwrap().count())
}

/// A directory or file as an argument.
fn text(of: &Path) -> &str {
    path(of)
}
