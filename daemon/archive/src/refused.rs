//! Work on files, on a thread for that, and what is refused of it.

use std::sync::Arc;

use axum::http::StatusCode;
use genom_cells::{Kept, KeptError};
use genom_doors::RpcError;
use genom_protocol::Code;

/// Does what reads and writes files.
///
/// # Errors
/// The work fails.
pub async fn at_work<T: Send + 'static>(
    kept: &Arc<Kept>,
    work: impl FnOnce(&Kept) -> Result<T, KeptError> + Send + 'static,
) -> Result<T, RpcError> {
    let kept = Arc::clone(kept);
    let done = tokio::task::spawn_blocking(move || work(&kept)).await;
    done.map_err(|error| RpcError::internal(error.to_string()))?.map_err(refused)
}

/// An error as the client gets it. What somebody may try often without a reason is logged.
#[must_use]
pub fn refused(error: KeptError) -> RpcError {
    let told = error.to_string();
    match error {
        KeptError::Unknown(file, names) => {
            let names = names.iter().map(String::as_str);
            RpcError::unknown(Code::NoSuchRecording, "no recording", &file, names)
        }
        KeptError::Name(_) => {
            tracing::warn!("recordings: refused: {told}");
            RpcError::bad_input(told).place("/name")
        }
        KeptError::Taken(_) => RpcError::conflict(Code::NameTaken, told).place("/name"),
        KeptError::Full(_) => {
            tracing::warn!("recordings: refused: {told}");
            RpcError::conflict(Code::RecordingsFull, told)
        }
        KeptError::TooMany(_) => {
            tracing::warn!("recordings: refused: {told}");
            RpcError::new(StatusCode::SERVICE_UNAVAILABLE, Code::TooManyRecordings, told)
        }
        KeptError::UnderWay(..) => RpcError::conflict(Code::UnderWay, told),
        KeptError::Nothing { .. } => RpcError::conflict(Code::NoSuchInport, told),
        KeptError::Read(..) => RpcError::conflict(Code::Unreadable, told),
        KeptError::Shelf(_) | KeptError::Io { .. } => RpcError::internal(told),
    }
}
