//! `std_srvs/srv/Trigger`, served: the only service here whose types hiroz writes and reads itself.

use hiroz::msg::{SerdeCdrSerdes, ZMessage, ZService};
use hiroz::node::ZNode;
use hiroz::{Builder as _, TypeHash, TypeInfo};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use tokio::runtime::Runtime;
use tokio::task::JoinHandle;

use super::{Wrong, text};

/// A structure without members is one byte in ROS.
#[derive(Deserialize, Serialize)]
struct Request {
    nothing: u8,
}

#[derive(Clone, Deserialize, Serialize)]
struct Response {
    success: bool,
    message: String,
}

impl ZMessage for Request {
    type Serdes = SerdeCdrSerdes<Self>;
}

impl ZMessage for Response {
    type Serdes = SerdeCdrSerdes<Self>;
}

struct Trigger;

impl ZService for Trigger {
    type Request = Request;
    type Response = Response;
}

/// Ends when it is dropped.
pub(crate) struct Served(JoinHandle<()>);

impl Drop for Served {
    fn drop(&mut self) {
        self.0.abort();
    }
}

/// Serves it under this name and with this hash, with these responses one after the other; the last
/// one again and again.
pub(crate) fn serve(runtime: &Runtime, node: &ZNode, given: &[Value]) -> Result<Served, Wrong> {
    let (service, ty, hash) = (text(given, 0)?, text(given, 1)?, text(given, 2)?);
    let hash = TypeHash::from_rihs_string(hash).ok_or("this is no hash")?;
    let mut responses: Vec<Response> =
        serde_json::from_value(given.get(3).cloned().unwrap_or_default())?;
    responses.reverse();
    let ty = Some(TypeInfo::new(ty, hash));
    let mut server = node.create_service_impl::<Trigger>(service, ty).build()?;
    Ok(Served(runtime.spawn(async move {
        while let Ok(request) = server.async_take_request().await {
            let next =
                if responses.len() > 1 { responses.pop() } else { responses.first().cloned() };
            let Some(response) = next else { return };
            if request.reply(&response).await.is_err() {
                return;
            }
        }
    })))
}
