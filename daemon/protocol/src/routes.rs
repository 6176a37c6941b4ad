//! What the control plane does: each path with the right that it requires, the types of its query,
//! body and reply, and the services of components that have the same effect.
//!
//! This is the only table of rights: the daemon's access checks and its `/openapi.json` are made of
//! it, and a service that every component has ([`STANDARD_SERVICES`]) requires the right of its row.
//! Clients make requests from a [`Route`], so that a reply is always read as the type that the path
//! answers. A test in `tests/` compares this list with the daemon's `/openapi.json`.

use std::any::type_name;
use std::fmt;
use std::marker::PhantomData;

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use serde::Serialize;
use serde_json::Value;

use crate::frames::Channels;
use crate::{
    Aborted, About, Activities, Activity, AllAborted, Answers, Applied, AskParameters, BlackBox,
    BlackBoxLeft, CallParameters, CallReply, Cell, CellEnds, Cells, Change, ChangeParameters,
    Cleared, Clock, Component, ComponentReload, Components, Connection, ConnectionRequest,
    Connections, CrashReport, Crashes, Daemons, DeploymentRequest, Description, Disconnected,
    DoctorParameters, Dumped, Examined, Findings, Fired, Frozen, GoesOn, Histograms,
    ImageParameters, Inputs, KeepRequest, KeptRecording, KeptRecordings, KeptReplay, Link,
    LinkRequest, LoadRequest, LogEntry, LogParameters, Logs, LookParameters, MiddlewareParameters,
    Middlewares, MoveRequest, Moved, NeededEnds, PlotColumns, PlotParameters, Port, PortParameters,
    PortTraffic, PortType, Ports, Published, Ready, ReadyParameters, RecordingEnds,
    RecordingRemoved, RecordingRequest, ReloadRequest, Reloaded, ReplayRequest, Replayed, Right,
    Service, Sources, Statistics, StepRequest, Stopping, StreamParameters, TakenBack, ThawRequest,
    Thawed, Timeline, TimelineParameters, Unloaded, ValueParameters, Withheld,
};

/// HTTP method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Reads a resource.
    Get,
    /// Replaces a resource.
    Put,
    /// Creates a resource, or performs an action.
    Post,
    /// Removes a resource, or stops an activity.
    Delete,
}

impl Method {
    /// The method in capitals, as in a request.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Get => "GET",
            Self::Put => "PUT",
            Self::Post => "POST",
            Self::Delete => "DELETE",
        }
    }
}

/// Method and path of a request whose query is of type `Q`, whose body is of type `B`, and whose
/// reply is of type `R`.
pub struct Route<R, Q = (), B = ()> {
    /// HTTP method.
    pub method: Method,
    /// Path and query, percent-encoded.
    pub path: String,
    /// The right that it takes; `None` if the reply is public.
    pub right: Option<Right>,
    types: PhantomData<fn(Q, B) -> R>,
}

impl<R, Q, B> Clone for Route<R, Q, B> {
    fn clone(&self) -> Self {
        let (method, path, right) = (self.method, self.path.clone(), self.right);
        Self { method, path, right, types: PhantomData }
    }
}

impl<R, Q, B> fmt::Debug for Route<R, Q, B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.method.as_str(), self.path)
    }
}

impl<R, Q: Serialize, B> Route<R, Q, B> {
    /// The same route with a query.
    #[must_use]
    pub fn with(mut self, query: &Q) -> Self {
        // No query can fail to serialise: all are flat, and consist of texts and numbers.
        let query = serde_urlencoded::to_string(query).unwrap_or_default();
        if !query.is_empty() {
            self.path = format!("{}?{query}", self.path);
        }
        self
    }
}

/// A stream of server-sent events whose data are of type `T`.
#[derive(Debug)]
pub struct Stream<T>(PhantomData<T>);

/// A body or reply that is not JSON.
#[derive(Debug)]
pub struct Bytes;

/// An entry of the list of routes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listed {
    /// HTTP method.
    pub method: Method,
    /// The path, with names in braces: `/components/{component}`.
    pub template: &'static str,
    /// The right that a token must have; `None` if the reply is public.
    pub right: Option<Right>,
    /// Services of components that have the same effect, and therefore require the same right.
    pub services: &'static [&'static str],
    /// Name of the reply's type.
    pub reply: &'static str,
    /// Name of the body's type, `()` if there is no body.
    pub body: &'static str,
}

/// The last segment of a type's path.
fn name_of<T>() -> &'static str {
    let name = type_name::<T>();
    name.split('<').next().and_then(|name| name.rsplit("::").next()).unwrap_or(name)
}

macro_rules! routes {
    ($($(#[$doc:meta])* $method:ident $name:ident($($part:ident),*)
        [$($right:ident $(: $($service:ident)+)?)?] $template:literal
        $(? $query:ty)? $(=> $body:ty)?, $reply:ty;)*) => {
        $(
            $(#[$doc])*
            #[must_use]
            pub fn $name($($part: &str),*) -> Route<$reply, routes!(@or $($query)?), routes!(@or $($body)?)> {
                let parts: &[(&str, &str)] = &[$((stringify!($part), $part)),*];
                let (method, right) = (Method::$method, routes!(@right $($right)?));
                Route { method, path: filled($template, parts), right, types: PhantomData }
            }
        )*

        /// The services that every component has and that act as a supervisor does, each with the
        /// right that the route of the same effect requires.
        pub const STANDARD_SERVICES: &[(&str, Right)] =
            &[$($($($((stringify!($service), Right::$right),)+)?)?)*];

        /// All routes.
        #[must_use]
        pub fn all() -> Vec<Listed> {
            vec![$(Listed {
                method: Method::$method,
                template: $template,
                right: routes!(@right $($right)?),
                services: &[$($($(stringify!($service)),+)?)?],
                reply: name_of::<$reply>(),
                body: name_of::<routes!(@or $($body)?)>(),
            }),*]
        }
    };
    (@right) => { None };
    (@right $right:ident) => { Some(Right::$right) };
    (@or) => { () };
    (@or $ty:ty) => { $ty };
}

routes! {
    /// Describes the daemon.
    Get about() [Read] "/", About;
    /// Whether the daemon has loaded the components of its configuration.
    Get ready() [Read] "/ready" ?ReadyParameters, Ready;
    /// Stops the daemon.
    Post shutdown() [Admin] "/shutdown", Stopping;
    /// Reads the token file again.
    Post reload_tokens() [Admin] "/tokens/reload", Reloaded;
    /// Lists the running components.
    Get components() [Read] "/components", Components;
    /// Loads a component.
    Post load() [Admin] "/components" => LoadRequest, Component;
    /// Describes a component.
    Get component(component) [Read] "/components/{component}", Description;
    /// Unloads a component.
    Delete unload(component) [Admin: kill] "/components/{component}", Unloaded;
    /// Exchanges the library of a running component.
    Post reload(component) [Admin] "/components/{component}/reload" => ReloadRequest, ComponentReload;
    /// The cells.
    Get cells() [Read] "/cells", Cells;
    /// Ends one with all that is in it.
    Delete end_cell(cell) [Admin] "/cells/{cell}", CellEnds;
    /// Kills its process, as a fault would; its components come back as their policies say. Of a
    /// cell that has failed, starts the process again.
    Post restart_cell(cell) [Admin] "/cells/{cell}/restart", Cell;
    /// Reports of cells whose process ended without being asked to.
    Get crashes() [Read] "/crashes", Crashes;
    /// One of them.
    Get crash(crash) [Read] "/crashes/{crash}", CrashReport;
    /// How the black box is.
    Get blackbox() [Read] "/blackbox", BlackBox;
    /// Has it write a file.
    Post save_blackbox() [Call] "/blackbox", BlackBoxLeft;
    /// What it keeps, in the form of a recording.
    Get blackbox_frames() [Read] "/blackbox/frames", Bytes;
    /// The types of a component as JSON Schemas.
    Get schema(component) [Read] "/components/{component}/schema", Value;
    /// What a component was made of: the texts of its description, and how its tasks are executed.
    Get sources(component) [Read] "/components/{component}/sources", Sources;
    /// Moves a component, or one of its ports, to other middlewares.
    Put move_component(component) [Wire] "/components/{component}/backend" => MoveRequest, Moved;
    /// Opens out ports of a component for readers in other processes, and closes those that these do
    /// not need any more: as a daemon asks its cells.
    Put need_ends(component) [Wire] "/components/{component}/ends" => NeededEnds, NeededEnds;
    /// Statistics of the tasks and codels of a component.
    Get statistics(component) [Read] "/components/{component}/tasks", Statistics;
    /// How often the tasks of a component took how long.
    Get histograms(component) [Read] "/components/{component}/tasks/histograms", Histograms;
    /// Fires an event.
    Post fire(component, event) [Call] "/components/{component}/events/{event}", Fired;
    /// Describes a service.
    Get service(component, service) [Read] "/components/{component}/services/{service}", Service;
    /// Calls a service.
    Post call(component, service) [Call] "/components/{component}/services/{service}"
        ?CallParameters => Inputs, CallReply;
    /// Lists the activities of a component.
    Get activities(component) [Read] "/components/{component}/activities", Activities;
    /// Aborts all activities of a component.
    Delete abort_all(component) [Call] "/components/{component}/activities", AllAborted;
    /// Describes an activity, given by its number or the name of its service.
    Get activity(component, activity) [Read] "/components/{component}/activities/{activity}"
        ?LookParameters, Activity;
    /// Aborts an activity, given by its number, or all of a service, given by its name.
    Delete abort(component, activity) [Call: abort_activity]
        "/components/{component}/activities/{activity}", Aborted;
    /// Aborts all activities of all components.
    Delete stop() [Call] "/activities", AllAborted;
    /// Lists the ports of all components.
    Get ports() [Read] "/ports" ?PortParameters, Ports;
    /// Lists the ports of a component.
    Get ports_of(component) [Read] "/components/{component}/ports" ?PortParameters, Ports;
    /// Describes a port, with its value.
    Get port(component, port) [Read] "/components/{component}/ports/{port}" ?ValueParameters, Port;
    /// Publishes a value to an in port.
    Post publish(component, port) [Call] "/components/{component}/ports/{port}"
        ?ValueParameters => Value, Published;
    /// The type of a port, with its memory layout.
    Get port_type(component, port) [Read] "/components/{component}/ports/{port}/type", PortType;
    /// Streams the values of a port.
    Get values(component, port) [Read] "/components/{component}/ports/{port}/stream"
        ?StreamParameters, Stream<Value>;
    /// The value of a port as an image.
    Get image(component, port) [Read] "/components/{component}/ports/{port}/image"
        ?ImageParameters, Bytes;
    /// Streams every sample of ports of a component, in columns of a plot.
    Get plots(component) [Read] "/components/{component}/plots"
        ?PlotParameters, Stream<PlotColumns>;
    /// Counters of a port.
    Get traffic(component, port) [Read] "/components/{component}/ports/{port}/traffic"
        ?ValueParameters, PortTraffic;
    /// Why no data flows through a port.
    Get why(component, port) [Read] "/components/{component}/ports/{port}/why", Findings;
    /// What keeps components from running well.
    Get doctor() [Read] "/doctor" ?DoctorParameters, Examined;
    /// Lists the connections.
    Get connections() [Read] "/connections", Connections;
    /// Makes a connection.
    Post connect() [Wire: connect_port connect_service connect_remote]
        "/connections" => ConnectionRequest, Connection;
    /// Removes the connection of an in port or a remote.
    Delete disconnect(component, port) [Wire] "/connections/{component}/{port}", Disconnected;
    /// Removes the connection of an element of a multiple in port.
    Delete disconnect_element(component, port, element) [Wire]
        "/connections/{component}/{port}/{element}", Disconnected;
    /// What runs, as a deployment.
    Get dump() [Read] "/deployment", Dumped;
    /// Applies a deployment.
    Post apply() [Admin] "/deployment" => DeploymentRequest, Applied;
    /// Undoes what the last deployment did.
    Post take_back() [Admin] "/deployment/take_back", TakenBack;
    /// Writes the state of the running system into the reply.
    Post freeze() [Admin] "/freeze", Frozen;
    /// Brings a system back as it was.
    Post thaw() [Admin] "/thaw" => ThawRequest, Thawed;
    /// Lets a component go on that was loaded held.
    Post go_on(component) [Admin] "/components/{component}/go_on", GoesOn;
    /// Lists the channels that a recording of everything would have.
    Get channels() [Read] "/channels", Channels;
    /// Records ports and calls of services.
    Post record() [Read] "/recordings" => RecordingRequest, Bytes;
    /// Ends a recording.
    Delete end_recording(number) [Read] "/recordings/{number}", RecordingEnds;
    /// Lists the recordings that the daemon keeps.
    Get kept() [Read] "/recordings/kept", KeptRecordings;
    /// Has the daemon record into a file that it keeps.
    Post keep() [Call] "/recordings/kept" => KeepRequest, KeptRecording;
    /// The file of one of them.
    Get kept_file(file) [Read] "/recordings/kept/{file}", Bytes;
    /// Removes one.
    Delete remove_kept(file) [Admin] "/recordings/kept/{file}", RecordingRemoved;
    /// Ends one that is under way.
    Post end_kept(file) [Call] "/recordings/kept/{file}/end", KeptRecording;
    /// Publishes its samples to in ports, with their timing.
    Post play_kept(file) [Call] "/recordings/kept/{file}/replay" => ReplayRequest, KeptReplay;
    /// Ends that.
    Delete stop_kept(file) [Call] "/recordings/kept/{file}/replay", KeptReplay;
    /// Publishes samples of a recording.
    Post replay() [Call] "/replay" => Bytes, Replayed;
    /// Streams changes in the daemon.
    Get events() [Read] "/events" ?ChangeParameters, Stream<Change>;
    /// Streams the changes of the last minutes, with their dates.
    Get timeline() [Read] "/timeline/stream" ?TimelineParameters, Stream<Timeline>;
    /// Entries of the log.
    Get logs() [Read] "/logs" ?LogParameters, Logs;
    /// Streams entries of the log.
    Get log_stream() [Read] "/logs/stream" ?LogParameters, Stream<LogEntry>;
    /// Makes a link that opens the web console, once.
    Post web_link() [Read] "/web/links" => LinkRequest, Link;
    /// Metrics for Prometheus.
    Get metrics() [Read] "/metrics", Bytes;
    /// The clock of the components.
    Get clock() [Read] "/clock", Clock;
    /// Advances the clock, if it is virtual.
    Post step() [Call] "/clock" => StepRequest, Clock;
    /// Why the service manager gets no sign of life.
    Get withheld() [Read] "/withheld", Withheld;
    /// Gives signs of life again that were withheld because of a component.
    Delete clear_withheld(instance) [Admin] "/withheld/{instance}", Cleared;
    /// Lists the middlewares.
    Get middlewares() [Read] "/middlewares" ?MiddlewareParameters, Middlewares;
    /// Lists the daemons that are visible on middlewares.
    Get daemons() [Read] "/daemons", Daemons;
    /// Sends a hello to all daemons that answer to a name.
    Post hello(daemon) [Call] "/daemons/{daemon}/hello" => Bytes, Answers;
    /// Sends a sealed question to one daemon.
    Post question(daemon) [Call] "/daemons/{daemon}/questions" ?AskParameters => Bytes, Bytes;
    /// The OpenAPI document.
    Get document() [] "/openapi.json", Value;
    /// A page to browse it.
    Get page() [] "/docs", Bytes;
}

/// The right that calling a service requires which every component has, besides [`Right::Call`].
/// A service without a row is for administrators, as is a route without one.
#[must_use]
pub fn right_of_standard_service(name: &str) -> Right {
    let found = STANDARD_SERVICES.iter().find(|(service, _)| *service == name);
    found.map_or(Right::Admin, |(_, right)| *right)
}

/// Whether every component has a service of this name.
#[must_use]
pub fn is_standard_service(name: &str) -> bool {
    STANDARD_SERVICES.iter().any(|(service, _)| *service == name)
}

/// All characters but the unreserved ones (RFC 3986, 2.3).
const RESERVED: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~');

/// Fills names into a path, percent-encoded so that each stays within its segment.
fn filled(template: &str, parts: &[(&str, &str)]) -> String {
    let mut path = String::new();
    for segment in template.split('/').skip(1) {
        path.push('/');
        let name = segment.strip_prefix('{').and_then(|segment| segment.strip_suffix('}'));
        match name.and_then(|name| parts.iter().find(|(part, _)| *part == name)) {
            Some((_, value)) => path.extend(utf8_percent_encode(value, RESERVED)),
            None => path.push_str(segment),
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_never_leave_their_segment() {
        assert_eq!(component("a/b?c d").path, "/components/a%2Fb%3Fc%20d");
        assert_eq!(about().path, "/");
        let element = disconnect_element("demo", "cameras", "left/eye");
        assert_eq!(element.path, "/connections/demo/cameras/left%2Feye");
    }

    #[test]
    fn a_query_says_what_is_not_as_usual() {
        assert_eq!(ports().with(&PortParameters::default()).path, "/ports");
        assert_eq!(
            ports().with(&PortParameters { values: Some(false) }).path,
            "/ports?values=false"
        );
        let query = LogParameters { component: Some("a b&c".into()), last: Some(3), level: None };
        assert_eq!(logs().with(&query).path, "/logs?component=a+b%26c&last=3");
        assert_eq!(
            call("demo", "go").with(&CallParameters::default()).path,
            call("demo", "go").path
        );
    }

    #[test]
    fn every_route_is_listed_once_and_names_its_types() {
        let all = all();
        for (at, one) in all.iter().enumerate() {
            let same =
                |other: &Listed| (other.method, other.template) == (one.method, one.template);
            assert!(!all[..at].iter().any(same), "{one:?}");
        }
        let load = all.iter().find(|one| one.body == "LoadRequest").unwrap();
        assert_eq!(
            (load.method, load.template, load.reply),
            (Method::Post, "/components", "Component")
        );
        assert_eq!(all.iter().find(|one| one.template == "/events").unwrap().reply, "Stream");
    }

    #[test]
    fn a_service_requires_the_right_of_the_route_that_does_the_same() {
        for route in all() {
            for service in route.services {
                assert_eq!(Some(right_of_standard_service(service)), route.right, "{service}");
            }
        }
        let services = all().iter().flat_map(|one| one.services).count();
        assert_eq!(services, STANDARD_SERVICES.len());
        assert_eq!(right_of_standard_service("kill"), Right::Admin);
        assert_eq!(right_of_standard_service("of_a_later_version"), Right::Admin);
        let open: Vec<_> = all().into_iter().filter(|one| one.right.is_none()).collect();
        let open: Vec<_> = open.iter().map(|one| one.template).collect();
        assert_eq!(open, ["/openapi.json", "/docs"], "how to ask, and nothing else");
    }
}
