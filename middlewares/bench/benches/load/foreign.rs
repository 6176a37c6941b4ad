//! Images between ports and a node of ROS 2 that is none of genomd's: rclpy on Fast DDS
//! (`foreign.py`), both ways.

use std::error::Error;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

use genom_bench::bare::ros2::DOMAIN;
use genom_bench::clock;
use genom_components::ros2;
use genom_middleware::{Address, Policy};
use genom_ros2::{Options, Rmw, Ros2};
use genom_types::{DataType, Kind, Member, Record, ScopedName, TypeTable};
use serde_json::json;

use crate::ends::{reader, writer};
use crate::reading::PERIOD;
use crate::writing::{Outcome, Reader, meet, send};
use crate::{FLOWS, Flow, usage};

/// Its row.
pub(crate) const NAME: &str = "rclpy";

/// Nanoseconds without an image after which no more comes, when all were sent.
const STRAGGLERS: u64 = 500_000_000;

/// What ROS calls the topic of a port `bench/image`.
const TOPIC: &str = "/bench/image";

/// `::bench::image`, with the structure of `std_msgs/msg/UInt8MultiArray`, of so many octets.
fn image(bytes: usize) -> Record {
    let mut table = TypeTable::default();
    let member = |name: &str, ty| Member { name: name.to_owned(), ty };
    let (octet, number) = (table.add(Kind::Octet), table.add(Kind::UnsignedLong));
    let text = table.add(Kind::String { bound: None });
    let dimension = table.add(Kind::Struct {
        name: ScopedName::new(["bench", "dimension"]),
        members: vec![member("label", text), member("size", number), member("stride", number)],
    });
    let all = table.add(Kind::Sequence { element: dimension, bound: None });
    let layout = table.add(Kind::Struct {
        name: ScopedName::new(["bench", "layout"]),
        members: vec![member("dim", all), member("data_offset", number)],
    });
    let data = table.add(Kind::Sequence { element: octet, bound: None });
    let id = table.add(Kind::Struct {
        name: ScopedName::new(["bench", "image"]),
        members: vec![member("layout", layout), member("data", data)],
    });
    let mut record = Record::new(&DataType::new(&table.into(), id).unwrap());
    record.merge_json(&json!({ "data": vec![1_u8; bytes] })).unwrap();
    record
}

fn ours() -> Arc<Ros2> {
    let image = ("::bench::image".to_owned(), "std_msgs/msg/UInt8MultiArray".to_owned());
    let (rmw, domain) = (Some(Rmw::Dds), Some(DOMAIN));
    let options = Options { rmw, domain, masquerade: [image].into(), ..Options::default() };
    Ros2::open(&options).unwrap()
}

fn node(arguments: &[&str]) -> Result<Command, Box<dyn Error>> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/load/foreign.py");
    let mut node = ros2::script(&file, DOMAIN.into(), None)?;
    node.args(arguments);
    Ok(node)
}

pub(crate) fn measure(seconds: u32) -> Result<(), Box<dyn Error>> {
    let flow = &FLOWS[0];
    to_node(flow, seconds)?;
    from_node(flow, seconds)
}

fn to_node(flow: &Flow, seconds: u32) -> Result<(), Box<dyn Error>> {
    let ours = ours();
    let mut ends = [writer(&*ours, &Address::new("bench", "image"), image(flow.bytes))];
    let mut node = Reader::of(&mut node(&["read", TOPIC])?)?;
    if !meet(&mut node, &mut ends)? {
        println!("{NAME:>9} {:>18} {:>6} nothing arrives", flow.name, "to");
        return node.give_up();
    }
    send(&mut node, &mut ends, flow, seconds)?.print(NAME, flow.name, "to");
    node.finish()
}

fn from_node(flow: &Flow, seconds: u32) -> Result<(), Box<dyn Error>> {
    let ours = ours();
    let count = u64::from(flow.rate) * u64::from(seconds);
    let numbers = [flow.bytes.to_string(), flow.rate.to_string(), count.to_string()];
    let mut words = vec!["write", TOPIC];
    words.extend(numbers.iter().map(String::as_str));
    let mut node = Reader::of(&mut node(&words)?)?;
    let at = Address::new("bench", "image");
    let mut end = reader(&*ours, &at, image(0), Policy::Ring(8));
    while !end.arrived()? {
        clock::sleep_until(clock::now() + PERIOD);
    }
    node.tell()?;
    // Those that were written before.
    let rest = clock::now() + STRAGGLERS;
    while clock::now() < rest {
        end.arrived()?;
        clock::sleep_until(clock::now() + PERIOD);
    }
    let (begun, busy) = (clock::now(), usage::processor());
    let mut last = begun;
    let (mut arrived, mut said) = (0, None);
    while said.is_none() || clock::now() < last + STRAGGLERS {
        while end.arrived()? {
            arrived += 1;
            last = clock::now();
        }
        if said.is_none() {
            said = node.answer()?;
            last = clock::now();
        }
        clock::sleep_until(clock::now() + PERIOD);
    }
    let (sent, theirs) = said.unwrap_or_default();
    let passed = Duration::from_nanos(last - begun);
    let busy = usage::processor().saturating_sub(busy) + theirs;
    Outcome { sent, arrived, passed, busy }.print(NAME, flow.name, "from");
    node.finish()
}
