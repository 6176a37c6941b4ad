//! Names of middlewares as a configuration gives them: one, or several at once.

use std::fmt;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The middlewares a port or a component is on: `"shm"`, `"shm+zenoh"` or `["shm", "zenoh"]`.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize, ToSchema)]
#[serde(try_from = "OneOrMore", into = "String")]
#[schema(value_type = OneOrMore)]
pub struct BackendNames(Vec<String>);

#[derive(Deserialize, ToSchema)]
#[serde(untagged, expecting = "expected the name of a backend, or a list of names")]
enum OneOrMore {
    One(String),
    More(Vec<String>),
}

impl BackendNames {
    /// One middleware.
    pub fn one(name: impl Into<String>) -> Self {
        Self(vec![name.into()])
    }

    /// In the order given, without repetition.
    pub fn names(&self) -> &[String] {
        &self.0
    }

    /// The one that counts where only one can.
    pub fn first(&self) -> &str {
        self.0.first().map_or("", String::as_str)
    }

    /// Whether a middleware is among them.
    pub fn has(&self, name: &str) -> bool {
        self.0.iter().any(|known| known == name)
    }
}

impl TryFrom<OneOrMore> for BackendNames {
    type Error = &'static str;

    fn try_from(given: OneOrMore) -> Result<Self, Self::Error> {
        let given = match given {
            OneOrMore::One(name) => name.split('+').map(str::to_owned).collect(),
            OneOrMore::More(names) => names,
        };
        let mut names = Vec::new();
        for name in given {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        if names.is_empty() { Err("name one backend at least") } else { Ok(Self(names)) }
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
