//! `genomctl digest`: the digests of components and services (genom3.md 4.9). No daemon.

use std::path::PathBuf;

use genom_description::model::Component;
use serde_json::{Map, Value, json};

use crate::failure::Failure;
use crate::reading::Reading;
use crate::session::Session;

/// Print the digests of components and of their services. Both sides of a connection must have
/// equal digests.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .gen files, read in order as one specification.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let analysis = args.reading.read_sound(&args.files)?;
    let components = analysis.specification.components.iter();
    let render = if session.json { data } else { text };
    session.print(&components.map(render).collect::<String>())
}

fn text(component: &Component) -> String {
    let mut text = format!("{}  {}\n", component.digest, component.name);
    for service in &component.services {
        text.push_str(&format!("{}  {}/{}\n", service.digest, component.name, service.name));
    }
    text
}

fn data(component: &Component) -> String {
    let services: Map<String, Value> = component
        .services
        .iter()
        .map(|service| (service.name.clone(), json!(service.digest)))
        .collect();
    let line = json!({
        "component": component.name, "digest": component.digest, "services": services,
    });
    format!("{line}\n")
}
