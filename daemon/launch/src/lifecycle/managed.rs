//! What a deployment says of a component that ROS manages.

use genom_protocol::{CallEntry, ConnectionEntry, Deployment, LoadRequest, component_of};

/// A component that ROS loads and starts, and what of the deployment goes with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Managed {
    /// Instance name, which is that of the node.
    pub(crate) name: String,
    pub(crate) load: LoadRequest,
    /// Connections of its in ports and remotes, and those to its out ports and services by components
    /// that are not managed.
    pub(crate) connections: Vec<ConnectionEntry>,
    pub(crate) calls: Vec<CallEntry>,
    /// What runs while it is active.
    pub(crate) activities: Vec<CallEntry>,
}

/// Takes the components with these names, and all that is said of them, out of a deployment. A name
/// that it does not have is left out.
#[must_use]
pub fn take(names: &[String], deployment: &mut Deployment) -> Vec<Managed> {
    let is = |name: &str| names.iter().any(|other| other == name);
    let (managed, others): (Vec<_>, Vec<_>) =
        deployment.component.drain(..).partition(|component| is(&component.instance()));
    deployment.component = others;
    for component in &mut deployment.component {
        // It does not wait for what may never be loaded.
        component.after.retain(|name| !is(name));
    }
    let mut all: Vec<Managed> = managed
        .into_iter()
        .map(|load| Managed {
            name: load.instance(),
            // When which one is loaded is up to who manages them.
            load: LoadRequest { after: Vec::new(), daemon: None, ..load },
            connections: Vec::new(),
            calls: Vec::new(),
            activities: Vec::new(),
        })
        .collect();
    let find = |name: &str| all.iter().position(|one| one.name == name);
    let mut goes = Vec::new();
    deployment.connection.retain(|entry| {
        let place = find(entry.reader()).or_else(|| find(writer(entry)));
        goes.extend(place.map(|place| (place, entry.clone())));
        place.is_none()
    });
    goes.into_iter().for_each(|(place, entry)| all[place].connections.push(entry));
    for one in &mut all {
        let of_it = |entry: &mut CallEntry| entry.component == one.name;
        one.calls = deployment.call.extract_if(.., of_it).collect();
        one.activities = deployment.activity.extract_if(.., of_it).collect();
    }
    all
}

/// The instance that has the out port or the service: without the middleware in front.
fn writer(entry: &ConnectionEntry) -> &str {
    let address = entry.outport.split_once(':').map_or(&*entry.outport, |(_, address)| address);
    component_of(address)
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;

    fn component(name: &str, after: &[&str]) -> LoadRequest {
        let after = after.iter().map(|&name| name.to_owned()).collect();
        LoadRequest {
            library: "demo.so".into(),
            name: Some(name.to_owned()),
            after,
            ..LoadRequest::default()
        }
    }

    fn connection(inport: &str, outport: &str) -> ConnectionEntry {
        let (inport, outport) = (inport.to_owned(), outport.to_owned());
        ConnectionEntry { inport, outport, policy: None, over: None }
    }

    fn call(component: &str) -> CallEntry {
        CallEntry { component: component.to_owned(), service: "go".to_owned(), inputs: Value::Null }
    }

    #[test]
    fn all_that_is_said_of_a_managed_component_goes_with_it() {
        let mut deployment = Deployment {
            component: vec![component("arm", &["base"]), component("base", &["arm"])],
            connection: vec![
                connection("arm/goal", "base/pose"),
                connection("base/arm", "shm:arm/pose"),
                connection("base/map", "ros2:/map"),
            ],
            call: vec![call("base"), call("arm")],
            activity: vec![call("arm"), call("base")],
        };
        let all = take(&["arm".to_owned()], &mut deployment);
        let [arm] = &all[..] else { panic!("{all:?}") };
        assert_eq!((arm.name.as_str(), &arm.load), ("arm", &component("arm", &[])));
        assert_eq!(arm.connections.len(), 2);
        assert_eq!((arm.calls.len(), arm.activities.len()), (1, 1));
        assert_eq!(deployment.component, [component("base", &[])]);
        assert_eq!(deployment.connection, [connection("base/map", "ros2:/map")]);
        assert_eq!((deployment.call.len(), deployment.activity.len()), (1, 1));
    }

    #[test]
    fn a_connection_between_two_managed_components_is_made_with_the_reader() {
        let mut deployment = Deployment {
            component: vec![component("a", &[]), component("b", &[])],
            connection: vec![connection("b/in", "a/out")],
            ..Deployment::default()
        };
        let all = take(&["a".to_owned(), "b".to_owned()], &mut deployment);
        assert_eq!(all[0].connections, []);
        assert_eq!(all[1].connections, [connection("b/in", "a/out")]);
        assert_eq!(deployment, Deployment::default());
    }
}
