//! The one shape of errors: `{"error": {"code", "message", "where", "help"}}`.

use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use genom_runtime::HeldUp;
use serde::Serialize;
use utoipa::ToSchema;

use crate::nearest::suggest;

/// Why a request was refused. Nothing was changed.
#[derive(Clone, Debug)]
pub(crate) struct RpcError {
    status: StatusCode,
    reason: Reason,
}

/// The body of every refusal.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct Refusal {
    error: Reason,
}

/// Why a request was refused.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(crate) struct Reason {
    /// Stable name of the reason.
    code: &'static str,
    /// One sentence.
    message: String,
    /// Place in the request: a JSON pointer into the body, or a parameter.
    #[serde(rename = "where", skip_serializing_if = "Option::is_none")]
    place: Option<String>,
    /// The way out.
    #[serde(skip_serializing_if = "Option::is_none")]
    help: Option<String>,
}

impl RpcError {
    pub(crate) fn new(status: StatusCode, code: &'static str, message: impl Into<String>) -> Self {
        let reason = Reason { code, message: message.into(), place: None, help: None };
        Self { status, reason }
    }

    /// 404 for a name among others; suggests the nearest.
    pub(crate) fn unknown<'a>(
        code: &'static str,
        what: impl std::fmt::Display,
        typed: &str,
        candidates: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        Self::new(StatusCode::NOT_FOUND, code, format!("{what} `{typed}`"))
            .help(suggest(typed, candidates))
    }

    /// 422 for an input of the wrong shape.
    pub(crate) fn bad_input(message: impl Into<String>) -> Self {
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, "bad_input", message)
    }

    /// 409 for what cannot be done now.
    pub(crate) fn conflict(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(StatusCode::CONFLICT, code, message)
    }

    /// 503: a codel of a component does not return, so that what was asked cannot be done.
    pub(crate) fn held_up(error: &HeldUp) -> Self {
        let name = &error.instance;
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "held_up", error.to_string()).help(format!(
            "nothing was done; when it returns, ask again; `genomctl unload {name}` stops the rest \
             of the component and frees its name"
        ))
    }

    /// 413: more than the daemon is ready to read.
    pub(crate) fn too_large() -> Self {
        let message = "the request's body is too large";
        Self::new(StatusCode::PAYLOAD_TOO_LARGE, "too_large", message)
            .help("rpc.max_body of the daemon's configuration is the limit")
    }

    /// 500: the daemon itself failed.
    pub(crate) fn internal(message: impl Into<String>) -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, "internal", message)
    }

    /// The HTTP status.
    pub(crate) fn status(&self) -> StatusCode {
        self.status
    }

    /// The sentence.
    pub(crate) fn message(&self) -> &str {
        &self.reason.message
    }

    /// A place in a value of the body, as `goal.x[2]`.
    pub(crate) fn inside(self, path: &str) -> Self {
        let steps = path.split(['.', '[', ']']).filter(|step| !step.is_empty());
        let pointer: String = steps.flat_map(|step| ["/", step]).collect();
        self.place(pointer)
    }

    pub(crate) fn place(mut self, place: impl Into<String>) -> Self {
        self.reason.place = Some(place.into());
        self
    }

    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        self.reason.help = Some(help.into());
        self
    }
}

impl IntoResponse for RpcError {
    fn into_response(self) -> Response {
        (self.status, Json(Refusal { error: self.reason })).into_response()
    }
}
