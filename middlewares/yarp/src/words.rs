//! Words of requests to `/<component>/rpc` and of their answers; `docs/yarp.md` explains them.

/// Runs a service as `start`, `wait` and `cancel` do, for callers that follow activities.
pub(crate) const START: &str = "@start";
pub(crate) const WAIT: &str = "@wait";
pub(crate) const CANCEL: &str = "@cancel";
/// Lists the services, also without the `@`.
pub(crate) const HELP: &str = "@help";

/// An activity was accepted, under this number.
pub(crate) const ACCEPTED: &str = "accepted";
/// An activity has entered this state.
pub(crate) const STATE: &str = "state";
/// Success; outputs follow.
pub(crate) const OK: &str = "ok";
/// An exception: its name, and its members as JSON.
pub(crate) const EXCEPTION: &str = "exception";
/// The request was not understood, or could not be served; a sentence follows.
pub(crate) const ERROR: &str = "error";
/// There is no such service.
pub(crate) const NOBODY: &str = "nobody";
/// The service has other types, which follow.
pub(crate) const MISMATCH: &str = "mismatch";
/// The service went away before it answered.
pub(crate) const GONE: &str = "gone";
