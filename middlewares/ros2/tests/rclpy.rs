//! Our ports, services and activities together with genuine ROS 2 Jazzy nodes.
//!
//! No test assumes that discovery has finished: the peer replies when ROS reports the connection,
//! and what we write before that waits for it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "test code, also outside of test functions")]

mod world;

use std::sync::{Arc, Mutex};

use genom_components::peer::Peer;
use genom_conformance::eventually;
use genom_middleware::{
    ActivityId, Address, Discovery, EndpointKind, Middleware, Outcome, Policy, PortSpec, Ports,
    Reading, Replies, Served, ServiceHandler, ServiceKind, ServiceType, Services,
};
use genom_ros2::{Options, Ros2, ServiceMapping};
use genom_types::{DataType, Kind, Member, Record, ScopedName, TypeTable};
use serde_json::{Map, Value, json};
use world::Domain;

/// A ROS node named `peer`.
fn peer(domain: &Domain) -> Peer {
    let node = genom_components::ros2::node(domain.number().into(), None);
    Peer::start(&mut node.unwrap_or_else(|error| panic!("there is no ROS 2: {error}")))
}

/// `::demo::pose`, with the structure of `geometry_msgs/msg/Pose`.
fn pose() -> DataType {
    let mut table = TypeTable::default();
    let double = table.add(Kind::Double);
    let mut of = |name: &str, members: &[&str]| {
        let member = |name: &&str| Member { name: (*name).to_owned(), ty: double };
        let members = members.iter().map(member).collect();
        table.add(Kind::Struct { name: ScopedName::new(["demo", name]), members })
    };
    let point = of("point", &["x", "y", "z"]);
    let turn = of("turn", &["x", "y", "z", "w"]);
    let member = |name: &str, ty| Member { name: name.to_owned(), ty };
    let id = table.add(Kind::Struct {
        name: ScopedName::new(["demo", "pose"]),
        members: vec![member("position", point), member("orientation", turn)],
    });
    DataType::new(&Arc::new(table), id).unwrap()
}

fn nth_pose(n: f64) -> Value {
    json!({
        "position": {"x": n, "y": n + 0.5, "z": -n},
        "orientation": {"x": 0.0, "y": 0.0, "z": 0.5, "w": 1.0 / n},
    })
}

/// A participant for which `::demo::pose` masquerades as ROS's own type.
fn with_poses(domain: &Domain) -> Arc<Ros2> {
    let pose = ("::demo::pose".to_owned(), "geometry_msgs/msg/Pose".to_owned());
    let options = Options { masquerade: [pose].into(), ..domain.options() };
    Ros2::open(&options).unwrap()
}

#[test]
fn a_ros_node_reads_a_port_as_a_message_of_its_own() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = with_poses(&domain);
    let at = Address::new("demo", "pose");
    let mut writer = ros2.publisher(&PortSpec::new(&at, &pose())).unwrap();
    let mut value = Record::new(&pose());
    value.merge_json(&nth_pose(1.0)).unwrap();
    writer.publish(&value).unwrap();
    let mut peer = peer(&domain);
    peer.ask(&json!(["read", "/demo/pose", "geometry_msgs/msg/Pose"]));
    assert_eq!(peer.ask(&json!(["sample", "/demo/pose"])), nth_pose(1.0), "though it came late");
    for n in 2..20 {
        value.merge_json(&nth_pose(f64::from(n))).unwrap();
        writer.publish(&value).unwrap();
        let sample = peer.ask(&json!(["sample", "/demo/pose"]));
        assert_eq!(sample, nth_pose(f64::from(n)));
    }
    let topics = peer.ask(&json!(["topics"]));
    assert_eq!(topics["/demo/pose"], json!(["geometry_msgs/msg/Pose"]));
    assert_eq!(ros2.obstacles(&at), [], "the hashes of the types are the same");
    drop(writer);
    peer.ask(&json!(["no node", "demo", "/"]));
    // And after everything is closed, no other names either.
    drop(ros2);
    peer.ask(&json!(["no writer", "/demo/pose"]));
}

#[test]
fn a_node_that_means_another_structure_by_the_name_of_a_type_is_told_of() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = domain.open();
    let mut table = TypeTable::default();
    let member = Member { name: "heading".to_owned(), ty: table.add(Kind::Double) };
    let name = ScopedName::new(["geometry_msgs", "pose"]);
    let id = table.add(Kind::Struct { name, members: vec![member] });
    let ty = DataType::new(&Arc::new(table), id).unwrap();
    let at = Address::new("demo", "pose");
    let _writer = ros2.publisher(&PortSpec::new(&at, &ty)).unwrap();
    let mut peer = peer(&domain);
    peer.ask(&json!(["read", "/demo/pose", "geometry_msgs/msg/Pose"]));
    let mut told = Vec::new();
    eventually("it is told", || {
        told = ros2.obstacles(&at);
        !told.is_empty()
    });
    let what = &told[0].what;
    assert!(
        what.starts_with(
            "a reader of demo/pose on ros2 means another structure by geometry_msgs/msg/Pose: \
             RIHS01_"
        ),
        "{what}"
    );
    assert_eq!(told.len(), 1);
}

#[test]
fn a_port_reads_what_a_ros_node_writes() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = with_poses(&domain);
    let at = Address::new("robot", "goal_pose");
    let mut reader = ros2.subscription(&PortSpec::new(&at, &pose()), Policy::Queue(8)).unwrap();
    let mut peer = peer(&domain);
    peer.ask(&json!(["write", "/robot/goal_pose", "geometry_msgs/msg/Pose"]));
    let mut got = Record::new(&pose());
    for n in 1..20 {
        peer.ask(&json!(["put", "/robot/goal_pose", nth_pose(f64::from(n))]));
        eventually("the pose arrives", || reader.read(&mut got).unwrap() == Reading::New);
        assert_eq!(got.to_json(), nth_pose(f64::from(n)));
    }
    assert_eq!(reader.dropped(), 0);
    let listed = ros2.discover().unwrap();
    let listed = listed.iter().any(|end| {
        end.kind == EndpointKind::Publisher
            && (end.address.as_str(), end.ty.as_str())
                == ("robot/goal_pose", "geometry_msgs/msg/Pose")
    });
    assert!(listed, "the node's topic is listed");
}

/// Makes the type of a member.
type Make = fn(&mut TypeTable) -> Kind;

/// A struct of the service with these members.
fn structure(service: &str, part: &str, members: &[(&str, Make)]) -> DataType {
    let mut table = TypeTable::default();
    let members = members.iter().map(|(name, kind)| {
        let kind = kind(&mut table);
        let ty = table.add(kind);
        Member { name: (*name).to_owned(), ty }
    });
    let members = members.collect();
    let name = ScopedName::new(["demo", service, part]);
    let id = table.add(Kind::Struct { name, members });
    DataType::new(&Arc::new(table), id).unwrap()
}

/// The data of a component, by name.
type Ids = Arc<Mutex<Map<String, Value>>>;

/// An attribute with one member, which refuses 13.
struct Attribute {
    ids: Ids,
    ty: ServiceType,
}

impl Attribute {
    fn serve(ros2: &Ros2, ids: &Ids, member: &str, kind: Make) -> [Box<dyn Served>; 2] {
        let value = [(member, kind)];
        ["get", "set"].map(|verb| {
            let name = format!("{verb}_{member}");
            let (input, output): (&[_], &[_]) =
                if verb == "get" { (&[], &value) } else { (&value, &[]) };
            let ty = ServiceType::new(
                ServiceKind::Attribute,
                structure(&name, "input", input),
                structure(&name, "output", output),
            );
            let handler = Arc::new(Self { ids: Arc::clone(ids), ty: ty.clone() });
            ros2.serve(&Address::new("robot", name), &ty, handler).unwrap()
        })
    }
}

impl ServiceHandler for Attribute {
    fn request(&self, input: Record, replies: Box<dyn Replies>) {
        let mut ids = self.ids.lock().unwrap();
        for (name, value) in input.to_json().as_object().into_iter().flatten() {
            if *value == json!(13) {
                let (name, detail) = ("::demo::UNLUCKY".to_owned(), json!({"value": 13}));
                return replies.finish(Outcome::Exception { name, detail });
            }
            ids.insert(name.clone(), value.clone());
        }
        let mut output = Record::new(&self.ty.output);
        if let Some(name) = self.ty.output.member_name(0) {
            output.merge_json(&json!({name: ids[name]})).unwrap();
        }
        replies.finish(Outcome::Success(output));
    }

    fn cancel(&self, _: ActivityId) {}
}

#[test]
fn a_ros_node_gets_and_sets_attributes_as_parameters() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = domain.open();
    let ids = json!({"on": true, "count": -3, "gain": 0.25, "name": "élan", "row": [1, 2]});
    let ids: Ids = Arc::new(Mutex::new(ids.as_object().unwrap().clone()));
    let kinds: [(&str, Make); 5] = [
        ("on", |_| Kind::Boolean),
        ("count", |_| Kind::Short),
        ("gain", |_| Kind::Double),
        ("name", |_| Kind::String { bound: Some(9) }),
        ("row", |table| Kind::Sequence { element: table.add(Kind::Long), bound: None }),
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
fn a_component_that_serves_a_name_of_ros_itself_has_no_parameters() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = domain.open();
    let ids = Ids::default();
    let kind: Make = |_| Kind::Double;
    let _gain = Attribute::serve(&ros2, &ids, "gain", kind);
    let mut peer = peer(&domain);
    peer.ask(&json!(["service", "/robot/list_parameters", "robot", "/"]));
    let _clash = Attribute::serve(&ros2, &ids, "parameters", kind);
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
    let served = Attribute::serve(&ros2, &ids, "use_sim_time", |_| Kind::Boolean);
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

const DESCRIBE: &str = "type_description_interfaces/srv/GetTypeDescription";

/// What node `of` says of a type, without what is known of ROS's own types only where their packages
/// are: defaults and comments.
fn description(peer: &mut Peer, of: &str, name: &str, hash: &str) -> Value {
    let asked = json!({"type_name": name, "type_hash": hash});
    let mut told = peer.ask(&json!(["call", format!("/{of}/get_type_description"), asked]));
    for source in told["type_sources"].as_array_mut().unwrap() {
        source["raw_file_contents"].take();
    }
    told["extra_information"].take();
    let description = &mut told["type_description"];
    let mut all = vec![description["type_description"].take()];
    all.append(description["referenced_type_descriptions"].as_array_mut().unwrap());
    for one in &mut all {
        for field in one["fields"].as_array_mut().unwrap() {
            field["default_value"].take();
        }
    }
    told["type_description"] = all.into();
    told
}

#[test]
fn types_of_ros_are_described_as_a_node_of_ros_describes_them() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = with_poses(&domain);
    let _writer = ros2.publisher(&PortSpec::new(&Address::new("robot", "pose"), &pose())).unwrap();
    let mut peer = peer(&domain);
    peer.ask(&json!(["read", "/robot/pose", "geometry_msgs/msg/Pose"]));
    for node in ["robot", "peer"] {
        peer.ask(&json!(["client", format!("/{node}/get_type_description"), DESCRIBE]));
    }
    // Those of the port, and of the service itself.
    for name in ["geometry_msgs/msg/Pose", DESCRIBE] {
        let by_name = json!({"type_name": name});
        let found = peer.ask(&json!(["call", "/robot/get_type_description", by_name]));
        let hash = &found["extra_information"][0];
        assert_eq!(hash["key"], "type_hash", "{found}");
        let hash = hash["value"].as_str().unwrap();
        let theirs = description(&mut peer, "peer", name, hash);
        assert_eq!(theirs["successful"], true, "{name}: {theirs}");
        assert_eq!(description(&mut peer, "robot", name, hash), theirs, "{name}");
    }
}

#[test]
fn a_component_that_serves_the_name_of_descriptions_itself_describes_no_types() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = domain.open();
    let _own = Attribute::serve(&ros2, &Ids::default(), "type_description", |_| Kind::Double);
    let mut peer = peer(&domain);
    peer.ask(&json!(["parameters", "robot"]));
    let types = peer.ask(&json!(["service", "/robot/get_type_description", "robot", "/"]));
    assert_eq!(types, json!(["demo/srv/GetTypeDescription"]));
}
