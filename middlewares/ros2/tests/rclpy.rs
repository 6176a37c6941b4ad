//! Our ports, services and activities together with genuine ROS 2 Jazzy nodes.
//!
//! No test assumes that discovery has finished: the peer replies when ROS reports the connection,
//! and what we write before that waits for it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "test code, also outside of test functions")]

mod frames;
mod parameters;
#[path = "world/services.rs"]
mod services;
mod world;

use std::sync::Arc;

use genom_components::peer::Peer;
use genom_conformance::eventually;
use genom_middleware::{Address, Discovery, EndpointKind, Policy, PortSpec, Ports, Reading};
use genom_ros2::{Options, Ros2, ServiceMapping};
use genom_types::{DataType, Kind, Member, Record, ScopedName, TypeTable};
use parameters::{Attribute, Ids};
use serde_json::{Value, json};
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

/// `::camera::image`, with the structure of `std_msgs/msg/UInt8MultiArray`.
fn image() -> DataType {
    let mut table = TypeTable::default();
    let member = |name: &str, ty| Member { name: name.to_owned(), ty };
    let (octet, number) = (table.add(Kind::Octet), table.add(Kind::UnsignedLong));
    let text = table.add(Kind::String { bound: None });
    let mut of = |name: &str, members| {
        table.add(Kind::Struct { name: ScopedName::new(["camera", name]), members })
    };
    let side =
        of("side", vec![member("label", text), member("size", number), member("stride", number)]);
    let sides = table.add(Kind::Sequence { element: side, bound: None });
    let data = table.add(Kind::Sequence { element: octet, bound: None });
    let mut of = |name: &str, members| {
        table.add(Kind::Struct { name: ScopedName::new(["camera", name]), members })
    };
    let layout = of("layout", vec![member("dim", sides), member("data_offset", number)]);
    let id = of("image", vec![member("layout", layout), member("data", data)]);
    DataType::new(&Arc::new(table), id).unwrap()
}

/// More than the buffer of its socket has room for, unless its user gives it another one: it loses
/// parts, and is sent them again.
#[test]
fn images_of_6_mb_reach_a_ros_node_whole_and_in_order() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let as_bytes = ("::camera::image".to_owned(), "std_msgs/msg/UInt8MultiArray".to_owned());
    let options = Options { masquerade: [as_bytes].into(), ..domain.options() };
    let ros2 = Ros2::open(&options).unwrap();
    let at = Address::new("camera", "image");
    let mut writer = ros2.publisher(&PortSpec::new(&at, &image())).unwrap();
    let mut peer = peer(&domain);
    let mut value = Record::new(&image());
    for n in 0_u8..4 {
        let mut octets = (0..=250).collect::<Vec<u8>>().repeat(24_000);
        octets.rotate_left(n.into());
        // No dimension, no offset, and the octets after their number.
        let length = u32::try_from(octets.len()).unwrap();
        let cdr = [&[0; 8][..], &length.to_le_bytes(), &octets].concat();
        value.decode_cdr(&cdr).unwrap();
        writer.publish(&value).unwrap();
        if n == 0 {
            // What is written while they meet may come twice.
            peer.ask(&json!(["read", "/camera/image", "std_msgs/msg/UInt8MultiArray"]));
        }
        let sum: u64 = (0_u64..).zip(&octets).map(|(place, octet)| place * u64::from(*octet)).sum();
        let came = peer.ask(&json!(["digest", "/camera/image"]));
        assert_eq!(came, json!([octets.len(), sum]));
    }
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
    let listed = || {
        ros2.discover().unwrap().iter().any(|end| {
            end.kind == EndpointKind::Publisher
                && (end.address.as_str(), end.ty.as_str())
                    == ("robot/goal_pose", "geometry_msgs/msg/Pose")
        })
    };
    assert!(listed(), "the node's topic is listed");
    peer.ask(&json!(["close", "/robot/goal_pose"]));
    eventually("it is gone from the list when it is closed", || !listed());
}

/// Participants of Fast DDS with this file count as gone after a second, not after 20.
const SHORT_LEASE: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<profiles xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles">
  <participant profile_name="short" is_default_profile="true"><rtps><builtin><discovery_config>
    <leaseDuration><sec>1</sec></leaseDuration>
    <leaseAnnouncement><nanosec>200000000</nanosec></leaseAnnouncement>
  </discovery_config></builtin></rtps></participant>
</profiles>"#;

#[test]
fn what_a_killed_ros_node_wrote_is_gone_from_the_list_when_its_lease_is_over() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = with_poses(&domain);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("short.xml");
    std::fs::write(&file, SHORT_LEASE).unwrap();
    let mut node = genom_components::ros2::node(domain.number().into(), None).unwrap();
    let mut peer = Peer::start(node.env("FASTRTPS_DEFAULT_PROFILES_FILE", file));
    peer.ask(&json!(["write", "/robot/pose", "geometry_msgs/msg/Pose", true]));
    let listed = || ros2.discover().unwrap().iter().any(|end| end.address.as_str() == "robot/pose");
    eventually("the node's topic is listed", listed);
    // Killed.
    drop(peer);
    eventually("it is gone", || !listed());
}

#[test]
fn a_port_that_comes_late_gets_what_a_latched_writer_of_a_ros_node_wrote_last() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let mut peer = peer(&domain);
    peer.ask(&json!(["write", "/robot/map_pose", "geometry_msgs/msg/Pose", true]));
    for n in 1..4 {
        peer.ask(&json!(["put", "/robot/map_pose", nth_pose(f64::from(n))]));
    }
    let ros2 = with_poses(&domain);
    let at = Address::new("robot", "map_pose");
    let mut reader = ros2.subscription(&PortSpec::new(&at, &pose()), Policy::Queue(8)).unwrap();
    let mut got = Record::new(&pose());
    eventually("the last pose arrives", || reader.read(&mut got).unwrap() == Reading::New);
    assert_eq!(got.to_json(), nth_pose(3.0), "nothing before it");
    peer.ask(&json!(["put", "/robot/map_pose", nth_pose(4.0)]));
    eventually("the next one arrives", || reader.read(&mut got).unwrap() == Reading::New);
    assert_eq!((got.to_json(), reader.dropped()), (nth_pose(4.0), 0));
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
    let _own = Attribute::serve(&ros2, &Ids::default(), "type_description", services::DOUBLE);
    let mut peer = peer(&domain);
    peer.ask(&json!(["parameters", "robot"]));
    let types = peer.ask(&json!(["service", "/robot/get_type_description", "robot", "/"]));
    assert_eq!(types, json!(["demo/srv/GetTypeDescription"]));
}
