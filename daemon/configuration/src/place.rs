//! The source of an in port or the service of a remote: an address, optionally with its middleware.

use genom_middleware::Address;
use genom_protocol::address::NoPlace;
use genom_registry::{BackendError, check};

/// An address such as `demo/position`, or `zenoh:robot/pose`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Name of the middleware, if given.
    pub backend: Option<String>,
    /// The address on the middleware.
    pub address: Address,
}

/// Why a text is not a [`Place`].
#[derive(Debug, thiserror::Error)]
pub enum PlaceError {
    /// It does not have the form `[BACKEND:]COMPONENT/PORT[/ELEMENT]`.
    #[error(transparent)]
    Form(#[from] NoPlace),
    /// There is no middleware of that name.
    #[error(transparent)]
    Backend(#[from] BackendError),
}

impl Place {
    /// Parses an address, with or without a middleware before it.
    ///
    /// # Errors
    /// The text is not an address, or no middleware has the name before it.
    pub fn parse(text: &str) -> Result<Self, PlaceError> {
        let genom_protocol::Place { backend, address } = text.parse()?;
        if let Some(backend) = &backend {
            check(backend)?;
        }
        Ok(Self { backend, address: Address::new(&address.component, address.name()) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middleware_before_an_address_has_to_be_known() {
        let place = Place::parse("shm:demo/cameras/left").unwrap();
        assert_eq!(place.backend.as_deref(), Some("shm"));
        assert_eq!(place.address, Address::new("demo", "cameras/left"));
        assert_eq!(Place::parse("ros2:/left/scan").unwrap().address, Address::new("", "left/scan"));
        assert!(matches!(Place::parse("shm:"), Err(PlaceError::Form(_))));
        let told = Place::parse("smh:demo/position").unwrap_err().to_string();
        assert!(told.contains("did you mean `shm`?"), "{told}");
    }
}
