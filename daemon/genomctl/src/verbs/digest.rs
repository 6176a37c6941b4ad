//! `genomctl digest`: digests of components and their services. No daemon.

use std::path::PathBuf;

use genom_description::model::Component;

use crate::failure::Failure;
use crate::session::Session;
use crate::table::table;
use crate::verbs::check::Reading;

/// Show the digests of components and services: equal digests, equal interfaces.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .gen files, read in order as one specification.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let specification = args.reading.understand(&args.files)?;
    for component in &specification.components {
        if session.json {
            let services: serde_json::Map<_, _> = component
                .services
                .iter()
                .map(|service| (service.name.clone(), service.digest.as_str().into()))
                .collect();
            let reply = serde_json::json!({
                "component": component.name, "digest": component.digest, "services": services,
            });
            session.print(&format!("{reply}\n"))?;
        } else {
            session.print(&render(component))?;
        }
    }
    Ok(())
}

fn render(component: &Component) -> String {
    let mut rows = vec![vec![component.name.clone(), component.digest.clone()]];
    rows.extend(component.services.iter().filter(|service| !service.standard).map(|service| {
        vec![format!("{}/{}", component.name, service.name), service.digest.clone()]
    }));
    table(&["NAME", "DIGEST"], &rows)
}
