//! The configuration of a deployment for a way.

use std::path::Path;

use genom_apart::{entries, set};
use toml::{Table, Value};

use crate::way::Way;

/// The configuration of a way cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum NoConfiguration {
    /// The way names a component that the deployment does not have.
    #[error("the deployment has no component `{component}`; it has {known}")]
    Component {
        /// The name.
        component: String,
        /// Those that it has.
        known: String,
    },
    /// What genomd printed is not a configuration.
    #[error("genomd --dump-config: {0}")]
    Unreadable(#[from] toml::de::Error),
}

impl Way {
    /// The configuration for this way: `text` is what `genomd --dump-config` prints of the
    /// deployment. With `isolated`, each component is in a cell of its own.
    ///
    /// # Errors
    /// The way does not fit the deployment.
    pub fn configuration(&self, text: &str, isolated: bool) -> Result<Table, NoConfiguration> {
        let mut table: Table = text.parse()?;
        set(&mut table, "backend", self.backend.clone());
        set(&mut table, "clock", "monotonic");
        table.remove("blackbox");
        assign(&mut table, self, isolated)?;
        Ok(table)
    }
}

/// The middlewares and processes of components and connections.
fn assign(table: &mut Table, way: &Way, isolated: bool) -> Result<(), NoConfiguration> {
    let mut known = Vec::new();
    for component in entries(table, "component") {
        let name = instance(component);
        for key in ["backend", "ports"] {
            component.remove(key);
        }
        let own = way.ports.iter().filter(|((component, _), _)| *component == name);
        let ports: Table =
            own.map(|((_, port), backend)| (port.clone(), several(backend))).collect();
        if !ports.is_empty() {
            set(component, "ports", ports);
        }
        if isolated {
            set(component, "cell", name.clone());
        }
        known.push(name);
    }
    if let Some(((component, _), _)) = way.ports.iter().find(|((name, _), _)| !known.contains(name))
    {
        return Err(NoConfiguration::Component {
            component: component.clone(),
            known: known.join(", "),
        });
    }
    for connection in entries(table, "connection") {
        let Some(out) = connection.get("out").and_then(Value::as_str) else { continue };
        let address = out.split_once(':').map_or(out, |(_, address)| address).to_owned();
        let of = address.split('/').next().unwrap_or_default();
        // One from elsewhere stays on the middleware where it is.
        if known.iter().any(|name| name == of) {
            connection.remove("backend");
            connection.remove("over");
            set(connection, "out", address);
        }
    }
    Ok(())
}

/// The name of an instance, as genomd makes it if none is given.
fn instance(component: &Table) -> String {
    let text = |key: &str| component.get(key).and_then(Value::as_str);
    let stem = |library: &str| {
        Path::new(library).file_stem().unwrap_or_default().to_string_lossy().into_owned()
    };
    text("name").map_or_else(|| text("library").map(stem).unwrap_or_default(), str::to_owned)
}

/// One middleware, or several joined by `+`.
fn several(backend: &str) -> Value {
    Value::Array(backend.split('+').map(Value::from).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEPLOYMENT: &str = r#"
        backend = "zenoh"
        clock = "virtual"
        [[component]]
        library = "/lib/camera.so"
        backend = ["zenoh", "ros2"]
        [component.ports]
        image = "zenoh"
        [[component]]
        library = "viewer"
        name = "screen"
        [[connection]]
        in = "screen/image"
        out = "zenoh:camera/image"
        backend = "zenoh"
        [[connection]]
        in = "screen/clock"
        out = "ros2:/clock"
    "#;

    fn configured(way: &str, isolated: bool) -> Result<Table, NoConfiguration> {
        way.parse::<Way>().unwrap().configuration(DEPLOYMENT, isolated)
    }

    #[test]
    fn all_is_on_the_middleware_of_the_way_but_for_what_comes_from_elsewhere() {
        let table = configured("shm", false).unwrap();
        assert_eq!(
            (table["backend"].as_str(), table["clock"].as_str()),
            (Some("shm"), Some("monotonic"))
        );
        let camera = table["component"][0].as_table().unwrap();
        assert_eq!(camera.keys().collect::<Vec<_>>(), ["library"]);
        let connections = table["connection"].as_array().unwrap();
        assert_eq!(connections[0]["out"].as_str(), Some("camera/image"));
        assert!(connections[0].get("backend").is_none());
        assert_eq!(connections[1]["out"].as_str(), Some("ros2:/clock"));
    }

    #[test]
    fn ports_of_a_mix_and_cells_are_those_of_their_components() {
        let table = configured("shm: camera/image=zenoh+ros2", true).unwrap();
        let camera = table["component"][0].as_table().unwrap();
        let image = camera["ports"]["image"].as_array().unwrap();
        assert_eq!(
            image.iter().map(|one| one.as_str().unwrap()).collect::<Vec<_>>(),
            ["zenoh", "ros2"]
        );
        assert_eq!(camera["cell"].as_str(), Some("camera"));
        assert_eq!(table["component"][1]["cell"].as_str(), Some("screen"));
        let told = configured("shm: viewer/image=zenoh", false).unwrap_err().to_string();
        assert_eq!(told, "the deployment has no component `viewer`; it has camera, screen");
    }
}
