//! Where an in port reads or a remote calls: an address, and on which middleware when that is said.

use genom_middleware::Address;
use genom_protocol::address::NoPlace;
use genom_registry::{BackendError, check};

/// `demo/position`, or `zenoh:robot/pose`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The middleware, when it was named.
    pub backend: Option<String>,
    /// The address on it.
    pub address: Address,
}

/// The text names no place.
#[derive(Debug, thiserror::Error)]
pub enum PlaceError {
    /// Not of the form.
    #[error(transparent)]
    Form(#[from] NoPlace),
    /// No such middleware.
    #[error(transparent)]
    Backend(#[from] BackendError),
}

impl Place {
    /// Reads an address, with or without a middleware before it.
    ///
    /// # Errors
    /// The text is no address, or no middleware has the name before it.
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
