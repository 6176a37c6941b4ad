//! Remedies made of routes: their method, path and right are those of the route.

use serde::Serialize;

use crate::routes::Route;
use crate::{Choice, ConnectionRequest, ReloadRequest, Remedy, Right, routes};

impl Remedy {
    /// A request without a body.
    #[must_use]
    pub fn new<R, Q, B>(does: impl Into<String>, route: &Route<R, Q, B>) -> Self {
        Self {
            does: does.into(),
            method: route.method.as_str().to_owned(),
            path: route.path.clone(),
            body: None,
            // A route without one is public; nothing that helps is.
            right: route.right.unwrap_or(Right::Admin),
            choose: None,
        }
    }

    /// A request with this body.
    #[must_use]
    pub fn with<R, Q, B: Serialize>(
        does: impl Into<String>,
        route: &Route<R, Q, B>,
        body: &B,
    ) -> Self {
        // No body can fail to serialise: all are trees of texts and numbers.
        Self { body: serde_json::to_value(body).ok(), ..Self::new(does, route) }
    }

    /// Takes a component down.
    #[must_use]
    pub fn unload(component: &str) -> Self {
        Self::new(format!("Unload {component}"), &routes::unload(component))
    }

    /// Runs what the library of a component is now: once a codel was mended.
    #[must_use]
    pub fn reload(component: &str) -> Self {
        let does = format!("Reload {component} as it was built last");
        Self::with(does, &routes::reload(component), &ReloadRequest::default())
    }

    /// Connects an in port: to this out port, or to one that the user chooses.
    #[must_use]
    pub fn connect(inport: &str, outport: Option<&str>) -> Self {
        let body = ConnectionRequest {
            inport: inport.to_owned(),
            outport: outport.unwrap_or_default().to_owned(),
            policy: None,
            over: None,
            wait: false,
        };
        let with = |does| Self::with(does, &routes::connect(), &body);
        match outport {
            Some(outport) => with(format!("Connect {inport} to {outport}")),
            None => with(format!("Connect {inport}")).choose(Choice::OutPort),
        }
    }

    /// The same, when the user has chosen what is missing in its body.
    #[must_use]
    pub fn choose(self, choice: Choice) -> Self {
        Self { choose: Some(choice), ..self }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_remedy_is_a_request_with_the_right_of_its_route() {
        let unload = Remedy::unload("a/b");
        assert_eq!(
            json!(unload),
            json!({"does": "Unload a/b", "method": "DELETE", "path": "/components/a%2Fb",
                   "right": "admin"})
        );
        let reload = Remedy::reload("a");
        assert_eq!((reload.method.as_str(), reload.body), ("POST", Some(json!({}))));
        let connect = Remedy::connect("a/in", None);
        assert_eq!(connect.body, Some(json!({"in": "a/in", "out": ""})));
        assert_eq!((connect.right, connect.choose), (Right::Wire, Some(Choice::OutPort)));
        let started = Remedy::new("Start", &routes::call("a", "go"));
        assert_eq!(started.right, Right::Call);
    }
}
