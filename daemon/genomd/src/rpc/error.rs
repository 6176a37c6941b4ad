//! The one shape of errors: `{"error": {"code", "message", "where", "help"}}`.

use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use genom_nearest::suggest;
use genom_protocol::{Code, Reason, Refusal};
use genom_runtime::HeldUp;

/// Why a request was refused. Nothing was changed.
#[derive(Clone, Debug)]
pub(crate) struct RpcError {
    status: StatusCode,
    reason: Reason,
}

impl RpcError {
    pub(crate) fn new(status: StatusCode, code: Code, message: impl Into<String>) -> Self {
        Self { status, reason: Reason::new(code, message) }
    }

    /// 404 for a name among others; suggests the nearest.
    pub(crate) fn unknown<'a>(
        code: Code,
        what: impl std::fmt::Display,
        typed: &str,
        candidates: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        Self::new(StatusCode::NOT_FOUND, code, format!("{what} `{typed}`"))
            .help(suggest(typed, candidates))
    }

    /// 422 for an input of the wrong shape.
    pub(crate) fn bad_input(message: impl Into<String>) -> Self {
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, Code::BadInput, message)
    }

    /// 409 for what cannot be done now.
    pub(crate) fn conflict(code: Code, message: impl Into<String>) -> Self {
        Self::new(StatusCode::CONFLICT, code, message)
    }

    /// 503: a codel of a component does not return, so that what was asked cannot be done.
    pub(crate) fn held_up(error: &HeldUp) -> Self {
        let name = &error.instance;
        Self::new(StatusCode::SERVICE_UNAVAILABLE, Code::HeldUp, error.to_string()).help(format!(
            "nothing was done; when it returns, ask again; `genomctl unload {name}` stops the rest \
             of the component and frees its name"
        ))
    }

    /// 413: more than the daemon is ready to read.
    pub(crate) fn too_large() -> Self {
        let message = "the request's body is too large";
        Self::new(StatusCode::PAYLOAD_TOO_LARGE, Code::TooLarge, message)
            .help("rpc.max_body of the daemon's configuration is the limit")
    }

    /// 500: the daemon itself failed.
    pub(crate) fn internal(message: impl Into<String>) -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, Code::Internal, message)
    }

    /// Status of the response.
    pub(crate) fn status(&self) -> StatusCode {
        self.status
    }

    /// What happened, in one sentence.
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
