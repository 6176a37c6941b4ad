//! What a node has of ROS itself, on zenoh: its parameters. Requests and replies are CDR, as the types
//! of Jazzy have it.

use super::*;

const LIST: &str = "rcl_interfaces::srv::dds_::ListParameters_";
const LIST_HASH: &str = "RIHS01_3e6062bfbb27bfb8730d4cef2558221f51a11646d78e7bb30a1e83afac3aad9d";
const GET: &str = "rcl_interfaces::srv::dds_::GetParameters_";
const GET_HASH: &str = "RIHS01_bf9803d5c74cf989a5de3e0c2e99444599a627c7ff75f97b8c05b01003675cbc";

/// A text in CDR, padded.
fn text(text: &str) -> Vec<u8> {
    let length = u32::try_from(text.len() + 1).unwrap();
    let mut bytes = [&length.to_le_bytes()[..], text.as_bytes(), &[0]].concat();
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes
}

/// Names of parameters, as a request.
fn names(names: &[&str]) -> String {
    let count = u32::try_from(names.len()).unwrap().to_le_bytes();
    let names = names.iter().flat_map(|name| text(name)).collect::<Vec<_>>();
    hexadecimal(&[&[0, 1, 0, 0][..], &count, &names].concat())
}

/// The names of the parameters of node `demo`, in hexadecimal.
fn listed(node: &mut Peer) -> String {
    node.ask(&json!(["client", "/demo/list_parameters", LIST, LIST_HASH]));
    // No prefixes, any depth.
    let all = "00010000".to_owned() + &"00".repeat(16);
    let reply = node.ask(&json!(["call", "/demo/list_parameters", all]));
    reply["body"].as_str().unwrap().to_owned()
}

#[test]
fn attributes_are_parameters_of_the_node() {
    let place = Place::new();
    let ros2 = place.open();
    const DOUBLE: Make = |table| table.add(Kind::Double);
    let input = part("get_speed", "input", &[]);
    let output = part("get_speed", "output", &[("speed", DOUBLE)]);
    let ty = ServiceType::new(ServiceKind::Attribute, input, output);
    struct Speed(DataType);
    impl ServiceHandler for Speed {
        fn request(&self, _: Record, replies: Box<dyn Replies>) {
            replies.finish(Outcome::Success(record(&self.0, &json!({"speed": 0.5}))));
        }
        fn cancel(&self, _: ActivityId) {}
    }
    let handler = Arc::new(Speed(ty.output.clone()));
    let _served = ros2.serve(&Address::new("demo", "get_speed"), &ty, handler).unwrap();
    let mut node = node(&place, false);
    let listed = listed(&mut node);
    for name in ["speed", "use_sim_time"] {
        assert!(listed.contains(&hexadecimal(&text(name))), "{name}: {listed}");
    }
}

#[test]
fn every_node_says_in_use_sim_time_whether_its_time_is_that_of_a_simulator() {
    for simulated in [false, true] {
        let place = Place::new();
        let ros2 = place.open();
        if simulated {
            ros2.simulated_time();
        }
        let _writer = ros2.publisher(&PortSpec::new(&speed(), &double())).unwrap();
        let mut node = node(&place, false);
        let listed = listed(&mut node);
        assert!(listed.contains(&hexadecimal(&text("use_sim_time"))), "{listed}");
        node.ask(&json!(["client", "/demo/get_parameters", GET, GET_HASH]));
        let request = names(&["use_sim_time", "speed"]);
        let reply = node.ask(&json!(["call", "/demo/get_parameters", request]));
        // Two values; the first is a bool (1), and this one.
        let begins = hexadecimal(&[0, 1, 0, 0, 2, 0, 0, 0, 1, u8::from(simulated)]);
        let body = reply["body"].as_str().unwrap();
        assert!(body.starts_with(&begins), "{body}");
    }
}
