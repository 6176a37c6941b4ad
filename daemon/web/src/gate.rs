//! Every request to the console passes here: whether its own pages made it, and in which session.

use axum::Extension;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};
use genom_doors::{Holder, RpcError};
use genom_protocol::Code;

use crate::console::Console;
use crate::inside::Inside;
use crate::secret::Secret;
use crate::site::Purpose;

/// What a page may do: use files of this console and ask this console, nothing else. Scripts cannot
/// write markup (trusted types), so that no value can become any.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; \
    connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; \
    require-trusted-types-for 'script'; trusted-types 'none'";

const HEADERS: [(header::HeaderName, &str); 6] = [
    (header::CONTENT_SECURITY_POLICY, POLICY),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::X_FRAME_OPTIONS, "DENY"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    (header::HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
];

/// Refuses requests of other pages, and gives every reply the headers that protect pages.
pub(crate) async fn check(
    State(console): State<Console>,
    request: Request,
    next: Next,
) -> Response {
    let path = request.uri().path();
    let data = ["/api/", "/session", "/live"].iter().any(|data| path.starts_with(data));
    let purpose = if data { Purpose::Data } else { Purpose::Page };
    // A whole address in the request line would count instead of `Host`.
    let whole = request.uri().authority().is_some();
    let admitted = console.site().admit(purpose, request.method(), request.headers());
    let mut response = match admitted {
        Ok(()) if !whole => next.run(request).await,
        Ok(()) => refused(&console, &request, "the request line has a whole address"),
        Err(foreign) => refused(&console, &request, &foreign.to_string()),
    };
    let headers = response.headers_mut();
    for (name, value) in HEADERS {
        headers.insert(name, HeaderValue::from_static(value));
    }
    if data {
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    }
    response
}

fn refused(console: &Console, request: &Request, why: &str) -> Response {
    console.refuse(request, why);
    RpcError::new(StatusCode::FORBIDDEN, Code::Origin, why)
        .help("open the console by an IP address, localhost or a name of web.hosts")
        .into_response()
}

/// Lets requests of sessions pass, with the session's holder as an extension.
pub(crate) async fn enter(
    State(console): State<Console>,
    mut request: Request,
    next: Next,
) -> Response {
    let Some((secret, holder)) = session(&console, request.headers()) else {
        console.refuse(&request, "nobody is signed in");
        let refused =
            RpcError::new(StatusCode::UNAUTHORIZED, Code::Unauthorized, "nobody is signed in here")
                .help("`genomctl web` prints a link that signs in");
        return refused.into_response();
    };
    request.extensions_mut().insert(secret);
    request.extensions_mut().insert(holder);
    next.run(request).await
}

/// The session of a request. A server on another port of the same machine may have set cookies of
/// the same name, so that each is tried.
pub(crate) fn session(console: &Console, headers: &HeaderMap) -> Option<(Secret, Holder)> {
    let all = headers.get_all(header::COOKIE).iter().filter_map(|all| all.to_str().ok());
    let pairs = all.flat_map(|all| all.split(';')).filter_map(|one| one.trim().split_once('='));
    let ours = pairs.filter(|(name, _)| *name == console.cookie()).take(4);
    ours.map(|(_, value)| Secret(value.to_owned()))
        .find_map(|secret| console.holder(&secret).map(|holder| (secret, holder)))
}

/// Passes a request on to the control plane.
pub(crate) async fn pass(Extension(inside): Extension<Inside>, request: Request) -> Response {
    let whole = request.uri().path_and_query().map_or("/", |path| path.as_str());
    match whole.strip_prefix("/api").filter(|path| path.starts_with('/')).map(str::to_owned) {
        Some(path) => inside.pass(request, &path).await,
        None => {
            let message = format!("no page `{}`", request.uri().path());
            RpcError::new(StatusCode::NOT_FOUND, Code::NoSuchPath, message).into_response()
        }
    }
}
