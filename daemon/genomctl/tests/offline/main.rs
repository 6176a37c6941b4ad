//! The verbs that need no daemon, black box: what is typed, and exactly what is shown.

#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod agreement;
mod check;
mod fmt;
mod made;
mod support;
