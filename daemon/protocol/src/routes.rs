//! The paths of the control plane, each with what it takes and what it answers.
//!
//! A client asks for a [`Route`], so that a reply is always read as the type that its path
//! answers. `tests/` compares this list with the daemon's `/openapi.json`.

use std::any::type_name;
use std::fmt;
use std::marker::PhantomData;

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use serde::Serialize;
use serde_json::Value;

use crate::{
    Aborted, About, Activities, Activity, AllAborted, Answers, Applied, AskParameters,
    CallParameters, CallReply, Change, ChangeParameters, Clock, Component, Components, Connection,
    ConnectionRequest, Connections, Daemons, DeploymentRequest, Description, Disconnected, Dumped,
    Findings, Fired, Inputs, LoadRequest, LogEntry, LogParameters, Logs, LookParameters,
    MiddlewareParameters, Middlewares, MoveRequest, Moved, Port, PortParameters, PortTraffic,
    PortType, Ports, Published, Ready, ReadyParameters, RecordingEnds, RecordingRequest, Reloaded,
    Replayed, Service, Statistics, StepRequest, Stopping, StreamParameters, Unloaded,
    ValueParameters,
};

/// What is done to a resource, in HTTP's words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Look.
    Get,
    /// Replace.
    Put,
    /// Make, or do something.
    Post,
    /// Take away, or stop.
    Delete,
}

impl Method {
    /// In capitals, as it stands in a request.
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

/// A request without its body: it answers `R`, takes a query `Q` and a body `B`.
pub struct Route<R, Q = (), B = ()> {
    /// What is done.
    pub method: Method,
    /// Path and query, as they stand in a request.
    pub path: String,
    types: PhantomData<fn(Q, B) -> R>,
}

impl<R, Q, B> fmt::Debug for Route<R, Q, B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.method.as_str(), self.path)
    }
}

impl<R, Q: Serialize, B> Route<R, Q, B> {
    /// The same with a query.
    #[must_use]
    pub fn with(mut self, query: &Q) -> Self {
        // None of the queries can fail: they are flat, and made of texts and numbers.
        let query = serde_urlencoded::to_string(query).unwrap_or_default();
        if !query.is_empty() {
            self.path = format!("{}?{query}", self.path);
        }
        self
    }
}

/// Server-sent events whose data are `T`.
#[derive(Debug)]
pub struct Stream<T>(PhantomData<T>);

/// Bytes that are no JSON.
#[derive(Debug)]
pub struct Bytes;

/// A line of the list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listed {
    /// What is done.
    pub method: Method,
    /// The path, names in braces: `/components/{component}`.
    pub template: &'static str,
    /// Name of the type that it answers.
    pub reply: &'static str,
    /// Name of the type that it takes, `()` when it takes none.
    pub body: &'static str,
}

/// The last name of a type's path.
fn name_of<T>() -> &'static str {
    let name = type_name::<T>();
    name.split('<').next().and_then(|name| name.rsplit("::").next()).unwrap_or(name)
}

macro_rules! routes {
    ($($(#[$doc:meta])* $method:ident $name:ident($($part:ident),*) $template:literal
        $(? $query:ty)? $(=> $body:ty)?, $reply:ty;)*) => {
        $(
            $(#[$doc])*
            #[must_use]
            pub fn $name($($part: &str),*) -> Route<$reply, routes!(@or $($query)?), routes!(@or $($body)?)> {
                let parts: &[(&str, &str)] = &[$((stringify!($part), $part)),*];
                Route { method: Method::$method, path: filled($template, parts), types: PhantomData }
            }
        )*

        /// Every route.
        #[must_use]
        pub fn all() -> Vec<Listed> {
            vec![$(Listed {
                method: Method::$method,
                template: $template,
                reply: name_of::<$reply>(),
                body: name_of::<routes!(@or $($body)?)>(),
            }),*]
        }
    };
    (@or) => { () };
    (@or $ty:ty) => { $ty };
}

routes! {
    /// What the daemon is.
    Get about() "/", About;
    /// Whether it has loaded what it was started with.
    Get ready() "/ready" ?ReadyParameters, Ready;
    /// Stops it.
    Post shutdown() "/shutdown", Stopping;
    /// Reads the token file again.
    Post reload_tokens() "/tokens/reload", Reloaded;
    /// The components that run.
    Get components() "/components", Components;
    /// Loads one.
    Post load() "/components" => LoadRequest, Component;
    /// Describes one.
    Get component(component) "/components/{component}", Description;
    /// Unloads one.
    Delete unload(component) "/components/{component}", Unloaded;
    /// The types of one as JSON Schemas.
    Get schema(component) "/components/{component}/schema", Value;
    /// Moves one, or one of its ports, to other middlewares.
    Put move_component(component) "/components/{component}/backend" => MoveRequest, Moved;
    /// Statistics of its tasks and codels.
    Get statistics(component) "/components/{component}/tasks", Statistics;
    /// Fires an event.
    Post fire(component, event) "/components/{component}/events/{event}", Fired;
    /// Describes a service.
    Get service(component, service) "/components/{component}/services/{service}", Service;
    /// Calls a service.
    Post call(component, service) "/components/{component}/services/{service}"
        ?CallParameters => Inputs, CallReply;
    /// The activities of a component.
    Get activities(component) "/components/{component}/activities", Activities;
    /// Asks them all to stop.
    Delete abort_all(component) "/components/{component}/activities", AllAborted;
    /// Looks at an activity, by its number or the name of its service.
    Get activity(component, activity) "/components/{component}/activities/{activity}"
        ?LookParameters, Activity;
    /// Asks it to stop; all of a service, by its name.
    Delete abort(component, activity) "/components/{component}/activities/{activity}", Aborted;
    /// Asks all activities of all components to stop.
    Delete stop() "/activities", AllAborted;
    /// The ports of all components.
    Get ports() "/ports" ?PortParameters, Ports;
    /// The ports of a component.
    Get ports_of(component) "/components/{component}/ports" ?PortParameters, Ports;
    /// A port and its value.
    Get port(component, port) "/components/{component}/ports/{port}" ?ValueParameters, Port;
    /// Publishes a value to an in port.
    Post publish(component, port) "/components/{component}/ports/{port}"
        ?ValueParameters => Value, Published;
    /// The type of a port, as it lies in memory.
    Get port_type(component, port) "/components/{component}/ports/{port}/type", PortType;
    /// Follows its values.
    Get values(component, port) "/components/{component}/ports/{port}/stream"
        ?StreamParameters, Stream<Value>;
    /// Counts of a port.
    Get traffic(component, port) "/components/{component}/ports/{port}/traffic"
        ?ValueParameters, PortTraffic;
    /// Why no data flows through a port.
    Get why(component, port) "/components/{component}/ports/{port}/why", Findings;
    /// The connections.
    Get connections() "/connections", Connections;
    /// Makes one.
    Post connect() "/connections" => ConnectionRequest, Connection;
    /// Takes that of an in port or a remote away.
    Delete disconnect(component, port) "/connections/{component}/{port}", Disconnected;
    /// Takes that of an element away.
    Delete disconnect_element(component, port, element)
        "/connections/{component}/{port}/{element}", Disconnected;
    /// What runs, as a deployment.
    Get dump() "/deployment", Dumped;
    /// Brings the daemon to what a deployment says.
    Post apply() "/deployment" => DeploymentRequest, Applied;
    /// Records ports and what services are asked.
    Post record() "/recordings" => RecordingRequest, Bytes;
    /// Ends a recording.
    Delete end_recording(number) "/recordings/{number}", RecordingEnds;
    /// Publishes samples of a recording.
    Post replay() "/replay" => Bytes, Replayed;
    /// Follows what changes.
    Get events() "/events" ?ChangeParameters, Stream<Change>;
    /// What was logged.
    Get logs() "/logs" ?LogParameters, Logs;
    /// Follows what is logged.
    Get log_stream() "/logs/stream" ?LogParameters, Stream<LogEntry>;
    /// Figures for Prometheus.
    Get metrics() "/metrics", Bytes;
    /// The clock that components live by.
    Get clock() "/clock", Clock;
    /// Steps it, when it is virtual.
    Post step() "/clock" => StepRequest, Clock;
    /// The middlewares.
    Get middlewares() "/middlewares" ?MiddlewareParameters, Middlewares;
    /// The daemons that are visible on them.
    Get daemons() "/daemons", Daemons;
    /// Passes a hello on to all that answer to a name.
    Post hello(daemon) "/daemons/{daemon}/hello" => Bytes, Answers;
    /// Passes a sealed question on to one of them.
    Post question(daemon) "/daemons/{daemon}/questions" ?AskParameters => Bytes, Bytes;
    /// The OpenAPI document.
    Get document() "/openapi.json", Value;
    /// A page to browse it.
    Get page() "/docs", Bytes;
}

/// All but the unreserved characters (RFC 3986, 2.3).
const RESERVED: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~');

/// A path with its names, which never leave their segment.
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
}
