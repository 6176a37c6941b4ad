//! Parsers of addresses as arguments: `COMPONENT/PORT`, optionally with a middleware.

use genom_protocol::{Address, Place};

/// The form of an address, for errors.
const EXPECTED: &str = "expected COMPONENT/PORT, for instance demo/position";

/// The address of a port, service or remote of the daemon.
pub(crate) fn address(text: &str) -> Result<Address, &'static str> {
    text.parse().map_err(|_| EXPECTED)
}

/// An address of any daemon, on any middleware.
pub(crate) fn place(text: &str) -> Result<Place, &'static str> {
    text.parse().map_err(|_| EXPECTED)
}

/// The query that selects the element of an address.
pub(crate) fn element(of: &Address) -> genom_protocol::ValueParameters {
    genom_protocol::ValueParameters { element: of.element.clone() }
}
