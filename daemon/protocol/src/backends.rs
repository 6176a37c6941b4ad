//! The middlewares of components and ports, and moves between them.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

/// The middlewares of a port or a component: `"shm"`, `"shm+zenoh"` or `["shm", "zenoh"]`.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(try_from = "OneOrMore", into = "String")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema), schema(value_type = OneOrMore))]
pub struct BackendNames(Vec<String>);

/// One string, which may hold several names separated by `+`, or a list of names.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected the name of a backend, or a list of names")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub(crate) enum OneOrMore {
    One(String),
    More(Vec<String>),
}

impl BackendNames {
    /// A single middleware.
    #[must_use]
    pub fn one(name: impl Into<String>) -> Self {
        Self(vec![name.into()])
    }

    /// The names in the order given, without repetition.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.0
    }

    /// These and others.
    #[must_use]
    pub fn with(mut self, others: &[String]) -> Self {
        for name in others {
            if !self.has(name) {
                self.0.push(name.clone());
            }
        }
        self
    }

    /// The first name, for uses that take only one.
    #[must_use]
    pub fn first(&self) -> &str {
        self.0.first().map_or("", String::as_str)
    }

    /// Whether a middleware is among them.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.0.iter().any(|known| known == name)
    }
}

/// Parses what is typed on a command line: names separated by `+`.
impl From<&str> for BackendNames {
    fn from(text: &str) -> Self {
        let mut names = Vec::new();
        for name in text.split('+') {
            if !names.iter().any(|known| known == name) {
                names.push(name.to_owned());
            }
        }
        Self(names)
    }
}

impl TryFrom<OneOrMore> for BackendNames {
    type Error = &'static str;

    fn try_from(given: OneOrMore) -> Result<Self, Self::Error> {
        let names = match given {
            OneOrMore::One(name) => Self::from(name.as_str()),
            OneOrMore::More(names) if names.is_empty() => return Err("name one backend at least"),
            OneOrMore::More(names) => Self::from(names.join("+").as_str()),
        };
        Ok(names)
    }
}

impl From<BackendNames> for String {
    fn from(names: BackendNames) -> Self {
        names.to_string()
    }
}

impl fmt::Display for BackendNames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.join("+"))
    }
}

/// A component, or one of its ports, is to move to other middlewares.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct MoveRequest {
    /// The new middlewares.
    pub backend: BackendNames,
    /// Name of the port, to move only that one.
    #[serde(default)]
    pub port: Option<String>,
}

/// The middlewares that a component or a port uses now.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Moved {
    /// Instance name.
    pub component: String,
    /// Name of the port, if only one moved.
    pub port: Option<String>,
    /// Its middlewares.
    pub backend: BackendNames,
}

/// Out ports of a component that connections read over middlewares which the ports are not on by
/// themselves: those of readers in other processes of the daemon, which tells its cells.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct NeededEnds {
    /// The middlewares, by port, or by `port/element` of a multiple one.
    pub ports: BTreeMap<String, BackendNames>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn several_names_read_as_a_list_or_with_a_plus_between() {
        for (given, written) in [
            (json!("shm"), json!("shm")),
            (json!(["shm"]), json!("shm")),
            (json!(["shm", "zenoh", "shm"]), json!("shm+zenoh")),
            (json!("shm+zenoh"), json!("shm+zenoh")),
        ] {
            let names: BackendNames = serde_json::from_value(given).unwrap();
            assert_eq!(serde_json::to_value(&names).unwrap(), written);
        }
        let refused = serde_json::from_value::<BackendNames>(json!(3)).unwrap_err().to_string();
        assert!(refused.contains("the name of a backend"), "{refused}");
        let refused = serde_json::from_value::<BackendNames>(json!([])).unwrap_err().to_string();
        assert_eq!(refused, "name one backend at least");
    }
}
