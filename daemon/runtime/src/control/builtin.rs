//! The standard services (genom3.md 4.8).

use genom_types::Record;
use serde_json::Value;

use super::genom;
use crate::api::{ConnectionError, Exception};
use crate::engine::Engine;
use crate::plan::Builtin;

impl Engine {
    pub(crate) fn builtin(&self, builtin: Builtin, input: &Record) -> Result<(), Exception> {
        let given = input.to_json();
        let text = |name: &str| given.get(name).and_then(Value::as_str).unwrap_or_default();
        let connected = |result: Result<(), ConnectionError>| {
            result.map_err(|error| {
                tracing::warn!(instance = self.name, "{error}");
                Exception { name: error.exception().to_owned(), detail: Value::Null }
            })
        };
        match builtin {
            Builtin::AbortActivity => {
                let id = given.get("activity").and_then(Value::as_u64).unwrap_or_default();
                let id = u32::try_from(id).unwrap_or_default();
                self.abort(id, "abort_activity").map_err(|_| genom("no_such_activity", Value::Null))
            }
            Builtin::ConnectPort => {
                connected(self.supervision.connect_port(text("local"), text("remote")))
            }
            Builtin::ConnectService => {
                connected(self.supervision.connect_service(text("local"), text("remote")))
            }
            Builtin::Kill => {
                self.supervision.kill();
                Ok(())
            }
        }
    }
}
