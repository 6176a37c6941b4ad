//! What a node has of ROS itself, on zenoh: its parameters, and descriptions of types. Requests and replies are CDR, as the types
//! of Jazzy have it.

use super::*;

const LIST: &str = "rcl_interfaces::srv::dds_::ListParameters_";
const LIST_HASH: &str = "RIHS01_3e6062bfbb27bfb8730d4cef2558221f51a11646d78e7bb30a1e83afac3aad9d";
const GET: &str = "rcl_interfaces::srv::dds_::GetParameters_";
const GET_HASH: &str = "RIHS01_bf9803d5c74cf989a5de3e0c2e99444599a627c7ff75f97b8c05b01003675cbc";

const DESCRIBE: &str = "type_description_interfaces::srv::dds_::GetTypeDescription_";
const DESCRIBE_HASH: &str =
    "RIHS01_69b9c19c1021405984cc60dbbb1edceb147a6538b411d812ba6afabeed962cd5";

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
    let ty = service(ServiceKind::Attribute, "get_speed", &[], &[("speed", DOUBLE)]);
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

/// The description of `std_msgs/msg/Float64`, as a reply.
fn description_of_float(text_of_it: Option<&str>, hash: Option<&str>) -> String {
    let mut body = [&[1, 0, 0, 0][..], &text(""), &text("std_msgs/msg/Float64")].concat();
    // One field: a double (11), of no capacities, no nested type and no default.
    body.extend([&[1, 0, 0, 0, 5, 0, 0, 0][..], b"data\0", &[11]].concat());
    body.resize(body.len().next_multiple_of(8) + 16, 0);
    body.extend([&text("")[..], &text("")].concat());
    // No types within it.
    body.extend([0; 4]);
    body.extend(u32::from(text_of_it.is_some()).to_le_bytes());
    if let Some(one) = text_of_it {
        body.extend([text("std_msgs/msg/Float64"), text("msg"), text(one)].concat());
    }
    body.extend(u32::from(hash.is_some()).to_le_bytes());
    if let Some(hash) = hash {
        body.extend([text("type_hash"), text(hash)].concat());
    }
    hexadecimal(&[&[0, 1, 0, 0][..], &body].concat())
}

/// Replies are padded to four bytes, or not.
fn unpadded(body: &str) -> &str {
    body.trim_end_matches("00")
}

#[test]
fn a_node_describes_a_type_by_hash_or_by_name() {
    let place = Place::new();
    let ros2 = place.open();
    let _writer = ros2.publisher(&PortSpec::new(&speed(), &double())).unwrap();
    let mut node = node(&place, false);
    node.ask(&json!(["client", "/demo/get_type_description", DESCRIBE, DESCRIBE_HASH]));
    let mut ask = |name: &str, hash: &str, sources: bool| {
        let request = [&[0, 1, 0, 0][..], &text(name), &text(hash), &[u8::from(sources)]].concat();
        let call = json!(["call", "/demo/get_type_description", hexadecimal(&request)]);
        node.ask(&call)["body"].as_str().unwrap().to_owned()
    };
    let float = "std_msgs/msg/Float64";
    for (reply, expected) in [
        (ask(float, FLOAT_HASH, false), description_of_float(None, None)),
        (ask("", FLOAT_HASH, true), description_of_float(Some("float64 data\n"), None)),
        (ask(float, "", false), description_of_float(None, Some(FLOAT_HASH))),
        (ask(float, "INVALID", false), description_of_float(None, Some(FLOAT_HASH))),
    ] {
        assert_eq!(unpadded(&reply), unpadded(&expected));
    }
    for (name, hash, why) in [
        (float, TRIGGER_HASH, "no type of this hash is in use by this node"),
        ("demo/msg/State", "", "no type demo/msg/State is in use by this node"),
        (
            float,
            "RIHS01_7",
            "`RIHS01_7` is no type hash: that is RIHS01_ and 64 hexadecimal digits",
        ),
    ] {
        let reply = ask(name, hash, true);
        let begins = hexadecimal(&[&[0, 1, 0, 0, 0, 0, 0, 0][..], &text(why)].concat());
        assert!(reply.starts_with(&begins), "{why}: {reply}");
    }
}
