//! The form of all errors: `{"error": {"code", "message", "where", "help"}}`.

use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use genom_nearest::suggest;
use genom_protocol::{Code, Reason, Refusal};

/// Why a request was refused. The request changed nothing.
#[derive(Clone, Debug)]
pub struct RpcError {
    status: StatusCode,
    reason: Reason,
}

impl RpcError {
    /// A refusal without place and help.
    pub fn new(status: StatusCode, code: Code, message: impl Into<String>) -> Self {
        Self { status, reason: Reason::new(code, message) }
    }

    /// 404 for an unknown name; suggests the nearest known one.
    pub fn unknown<'a>(
        code: Code,
        what: impl std::fmt::Display,
        typed: &str,
        candidates: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        Self::new(StatusCode::NOT_FOUND, code, format!("{what} `{typed}`"))
            .help(suggest(typed, candidates))
    }

    /// 422 for an input of the wrong form.
    pub fn bad_input(message: impl Into<String>) -> Self {
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, Code::BadInput, message)
    }

    /// 409 for something that is not possible now.
    pub fn conflict(code: Code, message: impl Into<String>) -> Self {
        Self::new(StatusCode::CONFLICT, code, message)
    }

    /// 413: the body is larger than the limit.
    pub fn too_large() -> Self {
        let message = "the request's body is too large";
        Self::new(StatusCode::PAYLOAD_TOO_LARGE, Code::TooLarge, message)
            .help("rpc.max_body of the daemon's configuration is the limit")
    }

    /// 500: an error of the service itself.
    pub fn internal(message: impl Into<String>) -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, Code::Internal, message)
    }

    /// What another process of this daemon refused.
    pub fn passed_on(status: StatusCode, reason: Reason) -> Self {
        Self { status, reason }
    }

    /// The body of the response.
    pub fn refusal(self) -> Refusal {
        Refusal { error: self.reason }
    }

    /// Status of the response.
    pub fn status(&self) -> StatusCode {
        self.status
    }

    /// The message, as one sentence.
    pub fn message(&self) -> &str {
        &self.reason.message
    }

    /// Sets the place to one in a value of the body, such as `goal.x[2]`.
    #[must_use]
    pub fn inside(self, path: &str) -> Self {
        let steps = path.split(['.', '[', ']']).filter(|step| !step.is_empty());
        let pointer: String = steps.flat_map(|step| ["/", step]).collect();
        self.place(pointer)
    }

    /// Where in the request: a JSON pointer into the body, or a parameter.
    #[must_use]
    pub fn place(mut self, place: impl Into<String>) -> Self {
        self.reason.place = Some(place.into());
        self
    }

    /// What the user can do, as one sentence.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.reason.help = Some(help.into());
        self
    }
}

impl IntoResponse for RpcError {
    fn into_response(self) -> Response {
        (self.status, Json(self.refusal())).into_response()
    }
}
