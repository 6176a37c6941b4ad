//! A way to run a deployment: which middleware each port is on.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use genom_protocol::Address;

/// A middleware for all ports, with others for some of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Way {
    /// Name of the middleware of all ports that are not in `ports`.
    pub backend: String,
    /// Middlewares of single ports, by component and port.
    pub ports: BTreeMap<(String, String), String>,
}

/// The text is not a way.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoWay {
    /// It has no middleware.
    #[error("no middleware before `:`; write BACKEND: COMPONENT/PORT=BACKEND, ...")]
    Backend,
    /// An assignment of a port is not understood.
    #[error("`{0}`: expected COMPONENT/PORT=BACKEND")]
    Port(String),
}

impl Way {
    /// All ports on one middleware.
    #[must_use]
    pub fn all_on(backend: &str) -> Self {
        Self { backend: backend.to_owned(), ports: BTreeMap::new() }
    }
}

impl FromStr for Way {
    type Err = NoWay;

    fn from_str(text: &str) -> Result<Self, NoWay> {
        let (backend, ports) = text.split_once(':').unwrap_or((text, ""));
        let backend = backend.trim();
        if backend.is_empty() {
            return Err(NoWay::Backend);
        }
        let mut way = Self::all_on(backend);
        for one in ports.split(',').map(str::trim).filter(|one| !one.is_empty()) {
            let refused = || NoWay::Port(one.to_owned());
            let (port, backend) = one.split_once('=').ok_or_else(refused)?;
            let port: Address = port.trim().parse().map_err(|_| refused())?;
            let backend = backend.trim();
            if backend.is_empty() || port.element.is_some() {
                return Err(refused());
            }
            way.ports.insert((port.component, port.port), backend.to_owned());
        }
        Ok(way)
    }
}

impl fmt::Display for Way {
    /// As it is written.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.backend)?;
        for (rank, ((component, port), backend)) in self.ports.iter().enumerate() {
            let before = if rank == 0 { ": " } else { ", " };
            write!(f, "{before}{component}/{port}={backend}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_is_read_as_it_is_written() {
        for text in ["shm", "shm: camera/image=zenoh", "local: a/b=shm, c/d=ros2"] {
            assert_eq!(text.parse::<Way>().unwrap().to_string(), text);
        }
        assert_eq!("shm:a/b = zenoh".parse::<Way>().unwrap().to_string(), "shm: a/b=zenoh");
        assert_eq!(": a/b=shm".parse::<Way>(), Err(NoWay::Backend));
        for wrong in ["shm: a=zenoh", "shm: a/b", "shm: a/b=", "shm: a/b/c=zenoh"] {
            assert!(matches!(wrong.parse::<Way>(), Err(NoWay::Port(_))), "{wrong}");
        }
    }
}
