//! The one shape of errors: `{"error": {"code", "message", "where", "help"}}`.

use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde_json::{Map, Value, json};

use crate::nearest::suggest;

/// Why a request was refused. Nothing was changed.
#[derive(Clone, Debug)]
pub(crate) struct RpcError {
    status: StatusCode,
    code: &'static str,
    message: String,
    /// Place in the request: a JSON pointer into the body, or a parameter.
    place: Option<String>,
    help: Option<String>,
}

impl RpcError {
    pub(crate) fn new(status: StatusCode, code: &'static str, message: impl Into<String>) -> Self {
        Self { status, code, message: message.into(), place: None, help: None }
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

    pub(crate) fn place(mut self, place: impl Into<String>) -> Self {
        self.place = Some(place.into());
        self
    }

    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

impl IntoResponse for RpcError {
    fn into_response(self) -> Response {
        let mut error = Map::new();
        error.insert("code".into(), self.code.into());
        error.insert("message".into(), self.message.into());
        error.extend(self.place.map(|place| ("where".to_owned(), Value::from(place))));
        error.extend(self.help.map(|help| ("help".to_owned(), Value::from(help))));
        (self.status, Json(json!({ "error": error }))).into_response()
    }
}
