//! Addresses of ports and services: which component instance, which port or service.

use std::fmt;

use serde::{Deserialize, Serialize};

/// `<instance>/<port>`, or `<instance>/<port>/<element>` for an element of a multiple port.
///
/// ```
/// use genom_middleware::Address;
///
/// let at = Address::parse("arm/poses/left").expect("an instance and a port");
/// assert_eq!((at.instance.as_str(), at.name.as_str()), ("arm", "poses/left"));
/// assert_eq!(at, Address::new("arm", "poses/left"));
/// assert_eq!(Address::parse("arm"), None);
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Address {
    /// Instance name of the component.
    pub instance: String,
    /// Name of the port or service; for an element of a multiple port, `port/element`.
    pub name: String,
}

impl Address {
    /// Builds an address from an instance name and the name of a port or service.
    pub fn new(instance: impl Into<String>, name: impl Into<String>) -> Self {
        Self { instance: instance.into(), name: name.into() }
    }

    /// Parses `instance/name` or `instance/name/element`. `None` when a part is missing or empty.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let (instance, name) = text.split_once('/')?;
        let empty_part = instance.is_empty() || name.split('/').any(str::is_empty);
        (!empty_part).then(|| Self::new(instance, name))
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.instance, self.name)
    }
}
