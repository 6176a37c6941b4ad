//! Publishers and readers of other programs under a port's address, on a middleware that the port
//! is not on or has left.
//!
//! These see a port that nobody writes or reads.

use genom_description::model::PortDirection;
use genom_middleware::{Address, EndpointKind};
use genom_ports::PortKey;
use genom_registry::Backends;

use super::find::shows;
use crate::components::Hosted;

/// An endpoint that the port does not reach, and how to connect it.
#[derive(Clone, Debug)]
pub struct Stranded {
    /// What is wrong.
    pub what: String,
    /// What to do about it.
    pub fix: String,
}

/// Publishers under an in port's own address on middlewares where it does not read, and readers of
/// an out port on middlewares where it does not publish.
#[must_use]
pub fn stranded(backends: &Backends, hosted: &Hosted, key: &PortKey) -> Vec<Stranded> {
    let model = &hosted.model().ports[key.port];
    let at = hosted.port_address(key);
    let open = genom_registry::known().iter().filter_map(|known| backends.opened(known.name));
    match model.direction {
        PortDirection::In => {
            let made = hosted.ties.connection(key);
            let (reads, on) = made.map_or((None, None), |made| {
                let itself = made.outport == at;
                (Some(made.outport), itself.then_some(made.backend))
            });
            let elsewhere = open.filter(|open| on.as_deref() != Some(open.name()));
            elsewhere
                .filter(|open| shows(open.as_ref(), EndpointKind::Publisher, &at))
                .map(|open| unread(&at, open.name(), reads.as_ref()))
                .collect()
        }
        PortDirection::Out => {
            let names = hosted.backends_of(key);
            let elsewhere = open.filter(|open| !names.has(open.name()));
            elsewhere
                .filter(|open| shows(open.as_ref(), EndpointKind::Subscription, &at))
                .map(|open| {
                    let on = open.name();
                    Stranded {
                        what: format!("somebody reads {at} on {on}, and it is on {names}"),
                        fix: format!(
                            "have them subscribe again, or `genomctl backend {}/{} {names}+{on}` \
                             writes it there too",
                            hosted.name, model.name
                        ),
                    }
                })
                .collect()
        }
    }
}

fn unread(at: &Address, on: &str, reads: Option<&Address>) -> Stranded {
    let reads = match reads {
        None => "it is not connected".to_owned(),
        Some(reads) if reads == at => "it does not read there".to_owned(),
        Some(reads) => format!("it reads {reads}"),
    };
    Stranded {
        what: format!("somebody publishes {at} on {on}, and {reads}"),
        fix: format!("`genomctl connect {at} {on}:{at}`, or have them begin again"),
    }
}
