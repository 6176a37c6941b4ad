//! Messages with buffers, which nodes of ROS 2 Lyrical and later write on keys of their own.

use genom_components::peer::Peer;
use genom_conformance::eventually;
use genom_middleware::{Address, Policy, PortSpec, Ports as _, Quality, Reading};
use genom_types::{DataType, Kind, Record, TypeTable};
use serde_json::json;

use super::world::Place;
use super::{double, node, speed};

/// Writers of Lyrical and later send messages with a `uint8[]` on a key of their own to readers that
/// announce it; of others, some versions send them nothing.
#[test]
fn a_port_with_bytes_reads_what_nodes_of_lyrical_write_apart_and_each_sample_once() {
    let place = Place::new();
    let ros2 = place.open();
    let mut table = TypeTable::default();
    let octet = table.add(Kind::Octet);
    let id = table.add(Kind::Sequence { element: octet, bound: None });
    let bytes = DataType::new(&table.into(), id).unwrap();
    let at = Address::new("demo", "picture");
    let mut reader = ros2.subscription(&PortSpec::new(&at, &bytes), Policy::Queue(8)).unwrap();
    let _numbers = ros2.subscription(&PortSpec::new(&speed(), &double()), Policy::Latest).unwrap();
    let late = Quality { transient_local: Some(true), ..Quality::default() };
    let other = Address::new("demo", "map");
    let spec = PortSpec::new(&other, &bytes).of(late);
    let _late = ros2.subscription(&spec, Policy::Latest).unwrap();
    let mut node = node(&place, false);
    let tokens = |name: &str, node: &mut Peer| {
        let ends = node.ask(&json!(["there", format!("/%demo%{name}/")]));
        ends.as_object().unwrap().keys().cloned().collect::<Vec<_>>()
    };
    let [token] = &tokens("picture", &mut node)[..] else { panic!("one end") };
    assert!(token.ends_with("/backends:cpu:"), "{token}");
    for name in ["speed", "map"] {
        assert!(tokens(name, &mut node).iter().all(|key| !key.contains("backends")), "{name}");
    }
    let (ty, hash) = ends_of(token);
    node.ask(&json!(["write", "/demo/picture", ty, hash, false]));
    node.ask(&json!(["matched", "/demo/picture"]));
    let body = |n: u8| format!("00010000{:08x}{n:02x}", 1u32.swap_bytes());
    let mut got = Record::new(&bytes);
    for n in 1..5 {
        assert_eq!(node.ask(&json!(["buffers", "/demo/picture", body(n)])), json!(1));
        eventually("the sample arrives", || reader.read(&mut got).unwrap() == Reading::New);
        assert_eq!(got.to_json(), json!([n]));
    }
    // One that does not keep buffers apart.
    node.ask(&json!(["put", "/demo/picture", body(9)]));
    eventually("the sample arrives", || reader.read(&mut got).unwrap() == Reading::New);
    assert_eq!((got.to_json(), reader.dropped()), (json!([9]), 0));
}

/// Type and hash in a token.
fn ends_of(token: &str) -> (String, String) {
    let mut chunks = token.split('/').skip(10);
    let mut next = || chunks.next().unwrap().to_owned();
    (next(), next())
}
