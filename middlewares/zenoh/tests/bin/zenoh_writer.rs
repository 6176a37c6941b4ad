//! Writes demo/position on zenoh until it is killed: the peer of a test.

#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, reason = "part of a test")]

use std::io::Read;

use genom_middleware::conformance::samples::{numbered, state};
use genom_middleware::{Address, Middleware};
use genom_zenoh::{Options, Zenoh};

/// Called with the folder in which sessions meet. Ends with its standard input.
fn main() {
    let rendezvous = std::env::args_os().nth(1).map(Into::into);
    let zenoh = Zenoh::open(&Options { rendezvous, ..Options::default() }).unwrap();
    let mut writer = zenoh.publisher(&Address::new("demo", "position"), &state()).unwrap();
    writer.publish(&numbered(9)).unwrap();
    let _ = std::io::stdin().read_to_end(&mut Vec::new());
}
