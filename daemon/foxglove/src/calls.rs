//! Calls of services.
//!
//! An attribute or a function replies with its outputs, an activity with its number once it is
//! accepted: `/genom/activities` has its end. An exception is a failure of the call.

use std::sync::Arc;

use foxglove::ws_protocol::client::ServiceCallRequest;
use genom_protocol::{CallReply, Outcome, routes};
use serde_json::json;

use crate::client::{CALLS, Client};
use crate::hub::Hub;
use crate::inside::{Asker, Inside, Refused};
use crate::reply;

/// Why a call has no outputs.
#[derive(Debug, thiserror::Error)]
enum CallError {
    #[error("there is no service {0}")]
    Unknown(u32),
    #[error("`{0}`: inputs are in `json`")]
    Encoding(String),
    #[error("{CALLS} calls are under way already: wait for one to be answered")]
    Busy,
    #[error(transparent)]
    Refused(#[from] Refused),
}

/// Calls a service, beside what the client sends meanwhile.
pub(crate) fn call(hub: &Arc<Hub>, client: &Arc<Client>, asked: &ServiceCallRequest<'_>) {
    let (service_id, call_id) = (asked.service_id, asked.call_id);
    let refuse = |why: CallError| client.outbox.say(reply::answered(service_id, call_id, Err(why)));
    let Some(offered) = hub.service(service_id) else {
        return refuse(CallError::Unknown(service_id));
    };
    if !matches!(asked.encoding.as_ref(), "json" | "") {
        let encoding: String = asked.encoding.chars().take(50).collect();
        return refuse(CallError::Encoding(encoding.escape_default().to_string()));
    }
    let permits =
        (Arc::clone(&client.calls).try_acquire_owned(), Arc::clone(&hub.calls).try_acquire_owned());
    let (Ok(own), Ok(shared)) = permits else {
        return refuse(CallError::Busy);
    };
    let (hub, client) = (Arc::clone(hub), Arc::clone(client));
    let inputs = match asked.payload.as_ref() {
        [] => b"{}".to_vec(),
        inputs => inputs.to_vec(),
    };
    tokio::spawn(async move {
        let (component, service) = (&offered.component, &offered.service.name);
        let answer = ask(&hub.inside, &client.asker(), component, service, inputs).await;
        let answer = answer.map_err(CallError::Refused);
        client.outbox.say(reply::answered(service_id, call_id, answer));
        drop((own, shared));
    });
}

/// Calls a service; its outputs as JSON.
pub(crate) async fn ask(
    inside: &Inside,
    by: &Asker,
    component: &str,
    service: &str,
    inputs: Vec<u8>,
) -> Result<Vec<u8>, Refused> {
    let reply: CallReply = inside.ask(by, &routes::call(component, service), inputs).await?;
    if let Some(activity) = reply.activity() {
        return Ok(json!({ "activity": activity }).to_string().into_bytes());
    }
    match reply {
        CallReply::Ended(Outcome { exception: Some(name), detail, .. }) => {
            let detail = detail.filter(|detail| !detail.is_null());
            let detail = detail.map_or_else(String::new, |detail| format!(" {detail}"));
            Err(Refused(format!("{name}{detail}")))
        }
        CallReply::Ended(Outcome { result, .. }) => {
            Ok(result.unwrap_or_else(|| json!({})).to_string().into_bytes())
        }
        CallReply::Activity(_) | CallReply::Started(_) => Ok(b"{}".to_vec()),
    }
}
