//! Why no data flows through a port: each finding with its fix.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use genom_description::model::PortDirection;
use serde_json::{Value, json};

use crate::daemon::Daemon;
use crate::hosting::Hosted;
use crate::rpc::error::RpcError;
use crate::rpc::{components, ports};
use crate::wiring::connect;

/// `GET /components/{component}/ports/{port}/why`
pub(crate) async fn explain(
    State(daemon): State<Arc<Daemon>>,
    Path((component, port)): Path<(String, String)>,
) -> Result<Json<Value>, RpcError> {
    let hosted = components::find(&daemon, &component)?;
    let index = ports::find(&hosted, &port)?;
    // Discovery may have to ask other processes.
    let work = move || Json(json!({ "findings": findings(&daemon, &hosted, index) }));
    tokio::task::spawn_blocking(work).await.map_err(|error| RpcError::internal(error.to_string()))
}

fn finding(what: impl Into<String>, fix: impl Into<String>) -> Value {
    json!({"what": what.into(), "fix": fix.into()})
}

fn findings(daemon: &Daemon, hosted: &Hosted, port: usize) -> Vec<Value> {
    let mut out = Vec::new();
    let elements = ports::elements(hosted, port);
    let model = &hosted.model().ports[port];
    let (name, address) = (&hosted.name, hosted.address(&model.name, None));
    if elements.is_empty() {
        let what = format!("{address} is a multiple port without elements");
        out.push(match model.direction {
            PortDirection::In => finding(what, format!("`genomctl connect {address}/ELEMENT OUT`")),
            PortDirection::Out => finding(what, "its codels have to open one"),
        });
    }
    for element in elements {
        let address = hosted.address(&model.name, element.as_deref());
        let counts = hosted.wiring.gauge(port, element.as_deref()).map(|gauge| gauge.counts());
        let samples = counts.map_or(0, |counts| counts.samples);
        match (model.direction, hosted.wiring.connection(port, element.as_deref())) {
            (PortDirection::Out, _) if samples == 0 => {
                let fix = format!("`genomctl activities {name}`; start one that writes it");
                let idle = hosted.activities.running() == 0;
                let why = if idle { ", and no activity runs" } else { "" };
                out.push(finding(format!("{address} was never written{why}"), fix));
            }
            (PortDirection::In, None) => {
                let fix = format!("`genomctl connect {address} COMPONENT/PORT`");
                out.push(finding(format!("{address} is not connected"), fix));
            }
            (PortDirection::In, Some(made)) => {
                let gone = match daemon.components.get(&made.outport.instance) {
                    Some(_) => false,
                    None => daemon.backends.get(&made.backend).is_ok_and(|middleware| {
                        !connect::publishes(middleware.as_ref(), &made.outport)
                    }),
                };
                if gone {
                    let what = format!("nobody publishes {} on {}", made.outport, made.backend);
                    out.push(finding(what, "start its component; the connection is still there"));
                } else if samples == 0 {
                    let what = format!("{address} read nothing from {} yet", made.outport);
                    let fix =
                        format!("`genomctl why {}`, and see that a codel reads it", made.outport);
                    out.push(finding(what, fix));
                }
            }
            _ => {}
        }
        if let Some(failed) = counts.map(|counts| counts.failed).filter(|failed| *failed > 0) {
            let what = format!("{failed} writes or reads of {address} failed");
            out.push(finding(what, "look at the exceptions of its codels and at the log"));
        }
    }
    for task in hosted.figures().tasks.iter().filter(|task| task.overruns > 0) {
        let what = format!("task {} of {name} missed {} ticks", task.name, task.overruns);
        out.push(finding(
            what,
            format!("`genomctl stats {name}`; a longer period, or shorter codels"),
        ));
    }
    out
}
