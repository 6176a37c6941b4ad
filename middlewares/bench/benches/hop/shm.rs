//! Shared memory: bare iceoryx2, and the backend on it.

use std::path::Path;

use genom_bench::iceoryx::Bare;
use genom_bench::pair::{Receive, Send};
use genom_middleware::Middleware;
use genom_shm::{Options, Shm};

use crate::Backend;

pub(crate) struct Both {
    ours: Shm,
    bare: Bare,
}

impl Both {
    /// Both processes use the same folder, which nothing else uses.
    pub(crate) fn open(place: &Path) -> Self {
        let name = place.file_name().unwrap_or_default().to_string_lossy().replace('.', "");
        let root = place.join("ours");
        let prefix = Some(format!("bench{name}_"));
        let ours = Shm::open(Options { prefix, root: Some(root), ..Options::default() }).unwrap();
        Self { ours, bare: Bare::open(place) }
    }
}

impl Backend for Both {
    fn writer(&self, bytes: usize) -> Box<dyn Send> {
        self.bare.writer(bytes)
    }

    fn reader(&self, bytes: usize) -> Box<dyn Receive> {
        self.bare.reader(bytes)
    }

    fn ours(&self) -> &dyn Middleware {
        &self.ours
    }
}
