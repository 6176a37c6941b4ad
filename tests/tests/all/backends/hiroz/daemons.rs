//! A node made with hiroz that is the router, too, and a daemon that finds it.

use genom_components::hiroz;
use genom_components::peer::Peer;
use genom_tests::{Daemon, Home, component, path};
use serde_json::json;
use tempfile::TempDir;

pub(super) struct World {
    pub(super) daemon: Daemon,
    pub(super) peer: Peer,
    /// Of all that the daemon has.
    pub(super) namespace: String,
    _place: TempDir,
}

impl World {
    /// A node in the namespace `/lab`, and a daemon with this configuration and these arguments.
    pub(super) fn new(configuration: &str, arguments: &[&str]) -> Self {
        let place = tempfile::tempdir().unwrap();
        let router = format!("unixsock-stream/{}", place.path().join("router").display());
        let home = Home::new().configured(configuration);
        let namespace = format!("/{}", home.memory().prefix().trim_end_matches('_'));
        let mut node = hiroz::node(&router).unwrap();
        let node = node.args(["router", "/lab"]);
        let peer = Peer::start(node.env("ROS_DOMAIN_ID", home.memory().domain().to_string()));
        let found = format!("backends.ros2.zenoh.connect=[{router:?}]");
        let set = ["--set", "backends.ros2.rmw=\"zenoh\"", "--set", &found];
        // A lease of an hour: that a daemon has ended shows by its connection, or not at all here.
        let by = ["env", "ZENOH_CONFIG_OVERRIDE=transport/link/tx/lease=3600000"];
        let daemon = home.start_by(&by, &[&set, arguments].concat());
        Self { daemon, peer, namespace, _place: place }
    }

    /// With the demo on ROS 2, and these options.
    pub(super) fn demo(options: &[&str]) -> Self {
        let demo = component("demo");
        Self::new("", &[&["--backend", "ros2"], options, &[path(&demo.library)]].concat())
    }

    /// The name of what the demo has.
    pub(super) fn of_demo(&self, what: &str) -> String {
        format!("{}/demo/{what}", self.namespace)
    }
}

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn hiroz_lists_a_killed_daemon_no_more_though_a_gateway_had_its_session() {
    let mut world = World::demo(&[]);
    let (node, position) = (format!("{}/demo", world.namespace), world.of_demo("position"));
    assert_eq!(world.peer.ask(&json!(["nodes", node])), true);
    assert_eq!(world.peer.ask(&json!(["topic", position])), true);
    let (_, _home) = world.daemon.stop("KILL");
    assert_eq!(world.peer.ask(&json!(["no node", node])), false);
    assert_eq!(world.peer.ask(&json!(["no topic", position])), false);
    let set_speed = format!("{node}/set_speed");
    assert_eq!(world.peer.ask(&json!(["no service", set_speed])), false);
}
