//! Lets a client and a daemon that reach each other through third parties prove to each other that
//! they hold the same token. The token is never transmitted, and those who pass the messages on can
//! neither make a request nor an answer themselves.
//!
//! `docs/security.md` explains the design and specifies every byte. This crate holds what both
//! sides need; it opens no socket and reads no clock and no file.
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
