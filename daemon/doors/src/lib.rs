//! Doors before an HTTP service: who comes in, with which rights, and how much of it he may take.
//!
//! It takes any [`axum::Router`] with a table of the [`Rights`] that its routes ask for, puts a
//! [`Door`] before it ([`guard`]), and serves it ([`serve`]). It knows no handler.
//!
//! | Door | What proves who comes | What it has a right to |
//! |---|---|---|
//! | [`Door::own`]: a Unix socket ([`Socket`]) | the system: mode 0600 in a directory that others cannot change | everything |
//! | [`Door::guarded`]: TCP, beyond loopback by TLS ([`Listener::tcp`]) | a token ([`Tokens`]), or a client certificate that TLS has checked | what the token file says, what is said of certificates |
//! | [`Door::proved`]: messages that others pass on ([`Desk`]) | a proof to hold a token, which is never sent; each message is sealed | what the token file says |
//!
//! Limits, whoever it is:
//!
//! * Connections at each listener, and requests under way of one holder ([`Most`]). When all
//!   places are taken, the oldest connection on which no token was shown for 1 s makes room.
//! * 10 s for a TLS handshake, for the head of a request, and for its body; its size ([`guard`]).
//! * 10 s without a byte taken end a connection, as they end a stream of events ([`Streams`]), of
//!   which each holder has a limited number.
//! * 10 s between two log lines of one kind, with a count of what was left out.
//!
//! A route without a row in the table is for administrators. Tokens are compared in constant time,
//! and are in no log line and no message. What a process does with the descriptors that are opened
//! here is its own affair ([`Keep`]).
//!
//! ```
//! use axum::{Router, routing::get};
//! use genom_doors::{Door, Entrance, Most, Rights, Socket, guard, serve};
//! use genom_protocol::{Right, routes::Method};
//! use tokio_util::sync::CancellationToken;
//!
//! # #[tokio::main(flavor = "current_thread")]
//! # async fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = std::env::temp_dir().join(format!("doors-{}", std::process::id()));
//! # let path = folder.join("robot.sock");
//! let router = Router::new().route("/speed", get(async || "1.5"));
//! let rights = Rights::of([(Method::Get, "/speed", Some(Right::Read))]);
//! let (listener, name) = Socket::open(&path, Ok)?.split();
//! let entrance = Entrance { listener, router: guard(router, rights, Door::own(), 1 << 20) };
//! let closed = CancellationToken::new();
//! let serving = tokio::spawn(serve(vec![entrance], Most::default(), closed.clone()));
//! drop(name); // The socket's name goes first: who waits for the end finds nothing left.
//! closed.cancel();
//! serving.await?;
//! # std::fs::remove_dir_all(folder)?;
//! # Ok(())
//! # }
//! ```
//!
//! `examples/two_routes.rs` has the same on TCP, behind a token.

#![forbid(unsafe_code)]

mod access;
mod error;
mod guard;
mod guests;
mod holder;
mod input;
mod listen;
mod private;
mod relay;
mod rights;
mod seldom;
mod serve;
mod slots;
mod stall;
mod streams;
mod tls;
mod tokens;

pub use access::{Door, Log};
pub use error::RpcError;
pub use guard::guard;
pub use holder::Holder;
pub use input::{Body, Parameters, wait};
pub use listen::{Keep, ListenError, Listener, Socket, SocketName};
pub use private::NotPrivate;
pub use relay::Desk;
pub use rights::Rights;
pub use serve::{Entrance, Most, serve};
pub use slots::{Full, Share, Slot, Slots};
pub use streams::{Events, Streams, Writer, last_heard};
pub use tls::{Certificates, TlsError, acceptor};
pub use tokens::{TokenError, Tokens};
