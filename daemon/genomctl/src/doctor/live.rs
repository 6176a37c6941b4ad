//! Findings that need the live machine: whether multicast works, the daemon, versions.

use std::net::{Ipv4Addr, UdpSocket};
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use genom_protocol::{
    Components, LeftBehind, Middleware, Refused, RunningCodel, Spin, Unpaused, advice, routes,
};

use super::finding::Finding;
use super::machine::Machine;
use super::memory::{self, PREFIXES};
use crate::failure::Failure;
use crate::session::Session;

/// The multicast group by which DDS participants discover each other.
const GROUP: Ipv4Addr = Ipv4Addr::new(239, 255, 0, 1);
/// Within a machine a datagram arrives at once, or not at all.
const PATIENCE: Duration = Duration::from_millis(500);

/// Inspects this machine and the daemon.
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

/// Sends a datagram to the group and waits to receive it.
fn echo() -> std::io::Result<()> {
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
    socket.set_read_timeout(Some(PATIENCE))?;
    socket.join_multicast_v4(&GROUP, &Ipv4Addr::UNSPECIFIED)?;
    socket.set_multicast_loop_v4(true)?;
    let mark = std::process::id().to_le_bytes();
    socket.send_to(&mark, (GROUP, socket.local_addr()?.port()))?;
    let mut came = [0; 4];
    // Datagrams of other programs are skipped; the socket's timeout ends the loop.
    while socket.recv(&mut came)? != mark.len() || came != mark {}
    Ok(())
}

/// Findings on the daemon: version, tasks, stale socket.
async fn daemon(session: &Session) -> Vec<Finding> {
    const ABOUT: &str = "daemon";
    let about = match session.ask(routes::about()).await {
        Ok(about) => about.content,
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
    let version = about.genomd;
    let own = env!("CARGO_PKG_VERSION");
    let mut found = vec![if version == own {
        Finding::ok(ABOUT, format!("genomd {version} runs"))
    } else {
        let what = format!("genomd is {version}, genomctl is {own}");
        Finding::problem(ABOUT, what, "install both of one version")
    }];
    if let Ok(known) = session.ask(routes::middlewares()).await {
        let known = known.content.middlewares;
        let versions: Vec<_> = known.iter().map(|one| one.version.as_str()).collect();
        found.push(Finding::ok("middlewares", versions.join("; ")));
        found.extend(known.iter().flat_map(refused));
        found.extend(shared_memory(&known));
    }
    found.extend(components(session).await);
    found
}

/// Harmful messages of peers that a middleware dropped.
fn refused(middleware: &Middleware) -> impl Iterator<Item = Finding> {
    let name = &middleware.name;
    middleware.refused.iter().map(move |Refused { why, count, peer }| {
        let peer = peer.map_or_else(String::new, |peer| format!(", the last one from {peer}"));
        let what = format!("{name} refused {count} messages: {why}{peer}");
        let fix = format!("see who sends that; configs/{name}.toml tells of limits");
        Finding::note("refused", what, fix)
    })
}

/// Stale and damaged segments in the shared memory that this daemon uses.
fn shared_memory(known: &[Middleware]) -> Vec<Finding> {
    let Some(shm) = known.iter().find(|one| one.name == "shm") else { return Vec::new() };
    let (Some(root), Some(prefix)) = (shm.meet.get("root"), shm.meet.get("prefix")) else {
        return Vec::new();
    };
    if PREFIXES.iter().any(|known| prefix.starts_with(known)) {
        // Inspected already.
        return Vec::new();
    }
    let machine = Machine::at(Path::new("/"));
    vec![memory::nodes(&machine, std::slice::from_ref(root)), memory::segments(&machine, &[prefix])]
}

/// Findings on components, and on those that did not stop.
async fn components(session: &Session) -> Vec<Finding> {
    let Ok(listed) = session.ask(routes::components()).await else { return Vec::new() };
    let Components { components, left_behind, .. } = listed.content;
    let mut found: Vec<Finding> = left_behind.iter().map(left).collect();
    for component in &components {
        let name = &component.name;
        found.extend(component.stuck.iter().map(|codel| stuck(name, codel)));
        found.extend(component.spins.iter().map(|spin| spins(name, spin)));
        for rule in component.supervision.iter().filter(|rule| rule.violations > 0) {
            let (what, fix) = (advice::broken_rule(name, rule), advice::after_broken_rule(name));
            found.push(Finding::problem("supervision", what, fix));
        }
        if component.state == "damaged" {
            let what = format!("codels of {name} wrote past the memory they were given");
            let fix = format!(
                "`genomctl logs --level error` says which; mend it, `genomctl unload {name}` and load it"
            );
            found.push(Finding::problem("memory", what, fix));
        }
        found.extend(unmet(session, name).await);
        let Ok(statistics) = session.ask(routes::statistics(name)).await else { continue };
        for task in statistics.content.tasks.iter().filter(|task| task.overruns > 0) {
            let what = format!("task {} of {name} missed {} ticks", task.name, task.overruns);
            found.push(Finding::note("tasks", what, advice::overruns(name)));
        }
    }
    found
}

/// A component that did not stop.
fn left(LeftBehind { was, component, state }: &LeftBehind) -> Finding {
    let what = format!("of {was} ({component}): {state}");
    let fix = "it goes when its codel returns; restart genomd to be rid of it";
    Finding::problem("left behind", what, fix)
}

/// A codel of a component that does not return.
fn stuck(name: &str, running: &RunningCodel) -> Finding {
    let RunningCodel { codel, owner, task, for_ns, .. } = running;
    let whose = task.as_ref().map_or("a request".to_owned(), |task| format!("task {task}"));
    let time = for_ns / 1_000_000_000;
    let what = format!("{whose} of {name} is stuck in {codel} of {owner} for {time} s");
    let fix = format!(
        "look at what the codel waits for (gdb -p); `genomctl unload {name}` leaves it behind"
    );
    Finding::problem("codels", what, fix)
}

/// A task that occupies a processor and never pauses.
fn spins(name: &str, Spin { unpaused, processor }: &Spin) -> Finding {
    let Unpaused { task, codel, owner, for_ns, .. } = unpaused;
    let (time, share) = (for_ns / 1_000_000_000, processor * 100.0);
    let what = format!(
        "task {task} of {name} does not pause: codel {codel} of {owner} yields without pause for \
         {time} s ({share:.0} % of a processor)"
    );
    Finding::problem("codels", what, advice::unpaused(codel))
}

/// Connections of a component's ports whose two ends exist and do not reach each other.
async fn unmet(session: &Session, component: &str) -> Vec<Finding> {
    let mut found = Vec::new();
    let Ok(described) = session.ask(routes::component(component)).await else { return found };
    for port in &described.content.ports {
        let Ok(why) = session.ask(routes::why(component, &port.name)).await else { continue };
        let unmet = why.content.findings.into_iter().filter(|one| one.unmet);
        found.extend(unmet.map(|one| Finding::problem("ports", one.what, one.fix)));
    }
    found
}

/// Checks the configuration by running genomd.
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
