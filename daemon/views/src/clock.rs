//! The clock that requests step.

use std::sync::Arc;

use genom_doors::RpcError;
use genom_protocol::{ClockKind, Code};
use genom_runtime::{Clock, VirtualClock};
use genom_supervisor::Supervisor;

/// The virtual clock of a daemon, if it is one that requests step.
///
/// # Errors
/// It is the machine's clock, or follows another one.
pub fn stepped(supervisor: &Supervisor) -> Result<Arc<VirtualClock>, RpcError> {
    let Clock::Virtual(clock) = &supervisor.clock else {
        let message = "this daemon lives by the machine's clock, which nobody steps";
        return Err(RpcError::conflict(Code::MonotonicClock, message)
            .help("start it with `genomd --clock virtual`"));
    };
    if supervisor.settings.clock == ClockKind::Ros {
        let message = "the clock of this daemon follows /clock of ROS 2";
        return Err(RpcError::conflict(Code::ClockFollows, message)
            .help("step the simulator, or start the daemon with `genomd --clock virtual`"));
    }
    Ok(Arc::clone(clock))
}
