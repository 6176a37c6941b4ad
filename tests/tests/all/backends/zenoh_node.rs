//! A node of ROS 2 over zenoh that was made independently on plain zenoh
//! (`middlewares/ros2/tests/rmw_zenoh.py`), and is the router, too.

use std::process::Command;

use genom_components::peer::Peer;
use genom_components::python;
use genom_tests::{Daemon, Home, repository};
use tempfile::TempDir;

pub(super) struct Node {
    pub(super) peer: Peer,
    router: String,
    _place: TempDir,
}

impl Node {
    pub(super) fn start() -> Self {
        let place = tempfile::tempdir().unwrap();
        let router = format!("unixsock-stream/{}", place.path().join("router").display());
        let environment = python::environment(&["eclipse-zenoh==1.10.2", "xxhash==3.5.0"]).unwrap();
        let mut node = Command::new(environment);
        node.arg(repository().join("middlewares/ros2/tests/rmw_zenoh.py"));
        let peer = Peer::start(node.args([&router, "router"]));
        Self { peer, router, _place: place }
    }

    /// A daemon here that finds it, started by this program, with these arguments.
    #[track_caller]
    pub(super) fn daemon(&self, home: Home, by: &[&str], arguments: &[&str]) -> Daemon {
        let connect = format!("backends.ros2.zenoh.connect=[{:?}]", self.router);
        let options = [
            "backends.ros2.rmw=\"zenoh\"",
            "backends.ros2.domain=0",
            "backends.ros2.namespace=\"\"",
            &connect,
            "backends.ros2.zenoh.listen=[\"tcp/127.0.0.1:0\"]",
        ];
        let set = options.into_iter().flat_map(|one| ["--set", one]);
        home.start_by(by, &set.chain(arguments.iter().copied()).collect::<Vec<_>>())
    }
}
