//! `genomctl freeze` and `genomctl thaw`: a running system in a file, and back.

mod refused;
mod snapshots;
mod thawed;

use std::path::PathBuf;

use genom_tests::{Daemon, Home, component, path};
use serde_json::Value;

/// The demo in the daemon's own process, and as `far` in a cell, on a clock that is stepped.
fn robot() -> Daemon {
    let library = component("demo").library;
    let text = format!(
        "clock = \"virtual\"\n[[component]]\nlibrary = {library:?}\n\
         [[component]]\nlibrary = {library:?}\nname = \"far\"\ncell = \"arm\"\n"
    );
    Home::new().configured(&text).start(&[])
}

/// A daemon on a clock that is stepped, without components.
fn empty() -> Daemon {
    Home::new().configured("clock = \"virtual\"").start(&[])
}

/// A file of the test.
fn file(daemon: &Daemon) -> PathBuf {
    daemon.home().path().join("robot.json")
}

/// Freezes; returns the text, and what was told.
#[track_caller]
fn freeze(daemon: &Daemon) -> (String, String) {
    let file = file(daemon);
    let told = daemon.ctl(&["freeze", path(&file)]);
    told.expect_code(0);
    (std::fs::read_to_string(file).unwrap(), told.out)
}

/// Thaws a text; fails if that is refused.
#[track_caller]
fn thaw(daemon: &Daemon, text: &str, more: &[&str]) -> String {
    let file = file(daemon);
    std::fs::write(&file, text).unwrap();
    let told = daemon.ctl(&[&["thaw", path(&file)], more].concat());
    told.expect_code(0);
    told.out
}

/// The text with a change.
fn changed(text: &str, change: impl FnOnce(&mut Value)) -> String {
    let mut value = serde_json::from_str(text).unwrap();
    change(&mut value);
    value.to_string()
}
