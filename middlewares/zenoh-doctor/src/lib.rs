//! Finds what keeps a zenoh session from others, as `genomctl doctor` tells it: endpoints that are
//! not reached, settings by which nobody is found, certificates that cannot be used, rules of access
//! control that deny what is needed.
//!
//! It asks no other session anything but to open a session with it. zenoh's admin space is not
//! queried: both sessions hang if somebody declares something at that moment
//! (eclipse-zenoh/zenoh#2619).

#![forbid(unsafe_code)]

mod access;
mod alone;
mod certificates;
mod peers;
mod role;
mod settings;
mod words;

use genom_middleware::Obstacle;
use zenoh::key_expr::OwnedKeyExpr;
use zenoh::{Config, Session};

pub use role::Role;
pub use words::{mistake, plain};

/// An open session.
#[derive(Debug)]
pub struct Examined<'a> {
    /// The session.
    pub session: &'a Session,
    /// What it was opened with, without endpoints of others that need not be there.
    pub config: &'a Config,
    /// Whether it finds others in a way that is not in the configuration.
    pub meets: bool,
    /// The keys that it uses.
    pub keys: &'a [(OwnedKeyExpr, Role)],
}

/// What keeps a session from others. May take some seconds, if an endpoint does not answer.
#[must_use]
pub fn examine(of: &Examined<'_>) -> Vec<Obstacle> {
    let mut found = alone::alone(of.config, of.meets);
    found.extend(certificates::unusable(of.config));
    found.extend(access::denied(of.config, of.keys));
    found.extend(peers::unreached(of.session, of.config));
    found
}
