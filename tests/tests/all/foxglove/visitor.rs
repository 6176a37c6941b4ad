//! A client, which `tests/fixtures/foxglove/client.mjs` is.

use std::process::Command;

use genom_components::node;
use genom_components::peer::Peer;
use genom_tests::{Daemon, Home, component, path, repository};
use serde_json::{Value, json};

/// Configuration of a source at a free port; `more` are further keys of its section.
pub(super) fn source(more: &str) -> String {
    format!("[foxglove]\nlisten = \"127.0.0.1:0\"\n{more}\n")
}

/// What clients may do that do all.
pub(super) const CALL: &str = "rights = [\"read\", \"call\"]";

/// A daemon with the demo and a source, and the address of it: `127.0.0.1:PORT`.
pub(super) fn demo(more: &str, arguments: &[&str]) -> (Daemon, String) {
    let demo = component("demo");
    let home = Home::new().configured(&source(more));
    let daemon = home.start(&[&["--backend", "local"], arguments, &[path(&demo.library)]].concat());
    let address = address(&daemon);
    (daemon, address)
}

/// Where the source of a daemon is, by its log.
pub(super) fn address(daemon: &Daemon) -> String {
    let logs = daemon.home().get("/logs");
    let all = logs["logs"].as_array().expect("entries").iter();
    let mut told = all.filter_map(|one| one["message"].as_str());
    let line = told.find_map(|line| line.strip_prefix("foxglove on ws://"));
    line.expect("it says where it is").to_owned()
}

/// A connected client.
pub(super) struct Client(Peer);

impl Client {
    /// Connects as Foxglove does.
    #[track_caller]
    pub(super) fn new(daemon: &Daemon, address: &str) -> Self {
        Self(Peer::start(&mut command(daemon, &[&format!("ws://{address}")])))
    }

    /// Connects by another name of the protocol.
    #[track_caller]
    pub(super) fn of(daemon: &Daemon, address: &str, protocol: &str) -> Self {
        Self(Peer::start(&mut command(daemon, &[&format!("ws://{address}"), protocol])))
    }

    /// Does `verb` of the script, and waits for what comes of it.
    #[track_caller]
    pub(super) fn ask(&mut self, verb: &str, arguments: &[Value]) -> Value {
        let all: Vec<_> = [json!(verb)].into_iter().chain(arguments.iter().cloned()).collect();
        self.0.ask(&Value::from(all))
    }

    /// The same with one text.
    #[track_caller]
    pub(super) fn of_name(&mut self, verb: &str, name: &str) -> Value {
        self.ask(verb, &[json!(name)])
    }

    /// Waits until it was told something that contains this.
    #[track_caller]
    pub(super) fn is_told(&mut self, text: &str) {
        self.of_name("status", text);
    }
}

/// The script, with the packages that it uses.
fn command(daemon: &Daemon, arguments: &[&str]) -> Command {
    let directory = daemon.home().path().join("foxglove");
    if !directory.exists() {
        let source = repository().join("tests/fixtures/foxglove");
        node::package(&source, &directory).unwrap_or_else(|error| panic!("{error}"));
    }
    let mut command = Command::new("node");
    command.env("PATH", node::path().unwrap_or_else(|error| panic!("{error}")));
    command.arg(directory.join("client.mjs")).args(arguments);
    command
}
