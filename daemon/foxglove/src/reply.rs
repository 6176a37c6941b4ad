//! Messages to clients.

use std::fmt::Display;

use foxglove::ws_protocol::server::{ServiceCallFailure, ServiceCallResponse, Status};
use foxglove::ws_protocol::{BinaryMessage as _, JsonMessage};
use tokio_tungstenite::tungstenite::Message;

/// A message of JSON.
pub(crate) fn json(message: &impl JsonMessage) -> Message {
    let mut text = message.to_string();
    // It may wait for long.
    text.shrink_to_fit();
    Message::text(text)
}

/// Something went wrong.
pub(crate) fn error(message: impl Into<String>) -> Message {
    json(&Status::error(message))
}

/// What a service answered.
pub(crate) fn answered(
    service_id: u32,
    call_id: u32,
    answer: Result<Vec<u8>, impl Display>,
) -> Message {
    match answer {
        Ok(payload) => {
            let response = ServiceCallResponse {
                service_id,
                call_id,
                encoding: "json".into(),
                payload: payload.into(),
            };
            Message::Binary(response.to_bytes().into())
        }
        Err(why) => json(&ServiceCallFailure { service_id, call_id, message: why.to_string() }),
    }
}
