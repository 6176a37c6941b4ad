//! The configuration of the daemon that a scenario begins with.

use std::path::PathBuf;

use genom_apart::{entries, set, within};
use serde::Serialize;
use toml::{Table, Value};

use crate::model::Setup;

/// Bytes of the black box of each process, of which most are for activities: some 300,000 changes.
const MEMORY: i64 = 256 << 20;

/// What the command line says in place of the file.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// The middleware of all ports.
    pub backend: Option<String>,
    /// Directories in which components are searched first.
    pub path: Vec<PathBuf>,
}

/// The setup cannot be written as a configuration.
#[derive(Debug, thiserror::Error)]
pub enum NoSetup {
    /// What genomd printed of the deployment is not a configuration.
    #[error("genomd --dump-config: {0}")]
    Unreadable(#[from] toml::de::Error),
    /// It cannot be written as TOML.
    #[error("the setup: {0}")]
    Text(#[from] toml::ser::Error),
}

impl Setup {
    /// The configuration of the daemon. `deployment` is what `genomd --dump-config` prints of the
    /// deployment, if there is one.
    ///
    /// # Errors
    /// The deployment is not one, or the setup cannot be written.
    pub fn configuration(
        &self,
        deployment: Option<&str>,
        overrides: &Overrides,
    ) -> Result<Table, NoSetup> {
        let mut table: Table = deployment.unwrap_or_default().parse()?;
        set(&mut table, "clock", "virtual");
        if let Some(backend) = overrides.backend.as_ref() {
            for component in entries(&mut table, "component") {
                component.remove("backend");
                component.remove("ports");
            }
            set(&mut table, "backend", backend.as_str());
        } else if let Some(backend) = &self.backend {
            set(&mut table, "backend", backend.as_str());
        }
        let path = overrides.path.iter().chain(&self.path);
        let path = path.map(|directory| directory.to_string_lossy().into_owned().into());
        prepend(&mut table, "path", path.collect());
        append(&mut table, "component", &self.components)?;
        append(&mut table, "connection", &self.connections)?;
        table.remove("blackbox");
        within(&mut table, "blackbox", |section| {
            set(section, "enabled", true);
            set(section, "seconds", 86_400.0);
            set(section, "bytes", MEMORY);
            set(section, "port_bytes", MEMORY / 4);
            for nothing in ["ports", "on", "exceptions"] {
                set(section, nothing, Vec::<Value>::new());
            }
        });
        Ok(table)
    }
}

fn list(table: &mut Table, key: &str) -> Vec<Value> {
    match table.remove(key) {
        Some(Value::Array(list)) => list,
        _ => Vec::new(),
    }
}

fn prepend(table: &mut Table, key: &str, mut more: Vec<Value>) {
    more.extend(list(table, key));
    set(table, key, more);
}

fn append(table: &mut Table, key: &str, more: &[impl Serialize]) -> Result<(), toml::ser::Error> {
    let mut all = list(table, key);
    for one in more {
        all.push(Value::try_from(one)?);
    }
    set(table, key, all);
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::model::Suite;

    const FILE: &str = r#"
        path = ["lib"]
        [[scenario]]
        name = "moves"
        components = ["demo", { library = "../arm.so", name = "arm", cell = "c" }]
        connections = [{ in = "arm/goal", out = "demo/position" }]
        steps = [{ step = "1ms" }]
    "#;

    #[test]
    fn what_a_scenario_runs_comes_after_its_deployment() {
        let suite = Suite::read(Path::new("/robot/tests/moves.toml"), FILE).unwrap();
        let setup = &suite.scenarios[0].setup;
        let deployment = "path = [\"/opt\"]\nbackend = \"zenoh\"\nclock = \"monotonic\"\n\
                          [[component]]\nlibrary = \"eye\"\nbackend = \"ros2\"\n";
        let table = setup.configuration(Some(deployment), &Overrides::default()).unwrap();
        assert_eq!(table["clock"].as_str(), Some("virtual"));
        assert_eq!(table["backend"].as_str(), Some("zenoh"));
        let libraries = table["component"].as_array().unwrap().iter();
        let libraries: Vec<_> = libraries.map(|one| one["library"].as_str().unwrap()).collect();
        assert_eq!(libraries, ["eye", "demo", "/robot/tests/../arm.so"]);
        assert_eq!(table["connection"][0]["in"].as_str(), Some("arm/goal"));
        assert_eq!(table["path"][0].as_str(), Some("/robot/tests/lib"));
        assert_eq!(table["blackbox"]["enabled"].as_bool(), Some(true));
        let shm = Overrides { backend: Some("shm".to_owned()), path: vec!["/first".into()] };
        let table = setup.configuration(Some(deployment), &shm).unwrap();
        assert_eq!(table["backend"].as_str(), Some("shm"));
        assert!(table["component"][0].get("backend").is_none());
        assert_eq!(table["path"][0].as_str(), Some("/first"));
    }
}
