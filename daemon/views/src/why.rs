//! Why no data flows through a port: findings with advice.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use genom_description::model::{
    CodelParameter, Direction, Parameter, PortDirection, PortIx, RemoteIx, Service, ServiceKind,
    Source,
};
use genom_doors::RpcError;
use genom_middleware::{Address, Obstacle};
use genom_ports::PortKey;
use genom_protocol::{Finding, Findings, Remedy, advice, routes};
use genom_runtime::seconds;
use genom_supervisor::Supervisor;
use genom_supervisor::components::Hosted;
use genom_supervisor::connections::{self, stranded};

use crate::named::{find, find_port};

/// Tell why no data flows through a port, or why calls of a remote fail.
#[utoipa::path(
    get,
    path = "/components/{component}/ports/{port}/why",
    tag = "ports",
    responses((status = 200, body = Findings), (status = 404))
)]
pub async fn why(
    State(supervisor): State<Arc<Supervisor>>,
    Path((component, port)): Path<(String, String)>,
) -> Result<Json<Findings>, RpcError> {
    let hosted = find(&supervisor.components, &component)?;
    let remote = hosted.model().remotes.find(|remote| remote.name == port);
    let port = match remote {
        Some(_) => None,
        None => Some(find_port(&hosted, &port)?),
    };
    // Discovery may have to ask other processes, and blocks.
    let work = move || {
        let Some(port) = port else {
            let findings = remote.map(|remote| of_remote(&supervisor, &hosted, remote));
            return Json(Findings { findings: findings.unwrap_or_default(), flows: vec![] });
        };
        let mut findings = of_port(&supervisor, &hosted, port);
        // Problems of the component do not necessarily affect this port.
        let flows = if findings.is_empty() { flows(&hosted, port) } else { Vec::new() };
        findings.extend(of_component(&hosted));
        Json(Findings { findings, flows })
    };
    tokio::task::spawn_blocking(work).await.map_err(|error| RpcError::internal(error.to_string()))
}

/// Addresses of the port or its elements that were written or read recently.
fn flows(hosted: &Hosted, port: PortIx) -> Vec<String> {
    let model = &hosted.model().ports[port];
    let one = |key: PortKey| {
        let counts = hosted.ties.gauge(&key)?.counts();
        let age = counts.age_ns.filter(|age| counts.samples > 0 && *age <= STALE)?;
        let did = match model.direction {
            PortDirection::In => "read",
            PortDirection::Out => "written",
        };
        let (address, ms) = (hosted.port_address(&key), age / 1_000_000);
        let over = hosted.ties.connection(&key).filter(|made| made.fixed);
        let over = over.map_or(String::new(), |made| format!(", over {}", made.backend));
        Some(format!(
            "{address} was last {did} {ms} ms ago, {} samples so far{over}",
            counts.samples
        ))
    };
    hosted.elements(port).into_iter().filter_map(one).collect()
}

fn of_port(supervisor: &Supervisor, hosted: &Hosted, port: PortIx) -> Vec<Finding> {
    let mut out = Vec::new();
    let elements = hosted.elements(port);
    let model = &hosted.model().ports[port];
    let address = hosted.address(&model.name, None);
    if elements.is_empty() {
        let what = format!("{address} is a multiple port without elements");
        out.push(match model.direction {
            PortDirection::In => {
                Finding::new(what, format!("`genomctl connect {address}/ELEMENT OUT`"))
            }
            PortDirection::Out => Finding::new(what, "its codels have to open one"),
        });
    }
    for key in elements {
        let address = hosted.port_address(&key);
        let counts = hosted.ties.gauge(&key).map(|gauge| gauge.counts());
        let samples = counts.map_or(0, |counts| counts.samples);
        let age = counts.and_then(|counts| counts.age_ns).unwrap_or_default();
        match (model.direction, hosted.ties.connection(&key)) {
            (PortDirection::Out, _) if samples == 0 => {
                let why = if idle(hosted) { ", and no activity runs" } else { "" };
                let what = format!("{address} was never written{why}");
                out.push(unwritten(what, hosted, port));
            }
            (PortDirection::Out, _) if idle(hosted) && age > STALE => {
                let what = format!(
                    "{address} was last written {} s ago, and no activity runs",
                    age / STALE
                );
                out.push(unwritten(what, hosted, port));
            }
            (PortDirection::In, None) => {
                let fix = format!("`genomctl connect {address} COMPONENT/PORT`");
                let connect = Remedy::connect(&address.to_string(), None);
                let what = format!("{address} is not connected");
                out.push(Finding::new(what, fix).or(connect));
                if let Some(what) = hosted.ties.differed(&key) {
                    let fix = "make the two .gen types equal";
                    out.push(Finding::new(format!("a connection was refused: {what}"), fix));
                }
            }
            (PortDirection::In, Some(made)) => {
                let gone = match supervisor.components.get(&made.outport.instance) {
                    Some(_) => false,
                    None => supervisor.backends.get(&made.backend).is_ok_and(|middleware| {
                        !connections::publishes(middleware.as_ref(), &made.outport)
                    }),
                };
                if gone {
                    let what = format!("nobody publishes {} on {}", made.outport, made.backend);
                    let fix = "start its component; the connection is still there";
                    out.push(Finding::new(what, fix).or(disconnect(hosted, &key)));
                } else if samples == 0 {
                    let over =
                        if made.fixed { format!(" over {}", made.backend) } else { String::new() };
                    let what = format!("{address} read nothing from {}{over} yet", made.outport);
                    // Connected to its own address: values are published from outside.
                    out.push(if made.outport == address {
                        let fix =
                            "see that a codel reads it: `genomctl activities` shows what runs";
                        Finding::new(what, fix)
                    } else {
                        let see = Some(made.outport.to_string());
                        let fix = format!(
                            "`genomctl why {}`, and see that a codel reads it",
                            made.outport
                        );
                        Finding { see, ..Finding::new(what, fix) }
                    });
                }
            }
            _ => {}
        }
        out.extend(unmet(supervisor, hosted, &key));
        let stranded = stranded(&supervisor.backends, hosted, &key);
        out.extend(stranded.into_iter().map(|one| Finding::new(one.what, one.fix)));
        if let Some(failed) = counts.map(|counts| counts.failed).filter(|failed| *failed > 0) {
            let what = format!("{failed} writes or reads of {address} failed");
            out.push(Finding::new(what, "look at the exceptions of its codels and at the log"));
        }
    }
    out
}

/// Problems of the component that concern all ports.
fn of_component(hosted: &Hosted) -> Vec<Finding> {
    let mut out = Vec::new();
    stuck_codels(hosted, &mut out);
    spinning_codels(hosted, &mut out);
    stopped_tasks(hosted, &mut out);
    broken_rules(hosted, &mut out);
    out.extend(hosted.notes.iter().map(|note| Finding::new(note, "see docs/freeze.md")));
    if let Some(written) = hosted.damage() {
        let fix = "set check_memory = \"each-codel\" to find the codel, mend it and load it again";
        let what = format!("the memory of {} is damaged: {written}", hosted.name);
        out.push(Finding::new(what, fix).or(Remedy::unload(&hosted.name)));
    }
    out
}

/// Problems of a remote: it is not connected, or its service does not exist.
fn of_remote(supervisor: &Supervisor, hosted: &Hosted, remote: RemoteIx) -> Vec<Finding> {
    let mut out = remote_unserved(supervisor, hosted, remote);
    stuck_codels(hosted, &mut out);
    if let Some(provider) = hosted.ties.remote(remote)
        && let Some(provider) = supervisor.components.get(&provider.service.instance)
        && provider.name != hosted.name
    {
        stuck_codels(&provider, &mut out);
    }
    out
}

fn remote_unserved(supervisor: &Supervisor, hosted: &Hosted, remote: RemoteIx) -> Vec<Finding> {
    let address = hosted.address(&hosted.model().remotes[remote].name, None);
    let Some(made) = hosted.ties.remote(remote) else {
        let fix = format!("`genomctl connect {address} COMPONENT/SERVICE`");
        return vec![Finding::new(format!("{address} is not connected"), fix)];
    };
    let (there, place) = match &made.backend {
        None => {
            let provider = supervisor.components.get(&made.service.instance);
            let serves =
                provider.is_some_and(|one| one.plan().service(&made.service.name).is_some());
            (serves, "in this daemon".to_owned())
        }
        Some(backend) => {
            let on = supervisor.backends.get(backend);
            let serves = on.is_ok_and(|on| connections::serves(on.as_ref(), &made.service));
            (serves, format!("on {backend}"))
        }
    };
    if there {
        return Vec::new();
    }
    let what = format!("nobody provides {} {place}", made.service);
    let fix = match &made.backend {
        None => "start its component; the connection is still there",
        // A service that is not offered cannot be distinguished from one that does not exist.
        Some(_) => {
            "start its component; the connection is still there. If it runs, `genomctl info` there \
             tells what [services] of its daemon's configuration offers"
        }
    };
    vec![Finding::new(what, fix)]
}

/// Endpoints that exist and do not reach each other, on the middlewares in use.
fn unmet(supervisor: &Supervisor, hosted: &Hosted, key: &PortKey) -> Vec<Finding> {
    let port = &hosted.model().ports[key.port];
    let on = |backend: &str, address: &Address| {
        let middleware = supervisor.backends.opened(backend);
        middleware.map(|middleware| middleware.obstacles(address)).unwrap_or_default()
    };
    let obstacles = match hosted.ties.connection(key) {
        Some(made) => on(&made.backend, &made.outport),
        None if port.direction == PortDirection::In => Vec::new(),
        None => {
            let address = hosted.port_address(key);
            let names = hosted.backends_of(key);
            names.names().iter().flat_map(|backend| on(backend, &address)).collect()
        }
    };
    let fix = |fix: String| fix.replace("PORT]", &format!("{}]", port.name));
    let unmet = |one: Obstacle| Finding { unmet: true, ..Finding::new(one.what, fix(one.fix)) };
    obstacles.into_iter().map(unmet).collect()
}

/// Nanoseconds after which an out port without a new sample counts as not written, if no activity
/// runs.
const STALE: u64 = 1_000_000_000;

fn idle(hosted: &Hosted) -> bool {
    hosted.activities.running() == 0
}

/// An out port that nothing writes now, with the activity that would.
fn unwritten(what: String, hosted: &Hosted, port: PortIx) -> Finding {
    let name = &hosted.name;
    let writes = |service: &&Service| {
        service.kind == ServiceKind::Activity
            && !service.standard
            && service.codels.iter().any(|&codel| {
                let mut parameters = hosted.model().codels[codel].parameters.iter();
                parameters.any(|one| writes_port(one, port))
            })
    };
    let Some(service) = hosted.model().services.iter().find(writes) else {
        return Finding::new(what, format!("`genomctl info {name}` shows what can be started"));
    };
    let found = Finding::new(what, format!("`genomctl start {name} {}`", service.name));
    let takes = |one: &Parameter| one.direction != Direction::Out;
    let given = |one: &Parameter| one.default.as_ref().is_some_and(|found| found.value.is_some());
    if service.parameters.iter().any(|one| takes(one) && !given(one)) {
        // Whoever starts it has to say what it takes.
        return found;
    }
    let does = format!("Start {} of {name}", service.name);
    let no_inputs = serde_json::Value::Object(serde_json::Map::new());
    found.or(Remedy {
        body: Some(no_inputs),
        ..Remedy::new(does, &routes::call(name, &service.name))
    })
}

fn disconnect(hosted: &Hosted, key: &PortKey) -> Remedy {
    let (name, port) = (&hosted.name, &hosted.model().ports[key.port].name);
    let does = format!("Disconnect {}", hosted.port_address(key));
    match &key.element {
        None => Remedy::new(does, &routes::disconnect(name, port)),
        Some(element) => Remedy::new(does, &routes::disconnect_element(name, port, element)),
    }
}

fn writes_port(parameter: &CodelParameter, port: PortIx) -> bool {
    parameter.direction != Direction::In && parameter.source == Source::Port(port)
}

/// Codels that do not return.
fn stuck_codels(hosted: &Hosted, out: &mut Vec<Finding>) {
    let name = &hosted.name;
    for codel in hosted.stuck() {
        let whose =
            codel.task.as_ref().map_or("a request".to_owned(), |task| format!("task {task}"));
        let time = seconds(codel.for_ns);
        let what =
            format!("{whose} of {name} is stuck in {} of {} for {time}", codel.codel, codel.owner);
        let fix =
            format!("look at what the codel waits for; `genomctl unload {name}` leaves it behind");
        out.push(Finding::new(what, fix).or(Remedy::unload(name)));
    }
}

/// Tasks that occupy a processor and never pause.
fn spinning_codels(hosted: &Hosted, out: &mut Vec<Finding>) {
    for spin in hosted.spins() {
        let (task, codel) = (&spin.unpaused.task, &spin.unpaused.codel);
        let name = &hosted.name;
        let what = format!("task {task} of {name} does not pause: {spin}");
        out.push(Finding::new(what, advice::unpaused(codel)).or(Remedy::reload(name)));
    }
}

/// Missed ticks.
fn stopped_tasks(hosted: &Hosted, out: &mut Vec<Finding>) {
    let name = &hosted.name;
    for task in hosted.figures().tasks.iter().filter(|task| task.overruns > 0) {
        let what = format!("task {} of {name} missed {} ticks", task.name, task.overruns);
        out.push(Finding::new(what, advice::overruns(name)));
    }
}

/// Rules of supervision that were broken.
fn broken_rules(hosted: &Hosted, out: &mut Vec<Finding>) {
    let name = &hosted.name;
    for rule in hosted.rules().iter().filter(|rule| rule.violations > 0) {
        let (what, fix) = (advice::broken_rule(name, rule), advice::after_broken_rule(name));
        out.push(Finding::new(what, fix).or(Remedy::reload(name)));
    }
}
