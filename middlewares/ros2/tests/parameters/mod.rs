//! Parameters of nodes: attributes, and whether time is that of a simulator.

mod attribute;

use std::sync::Mutex;

pub(super) use attribute::{Attribute, Ids};
use genom_middleware::Middleware;
use serde_json::Map;

use super::*;
use crate::services::{BOOLEAN, DOUBLE, LONGS, Make, SHORT};

#[test]
fn a_ros_node_gets_and_sets_attributes_as_parameters() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = domain.open();
    let ids = json!({"on": true, "count": -3, "gain": 0.25, "name": "élan", "row": [1, 2]});
    let ids: Ids = Arc::new(Mutex::new(ids.as_object().unwrap().clone()));
    let kinds: [(&str, Make); 5] = [
        ("on", BOOLEAN),
        ("count", SHORT),
        ("gain", DOUBLE),
        ("name", |table| table.add(Kind::String { bound: Some(9) })),
        ("row", LONGS),
    ];
    let serve = |&(name, kind): &(&str, Make)| Attribute::serve(&ros2, &ids, name, kind);
    let mut served: Vec<_> = kinds.iter().flat_map(serve).collect();
    let mut peer = peer(&domain);
    peer.ask(&json!(["parameters", "robot"]));
    let names = json!(["on", "count", "gain", "name", "row", "gian"]);
    assert_eq!(
        peer.ask(&json!(["list", "robot"])),
        json!({"names": ["count", "gain", "name", "on", "row", "use_sim_time"], "prefixes": []})
    );
    assert_eq!(
        peer.ask(&json!(["get", "robot", names])),
        json!([true, -3, 0.25, "élan", [1, 2], null])
    );
    assert_eq!(
        peer.ask(&json!(["types", "robot", names])),
        json!(["BOOL", "INTEGER", "DOUBLE", "STRING", "INTEGER_ARRAY", "NOT_SET"])
    );
    // Set one after the other: a refused one does not affect the rest.
    let wanted = json!([
        ["on", false],
        ["count", 70000],
        ["gain", 2],
        ["gain", 1.5],
        ["name", "too long a name"],
        ["row", [3, 4, 5]],
        ["gian", 1.0],
        ["count", 13],
        ["count", 12],
    ]);
    let results = peer.ask(&json!(["set", "robot", wanted]));
    let reasons: Vec<_> = results
        .as_array()
        .unwrap()
        .iter()
        .map(|result| match result["successful"] == json!(true) {
            true => "",
            false => result["reason"].as_str().unwrap(),
        })
        .collect();
    assert_eq!(
        reasons,
        [
            "",
            "count: 70000 is out of range for short, which goes from -32768 to 32767",
            "it is of type double, not integer",
            "",
            "name: 15 bytes are too many for string<9>, which takes at most 8",
            "",
            "there is no parameter `gian`",
            "::demo::UNLUCKY {\"value\":13}",
            "",
        ]
    );
    assert_eq!(
        Value::Object(ids.lock().unwrap().clone()),
        json!({"on": false, "count": 12, "gain": 1.5, "name": "élan", "row": [3, 4, 5]})
    );
    let atomically = |values: Value| json!(["set", "robot", values, true]);
    assert_eq!(peer.ask(&atomically(json!([["gain", -1.0]])))["successful"], json!(true));
    assert_eq!(ids.lock().unwrap()["gain"], json!(-1.0));
    let refused = peer.ask(&atomically(json!([["gain", 0.0], ["count", 0]])));
    assert_eq!(refused["reason"], "attributes are set one by one: use set_parameters");
    assert_eq!(ids.lock().unwrap()["gain"], json!(-1.0));

    // Without its setter a parameter is read-only.
    drop(served.remove(3));
    let described = peer.ask(&json!(["describe", "robot", ["count", "name", "gian"]]));
    assert_eq!(
        described[0],
        json!({
            "name": "count",
            "type": 2,
            "description": "read by attribute get_count",
            "additional_constraints": "",
            "read_only": true,
            "dynamic_typing": false,
            "floating_point_range": [],
            "integer_range": [{"from_value": -32768, "to_value": 32767, "step": 1}],
        })
    );
    let name = &described[1];
    assert_eq!(name["description"], "read by attribute get_name, set by attribute set_name");
    assert_eq!(name["additional_constraints"], "at most 8 bytes");
    assert_eq!((&name["type"], &name["read_only"]), (&json!(4), &json!(false)));
    assert_eq!(described[2]["name"], "");
    let results = peer.ask(&json!(["set", "robot", [["count", 1]]]));
    assert_eq!(results, json!([{"successful": false, "reason": "`count` can only be read"}]));
    let types = peer.ask(&json!(["service", "/robot/get_parameters", "robot", "/"]));
    assert_eq!(types, json!(["rcl_interfaces/srv/GetParameters"]));

    // The services, and the node, are removed with the last attribute.
    served.clear();
    peer.ask(&json!(["no node", "robot", "/"]));
}

#[test]
fn what_was_dumped_of_a_node_is_loaded_into_it_again() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = domain.open();
    let before = json!({"gain": 0.25, "row": [1, 2]}).as_object().unwrap().clone();
    let ids: Ids = Arc::new(Mutex::new(before.clone()));
    let _served = [("gain", DOUBLE), ("row", LONGS)]
        .map(|(name, kind)| Attribute::serve(&ros2, &ids, name, kind));
    let mut peer = peer(&domain);
    peer.ask(&json!(["parameters", "robot"]));
    // As `ros2 param dump` and `ros2 param load` do: all that is listed, with `use_sim_time`.
    let dump = dumped(&mut peer, "robot");
    assert_eq!(dump, json!([["gain", "row", "use_sim_time"], [0.25, [1, 2], false]]));
    let changed = json!({"gain": 7.0, "row": []});
    ids.lock().unwrap().clone_from(changed.as_object().unwrap());
    let (names, values) = (dump[0].as_array().unwrap(), dump[1].as_array().unwrap());
    let wanted: Vec<_> =
        names.iter().zip(values).map(|(name, value)| json!([name, value])).collect();
    let results = peer.ask(&json!(["set", "robot", wanted]));
    let loaded = json!({"successful": true, "reason": ""});
    assert_eq!(results, json!([loaded, loaded, loaded]));
    assert_eq!(*ids.lock().unwrap(), before);
}

#[test]
fn a_component_that_serves_a_name_of_ros_itself_has_no_parameters() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = domain.open();
    let ids = Ids::default();
    let _gain = Attribute::serve(&ros2, &ids, "gain", DOUBLE);
    let mut peer = peer(&domain);
    peer.ask(&json!(["service", "/robot/list_parameters", "robot", "/"]));
    let _clash = Attribute::serve(&ros2, &ids, "parameters", DOUBLE);
    peer.ask(&json!(["no service", "/robot/list_parameters", "robot", "/"]));
}

/// What `ros2 param dump` writes of a node: all that it lists.
fn dumped(peer: &mut Peer, node: &str) -> Value {
    let names = peer.ask(&json!(["list", node]))["names"].clone();
    let values = peer.ask(&json!(["get", node, names]));
    json!([names, values])
}

#[test]
fn every_node_says_in_use_sim_time_whether_its_time_is_that_of_a_simulator() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let mut peer = peer(&domain);
    for (node, simulated) in [("own", false), ("simulated", true)] {
        let ros2 = domain.open();
        if simulated {
            ros2.simulated_time();
        }
        // A port makes a node, as an attribute does.
        let _writer = ros2.publisher(&PortSpec::new(&Address::new(node, "pose"), &pose())).unwrap();
        peer.ask(&json!(["parameters", node]));
        assert_eq!(dumped(&mut peer, node), json!([["use_sim_time"], [simulated]]));
        assert_eq!(peer.ask(&json!(["types", node, ["use_sim_time"]])), json!(["BOOL"]));
        let described = &peer.ask(&json!(["describe", node, ["use_sim_time"]]))[0];
        assert_eq!(
            (&described["name"], &described["type"], &described["read_only"]),
            (&json!("use_sim_time"), &json!(1), &json!(true))
        );
        let wanted =
            json!([["use_sim_time", simulated], ["use_sim_time", !simulated], ["use_sim_time", 1]]);
        let results = peer.ask(&json!(["set", node, wanted]));
        assert_eq!(results[0], json!({"successful": true, "reason": ""}));
        let why = results[1]["reason"].as_str().unwrap();
        let clock = if simulated { "--clock monotonic" } else { "--clock ros" };
        assert!(why.contains("that of the daemon") && why.contains(clock), "{why}");
        assert_eq!(results[2]["reason"], "it is of type bool, not integer");
        assert_eq!(dumped(&mut peer, node), json!([["use_sim_time"], [simulated]]));
    }
}

#[test]
fn a_parameter_use_sim_time_that_a_component_has_itself_is_shown_instead() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = domain.open();
    let ids: Ids = Arc::new(Mutex::new(Map::from_iter([("use_sim_time".into(), json!(true))])));
    let served = Attribute::serve(&ros2, &ids, "use_sim_time", BOOLEAN);
    let mut peer = peer(&domain);
    peer.ask(&json!(["parameters", "robot"]));
    assert_eq!(dumped(&mut peer, "robot"), json!([["use_sim_time"], [true]]));
    let results = peer.ask(&json!(["set", "robot", [["use_sim_time", false]]]));
    assert_eq!(results[0]["successful"], true);
    assert_eq!(ids.lock().unwrap()["use_sim_time"], json!(false));
    // Where something else of the component remains, so does the node, with the clock that it has.
    let _writer = ros2.publisher(&PortSpec::new(&Address::new("robot", "pose"), &pose())).unwrap();
    drop(served);
    let described = peer.ask(&json!(["describe", "robot", ["use_sim_time"]]));
    assert_eq!(described[0]["description"], "whether components live in the time of /clock");
}
