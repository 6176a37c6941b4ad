//! The route of the control plane that makes links.

use std::time::Instant;

use axum::http::Extensions;
use axum::{Extension, Json};
use genom_doors::{Body, Holder, RpcError};
use genom_protocol::{Code, Link, LinkRequest};

use crate::console::Console;
use crate::secret::Secret;
use crate::visitor::Visitor;

/// Make a link that opens the web console, once.
///
/// Whoever opens it has the rights of the client that asks for it, or fewer.
#[utoipa::path(
    post,
    path = "/web/links",
    tag = "daemon",
    request_body = LinkRequest,
    responses((status = 200, body = Link), (status = 409), (status = 422))
)]
pub async fn make_link(
    extensions: Extensions,
    Extension(holder): Extension<Holder>,
    Body(request): Body<LinkRequest>,
) -> Result<Json<Link>, RpcError> {
    let Some(Some(console)) = extensions.get::<Option<Console>>() else {
        return Err(RpcError::conflict(Code::NoConsole, "this daemon has no web console")
            .help("start it with `genomd --web`"));
    };
    for right in request.rights.iter().flatten() {
        holder.may(*right, format_args!("a link with the right `{right}`"))?;
    }
    // A session's link is one of whom the session is of.
    let visitor = match extensions.get::<Secret>() {
        Some(secret) => console.visitor(secret, request.rights),
        None => Some(Visitor::of(&holder, request.rights, console.tokens())),
    };
    let visitor = visitor.ok_or_else(|| RpcError::internal("the session is over already"))?;
    let made = console.links().make(visitor, Instant::now());
    let secret = made.map_err(|error| RpcError::internal(error.to_string()))?;
    let seconds = console.links().lifetime().as_secs_f64();
    // Browsers do not send what comes after `#`: it is in no log, and nothing that only fetches
    // the address uses the link up.
    Ok(Json(Link { url: format!("{}/sign-in#{secret}", console.url()), seconds }))
}
