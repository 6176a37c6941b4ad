//! Components made for a test, and supervisors that run them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};

use genom_description::diagnostic::render::human;
use genom_description::{Options, read_files, source};
use genom_description_tools::{Language, header};
use genom_supervisor::components::Hosted;
use genom_supervisor::{LoadRequest, Settings, Supervisor};

/// A directory that is removed after the test.
pub(crate) struct Scratch(tempfile::TempDir);

impl Scratch {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary directory"))
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    /// Builds a component: a header generated from the description, then the C compiler.
    pub(crate) fn component(&self, name: &str, description: &str, codels: &str) -> PathBuf {
        let at = |extension: &str| self.path().join(format!("{name}.{extension}"));
        fs::write(at("gen"), description).expect("a description written");
        let read = read_files(&[at("gen")], &Options::default(), &source::Disk);
        let mistakes = human(&read.diagnostics, &read.sources, false);
        assert!(!read.has_errors(), "{mistakes}");
        let types = header(&read.specification, Some(name), Language::C).expect("a header");
        fs::write(self.path().join(format!("{name}_c_types.h")), types).expect("a header written");
        let include = format!("#include \"{name}_c_types.h\"\n");
        fs::write(at("c"), include + codels).expect("codels written");
        let headers = concat!(env!("CARGO_MANIFEST_DIR"), "/../../plugin-api/include");
        let mut compiler = Command::new("cc");
        compiler.args(["-Wall", "-Wextra", "-Werror", "-fPIC", "-shared", "-I", headers, "-I"]);
        let done = compiler.arg(self.path()).arg(at("c")).arg("-o").arg(at("so")).output();
        let done = done.expect("a C compiler");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        at("so")
    }

    /// A supervisor with its own name space of shared memory.
    pub(crate) fn supervisor(&self) -> Arc<Supervisor> {
        let mut shm = toml::Table::new();
        let prefix = format!("genom_supervising_{}_", std::process::id());
        shm.insert("prefix".to_owned(), prefix.into());
        shm.insert("root".to_owned(), self.path().join("shm").display().to_string().into());
        let backends = BTreeMap::from([("shm".to_owned(), shm)]);
        Supervisor::new(Settings { backends, ..Settings::default() })
    }
}

/// Loads a library.
pub(crate) fn load(supervisor: &Arc<Supervisor>, library: PathBuf) -> Arc<Hosted> {
    let request = LoadRequest { library, ..LoadRequest::default() };
    supervisor.load(&request).unwrap_or_else(|error| panic!("{error}"))
}

/// Waits until `look` returns something, under a watchdog.
#[track_caller]
pub(crate) fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let end = Instant::now() + Duration::from_secs(60);
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(Instant::now() < end, "{what} does not come");
        std::thread::park_timeout(Duration::from_millis(2));
    }
}
