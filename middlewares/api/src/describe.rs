//! Spells types for error messages, with enough detail that two different types never read alike.

use genom_types::DataType;

use crate::service::ServiceType;

/// Name of a port's type, its size in bytes if it is fixed, and its digest.
#[must_use]
pub fn type_of_port(ty: &DataType) -> String {
    if ty.is_fixed_size() {
        format!("{} ({} bytes, digest {})", ty.name(), ty.size(), ty.digest())
    } else {
        format!("{} (variable size, digest {})", ty.name(), ty.digest())
    }
}

/// Input and output types of a service, and the digest of its description.
#[must_use]
pub fn types_of_service(service: &ServiceType) -> String {
    let types = format!("{} -> {}", type_of_port(&service.input), type_of_port(&service.output));
    match service.described.as_str() {
        "" => types,
        digest => format!("{types}, parameters and exceptions {digest}"),
    }
}
