//! A node of ROS 2 over zenoh that was made independently on plain zenoh
//! (`middlewares/ros2/tests/rmw_zenoh.py`), and is the router, too.

use std::process::Command;

use genom_components::peer::Peer;
use genom_components::python;
use genom_tests::repository;
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

    /// Options of a daemon that finds it, and these.
    pub(super) fn options(&self, more: &[&str]) -> Vec<String> {
        let of_ros2 = [
            "rmw=\"zenoh\"".to_owned(),
            "domain=0".to_owned(),
            "namespace=\"\"".to_owned(),
            format!("zenoh.connect=[{:?}]", self.router),
            "zenoh.listen=[\"tcp/127.0.0.1:0\"]".to_owned(),
        ];
        let set =
            of_ros2.iter().flat_map(|one| ["--set".to_owned(), format!("backends.ros2.{one}")]);
        set.chain(more.iter().map(|&word| word.to_owned())).collect()
    }
}
