//! Two routes behind a token: `GET /speed` asks for the right `read`, `POST /stop` for `call`.
//!
//! ```sh
//! genomctl token panel --rights read --into tokens.toml
//! cargo run -p genom-doors --example two_routes tokens.toml
//! ```

#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, reason = "it is a program")]

use std::error::Error;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use axum::Router;
use axum::routing::{get, post};
use genom_doors::{Door, Entrance, Listener, Most, Rights, Tokens, guard, serve};
use genom_protocol::Right;
use genom_protocol::routes::Method;
use tokio_util::sync::CancellationToken;

#[tokio::main]
async fn main() -> Result<(), Box<dyn Error>> {
    let tokens: PathBuf = std::env::args().nth(1).ok_or("usage: two_routes TOKENS")?.into();
    let (entrance, address) = behind_a_token(&tokens).await?;
    println!("http://{address}");
    serve(vec![entrance], Most::default(), CancellationToken::new()).await;
    Ok(())
}

/// Serves the two routes at a free port of this machine; returns its address.
pub(crate) async fn behind_a_token(
    tokens: &Path,
) -> Result<(Entrance, SocketAddr), Box<dyn Error>> {
    let router =
        Router::new().route("/speed", get(async || "1.5")).route("/stop", post(async || "stopped"));
    let rights = Rights::of([
        (Method::Get, "/speed", Some(Right::Read)),
        (Method::Post, "/stop", Some(Right::Call)),
    ]);
    let door = Door::guarded(Tokens::read(Some(tokens))?, Default::default(), Vec::new());
    let (listener, address) = Listener::tcp("127.0.0.1:0".parse()?, None, Ok).await?;
    Ok((Entrance { listener, router: guard(router, rights, door, 1 << 20) }, address))
}
