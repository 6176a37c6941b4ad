//! The daemon under attack, its peer on the network, and their neighbours.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use serde_json::Value;

use super::flow::Flow;
use crate::trial::{APART, FAST, daemon_apart};
use crate::{Daemon, Home, Memory, component, signal, until};

/// The middlewares with gateways.
pub(super) const BOTH: [&str; 2] = ["ros2", "zenoh"];

/// Components at 1 kHz: in the process of the daemon, and in a cell.
pub(super) const NEIGHBOURS: [&str; 2] = ["neighbour", "beside"];

/// Two daemons that meet on ROS 2 and on zenoh, each through gateways.
pub(super) struct Stage {
    pub(super) near: Daemon,
    pub(super) far: Daemon,
    pub(super) apart: Daemon,
}

impl Stage {
    /// The demo of the near daemon moves on both middlewares, and the far one reads it.
    pub(super) fn new() -> Self {
        let memory = Arc::new(Memory::new());
        let [demo, mission] = ["demo", "mission"].map(|name| component(name).library);
        let load = |name: &str, library: &Path, more: &str| {
            format!("[[component]]\nname = {name:?}\nlibrary = {library:?}\n{more}\n")
        };
        let [own, other] = NEIGHBOURS;
        let mut near = load(own, &demo, FAST);
        near += &load(other, &demo, &format!("cell = {other:?}\n{FAST}"));
        let mut near = format!("backend = \"local\"\n{near}");
        let mut far = "backend = \"local\"\n".to_owned();
        for on in BOTH {
            let backend = format!("backend = {on:?}");
            near += &load(&format!("on_{on}"), &demo, &backend);
            far += &load(&format!("of_{on}"), &mission, &backend);
        }
        let near = home(&memory, &near).start(&[]);
        let far = home(&memory, &far).start(&[]);
        let stage = Self { near, far, apart: daemon_apart() };
        for on in BOTH {
            let (reads, writes) = (format!("of_{on}/position"), format!("on_{on}/position"));
            stage.far.ctl(&["connect", &reads, &writes]).expect_code(0);
            let moves = format!("on_{on}");
            stage.near.ctl(&["call", &moves, "set_speed", "velocity=0.0005"]).expect_code(0);
            stage.near.ctl(&["start", &moves, "goto", "goal=1"]).expect_code(0);
        }
        stage
    }

    /// What the far daemon reads of the near one on a middleware.
    pub(super) fn flow(&self, on: &str) -> Flow {
        let flow = Flow::of(self.far.home().socket(), &format!("of_{on}"), "position");
        // The first value is that of the look before.
        until("samples come through", || flow.changes() > 2);
        flow.longest();
        flow
    }

    /// A cell of the near daemon, as it tells.
    pub(super) fn cell(&self, name: &str) -> Value {
        let told = self.near.home().get("/cells");
        let mut all = told["cells"].as_array().expect("cells").iter();
        all.find(|cell| cell["name"] == name).cloned().unwrap_or_default()
    }

    /// The process of a gateway; `None` while there is none.
    pub(super) fn gateway(&self, on: &str) -> Option<u32> {
        self.cell(&format!("gateway-{on}"))["pid"].as_u64().and_then(|pid| u32::try_from(pid).ok())
    }

    /// How often the process of a cell was started.
    pub(super) fn starts(&self, cell: &str) -> u64 {
        self.cell(cell)["starts"].as_u64().unwrap_or_default()
    }

    /// Ends the process of a gateway.
    pub(super) fn kill(&self, on: &str) {
        signal(self.gateway(on).expect("it runs"), "KILL");
    }

    /// Periods missed so far by the neighbours, and by the component apart.
    pub(super) fn missed(&self) -> [u64; 3] {
        let [own, beside] = NEIGHBOURS.map(|name| self.near.missed(name));
        [own, beside, self.apart.missed(APART)]
    }

    /// What both sides say of the port on a middleware.
    pub(super) fn told(&self, on: &str) -> String {
        let [writer, reader] = [format!("on_{on}"), format!("of_{on}")];
        let all = [
            self.near.ctl(&["ports", &writer]),
            self.near.ctl(&["cells"]),
            self.near.ctl(&["logs"]),
            self.far.ctl(&["why", &format!("{reader}/position")]),
            self.far.ctl(&["logs"]),
        ];
        all.map(|one| one.out + &one.err).join("\n")
    }

    /// UDP ports of the gateway of ROS 2.
    pub(super) fn udp(&self) -> Vec<u16> {
        self.gateway("ros2").map(|pid| ports(pid, "udp", "07")).unwrap_or_default()
    }

    /// TCP ports on which the gateway of zenoh listens.
    pub(super) fn tcp(&self) -> Vec<u16> {
        self.gateway("zenoh").map(|pid| ports(pid, "tcp", "0A")).unwrap_or_default()
    }
}

/// A home whose zenoh can be reached over TCP, from this machine.
fn home(memory: &Arc<Memory>, text: &str) -> Home {
    let home = Home::with(memory).configured(text);
    let path = home.path().join("genomd.toml");
    let own = fs::read_to_string(&path).expect("the file was written");
    let section = "[backends.zenoh]\n";
    let listens = format!("{section}listen = [\"tcp/127.0.0.1:0\"]\n");
    fs::write(path, own.replace(section, &listens)).expect("a file can be written");
    home
}

/// Ports of a process's sockets in this state, as `/proc/net` spells it.
fn ports(process: u32, protocol: &str, state: &str) -> Vec<u16> {
    let open = fs::read_dir(format!("/proc/{process}/fd")).into_iter().flatten().flatten();
    let open =
        open.filter_map(|one| fs::read_link(one.path()).ok()?.into_os_string().into_string().ok());
    let sockets: Vec<String> = open
        .filter_map(|one| Some(one.strip_prefix("socket:[")?.strip_suffix(']')?.to_owned()))
        .collect();
    let mut found = Vec::new();
    for file in [protocol.to_owned(), format!("{protocol}6")] {
        let text = fs::read_to_string(format!("/proc/net/{file}")).unwrap_or_default();
        for line in text.lines().skip(1) {
            let words: Vec<&str> = line.split_whitespace().collect();
            let [_, local, _, now, _, _, _, _, _, inode, ..] = words.as_slice() else { continue };
            let port =
                local.rsplit_once(':').and_then(|(_, port)| u16::from_str_radix(port, 16).ok());
            if *now == state && sockets.iter().any(|one| one == inode) {
                found.extend(port);
            }
        }
    }
    found
}
