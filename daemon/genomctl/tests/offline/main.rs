//! Black-box tests of the verbs that need no daemon: exact output for each command.

#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod agreement;
mod check;
mod fmt;
mod hints;
mod made;
mod spin;
mod support;
