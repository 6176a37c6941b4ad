//! `[lifecycle]`: components that a node of ROS 2 configures, activates, deactivates and cleans up
//! (ROS 2 design, "Managed nodes").

use genom_components::peer::Peer;
use genom_components::ros2;
use genom_tests::{Daemon, Home, component, path, until};
use serde_json::{Value, json};

/// A daemon whose demo ROS manages, and a node that does so.
struct World {
    daemon: Daemon,
    peer: Peer,
    node: String,
}

/// A deployment with the demo: at half its usual speed, and on its way to 0.5 m while it is active.
fn deployment(component: &str) -> String {
    let demo = genom_tests::component("demo");
    let library = path(&demo.library);
    format!(
        r#"
        backend = "ros2"
        lifecycle.components = ["demo"]
        [[component]]
        library = "{library}"
        {component}
        [[connection]]
        in = "demo/parameter"
        out = "ros2:/hand/gain"
        [[call]]
        component = "demo"
        service = "set_speed"
        inputs = {{ velocity = 0.5 }}
        [[activity]]
        component = "demo"
        service = "goto"
        inputs = {{ goal = 1.5 }}
        "#
    )
}

impl World {
    fn new(text: &str) -> Self {
        let home = Home::new();
        let memory = home.memory();
        let node = format!("/{}/demo", memory.prefix().trim_end_matches('_'));
        let mut ros = ros2::node(memory.domain(), None).unwrap();
        let daemon = home.configured(text).start(&[]);
        let mut peer = Peer::start(&mut ros);
        for (service, ty) in [
            ("change_state", "ChangeState"),
            ("get_state", "GetState"),
            ("get_available_transitions", "GetAvailableTransitions"),
            ("get_transition_graph", "GetAvailableTransitions"),
            ("get_available_states", "GetAvailableStates"),
        ] {
            let ty = format!("lifecycle_msgs/srv/{ty}");
            peer.ask(&json!(["client", format!("{node}/{service}"), ty]));
        }
        Self { daemon, peer, node }
    }

    fn call(&mut self, service: &str, request: &Value) -> Value {
        self.peer.ask(&json!(["call", format!("{}/{service}", self.node), request]))
    }

    /// Asks for a transition by its label; whether it was done.
    fn change(&mut self, label: &str) -> bool {
        let request = json!({"transition": {"id": 0, "label": label}});
        self.call("change_state", &request)["success"].as_bool().expect("whether it succeeded")
    }

    fn state(&mut self) -> String {
        let reply = self.call("get_state", &json!({}));
        reply["current_state"]["label"].as_str().expect("a label").to_owned()
    }

    /// What it can be asked to do now: number and label.
    fn possible(&mut self) -> Vec<(u64, String)> {
        let reply = self.call("get_available_transitions", &json!({}));
        let all = reply["available_transitions"].as_array().expect("a list").iter();
        let one = |one: &Value| {
            let transition = &one["transition"];
            (transition["id"].as_u64().unwrap(), transition["label"].as_str().unwrap().to_owned())
        };
        all.map(one).collect()
    }

    fn runs(&self) -> Vec<Value> {
        let all = self.daemon.home().get("/components/demo/activities");
        let all = all["activities"].as_array().expect("a list").iter();
        all.filter(|one| one["status"] == "running").cloned().collect()
    }

    fn is_loaded(&self) -> bool {
        let all = self.daemon.home().get("/components");
        !all["components"].as_array().expect("a list").is_empty()
    }
}

fn is(possible: &[(u64, String)], wanted: &[(u64, &str)]) -> bool {
    possible.iter().map(|(id, label)| (*id, label.as_str())).eq(wanted.iter().copied())
}

fn goes_through_all_its_states(mut world: World) {
    assert!(!world.is_loaded());
    assert_eq!(world.state(), "unconfigured");
    let possible = world.possible();
    assert!(is(&possible, &[(1, "configure"), (5, "shutdown")]), "{possible:?}");
    // What is not possible changes nothing.
    assert!(!world.change("activate"));
    assert!(!world.change("dance"));
    assert_eq!(world.state(), "unconfigured");

    // It is loaded, called and connected; nothing of the deployment is started.
    let event = format!("{}/transition_event", world.node);
    world.peer.ask(&json!(["read", event, "lifecycle_msgs/msg/TransitionEvent", 1]));
    assert!(world.change("configure"));
    let mut date = 0;
    let mut told = |world: &mut World| {
        // A reader that is known late gets the last event once more.
        let event = loop {
            let event = world.peer.ask(&json!(["sample", event]));
            let dated = event["timestamp"].as_u64().expect("nanoseconds");
            if dated > date {
                date = dated;
                break event;
            }
        };
        let label = |of: &str| event[of]["label"].as_str().unwrap().to_owned();
        [label("transition"), label("start_state"), label("goal_state")]
    };
    assert_eq!(told(&mut world), ["configure", "unconfigured", "configuring"]);
    assert_eq!(told(&mut world), ["transition_success", "configuring", "inactive"]);
    assert_eq!(world.state(), "inactive");
    world.daemon.ctl(&["call", "demo", "get_speed"]).expect_out("velocity = 0.5\n");
    let connections = world.daemon.home().get("/connections");
    assert_eq!(connections["connections"][0]["in"], "demo/parameter", "{connections}");
    assert!(world.runs().is_empty());

    // Asked for by number, as some clients do.
    let by_number = json!({"transition": {"id": 3, "label": ""}});
    assert_eq!(world.call("change_state", &by_number)["success"], true);
    let runs = world.runs();
    assert_eq!((runs.len(), &runs[0]["service"]), (1, &json!("goto")), "{runs:?}");
    let possible = world.possible();
    assert!(is(&possible, &[(4, "deactivate"), (7, "shutdown")]), "{possible:?}");

    // Its activity has braked and stopped when that is answered.
    assert!(world.change("deactivate"));
    assert_eq!(world.state(), "inactive");
    assert!(world.runs().is_empty());
    assert!(world.is_loaded());

    assert!(world.change("cleanup"));
    assert!(!world.is_loaded());
    assert_eq!(world.state(), "unconfigured");

    // And once more, up to the end.
    assert!(world.change("configure"));
    assert!(world.change("activate"));
    assert!(world.change("shutdown"));
    assert!(!world.is_loaded());
    assert_eq!(world.state(), "finalized");
    assert!(world.possible().is_empty());
    assert!(!world.change("configure"));
    world.daemon.stop("TERM").0.expect_code(0);
}

#[test]
fn a_ros_node_leads_a_component_through_the_states_of_a_managed_node() {
    goes_through_all_its_states(World::new(&deployment("")));
}

#[test]
fn a_component_in_a_cell_is_managed_in_the_same_way() {
    goes_through_all_its_states(World::new(&deployment("cell = \"arm\"")));
}

#[test]
fn the_states_and_ways_are_those_of_ros() {
    let mut world = World::new(&deployment(""));
    let states = world.call("get_available_states", &json!({}));
    let states = states["available_states"].as_array().unwrap();
    let known = [
        (1, "unconfigured"),
        (2, "inactive"),
        (3, "active"),
        (4, "finalized"),
        (10, "configuring"),
        (11, "cleaningup"),
        (12, "shuttingdown"),
        (13, "activating"),
        (14, "deactivating"),
    ];
    let known = known.map(|(id, label)| json!({"id": id, "label": label}));
    assert_eq!(states[..], known);
    let graph = world.call("get_transition_graph", &json!({}));
    let graph = graph["available_transitions"].as_array().unwrap();
    let way = json!({
        "transition": {"id": 31, "label": "transition_failure"},
        "start_state": {"id": 13, "label": "activating"},
        "goal_state": {"id": 2, "label": "inactive"},
    });
    assert!(graph.contains(&way), "{graph:?}");
}

#[test]
fn a_component_that_cannot_be_set_up_is_unloaded_again_and_the_log_says_why() {
    let text = deployment("").replace("velocity = 0.5", "velocity = 99.0");
    let mut world = World::new(&text);
    assert!(!world.change("configure"));
    assert_eq!(world.state(), "unconfigured");
    assert!(!world.is_loaded());
    let told = "demo: configure failed: set_speed ended with ::demo::OUT_OF_RANGE";
    assert!(world.daemon.ctl(&["logs"]).out.contains(told));

    // One that starts something which is refused stays inactive, and nothing runs.
    let mut world = World::new(&deployment("").replace("goal = 1.5", "goal = 99.0"));
    assert!(world.change("configure"));
    assert!(!world.change("activate"));
    assert_eq!(world.state(), "inactive");
    assert!(world.runs().is_empty());
}

#[test]
fn what_others_do_with_a_managed_component_is_seen() {
    let mut world = World::new(&deployment(""));
    assert!(world.change("configure"));
    assert!(world.change("activate"));
    world.daemon.ctl(&["unload", "demo"]).expect_code(0);
    assert_eq!(world.state(), "unconfigured");
    let demo = component("demo");
    world.daemon.ctl(&["load", path(&demo.library)]).expect_code(0);
    assert_eq!(world.state(), "inactive");
    assert!(world.change("activate"));
    assert_eq!(world.runs().len(), 1);
}

#[test]
fn requests_that_nobody_can_have_meant_and_many_at_once_harm_nothing() {
    let mut world = World::new(&deployment(""));
    for (id, label) in [(255, ""), (0, "\u{1}"), (5, &*"configure".repeat(1000))] {
        let request = json!({"transition": {"id": id, "label": label}});
        assert_eq!(world.call("change_state", &request)["success"], false);
    }
    // All at once: one of them configures it.
    let change = json!(["burst", format!("{}/change_state", world.node), 40, {
        "transition": {"id": 1, "label": ""},
    }]);
    let replies = world.peer.ask(&change);
    let replies = replies.as_array().unwrap();
    let done = replies.iter().filter(|reply| reply["success"] == true).count();
    assert_eq!(done, 1, "{replies:?}");
    until("it is configured", || world.state() == "inactive");
}

#[test]
fn a_name_that_no_component_has_is_refused_at_the_start() {
    let text = deployment("").replace("components = [\"demo\"]", "components = [\"dmo\"]");
    let refused = Home::new().configured(&text).refused(&[]);
    refused
        .expect_code(2)
        .expect_err("the deployment has no component `dmo`: did you mean `demo`?");
}
