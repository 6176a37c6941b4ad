//! Proves who holds a token, to a daemon that is reached through others: the token never leaves
//! its two ends, and whoever passes the messages on can neither ask nor answer in their place.
//!
//! `docs/security.md` has the reasoning and every byte. Here are the parts that both ends need;
//! no socket, no clock, no file.
//!
//! ```text
//! genomctl                     daemons that answer to the name
//!   hello: nonce, hint  ─────►
//!                       ◄─────  at, cookie, proof       (the daemon holds the token, too)
//!   sealed: number, request, MAC ─►                     (so does the client)
//!                       ◄─────  sealed: number, answer, MAC
//! ```

#![forbid(unsafe_code)]

mod client;
mod hex;
mod key;
pub mod message;
mod window;

pub use client::{Doubt, Forged, Greeting, HandshakeError, Session};
pub use hex::Bytes;
pub use key::{HINT, Handshake, Keys, MAC, NONCE, Token, random};
pub use window::Window;
