//! What keeps components from running well, on this machine and in this daemon.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::{Duration, Instant};

use axum::{Extension, Json};
use genom_doctor::{Machine, Seen, multicast, of_daemon, of_files};
use genom_doors::{Own, Parameters, RpcError};
use genom_protocol::{
    Address, Components, Diagnosis, DoctorParameters, Examined, Finding, MiddlewareParameters,
    PortParameters, routes,
};

use crate::together::Together;

/// How long ports are asked about; those that are left then are told by their number.
const PATIENCE: Duration = Duration::from_secs(5);

/// Examined one at a time: components are asked one after the other, and a datagram is sent.
static DAEMON: Together<Vec<Diagnosis>> = Together::new();
static MACHINE: Together<Vec<Diagnosis>> = Together::new();

/// Examine the machine and the daemon, and list findings with advice.
#[utoipa::path(
    get,
    path = "/doctor",
    tag = "daemon",
    params(DoctorParameters),
    responses((status = 200, body = Examined))
)]
pub async fn doctor(
    Extension(own): Extension<Own>,
    Parameters(parameters): Parameters<DoctorParameters>,
) -> Result<Json<Examined>, RpcError> {
    let daemon = async { Ok::<_, RpcError>(of_daemon(&look(&own).await)) };
    let daemon = DAEMON.get(daemon).await?;
    let machine = match parameters.daemon_only {
        true => Vec::new(),
        false => MACHINE.get(machine()).await?,
    };
    Ok(Json(Examined { machine, daemon }))
}

/// Reads files, and waits for a datagram.
async fn machine() -> Result<Vec<Diagnosis>, RpcError> {
    let work = || {
        let mut found = of_files(&Machine::at(Path::new("/")));
        found.push(multicast());
        found
    };
    let found = tokio::task::spawn_blocking(work).await;
    found.map_err(|error| RpcError::internal(error.to_string()))
}

/// What is asked; what does not answer is left out.
async fn look(own: &Own) -> Seen {
    let none = || Components { components: vec![], loading: vec![], left_behind: vec![] };
    let examine = MiddlewareParameters { trouble: true, ..Default::default() };
    let middlewares = own.read(&routes::middlewares().with(&examine)).await;
    let cells = own.read(&routes::cells()).await;
    let components = own.read(&routes::components()).await.unwrap_or_else(none);
    let mut statistics = BTreeMap::new();
    for component in &components.components {
        if let Some(told) = own.read(&routes::statistics(&component.name)).await {
            statistics.insert(component.name.clone(), told);
        }
    }
    let (ports, unasked) = findings(own).await;
    Seen {
        middlewares: middlewares.map(|told| told.middlewares).unwrap_or_default(),
        cells: cells.map(|told| told.cells).unwrap_or_default(),
        components,
        statistics,
        ports,
        unasked,
    }
}

/// Why no data flows through the ports of all components, by component.
async fn findings(own: &Own) -> (BTreeMap<String, Vec<Finding>>, usize) {
    let query = PortParameters { values: Some(false) };
    let all = own.read(&routes::ports().with(&query)).await;
    let all = all.map(|told| told.ports).unwrap_or_default();
    let ports = all.iter().filter_map(|port| port.address.parse::<Address>().ok());
    // Those of a multiple port are told together.
    let ports: BTreeSet<_> = ports.map(|address| (address.component, address.port)).collect();
    let (mut found, mut unasked) = (BTreeMap::<_, Vec<_>>::new(), 0);
    let end = Instant::now() + PATIENCE;
    for (component, port) in ports {
        if Instant::now() > end {
            unasked += 1;
            continue;
        }
        if let Some(told) = own.read(&routes::why(&component, &port)).await {
            found.entry(component).or_default().extend(told.findings);
        }
    }
    (found, unasked)
}
