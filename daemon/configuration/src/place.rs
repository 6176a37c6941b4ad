//! Where an in port reads: an address, and on which middleware when that is said.

use genom_middleware::Address;
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
    #[error("`{0}` is no COMPONENT/PORT, nor BACKEND:NAME/NAME")]
    Form(String),
    /// No such middleware.
    #[error(transparent)]
    Backend(#[from] BackendError),
}

impl Place {
    /// Reads an address, with or without a middleware before it.
    pub fn parse(text: &str) -> Result<Self, PlaceError> {
        let form = || PlaceError::Form(text.to_owned());
        let (backend, rest) = match text.split_once(':') {
            Some((backend, rest)) if !backend.contains('/') => (Some(backend), rest),
            _ => (None, text),
        };
        // Absolute names of foreign middlewares: `ros2:/scan`.
        let absolute = rest.strip_prefix('/').filter(|name| backend.is_some() && !name.is_empty());
        let address = match absolute {
            Some(name) => Address::new("", name),
            None => Address::parse(rest).ok_or_else(form)?,
        };
        if let Some(backend) = backend {
            check(backend)?;
        }
        Ok(Self { backend: backend.map(str::to_owned), address })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_middleware_may_stand_before_an_address() {
        let place = Place::parse("shm:demo/cameras/left").unwrap();
        assert_eq!(place.backend.as_deref(), Some("shm"));
        assert_eq!(place.address, Address::new("demo", "cameras/left"));
        assert_eq!(Place::parse("demo/position").unwrap().backend, None);
        assert!(matches!(Place::parse("shm:"), Err(PlaceError::Form(_))));
        let told = Place::parse("smh:demo/position").unwrap_err().to_string();
        assert!(told.contains("did you mean `shm`?"), "{told}");
    }
}
