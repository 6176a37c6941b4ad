//! Reasons of refusals by their stable names, for programs.

use serde::{Deserialize, Serialize};
use strum::{AsRefStr, Display, IntoStaticStr};

/// Why the daemon refused a request.
///
/// The names do not change between versions; later versions may add some, so that clients read
/// [`Reason::code`](crate::Reason) as text.
#[derive(
    Clone, Copy, Debug, AsRefStr, Display, IntoStaticStr, PartialEq, Eq, Deserialize, Serialize,
)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Code {
    /// The inputs or the body have the wrong shape.
    BadInput,
    /// The query has the wrong shape.
    BadQuery,
    /// Too many sessions are under way.
    Busy,
    /// A sealed message was changed on its way.
    Changed,
    /// The in port reads something else.
    Connected,
    /// The other daemon did not answer.
    DaemonSilent,
    /// A service of the component does not allow this one now.
    Disallowed,
    /// The activity has already ended.
    Ended,
    /// A codel does not return, so that nothing was done.
    HeldUp,
    /// The daemon itself failed.
    Internal,
    /// The component did not stop in time: its name is free, its threads are still there.
    LeftBehind,
    /// The body is no JSON.
    Malformed,
    /// The middleware failed.
    MiddlewareFailed,
    /// The daemon lives by the machine's clock, which is not stepped.
    MonotonicClock,
    /// The instance name is in use.
    NameTaken,
    /// No middleware of the daemon passes requests on.
    NoRelay,
    /// The deployment cannot be reached from what runs.
    NoPlan,
    /// No activity of that number or service.
    NoSuchActivity,
    /// No component of that name.
    NoSuchComponent,
    /// No daemon of that name.
    NoSuchDaemon,
    /// No event of that name.
    NoSuchEvent,
    /// No in port of that address.
    NoSuchInport,
    /// No library of that name.
    NoSuchLibrary,
    /// The path takes no such method.
    NoSuchMethod,
    /// No out port of that address.
    NoSuchOutport,
    /// No such path.
    NoSuchPath,
    /// No port of that name.
    NoSuchPort,
    /// No recording of that number.
    NoSuchRecording,
    /// No remote of that address.
    NoSuchRemote,
    /// No service of that name.
    NoSuchService,
    /// A step of the deployment was refused, and those before it were taken back.
    NotApplied,
    /// The port is not connected.
    NotConnected,
    /// The component cannot be loaded.
    NotLoadable,
    /// The daemon is still loading what it was started with.
    NotReady,
    /// The request was made by a client that is too old.
    OldClient,
    /// The request was made by a page of some web site.
    Origin,
    /// The port is an out port, which its component writes.
    OutPort,
    /// A sealed message came a second time.
    Replayed,
    /// The token has not the right that is needed.
    RightMissing,
    /// The session with the daemon is over: begin anew.
    SessionOver,
    /// The daemon, or the component, stops.
    Stopping,
    /// Another program publishes there.
    Taken,
    /// The other side did not come in time.
    Timeout,
    /// The token file has a mistake.
    TokenFile,
    /// The task runs as many activities as it may.
    TooManyActivities,
    /// Too many requests to other daemons are under way.
    TooManyQuestions,
    /// Too many requests are under way.
    TooManyRequests,
    /// Too many streams are open.
    TooManyStreams,
    /// The body is larger than the daemon reads.
    TooLarge,
    /// The body did not come in time.
    TooSlow,
    /// The two sides have different types.
    TypeMismatch,
    /// No token, or an unknown one.
    Unauthorized,
    /// The component is being unloaded.
    Unloading,
    /// The body could not be read.
    Unreadable,
}

impl Code {
    /// As it stands in a refusal.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.into()
    }
}
