//! Stable names of the reasons for refusals, for programs.

use serde::{Deserialize, Serialize};
use strum::{AsRefStr, Display, IntoStaticStr};

/// Why the daemon refused a request.
///
/// Names never change between versions, but later versions may add some. Clients should therefore
/// read [`Reason::code`](crate::Reason) as text.
#[derive(
    Clone, Copy, Debug, AsRefStr, Display, IntoStaticStr, PartialEq, Eq, Deserialize, Serialize,
)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Code {
    /// The inputs or the body do not have the expected form.
    BadInput,
    /// The query does not have the expected form.
    BadQuery,
    /// Too many sessions are open.
    Busy,
    /// The process of the component's cell has ended, or is being started.
    CellDown,
    /// A sealed message was changed on its way.
    Changed,
    /// The clock follows another one, and is not stepped by requests.
    ClockFollows,
    /// The in port is already connected to something else.
    Connected,
    /// The other daemon did not answer in time.
    DaemonSilent,
    /// A service of the component does not allow this one now.
    Disallowed,
    /// The activity has already ended.
    Ended,
    /// A codel does not return, so that nothing could be done.
    HeldUp,
    /// An error of the daemon itself.
    Internal,
    /// The link to the web console was used already, or is too old.
    LinkOver,
    /// The component did not stop in time: its name is free again, but its threads still run.
    LeftBehind,
    /// The body is not JSON.
    Malformed,
    /// The middleware reported an error.
    MiddlewareFailed,
    /// The daemon uses the machine's clock, which cannot be stepped.
    MonotonicClock,
    /// The instance name is already in use.
    NameTaken,
    /// No middleware of the daemon can relay requests.
    NoRelay,
    /// The black box is off.
    NoBlackBox,
    /// The daemon has no web console.
    NoConsole,
    /// There is no way from what runs to the deployment.
    NoPlan,
    /// There is no activity of that number, or none of that service.
    NoSuchActivity,
    /// No cell of that name.
    NoSuchCell,
    /// There is no component of that name.
    NoSuchComponent,
    /// There is no report of a crash of that name.
    NoSuchCrash,
    /// There is no daemon of that name.
    NoSuchDaemon,
    /// There is no event of that name.
    NoSuchEvent,
    /// There is no in port of that address.
    NoSuchInport,
    /// There is no library of that name.
    NoSuchLibrary,
    /// The path does not support the method.
    NoSuchMethod,
    /// There is no out port of that address.
    NoSuchOutport,
    /// There is no such path.
    NoSuchPath,
    /// There is no port of that name.
    NoSuchPort,
    /// There is no recording of that number.
    NoSuchRecording,
    /// There is no remote of that address.
    NoSuchRemote,
    /// There is no service of that name.
    NoSuchService,
    /// A step of the deployment was refused; the steps before it were undone.
    NotApplied,
    /// The port is not connected.
    NotConnected,
    /// The component cannot be loaded.
    NotLoadable,
    /// The daemon is still loading the components of its configuration.
    NotReady,
    /// The version of the client is too old.
    OldClient,
    /// The request comes from a web page of another origin.
    Origin,
    /// The port is an out port; only its component writes it.
    OutPort,
    /// A sealed message arrived a second time.
    Replayed,
    /// The library of the component is just being exchanged.
    Reloading,
    /// The directory of recordings is full.
    RecordingsFull,
    /// The token lacks the required right.
    RightMissing,
    /// The session with the daemon has expired: start a new one.
    SessionOver,
    /// The daemon or the component is stopping.
    Stopping,
    /// Another program already publishes there.
    Taken,
    /// The other side did not appear in time.
    Timeout,
    /// The token file is not valid.
    TokenFile,
    /// The task already runs as many activities as it may.
    TooManyActivities,
    /// Too many recordings or replays are under way.
    TooManyRecordings,
    /// Too many requests to other daemons are under way.
    TooManyQuestions,
    /// Too many requests are under way.
    TooManyRequests,
    /// Too many streams are open.
    TooManyStreams,
    /// The body is larger than the limit.
    TooLarge,
    /// The body did not arrive in time.
    TooSlow,
    /// The two sides have different types.
    TypeMismatch,
    /// No token was given, or an unknown one.
    Unauthorized,
    /// The recording is just being made or replayed, or is not.
    UnderWay,
    /// The component is being unloaded.
    Unloading,
    /// The body could not be read.
    Unreadable,
}

impl Code {
    /// The name, as it appears in refusals.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.into()
    }
}
