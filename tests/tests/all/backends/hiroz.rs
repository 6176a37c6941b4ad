//! A daemon whose ROS 2 is over zenoh, and a node made with hiroz, an implementation of ROS 2 that is
//! not ours: it computes names, types and hashes of ROS's services itself.

use std::fs;

use genom_components::hiroz;
use genom_components::peer::Peer;
use genom_tests::{Home, component, path};
use serde_json::{Value, json};

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
    let set = peer.ask(&json!(["parameters", "/base", "leg", "velocity", 0.25]));
    assert_eq!(set, json!({"names": ["velocity"], "set": [true], "value": 0.25}));
    daemon.ctl(&["call", "leg", "get_speed"]).expect_out("velocity = 0.25\n");
    let topics = peer.ask(&json!(["topics"]));
    let names: Vec<&Value> = topics.as_array().unwrap().iter().map(|one| &one[0]).collect();
    assert!(names.contains(&&json!("/odom")), "{topics}");
    let actions = peer.ask(&json!(["actions"]));
    assert!(actions.to_string().contains("/base/leg/goto"), "{actions}");
}
