//! A separate root folder and prefix for each test.

#![allow(
    dead_code,
    clippy::expect_used,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "test code; each binary uses its part"
)]

pub(crate) mod process;
pub(crate) mod writer;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use genom_conformance::World;
use genom_middleware::Middleware;
use genom_shm::{Options, Shm};

/// Isolated from all other tests on this machine.
pub(crate) struct ShmWorld {
    root: PathBuf,
    prefix: String,
}

impl ShmWorld {
    pub(crate) fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("genomtest_{}_{count}_", std::process::id());
        Self { root: std::env::temp_dir().join(&name), prefix: name }
    }

    pub(crate) fn options(&self) -> Options {
        Options {
            prefix: Some(self.prefix.clone()),
            root: Some(self.root.clone()),
            ..Options::default()
        }
    }

    pub(crate) fn open(&self) -> Shm {
        Shm::open(self.options()).expect("shared memory")
    }

    pub(crate) fn prefix(&self) -> &str {
        &self.prefix
    }

    pub(crate) fn root(&self) -> &Path {
        &self.root
    }
}

impl World for ShmWorld {
    fn join(&self) -> Arc<dyn Middleware> {
        Arc::new(self.open())
    }

    fn leftovers(&self) -> Vec<String> {
        let mut found = Vec::new();
        files(&self.root, &mut found);
        let shared = Path::new("/dev/shm").read_dir().into_iter().flatten().flatten();
        let shared = shared.map(|file| file.path().display().to_string());
        found.extend(shared.filter(|name| name.contains(&self.prefix)));
        // The 16 bytes in which iceoryx2 counts nodes. There is one counter for all processes of a
        // prefix; it is never removed, since somebody may be about to use it.
        found.retain(|name| !name.ends_with(".global_mgmt"));
        found
    }
}

impl Drop for ShmWorld {
    fn drop(&mut self) {
        for file in Path::new("/dev/shm").read_dir().into_iter().flatten().flatten() {
            if file.file_name().to_string_lossy().starts_with(&self.prefix) {
                let _ = std::fs::remove_file(file.path());
            }
        }
        let _ = std::fs::remove_dir_all(&self.root);
    }
}

/// All files below a folder.
fn files(folder: &Path, found: &mut Vec<String>) {
    for entry in folder.read_dir().into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            files(&path, found);
        } else {
            found.push(path.display().to_string());
        }
    }
}
