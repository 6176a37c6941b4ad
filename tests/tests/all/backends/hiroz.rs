//! A daemon whose ROS 2 is over zenoh, and a node made with hiroz, an implementation of ROS 2 that is
//! not ours: it computes names, types and hashes of ROS's services itself.

mod daemons;
mod runs;
mod tells;

use std::fs;

use genom_components::hiroz;
use genom_components::peer::Peer;
use genom_tests::{Home, component, path, until};
use serde_json::json;

/// A home whose ROS 2 is over zenoh, and the endpoint of its router.
fn over_zenoh(text: &str) -> (Home, String) {
    let home = Home::new().configured(text);
    let file = home.path().join("genomd.toml");
    let router = format!("unixsock-stream/{}", home.memory().root().join("router").display());
    let section = "[backends.ros2]\n";
    let zenoh = format!("{section}rmw = \"zenoh\"\nzenoh = {{ connect = [{router:?}] }}\n");
    let own = fs::read_to_string(&file).unwrap();
    fs::write(file, own.replace(section, &zenoh)).unwrap();
    (home, router)
}

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn hiroz_sees_components_by_their_names_and_sets_a_parameter() {
    let demo = component("demo");
    let library = path(&demo.library);
    let (home, router) = over_zenoh(&format!(
        r#"
        backend = "ros2"
        [[component]]
        library = "{library}"
        name = "arm"
        [[component]]
        library = "{library}"
        name = "leg"
        remap = ["__ns:=/base", "position:=/odom"]
        "#
    ));
    let prefix = home.memory().prefix().trim_end_matches('_').to_owned();
    let domain = home.memory().domain().to_string();
    let daemon = home.start(&[]);
    let mut node = hiroz::node(&router).unwrap();
    let mut peer = Peer::start(node.env("ROS_DOMAIN_ID", domain));
    let arm = format!("/{prefix}/arm");
    assert_eq!(peer.ask(&json!(["nodes", arm])), true);
    assert_eq!(peer.ask(&json!(["nodes", "/base/leg"])), true);
    let set = peer.ask(&json!(["parameters", "/base", "leg", "velocity", [0.25]]));
    assert_eq!((&set["set"], &set["value"]), (&json!([[true, ""]]), &json!(0.25)));
    daemon.ctl(&["call", "leg", "get_speed"]).expect_out("velocity = 0.25\n");
    // Each end is told by itself.
    for (kind, name) in [("topics", "/odom"), ("actions", "/base/leg/goto")] {
        until(name, || {
            let listed = peer.ask(&json!([kind]));
            listed.as_array().unwrap().iter().any(|one| one[0] == name)
        });
    }
}

/// A service of managed nodes, and the hash that ROS 2 Jazzy publishes for its type. hiroz has a
/// client for managed nodes, too, but with hashes that no ROS has.
struct Managed(&'static str, &'static str, &'static str);

const CHANGE: Managed = Managed(
    "change_state",
    "lifecycle_msgs::srv::dds_::ChangeState_",
    "RIHS01_356fe34f0475a43acf54542013af4167b0e729f77ea22ffb045c6ad8e20668e5",
);
const GET: Managed = Managed(
    "get_state",
    "lifecycle_msgs::srv::dds_::GetState_",
    "RIHS01_800a0a5aae599782b02932de0caf563f6dc4e7e94b794eadde075ba2cbef9795",
);

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn hiroz_configures_activates_and_cleans_up_a_managed_component() {
    let demo = component("demo");
    let (home, router) = over_zenoh(&format!(
        r#"
        backend = "ros2"
        lifecycle.components = ["arm"]
        [[component]]
        library = "{}"
        name = "arm"
        "#,
        path(&demo.library)
    ));
    let domain = home.memory().domain().to_string();
    let node = format!("/{}/arm", home.memory().prefix().trim_end_matches('_'));
    let _daemon = home.start(&[]);
    let mut hiroz = hiroz::node(&router).unwrap();
    let mut peer = Peer::start(hiroz.env("ROS_DOMAIN_ID", domain));
    for Managed(name, ty, hash) in [CHANGE, GET] {
        let there = peer.ask(&json!(["client", format!("{node}/{name}"), ty, hash]));
        assert_eq!(there, true, "{name}");
    }
    let events = format!("{node}/transition_event");
    let told = peer.ask(&json!(["learn", events, true]));
    assert_eq!(told["type"], "lifecycle_msgs/msg/TransitionEvent");
    assert_eq!(told["told"], told["hash"], "hiroz computes the same hash of its description");
    // Numbers of `lifecycle_msgs/msg/Transition` and `State`.
    for (transition, state) in [(1, 2), (3, 3), (4, 2), (2, 1)] {
        // CDR: the number, three bytes to the next multiple of four, an empty label.
        let request = format!("00010000{transition:02x}0000000100000000");
        let changed = peer.ask(&json!(["call", format!("{node}/change_state"), request]));
        assert_eq!(changed, "0001000001", "{transition}");
        let now = peer.ask(&json!(["call", format!("{node}/get_state"), "0001000000"]));
        let now = now.as_str().unwrap();
        assert!(now.starts_with(&format!("00010000{state:02x}")), "{transition}: {now}");
        // Its begin is told, too.
        while peer.ask(&json!(["learned", events]))["goal_state"]["id"] != state {}
    }
}
