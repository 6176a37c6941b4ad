//! Frames for tf2: ports of the type `frames` of `docs/ros2.md`, on `/tf` and `/tf_static`.

use std::path::Path;

use genom_middleware::{Middleware, Publisher, Quality};
use genom_types::TypeId;

use super::*;

const TF: &str = "tf2_msgs/msg/TFMessage";

/// `::arm::frames`
fn frames() -> DataType {
    let mut table = TypeTable::default();
    let (double, text) = (table.add(Kind::Double), table.add(Kind::String { bound: Some(64) }));
    let (long, ulong) = (table.add(Kind::Long), table.add(Kind::UnsignedLong));
    let mut of = |name: &str, members: &[(&str, TypeId)]| {
        let member = |&(name, ty): &(&str, TypeId)| Member { name: name.to_owned(), ty };
        let members = members.iter().map(member).collect();
        table.add(Kind::Struct { name: ScopedName::new(["arm", name]), members })
    };
    let time = of("time", &[("sec", long), ("nanosec", ulong)]);
    let offset = of("offset", &[("x", double), ("y", double), ("z", double)]);
    let turn = of("turn", &[("x", double), ("y", double), ("z", double), ("w", double)]);
    let members = [("stamp", time), ("parent", text), ("name", text)];
    let frame = of("frame", &[&members[..], &[("offset", offset), ("turn", turn)]].concat());
    let all = table.add(Kind::Sequence { element: frame, bound: Some(16) });
    let member = Member { name: "all".to_owned(), ty: all };
    let name = ScopedName::new(["arm", "frames"]);
    let id = table.add(Kind::Struct { name, members: vec![member] });
    DataType::new(&Arc::new(table), id).unwrap()
}

fn write(writer: &mut dyn Publisher, parent: &str, name: &str, x: f64) {
    let frame = json!({
        "stamp": {"sec": 7, "nanosec": 5},
        "parent": parent,
        "name": name,
        "offset": {"x": x},
        "turn": {"w": 1.0},
    });
    let mut record = Record::new(&frames());
    record.merge_json(&json!({ "all": [frame] })).unwrap();
    writer.publish(&record).unwrap();
}

/// What tf2 gets of that.
fn told(parent: &str, name: &str, x: f64) -> Value {
    let rotation = json!({"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0});
    json!({"transforms": [{
        "header": {"stamp": {"sec": 7, "nanosec": 5}, "frame_id": parent},
        "child_frame_id": name,
        "transform": {"translation": {"x": x, "y": 0.0, "z": 0.0}, "rotation": rotation},
    }]})
}

#[test]
fn tf2_gets_the_frames_of_a_component_and_the_static_ones_though_it_comes_late() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let masquerade = [("::arm::frames".to_owned(), TF.to_owned())].into();
    let ros2 = Ros2::open(&Options { masquerade, ..domain.options() }).unwrap();
    ros2.masquerade("arm/moving", "/tf").unwrap();
    ros2.masquerade("arm/fixed", "/tf_static").unwrap();
    let (moving, fixed) = (Address::new("arm", "moving"), Address::new("arm", "fixed"));
    let ty = frames();
    let mut moving = ros2.publisher(&PortSpec::new(&moving, &ty)).unwrap();
    let latched = Quality { transient_local: Some(true), ..Quality::default() };
    let mut fixed = ros2.publisher(&PortSpec::new(&fixed, &ty).of(latched)).unwrap();
    write(&mut *fixed, "base", "camera", 0.25);

    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let package = package.join("../../components/build/ros2/tf2_msgs").canonicalize().unwrap();
    let types = genom_components::ros2::types(&package).unwrap();
    let mut node = genom_components::ros2::node(domain.number().into(), Some(&types)).unwrap();
    let mut peer = Peer::start(&mut node);
    // With the quality of service of tf2's own listener.
    peer.ask(&json!(["read", "/tf_static", TF, 1, true]));
    assert_eq!(peer.ask(&json!(["sample", "/tf_static"])), told("base", "camera", 0.25));
    write(&mut *moving, "base", "hand", 1.0);
    peer.ask(&json!(["read", "/tf", TF]));
    assert_eq!(peer.ask(&json!(["sample", "/tf"])), told("base", "hand", 1.0));
    for n in 2..5 {
        write(&mut *moving, "base", "hand", f64::from(n));
        assert_eq!(peer.ask(&json!(["sample", "/tf"])), told("base", "hand", f64::from(n)));
    }
}
