//! Where iceoryx2 keeps its files, and how they are named.

use std::fs;
use std::path::{Path, PathBuf};

use iceoryx2::prelude::Config;

/// Folder of POSIX shared memory on Linux.
pub(crate) const SEGMENTS: &str = "/dev/shm";

/// Folders and file names for one prefix and root.
#[derive(Clone, Debug)]
pub(crate) struct Places {
    pub(crate) prefix: String,
    pub(crate) root: PathBuf,
    pub(crate) nodes: PathBuf,
    pub(crate) services: PathBuf,
    pub(crate) segments: PathBuf,
    pub(super) monitor: String,
    pub(super) service_tag: String,
    pub(super) port_tag: String,
    pub(super) service: String,
    pub(super) dynamic: String,
    pub(super) counter: String,
}

impl Places {
    pub(crate) fn of(config: &Config) -> Self {
        let global = &config.global;
        Self {
            prefix: global.prefix.to_string(),
            root: PathBuf::from(global.root_path().to_string()),
            nodes: PathBuf::from(global.node_dir().to_string()),
            services: PathBuf::from(global.service_dir().to_string()),
            segments: PathBuf::from(SEGMENTS),
            monitor: global.node.monitor_suffix.to_string(),
            service_tag: global.node.service_tag_suffix.to_string(),
            port_tag: global.node.port_tag_suffix.to_string(),
            service: global.service.static_config_storage_suffix.to_string(),
            dynamic: global.service.dynamic_config_storage_suffix.to_string(),
            counter: global.node.global_mgmt_suffix.to_string(),
        }
    }

    /// The part of a file's name between prefix and suffix.
    pub(super) fn name<'a>(&self, file: &'a str, suffix: &str) -> Option<&'a str> {
        file.strip_prefix(self.prefix.as_str())?.strip_suffix(suffix)
    }

    /// Folder of a node.
    pub(super) fn node(&self, id: u128) -> PathBuf {
        self.nodes.join(id.to_string())
    }

    /// The files that show that a node is alive: its state, the lock for cleaning it up, its
    /// process. In the order in which iceoryx2 removes them.
    pub(super) fn monitor(&self, id: u128) -> [PathBuf; 3] {
        ["", "_owner_lock", "_context"]
            .map(|part| self.nodes.join(format!("{}{id}{}{part}", self.prefix, self.monitor)))
    }
}

/// Names of a folder's entries; none if the folder does not exist.
pub(super) fn entries(folder: &Path) -> impl Iterator<Item = String> {
    let found = fs::read_dir(folder).into_iter().flatten().flatten();
    found.filter_map(|entry| entry.file_name().into_string().ok())
}
