//! Addresses of ports, services and remotes: `[BACKEND:]COMPONENT/PORT[/ELEMENT]`.
//!
//! Configurations, requests and command lines are all parsed here.

use std::fmt;
use std::str::FromStr;

/// `COMPONENT/PORT` or `COMPONENT/PORT/ELEMENT`. A service or a remote may take the place of the
/// port.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Address {
    /// Instance name. Empty for an absolute name of a foreign middleware (see [`Place`]).
    pub component: String,
    /// Name of the port, service or remote.
    pub port: String,
    /// Name of the element, if the port is multiple.
    pub element: Option<String>,
}

/// The text is not an [`Address`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no COMPONENT/PORT")]
pub struct NoAddress(pub String);

/// An address, optionally with its middleware: `shm:demo/position`.
///
/// After a middleware the name may be absolute, as foreign middlewares have them: `ros2:/scan`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Place {
    /// Name of the middleware. Whether there is one of that name is not checked.
    pub backend: Option<String>,
    /// The address on the middleware.
    pub address: Address,
}

/// The text is not a [`Place`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no COMPONENT/PORT, nor BACKEND:NAME/NAME")]
pub struct NoPlace(pub String);

/// A component, or one of its ports.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Subject {
    /// `COMPONENT`
    Component(String),
    /// `COMPONENT/PORT` or `COMPONENT/PORT/ELEMENT`
    Port(Address),
}

/// The component in `COMPONENT/PORT`, or in what begins like that, without a look at the rest.
#[must_use]
pub fn component_of(address: &str) -> &str {
    address.split('/').next().unwrap_or_default()
}

impl Address {
    /// `PORT`, or `PORT/ELEMENT`.
    #[must_use]
    pub fn name(&self) -> String {
        match &self.element {
            Some(element) => format!("{}/{element}", self.port),
            None => self.port.clone(),
        }
    }

    /// Splits `PORT[/ELEMENT]`; a second slash and what follows it belong to the element.
    fn of(component: &str, name: &str) -> Option<Self> {
        if name.split('/').any(str::is_empty) {
            return None;
        }
        let (port, element) = match name.split_once('/') {
            Some((port, element)) => (port, Some(element.to_owned())),
            None => (name, None),
        };
        Some(Self { component: component.to_owned(), port: port.to_owned(), element })
    }
}

impl FromStr for Address {
    type Err = NoAddress;

    fn from_str(text: &str) -> Result<Self, NoAddress> {
        text.split_once('/')
            .filter(|(component, _)| !component.is_empty())
            .and_then(|(component, name)| Self::of(component, name))
            .ok_or_else(|| NoAddress(text.to_owned()))
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.component, self.port)?;
        self.element.iter().try_for_each(|element| write!(f, "/{element}"))
    }
}

impl FromStr for Place {
    type Err = NoPlace;

    fn from_str(text: &str) -> Result<Self, NoPlace> {
        let (backend, rest) = match text.split_once(':') {
            Some((backend, rest)) if !backend.contains('/') => (Some(backend.to_owned()), rest),
            _ => (None, text),
        };
        let absolute = rest.strip_prefix('/').filter(|_| backend.is_some());
        let address = match absolute {
            Some(name) => Address::of("", name),
            None => rest.parse().ok(),
        };
        let address = address.ok_or_else(|| NoPlace(text.to_owned()))?;
        Ok(Self { backend, address })
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.backend.iter().try_for_each(|backend| write!(f, "{backend}:"))?;
        self.address.fmt(f)
    }
}

impl FromStr for Subject {
    type Err = NoAddress;

    fn from_str(text: &str) -> Result<Self, NoAddress> {
        match text.contains('/') {
            true => text.parse().map(Self::Port),
            false if text.is_empty() => Err(NoAddress(text.to_owned())),
            false => Ok(Self::Component(text.to_owned())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(component: &str, port: &str, element: Option<&str>) -> Address {
        let element = element.map(str::to_owned);
        Address { component: component.into(), port: port.into(), element }
    }

    #[test]
    fn an_address_has_a_component_a_port_and_maybe_an_element() {
        for (text, expected) in [
            ("demo/position", address("demo", "position", None)),
            ("demo/cameras/left", address("demo", "cameras", Some("left"))),
            ("demo/cameras/left/eye", address("demo", "cameras", Some("left/eye"))),
        ] {
            let read: Address = text.parse().unwrap();
            assert_eq!((read.to_string().as_str(), &read), (text, &expected));
        }
        for wrong in ["", "demo", "demo/", "/position", "demo//left", "demo/cameras/", "/"] {
            assert_eq!(wrong.parse::<Address>(), Err(NoAddress(wrong.to_owned())));
        }
    }

    #[test]
    fn a_middleware_may_stand_before_an_address_and_an_absolute_name_behind_it() {
        for (text, backend, expected) in [
            ("demo/position", None, address("demo", "position", None)),
            ("shm:demo/cameras/left", Some("shm"), address("demo", "cameras", Some("left"))),
            ("ros2:/scan", Some("ros2"), address("", "scan", None)),
            ("ros2:/left/arm/pose", Some("ros2"), address("", "left", Some("arm/pose"))),
        ] {
            let read: Place = text.parse().unwrap();
            assert_eq!((read.backend.as_deref(), &read.address), (backend, &expected));
            assert_eq!(read.to_string(), text);
        }
        for wrong in ["", "shm:", "shm:demo", "/scan", "ros2:/", "ros2://scan", "shm:demo/"] {
            assert_eq!(wrong.parse::<Place>(), Err(NoPlace(wrong.to_owned())));
        }
    }

    #[test]
    fn a_subject_is_a_component_or_a_port() {
        assert_eq!("demo".parse(), Ok(Subject::Component("demo".to_owned())));
        assert_eq!("demo/a/b".parse(), Ok(Subject::Port(address("demo", "a", Some("b")))));
        assert!("".parse::<Subject>().is_err() && "demo/".parse::<Subject>().is_err());
    }
}
