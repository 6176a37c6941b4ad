//! Components in processes of their own: a fault stays where it is.

mod adopted;
mod blackbox;
mod crashes;
mod deployed;
mod ended;
mod joined;
mod life;
mod limits;
mod monitors;
mod over;
mod refused;
mod safe_state;
mod supervised;

use std::path::PathBuf;

use genom_tests::{Daemon, component, path};
use serde_json::Value;

/// The configuration of two components in two cells, wired both ways and by a service.
fn mission(of_demo: &str) -> String {
    let (demo, mission) = (component("demo"), component("mission"));
    format!(
        "[[component]]\nlibrary = {:?}\ncell = \"base\"\n{of_demo}\n\
         [[component]]\nlibrary = {:?}\ncell = \"brain\"\n\
         [[connection]]\nin = \"mission/position\"\nout = \"demo/position\"\n\
         [[connection]]\nin = \"demo/parameter\"\nout = \"mission/gain\"\n\
         [[connection]]\nin = \"mission/goto\"\nout = \"demo/goto\"\n",
        demo.library, mission.library,
    )
}

/// A cell as the daemon tells it.
#[track_caller]
fn cell(daemon: &Daemon, name: &str) -> Value {
    let all = daemon.json(&["cells"]);
    let mut all = all["cells"].as_array().expect("cells").iter();
    all.find(|cell| cell["name"] == name).expect("the cell").clone()
}

/// Sends a signal to the process of a cell.
#[track_caller]
pub(crate) fn signal(daemon: &Daemon, name: &str, signal: &str) {
    let pid = &cell(daemon, name)["pid"];
    assert!(genom_tests::signal(pid, signal), "there is no process {pid}");
}

/// All files that belong to cells.
fn files(daemon: &Daemon) -> PathBuf {
    let mut all = daemon.home().socket().into_os_string();
    all.push(".cells");
    all.into()
}

/// Loads a component into a cell.
#[track_caller]
fn load(daemon: &Daemon, name: &str, more: &[&str]) {
    let library = component(name).library;
    daemon.ctl(&[&["load", path(&library)], more].concat()).expect_code(0);
}
