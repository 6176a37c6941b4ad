//! What only the live machine tells: multicast that really arrives, the daemon, its versions.

use std::net::{Ipv4Addr, UdpSocket};
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use serde_json::Value;

use super::memory::{self, PREFIXES};
use super::{Finding, Machine};
use crate::failure::Failure;
use crate::session::Session;

/// Where DDS participants look for each other.
const GROUP: Ipv4Addr = Ipv4Addr::new(239, 255, 0, 1);
/// Within one machine a datagram arrives at once, or not at all.
const PATIENCE: Duration = Duration::from_millis(500);

/// Looks at this machine and at the daemon.
pub(crate) async fn live(session: &Session, config: Option<&Path>) -> Vec<Finding> {
    let mut found = vec![multicast()];
    found.extend(daemon(session).await);
    found.extend(config.map(configuration));
    found
}

fn multicast() -> Finding {
    const ABOUT: &str = "multicast";
    match echo() {
        Ok(()) => Finding::ok(ABOUT, "a datagram to 239.255.0.1 comes back"),
        Err(error) => Finding::note(
            ABOUT,
            format!(
                "a datagram to 239.255.0.1 does not come back ({error}): ROS 2 peers do not find each other"
            ),
            "a route for multicast (`ip route add 239.0.0.0/8 dev lo`), and a firewall that lets UDP pass",
        ),
    }
}

/// Sends a datagram to the group and waits for it.
fn echo() -> std::io::Result<()> {
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
    socket.set_read_timeout(Some(PATIENCE))?;
    socket.join_multicast_v4(&GROUP, &Ipv4Addr::UNSPECIFIED)?;
    socket.set_multicast_loop_v4(true)?;
    let mark = std::process::id().to_le_bytes();
    socket.send_to(&mark, (GROUP, socket.local_addr()?.port()))?;
    let mut came = [0; 4];
    // Somebody else's datagram is none of ours; the time-out ends this.
    while socket.recv(&mut came)? != mark.len() || came != mark {}
    Ok(())
}

/// Its version, its tasks and its stale socket.
async fn daemon(session: &Session) -> Vec<Finding> {
    const ABOUT: &str = "daemon";
    let about = match session.get("/").await {
        Ok(about) => about,
        Err(Failure::Unreachable { target, chosen, source }) => {
            let what = match source.kind() {
                std::io::ErrorKind::ConnectionRefused => {
                    format!("{target} is there and nobody answers: its genomd was killed")
                }
                _ => format!("none runs on {target}"),
            };
            let start = "`genomd LIBRARY...` starts one, and takes the socket over".to_owned();
            let fix = chosen.map_or(start, |chosen| chosen.help());
            return vec![Finding::note(ABOUT, what, fix)];
        }
        Err(failure) => {
            return vec![Finding::problem(ABOUT, failure.to_string(), "restart it")];
        }
    };
    let version = about["genomd"].as_str().unwrap_or_default();
    let own = env!("CARGO_PKG_VERSION");
    let mut found = vec![if version == own {
        Finding::ok(ABOUT, format!("genomd {version} runs"))
    } else {
        let what = format!("genomd is {version}, genomctl is {own}");
        Finding::problem(ABOUT, what, "install both of one version")
    }];
    if let Ok(known) = session.get("/middlewares").await {
        let of = |one: &Value| Some(one["version"].as_str()?.to_owned());
        let known = known["middlewares"].as_array().map(Vec::as_slice).unwrap_or_default();
        let versions: Vec<_> = known.iter().filter_map(of).collect();
        found.push(Finding::ok("middlewares", versions.join("; ")));
        found.extend(known.iter().flat_map(refused));
        found.extend(shared_memory(known));
    }
    found.extend(tasks(session).await);
    found
}

/// What peers sent to a middleware that would have harmed.
fn refused(middleware: &Value) -> Vec<Finding> {
    let name = middleware["name"].as_str().unwrap_or_default();
    let all = middleware["refused"].as_array().map(Vec::as_slice).unwrap_or_default();
    let told = |one: &Value| {
        let (why, peer) = (one["why"].as_str().unwrap_or_default(), one["peer"].as_str());
        let peer = peer.map_or_else(String::new, |peer| format!(", the last one from {peer}"));
        let what = format!("{name} refused {} messages: {why}{peer}", one["count"]);
        let fix = format!("see who sends that; configs/{name}.toml tells of limits");
        Finding::note("refused", what, fix)
    };
    all.iter().map(told).collect()
}

/// What is left and damaged where this very daemon keeps its shared memory.
fn shared_memory(known: &[Value]) -> Vec<Finding> {
    let Some(shm) = known.iter().find(|one| one["name"] == "shm") else { return Vec::new() };
    let meet = |key: &str| shm["meet"][key].as_str();
    let (Some(root), Some(prefix)) = (meet("root"), meet("prefix")) else { return Vec::new() };
    if PREFIXES.iter().any(|known| prefix.starts_with(known)) {
        // Looked at already.
        return Vec::new();
    }
    let machine = Machine::at(Path::new("/"));
    vec![memory::nodes(&machine, &[root.to_owned()]), memory::segments(&machine, &[prefix])]
}

/// Ends of a component's ports that do not meet others, though both are there.
async fn unmet(session: &Session, component: &str) -> Vec<Finding> {
    let mut found = Vec::new();
    let path = crate::names::url(["components", component]);
    let Ok(told) = session.get(&path).await else { return found };
    let ports = told["ports"].as_array().map(Vec::as_slice).unwrap_or_default();
    for port in ports.iter().filter_map(|port| port["name"].as_str()) {
        let path = crate::names::url(["components", component, "ports", port, "why"]);
        let Ok(told) = session.get(&path).await else { continue };
        let told = told["findings"].as_array().map(Vec::as_slice).unwrap_or_default();
        for one in told.iter().filter(|one| one["unmet"] == true) {
            let text = |key: &str| one[key].as_str().unwrap_or_default().to_owned();
            found.push(Finding::problem("ports", text("what"), text("fix")));
        }
    }
    found
}

/// Codels of a component that do not return.
fn stuck(component: &Value) -> Vec<Finding> {
    let name = component["name"].as_str().unwrap_or_default();
    let codels = component["stuck"].as_array().map(Vec::as_slice).unwrap_or_default();
    let told = codels.iter().map(|one| {
        let text = |key: &str| one[key].as_str().unwrap_or_default();
        let whose =
            one["task"].as_str().map_or("a request".to_owned(), |task| format!("task {task}"));
        let time = one["for_ns"].as_u64().unwrap_or_default() / 1_000_000_000;
        let (codel, owner) = (text("codel"), text("owner"));
        let what = format!("{whose} of {name} is stuck in {codel} of {owner} for {time} s");
        let fix = format!(
            "look at what the codel waits for (gdb -p); `genomctl unload {name}` leaves it behind"
        );
        Finding::problem("codels", what, fix)
    });
    told.collect()
}

/// Tasks of a component that keep a processor and do not pause.
fn spins(component: &Value) -> Vec<Finding> {
    let name = component["name"].as_str().unwrap_or_default();
    let all = component["spins"].as_array().map(Vec::as_slice).unwrap_or_default();
    let told = all.iter().map(|one| {
        let text = |key: &str| one[key].as_str().unwrap_or_default();
        let time = one["for_ns"].as_u64().unwrap_or_default() / 1_000_000_000;
        let share = one["processor"].as_f64().unwrap_or_default() * 100.0;
        let (task, codel, owner) = (text("task"), text("codel"), text("owner"));
        let what = format!(
            "task {task} of {name} does not pause: codel {codel} of {owner} yields without pause for \
             {time} s ({share:.0} % of a processor)"
        );
        let fix = format!("let {codel} yield `pause::` and the state, or end");
        Finding::problem("codels", what, fix)
    });
    told.collect()
}

/// What is left of components that did not stop.
fn left_behind(listed: &Value) -> Vec<Finding> {
    let all = listed["left_behind"].as_array().map(Vec::as_slice).unwrap_or_default();
    let told = all.iter().map(|one| {
        let text = |key: &str| one[key].as_str().unwrap_or_default();
        let what = format!("of {} ({}): {}", text("was"), text("component"), text("state"));
        let fix = "it goes when its codel returns; restart genomd to be rid of it";
        Finding::problem("left behind", what, fix)
    });
    told.collect()
}

/// Tasks that miss ticks, and ports that do not meet.
async fn tasks(session: &Session) -> Vec<Finding> {
    let mut found = Vec::new();
    let Ok(listed) = session.get("/components").await else { return found };
    found.extend(left_behind(&listed));
    let names = listed["components"].as_array().map(Vec::as_slice).unwrap_or_default();
    for (one, name) in names.iter().filter_map(|one| Some((one, one["name"].as_str()?))) {
        found.extend(stuck(one));
        found.extend(spins(one));
        if one["state"] == "damaged" {
            let what = format!("codels of {name} wrote past the memory they were given");
            let fix = format!(
                "`genomctl logs --level error` says which; mend it, `genomctl unload {name}` and load it"
            );
            found.push(Finding::problem("memory", what, fix));
        }
        found.extend(unmet(session, name).await);
        let path = crate::names::url(["components", name, "tasks"]);
        let Ok(told) = session.get(&path).await else { continue };
        let tasks = told["tasks"].as_array().map(Vec::as_slice).unwrap_or_default();
        for task in tasks.iter().filter(|task| task["overruns"].as_u64() > Some(0)) {
            let task_name = task["name"].as_str().unwrap_or_default();
            let what = format!("task {task_name} of {name} missed {} ticks", task["overruns"]);
            let fix = format!(
                "`genomctl stats {name}`; a longer period, shorter codels, or a real-time priority"
            );
            found.push(Finding::note("tasks", what, fix));
        }
    }
    found
}

/// The configuration, as genomd itself reads it.
fn configuration(config: &Path) -> Finding {
    const ABOUT: &str = "configuration";
    let beside = std::env::current_exe().ok().map(|own| own.with_file_name("genomd"));
    let genomd = beside.filter(|path| path.is_file()).unwrap_or_else(|| "genomd".into());
    let read = Command::new(genomd).arg("--config").arg(config).arg("--dump-config").output();
    match read {
        Ok(read) if read.status.success() => {
            Finding::ok(ABOUT, format!("{} is understood", config.display()))
        }
        Ok(read) => {
            let told = String::from_utf8_lossy(&read.stderr);
            let told = told.trim().trim_start_matches("error: ").to_owned();
            Finding::problem(ABOUT, told, "configs/default.toml shows every key")
        }
        Err(error) => {
            Finding::problem(ABOUT, format!("genomd: {error}"), "put genomd beside genomctl")
        }
    }
}
