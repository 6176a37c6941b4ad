//! Names as arguments of the command line: `COMPONENT/PORT`, maybe with a middleware before it.

use genom_protocol::{Address, Place};

/// How a name is written.
const EXPECTED: &str = "expected COMPONENT/PORT, for instance demo/position";

/// A port, service or remote of the daemon.
pub(crate) fn address(text: &str) -> Result<Address, &'static str> {
    text.parse().map_err(|_| EXPECTED)
}

/// The same of any daemon, on any middleware.
pub(crate) fn place(text: &str) -> Result<Place, &'static str> {
    text.parse().map_err(|_| EXPECTED)
}

/// The query for the element of an address.
pub(crate) fn element(of: &Address) -> genom_protocol::ValueParameters {
    genom_protocol::ValueParameters { element: of.element.clone() }
}
