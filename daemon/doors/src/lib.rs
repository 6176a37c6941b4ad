//! Access control and limits in front of an HTTP service: who may connect, with which rights, and
//! how many resources each client may take.
//!
//! The crate takes any [`axum::Router`] with a table of the [`Rights`] that its routes require,
//! puts a [`Door`] before it ([`guard`]), and serves it ([`serve`]). It contains no handlers.
//!
//! | Door | How senders are authenticated | Their rights |
//! |---|---|---|
//! | [`Door::own`]: a Unix socket ([`Socket`]) | by the system: mode 0600 in a directory that others cannot change | all |
//! | [`Door::guarded`]: TCP, with TLS beyond loopback ([`Listener::tcp`]) | by a token ([`Tokens`]), or a client certificate that TLS has checked | those in the token file, or those of certificates |
//! | [`Door::proved`]: relayed messages ([`Desk`]) | by a proof that they hold a token, which is never sent; each message is sealed | those in the token file |
//!
//! Limits for all clients:
//!
//! * Connections of each listener, and requests under way of one holder ([`Most`]). When all
//!   connections are in use, the oldest one that has not shown a token for 1 s is closed.
//! * 10 s for a TLS handshake, for the head of a request, and for its body; the size of the body
//!   ([`guard`]).
//! * A peer that takes no byte for 10 s loses its connection or stream of events ([`Streams`]);
//!   the number of streams per holder is limited.
//! * 10 s between two log lines of one kind, with the number of those left out.
//!
//! A route without a row in the table requires `admin`. Tokens are compared in constant time, and
//! never appear in the log or in messages. A process can protect the descriptors that are opened
//! here ([`Keep`]).
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
//! drop(name); // Removed first: clients that wait for the end find no socket.
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
mod names;
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
mod within;

pub use access::{Door, Log, Peer};
pub use error::RpcError;
pub use guard::{Bodies, guard};
pub use holder::Holder;
pub use input::{Body, Parameters, wait};
pub use listen::{Keep, ListenError, Listener, Socket, SocketName};
pub use names::{one_header, own_name};
pub use private::NotPrivate;
pub use relay::Desk;
pub use rights::Rights;
pub use seldom::Seldom;
pub use serve::{Entrance, Most, serve};
pub use slots::{Full, Share, Slot, Slots};
pub use streams::{Events, Streams, Writer, last_heard};
pub use tls::{Certificates, TlsError, acceptor};
pub use tokens::{Mark, TokenError, Tokens};
pub use within::{Own, answers, ask_within};
