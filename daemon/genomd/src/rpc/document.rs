//! The OpenAPI document of the control plane, and a page to browse it.
//!
//! Paths, parameters and bodies come from the handlers and their types. Only what applies to all of
//! them is added here.

use axum::Extension;
use axum::body::Bytes;
use axum::http::{StatusCode, header};
use axum::response::{Html, IntoResponse};
use genom_protocol::Right;
use genom_protocol::routes::{self, Listed};
use utoipa::openapi::path::Operation;
use utoipa::openapi::security::{Http, HttpAuthScheme, SecurityRequirement, SecurityScheme};
use utoipa::openapi::{ContentBuilder, OpenApi, Ref, RefOr, ResponseBuilder, Tag};

/// Statuses that every operation may answer, from checks before the handlers.
const EVERYWHERE: [StatusCode; 5] = [
    StatusCode::BAD_REQUEST,
    StatusCode::UNAUTHORIZED,
    StatusCode::FORBIDDEN,
    StatusCode::REQUEST_TIMEOUT,
    StatusCode::PAYLOAD_TOO_LARGE,
];

const ABOUT: &str = "Control plane of genomd: components, services, activities, ports, wiring.\n\n\
    Statuses: 2xx, the daemon did it; how a service ended is in the body, `result` or `exception`, \
    since an exception is an answer of the component. 4xx and 5xx: refused, nothing ran, \
    `error` says why. Each operation names the right that a token needs for it; on the Unix \
    socket none is needed.";

/// The document as JSON, generated once.
#[derive(Clone, Debug)]
pub(crate) struct Document(Bytes);

impl Document {
    pub(super) fn new(document: &OpenApi) -> Self {
        Self(document.to_json().unwrap_or_default().into())
    }
}

/// Get this document.
#[utoipa::path(
    get,
    path = "/openapi.json",
    tag = "daemon",
    responses((status = 200, body = Object))
)]
pub(crate) async fn json(Extension(Document(text)): Extension<Document>) -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "application/json")], text)
}

/// A page to browse this document and try requests.
#[utoipa::path(
    get,
    path = "/docs",
    tag = "daemon",
    responses((status = 200, content_type = "text/html", body = String))
)]
pub(crate) async fn page() -> Html<&'static str> {
    Html(include_str!("docs.html"))
}

/// The document before operations are added: schemas of all types, including those of streams and
/// recordings, to which no operation refers.
pub(super) fn begun() -> OpenApi {
    <genom_protocol::openapi::Protocol as utoipa::OpenApi>::openapi()
}

/// Adds what applies to all operations.
pub(super) fn complete(document: &mut OpenApi) {
    document.info.title = "genomd".to_owned();
    document.info.version = env!("CARGO_PKG_VERSION").to_owned();
    document.info.description = Some(ABOUT.to_owned());
    let components = document.components.get_or_insert_default();
    let token = SecurityScheme::Http(Http::new(HttpAuthScheme::Bearer));
    components.add_security_scheme("token", token);
    let (mut tags, table) = (Vec::new(), routes::all());
    for (path, item) in &mut document.paths.paths {
        let all = [
            ("get", &mut item.get),
            ("put", &mut item.put),
            ("post", &mut item.post),
            ("delete", &mut item.delete),
        ];
        for (method, operation) in all {
            let Some(operation) = operation else { continue };
            // Operation identifiers consist of method and path, because names of handlers are not
            // unique.
            let words = path.split(|c: char| !c.is_ascii_alphanumeric());
            let words: Vec<_> = words.filter(|word| !word.is_empty()).collect();
            operation.operation_id = Some([&[method][..], &words].concat().join("_"));
            operation.security = Some(vec![asked(&table, method, path)]);
            refusals(operation);
            for tag in operation.tags.iter().flatten() {
                if !tags.contains(tag) {
                    tags.push(tag.clone());
                }
            }
        }
    }
    document.tags = Some(tags.into_iter().map(Tag::new).collect());
}

/// The right that the table requires; a route without a row requires `admin`.
fn asked(table: &[Listed], method: &str, path: &str) -> SecurityRequirement {
    let row = table
        .iter()
        .find(|one| one.template == path && one.method.as_str().eq_ignore_ascii_case(method));
    match row.map_or(Some(Right::Admin), |row| row.right) {
        Some(right) => SecurityRequirement::new("token", [right.to_string()]),
        None => SecurityRequirement::default(),
    }
}

/// Gives all error responses the common schema, and each status a description.
fn refusals(operation: &mut Operation) {
    let responses = &mut operation.responses.responses;
    for status in EVERYWHERE {
        let response = RefOr::T(ResponseBuilder::new().build());
        responses.entry(status.as_str().to_owned()).or_insert(response);
    }
    for (status, response) in responses {
        let RefOr::T(response) = response else { continue };
        let Ok(status) = status.parse::<StatusCode>() else { continue };
        if response.description.is_empty() {
            response.description = status.canonical_reason().unwrap_or_default().to_owned();
        }
        if !status.is_success() && response.content.is_empty() {
            let content = ContentBuilder::new().schema(Some(Ref::from_schema_name("Refusal")));
            response.content.insert("application/json".to_owned(), RefOr::T(content.build()));
        }
    }
}
