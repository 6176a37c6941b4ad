//! The web console: pages for browsers that show a daemon and command it.
//!
//! It has no control plane of its own. Pages ask the daemon's, below `/api`, with a session as their
//! credential; rights, limits, the log and errors are those of [`genom_doors`]. What is here:
//!
//! * Signing in: a link with a one-time token, which `genomctl web` asks for on the control plane
//!   ([`make_link`]), or a token of the token file. Both give a session cookie.
//! * Every request is checked for its `Host`, `Origin` and session before anything else.
//! * One live stream a page.
//! * The pages themselves: plain modules in `assets`.
//!
//! `docs/web.md` explains how to use it, and what keeps strangers out.

#![forbid(unsafe_code)]

mod assets;
mod blocks;
mod console;
mod entrance;
mod gate;
mod inside;
mod link;
mod links;
mod live;
mod secret;
mod sessions;
mod shelf;
mod sign_in;
mod site;
mod visitor;

pub use console::{Console, OpenError};
#[doc(hidden)]
pub use link::__path_make_link;
pub use link::make_link;
