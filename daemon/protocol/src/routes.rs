//! The paths of the control plane, with the types of their queries, bodies and replies.
//!
//! Clients make requests from a [`Route`], so that a reply is always read as the type that the path
//! answers. A test in `tests/` compares this list with the daemon's `/openapi.json`.

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
    types: PhantomData<fn(Q, B) -> R>,
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

        /// All routes.
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
    /// Describes the daemon.
    Get about() "/", About;
    /// Whether the daemon has loaded the components of its configuration.
    Get ready() "/ready" ?ReadyParameters, Ready;
    /// Stops the daemon.
    Post shutdown() "/shutdown", Stopping;
    /// Reads the token file again.
    Post reload_tokens() "/tokens/reload", Reloaded;
    /// Lists the running components.
    Get components() "/components", Components;
    /// Loads a component.
    Post load() "/components" => LoadRequest, Component;
    /// Describes a component.
    Get component(component) "/components/{component}", Description;
    /// Unloads a component.
    Delete unload(component) "/components/{component}", Unloaded;
    /// The types of a component as JSON Schemas.
    Get schema(component) "/components/{component}/schema", Value;
    /// Moves a component, or one of its ports, to other middlewares.
    Put move_component(component) "/components/{component}/backend" => MoveRequest, Moved;
    /// Statistics of the tasks and codels of a component.
    Get statistics(component) "/components/{component}/tasks", Statistics;
    /// Fires an event.
    Post fire(component, event) "/components/{component}/events/{event}", Fired;
    /// Describes a service.
    Get service(component, service) "/components/{component}/services/{service}", Service;
    /// Calls a service.
    Post call(component, service) "/components/{component}/services/{service}"
        ?CallParameters => Inputs, CallReply;
    /// Lists the activities of a component.
    Get activities(component) "/components/{component}/activities", Activities;
    /// Aborts all activities of a component.
    Delete abort_all(component) "/components/{component}/activities", AllAborted;
    /// Describes an activity, given by its number or the name of its service.
    Get activity(component, activity) "/components/{component}/activities/{activity}"
        ?LookParameters, Activity;
    /// Aborts an activity, given by its number, or all of a service, given by its name.
    Delete abort(component, activity) "/components/{component}/activities/{activity}", Aborted;
    /// Aborts all activities of all components.
    Delete stop() "/activities", AllAborted;
    /// Lists the ports of all components.
    Get ports() "/ports" ?PortParameters, Ports;
    /// Lists the ports of a component.
    Get ports_of(component) "/components/{component}/ports" ?PortParameters, Ports;
    /// Describes a port, with its value.
    Get port(component, port) "/components/{component}/ports/{port}" ?ValueParameters, Port;
    /// Publishes a value to an in port.
    Post publish(component, port) "/components/{component}/ports/{port}"
        ?ValueParameters => Value, Published;
    /// The type of a port, with its memory layout.
    Get port_type(component, port) "/components/{component}/ports/{port}/type", PortType;
    /// Streams the values of a port.
    Get values(component, port) "/components/{component}/ports/{port}/stream"
        ?StreamParameters, Stream<Value>;
    /// Counters of a port.
    Get traffic(component, port) "/components/{component}/ports/{port}/traffic"
        ?ValueParameters, PortTraffic;
    /// Why no data flows through a port.
    Get why(component, port) "/components/{component}/ports/{port}/why", Findings;
    /// Lists the connections.
    Get connections() "/connections", Connections;
    /// Makes a connection.
    Post connect() "/connections" => ConnectionRequest, Connection;
    /// Removes the connection of an in port or a remote.
    Delete disconnect(component, port) "/connections/{component}/{port}", Disconnected;
    /// Removes the connection of an element of a multiple in port.
    Delete disconnect_element(component, port, element)
        "/connections/{component}/{port}/{element}", Disconnected;
    /// What runs, as a deployment.
    Get dump() "/deployment", Dumped;
    /// Applies a deployment.
    Post apply() "/deployment" => DeploymentRequest, Applied;
    /// Records ports and calls of services.
    Post record() "/recordings" => RecordingRequest, Bytes;
    /// Ends a recording.
    Delete end_recording(number) "/recordings/{number}", RecordingEnds;
    /// Publishes samples of a recording.
    Post replay() "/replay" => Bytes, Replayed;
    /// Streams changes in the daemon.
    Get events() "/events" ?ChangeParameters, Stream<Change>;
    /// Entries of the log.
    Get logs() "/logs" ?LogParameters, Logs;
    /// Streams entries of the log.
    Get log_stream() "/logs/stream" ?LogParameters, Stream<LogEntry>;
    /// Metrics for Prometheus.
    Get metrics() "/metrics", Bytes;
    /// The clock of the components.
    Get clock() "/clock", Clock;
    /// Advances the clock, if it is virtual.
    Post step() "/clock" => StepRequest, Clock;
    /// Lists the middlewares.
    Get middlewares() "/middlewares" ?MiddlewareParameters, Middlewares;
    /// Lists the daemons that are visible on middlewares.
    Get daemons() "/daemons", Daemons;
    /// Sends a hello to all daemons that answer to a name.
    Post hello(daemon) "/daemons/{daemon}/hello" => Bytes, Answers;
    /// Sends a sealed question to one daemon.
    Post question(daemon) "/daemons/{daemon}/questions" ?AskParameters => Bytes, Bytes;
    /// The OpenAPI document.
    Get document() "/openapi.json", Value;
    /// A page to browse it.
    Get page() "/docs", Bytes;
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
}
