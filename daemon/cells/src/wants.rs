//! What connections need of other processes of the daemon.

use std::collections::BTreeMap;

use genom_configuration::place::Place;

/// What a connection needs of another process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Want {
    /// Component that writes the out port.
    pub(crate) writer: String,
    /// The out port, or the element of a multiple one.
    pub(crate) port: String,
    /// The middleware.
    pub(crate) over: String,
    /// Whether the connection was there: from then on it counts as long as its process has it.
    pub(crate) made: bool,
}

impl Want {
    /// Whether another one needs the same.
    pub(crate) fn is(&self, other: &Self) -> bool {
        (&self.writer, &self.port, &self.over) == (&other.writer, &other.port, &other.over)
    }
}

/// By the address of the in port.
pub(crate) type Wants = BTreeMap<String, Want>;

/// Out port and middleware of a connection for which one was asked.
pub(crate) fn asked(outport: &str, over: Option<&str>) -> Option<Want> {
    let Place { backend, address } = Place::parse(outport).ok()?;
    let over = over.map(str::to_owned).or(backend)?;
    Some(Want { writer: address.instance, port: address.name, over, made: false })
}
