//! Middlewares: what they can do, and what is visible on them.

use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use serde::Deserialize;
use serde_json::{Map, Value, json};

use crate::daemon::Daemon;
use crate::registry;
use crate::rpc::error::RpcError;
use crate::rpc::input::Parameters;

/// `?visible=true`
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ListParameters {
    /// Also list what is visible on the open ones.
    #[serde(default)]
    visible: bool,
}

/// `GET /middlewares`
pub(crate) async fn list(
    State(daemon): State<Arc<Daemon>>,
    Parameters(parameters): Parameters<ListParameters>,
) -> Result<Json<Value>, RpcError> {
    let visible = parameters.visible;
    // Discovery may have to ask other processes.
    tokio::task::spawn_blocking(move || Json(described(&daemon, visible)))
        .await
        .map_err(|error| RpcError::internal(error.to_string()))
}

fn described(daemon: &Daemon, visible: bool) -> Value {
    let mut middlewares = Vec::new();
    for known in registry::known() {
        let mut out = Map::new();
        out.insert("name".into(), known.name.into());
        out.insert("version".into(), known.version.into());
        if let Some(open) = daemon.backends.opened(known.name) {
            out.insert("capabilities".into(), json!(open.capabilities()));
            let meet: Map<_, _> = open
                .meeting_point()
                .into_iter()
                .map(|(key, value)| (key.to_owned(), value.into()))
                .collect();
            if !meet.is_empty() {
                out.insert("meet".into(), meet.into());
            }
            if visible {
                match open.discover() {
                    Ok(endpoints) => out.insert("endpoints".into(), json!(endpoints)),
                    Err(error) => out.insert("problem".into(), error.to_string().into()),
                };
            }
        }
        middlewares.push(Value::Object(out));
    }
    json!({ "default": daemon.settings.backend, "middlewares": middlewares })
}
