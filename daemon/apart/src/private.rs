//! What one daemon uses alone, so that it neither disturbs others nor is disturbed: directory,
//! socket, shared memory, zenoh sessions, a ROS domain on the loopback interface.

use std::fs;
use std::io;
use std::path::PathBuf;
use std::process;

use tempfile::TempDir;
use toml::{Table, Value};

/// DDS domains whose ports Linux gives to no other program: those of 102 to 214 lie where it takes
/// ports for programs that ask for any (ip_local_port_range; RTPS 9.6.1.1 computes the ports).
const DOMAINS: std::ops::Range<u32> = 215..232;

/// Files and names of one daemon; removed when dropped.
#[derive(Debug)]
pub struct Private {
    directory: TempDir,
    /// Of everything that has to have a name on this machine.
    name: String,
    domain: u32,
}

/// The configuration cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum NotWritten {
    /// It cannot be written as TOML.
    #[error("the configuration: {0}")]
    Text(#[from] toml::ser::Error),
    /// Its directory or file cannot be written.
    #[error("the directory of the daemon: {0}")]
    Io(#[from] io::Error),
}

impl Private {
    /// For the daemon number `number` of this process. `purpose` is a word of letters: daemons of
    /// different purposes have different names.
    ///
    /// # Errors
    /// No directory can be made.
    pub fn new(purpose: &str, number: usize) -> io::Result<Self> {
        let id = process::id();
        let name = format!("g{purpose}{id}n{number}");
        let directory =
            tempfile::Builder::new().prefix(&format!("genomctl-{purpose}-")).tempdir()?;
        fs::create_dir(directory.path().join(&name))?;
        Ok(Self { directory, name, domain: DOMAINS.start + id % (DOMAINS.end - DOMAINS.start) })
    }

    /// The socket of the daemon.
    #[must_use]
    pub fn socket(&self) -> PathBuf {
        self.directory.path().join("genomd.sock")
    }

    /// The file for what the daemon logs.
    #[must_use]
    pub fn log(&self) -> PathBuf {
        self.directory.path().join("log")
    }

    /// A directory with a name of its own on this machine, for a bare middleware.
    #[must_use]
    pub fn place(&self) -> PathBuf {
        self.directory.path().join(&self.name)
    }

    /// Writes the configuration of the daemon: what it says of components, connections, tasks,
    /// cells and middlewares, except where that reaches beyond this daemon.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn configure(&self, mut table: Table) -> Result<PathBuf, NotWritten> {
        set(&mut table, "watch", false);
        // The control plane is this directory's socket, and nothing is kept or told elsewhere.
        for section in ["rpc", "telemetry", "crashes"] {
            table.remove(section);
        }
        within(&mut table, "crashes", |crashes| set(crashes, "most", 0));
        within(&mut table, "cells", |cells| set(cells, "without_daemon", "stop"));
        within(&mut table, "backends", |sections| self.name_middlewares(sections));
        // All daemons of a deployment are one here.
        entries(&mut table, "component").for_each(|component| drop(component.remove("daemon")));
        let file = self.directory.path().join("genomd.toml");
        fs::write(&file, toml::to_string(&table)?)?;
        Ok(file)
    }

    fn name_middlewares(&self, sections: &mut Table) {
        let path = |name: &str| self.directory.path().join(name).to_string_lossy().into_owned();
        within(sections, "shm", |shm| {
            set(shm, "prefix", format!("{}_", self.name));
            set(shm, "root", path("shm"));
        });
        within(sections, "zenoh", |zenoh| {
            for key in ["config", "tls", "set", "insecure", "mode", "listen", "connect"] {
                zenoh.remove(key);
            }
            set(zenoh, "rendezvous", path("zenoh"));
        });
        within(sections, "ros2", |ros2| {
            set(ros2, "domain", i64::from(self.domain));
            set(ros2, "networks", "loopback");
            set(ros2, "namespace", self.name.clone());
        });
    }
}

impl Drop for Private {
    fn drop(&mut self) {
        // iceoryx2 leaves a segment in which it counts nodes, and a killed process all of its own.
        let mine = [format!("{}_", self.name), format!("bare{}_", self.name)];
        for entry in fs::read_dir("/dev/shm").into_iter().flatten().flatten() {
            let name = entry.file_name();
            if mine.iter().any(|mine| name.to_string_lossy().starts_with(mine.as_str())) {
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}

/// Sets a key.
pub fn set(table: &mut Table, key: &str, value: impl Into<Value>) {
    table.insert(key.to_owned(), value.into());
}

/// Changes the table of this key, which is made if there is none.
pub fn within(table: &mut Table, key: &str, change: impl FnOnce(&mut Table)) {
    let mut section = match table.remove(key) {
        Some(Value::Table(section)) => section,
        _ => Table::new(),
    };
    change(&mut section);
    table.insert(key.to_owned(), section.into());
}

/// The tables of an array of tables: none if there is no such key.
pub fn entries<'a>(table: &'a mut Table, key: &str) -> impl Iterator<Item = &'a mut Table> {
    let all = table.get_mut(key).and_then(Value::as_array_mut);
    all.into_iter().flatten().filter_map(Value::as_table_mut)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEPLOYMENT: &str = r#"
        backend = "zenoh"
        clock = "virtual"
        [rpc]
        listen = "0.0.0.0:7300"
        [backends.zenoh]
        connect = ["tcp/192.168.1.7:7447"]
        prefix = "lab"
        [backends.shm]
        depth = 4
        [[component]]
        library = "/lib/camera.so"
        daemon = "station"
    "#;

    #[test]
    fn nothing_reaches_others_and_the_rest_stays() {
        let private = Private::new("check", 0).unwrap();
        let file = private.configure(DEPLOYMENT.parse().unwrap()).unwrap();
        let table: Table = fs::read_to_string(file).unwrap().parse().unwrap();
        assert_eq!(
            (table["backend"].as_str(), table["clock"].as_str()),
            (Some("zenoh"), Some("virtual"))
        );
        assert!(!table.contains_key("rpc"));
        let camera = table["component"][0].as_table().unwrap();
        assert_eq!(camera.keys().collect::<Vec<_>>(), ["library"]);
        let zenoh = table["backends"]["zenoh"].as_table().unwrap();
        assert_eq!(zenoh.keys().collect::<Vec<_>>(), ["prefix", "rendezvous"]);
        assert_eq!(table["backends"]["shm"]["depth"].as_integer(), Some(4));
        assert_eq!(table["backends"]["ros2"]["networks"].as_str(), Some("loopback"));
    }

    #[test]
    fn what_is_private_goes_with_it() {
        let private = Private::new("check", 7).unwrap();
        let place = private.place();
        let segment = PathBuf::from(format!("/dev/shm/gcheck{}n7_left", process::id()));
        fs::write(&segment, "").unwrap();
        drop(private);
        assert!(!place.exists() && !segment.exists());
    }
}
