//! What nodes tell without being asked: `/rosout` and `/parameter_events`.

use std::sync::Arc;

use genom_middleware::{
    ActivityId, Address, LogEntry, LogLevel, Middleware, Outcome, Replies, ServiceHandler,
    ServiceKind, Services,
};
use genom_types::{DataType, Record};
use serde_json::json;

use super::services::{DOUBLE, service};
use super::world::Place;
use super::{hexadecimal, node};

#[test]
fn what_a_component_logs_and_which_of_its_parameters_are_set_reaches_a_node() {
    let place = Place::new();
    let ros2 = place.open();
    let ty = service(ServiceKind::Attribute, "set_speed", &[("speed", DOUBLE)], &[]);
    struct Done(DataType);
    impl ServiceHandler for Done {
        fn request(&self, _: Record, replies: Box<dyn Replies>) {
            replies.finish(Outcome::Success(Record::new(&self.0)));
        }
        fn cancel(&self, _: ActivityId) {}
    }
    let handler = Arc::new(Done(ty.output.clone()));
    let _served = ros2.serve(&Address::new("demo", "set_speed"), &ty, handler).unwrap();
    let entry = |instance: &str, message: &str| LogEntry {
        instance: instance.to_owned(),
        time: 1_500_000_000,
        level: LogLevel::Warn,
        place: "here".to_owned(),
        file: "arm.rs".to_owned(),
        line: 258,
        message: message.to_owned(),
    };
    assert!(ros2.takes_reports());
    ros2.log(&entry("demo", "hot"));
    // A component on another middleware: nobody hears of it here.
    ros2.log(&entry("elsewhere", "cold"));

    let mut node = node(&place, false);
    let log = "rcl_interfaces::msg::dds_::Log_";
    let hash = "RIHS01_e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac";
    node.ask(&json!(["read", "/rosout", log, hash, true]));
    let heard = node.ask(&json!(["sample", "/rosout"]));
    // 1.5 s since 1970, WARN, and the name of the logger.
    let wanted = format!("00010000010000000065cd1d1e00000005000000{}", hexadecimal(b"demo\0"));
    let body = heard["body"].as_str().unwrap();
    assert!(body.starts_with(&wanted), "{heard}");
    // The file, and at the end, on a multiple of 4, the line.
    assert!(body.contains(&hexadecimal(b"arm.rs\0")) && body.ends_with("02010000"), "{heard}");

    let event = "rcl_interfaces::msg::dds_::ParameterEvent_";
    let hash = "RIHS01_043e627780fcad87a22d225bc2a037361dba713fca6a6b9f4b869a5aa0393204";
    node.ask(&json!(["read", "/parameter_events", event, hash, false]));
    let set = "rcl_interfaces::srv::dds_::SetParameters_";
    let hash = "RIHS01_56eed9a67e169f9cb6c1f987bc88f868c14a8fc9f743a263bc734c154015d7e0";
    node.ask(&json!(["client", "/demo/set_parameters", set, hash]));
    // One parameter, `speed`, a double of 0.5; all other members of its value are empty.
    let name = format!("06000000{}", hexadecimal(b"speed\0"));
    let (integer, text) = ("00".repeat(8), "0100000000000000");
    let value = format!("0300{integer}000000000000e03f{text}{}", "00".repeat(20));
    let request = format!("0001000001000000{name}{value}");
    let reply = node.ask(&json!(["call", "/demo/set_parameters", request]));
    assert!(reply["body"].as_str().unwrap().starts_with("000100000100000001"), "{reply}");
    let heard = node.ask(&json!(["sample", "/parameter_events"]));
    let body = heard["body"].as_str().unwrap();
    assert!(
        body.contains(&hexadecimal(b"/demo\0")) && body.contains(&hexadecimal(b"speed\0")),
        "{body}"
    );
}
