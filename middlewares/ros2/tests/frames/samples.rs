//! Ports for frames, and frames as a port has them and as tf2 gets them.

use std::sync::Arc;

use genom_middleware::{Address, Middleware as _, PortSpec, Ports as _, Publisher, Quality};
use genom_ros2::{Options, Ros2};
use genom_types::{DataType, Kind, Member, Record, ScopedName, TypeId, TypeTable};
use serde_json::{Value, json};

pub(super) const TF: &str = "tf2_msgs/msg/TFMessage";

/// `::arm::frames`
pub(super) fn frames() -> DataType {
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

/// Out ports of a component `arm`.
pub(super) struct Arm {
    /// On `/tf`.
    pub(super) moving: Box<dyn Publisher>,
    /// On `/tf_static`, of which a late reader gets the last sample.
    pub(super) fixed: Box<dyn Publisher>,
}

impl Arm {
    pub(super) fn open(options: Options) -> Self {
        let masquerade = [("::arm::frames".to_owned(), TF.to_owned())].into();
        let ros2 = Ros2::open(&Options { masquerade, ..options }).unwrap();
        let port = |name: &str, topic: &str, latched: bool| {
            ros2.masquerade(&format!("arm/{name}"), topic).unwrap();
            let quality =
                Quality { transient_local: latched.then_some(true), ..Quality::default() };
            let (at, ty) = (Address::new("arm", name), frames());
            ros2.publisher(&PortSpec::new(&at, &ty).of(quality)).unwrap()
        };
        Self { moving: port("moving", "/tf", false), fixed: port("fixed", "/tf_static", true) }
    }
}

pub(super) fn write(writer: &mut dyn Publisher, parent: &str, name: &str, x: f64) {
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
pub(super) fn told(parent: &str, name: &str, x: f64) -> Value {
    let rotation = json!({"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0});
    json!({"transforms": [{
        "header": {"stamp": {"sec": 7, "nanosec": 5}, "frame_id": parent},
        "child_frame_id": name,
        "transform": {"translation": {"x": x, "y": 0.0, "z": 0.0}, "rotation": rotation},
    }]})
}
