//! RIHS01: the type hash by which ROS 2 recognises equal types (REP-2016).
//!
//! It is the SHA-256 of a JSON text with the description of a type.

use std::fmt::Write as _;

use sha2::{Digest, Sha256};

use crate::description::{Description, FieldType, Missing, fields};
use crate::interface::{Interface, Message};
use crate::structure::Find;

/// The hash of an interface: `RIHS01_` and 64 hexadecimal digits. `find` looks up the messages
/// within.
///
/// # Errors
/// `find` does not know one of them.
pub fn hash(interface: &Interface, find: Find<'_>) -> Result<String, Missing> {
    let Description { whole, others } = Description::of(interface, find)?;
    let mut text = String::from("{\"type_description\": ");
    describe(&whole, &mut text);
    text.push_str(", \"referenced_type_descriptions\": [");
    for (rank, message) in others.iter().enumerate() {
        text.push_str(if rank > 0 { ", " } else { "" });
        describe(message, &mut text);
    }
    text.push_str("]}");
    let mut out = String::from("RIHS01_");
    for byte in Sha256::digest(text.as_bytes()) {
        _ = write!(out, "{byte:02x}");
    }
    Ok(out)
}

fn describe(message: &Message, out: &mut String) {
    _ = write!(out, "{{\"type_name\": \"{}\", \"fields\": [", message.name);
    for (rank, field) in fields(message).iter().enumerate() {
        let FieldType { id, capacity, string_capacity, nested } = FieldType::of(field);
        _ = write!(
            out,
            "{}{{\"name\": \"{}\", \"type\": {{\"type_id\": {id}, \"capacity\": {capacity}, \
             \"string_capacity\": {string_capacity}, \"nested_type_name\": \"{nested}\"}}}}",
            if rank > 0 { ", " } else { "" },
            field.name,
        );
    }
    out.push_str("]}");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{TypeName, parse, standard};

    /// Hashes published with the packages of ROS 2 Jazzy (`share/PACKAGE/FOLDER/NAME.json`).
    const PUBLISHED: &[(&str, &str)] = &[
        (
            "std_srvs/srv/Empty",
            "RIHS01_5888399dedec5ccc85ea6451949fd2c9f97bfdf963f9a588821639fcd31b5d19",
        ),
        (
            "std_srvs/srv/SetBool",
            "RIHS01_abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a",
        ),
        (
            "std_srvs/srv/Trigger",
            "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
        ),
        (
            "test_msgs/action/Fibonacci",
            "RIHS01_be9273e3557225044b4a040811112491f7079326e3a573f83258b0b4c30bd069",
        ),
        (
            "action_msgs/srv/CancelGoal",
            "RIHS01_573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a",
        ),
        (
            "geometry_msgs/msg/Pose",
            "RIHS01_d501954e9476cea2996984e812054b68026ae0bfae789d9a10b23daf35cc90fa",
        ),
        (
            "geometry_msgs/msg/TwistWithCovarianceStamped",
            "RIHS01_77b67434531e6529b7a0091357b186b6ebdb17fd9ffd3e0c7ce9d3fb11a44563",
        ),
        (
            "std_msgs/msg/Header",
            "RIHS01_f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01",
        ),
        (
            "std_msgs/msg/Empty",
            "RIHS01_20b625256f32d5dbc0d04fee44f43c41e51c70d3502f84b4a08e7a9c26a96312",
        ),
        (
            "action_msgs/msg/GoalStatusArray",
            "RIHS01_6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e",
        ),
        (
            "rcl_interfaces/srv/DescribeParameters",
            "RIHS01_845b484d71eb0673dae682f2e3ba3c4851a65a3dcfb97bddd82c5b57e91e4cff",
        ),
        (
            "rcl_interfaces/srv/GetParameters",
            "RIHS01_bf9803d5c74cf989a5de3e0c2e99444599a627c7ff75f97b8c05b01003675cbc",
        ),
        (
            "rcl_interfaces/srv/GetParameterTypes",
            "RIHS01_da199c878688b3e530bdfe3ca8f74cb9fa0c303101e980a9e8f260e25e1c80ca",
        ),
        (
            "rcl_interfaces/srv/ListParameters",
            "RIHS01_3e6062bfbb27bfb8730d4cef2558221f51a11646d78e7bb30a1e83afac3aad9d",
        ),
        (
            "rcl_interfaces/srv/SetParameters",
            "RIHS01_56eed9a67e169f9cb6c1f987bc88f868c14a8fc9f743a263bc734c154015d7e0",
        ),
        (
            "rcl_interfaces/srv/SetParametersAtomically",
            "RIHS01_0e192ef259c07fc3c07a13191d27002222e65e00ccec653ca05e856f79285fcd",
        ),
        (
            "service_msgs/msg/ServiceEventInfo",
            "RIHS01_41bcbbe07a75c9b52bc96bfd5c24d7f0fc0a08c0cb7921b3373c5732345a6f45",
        ),
        (
            "type_description_interfaces/msg/TypeDescription",
            "RIHS01_739f2508c9fa3a6f330913ff5b9d25fb74159a077da71e1087f51a60c12a080b",
        ),
        (
            "type_description_interfaces/srv/GetTypeDescription",
            "RIHS01_69b9c19c1021405984cc60dbbb1edceb147a6538b411d812ba6afabeed962cd5",
        ),
        (
            "std_msgs/msg/Char",
            "RIHS01_3ad2d04dd29ba19d04b16659afa3ccaedd691914b02a64e82e252f2fa6a586a9",
        ),
        (
            "std_msgs/msg/Byte",
            "RIHS01_41e1a3345f73fe93ede006da826a6ee274af23dd4653976ff249b0f44e3e798f",
        ),
    ];

    #[test]
    fn hashes_are_those_that_ros_publishes() {
        for (name, published) in PUBLISHED {
            let interface = &standard::all()[&TypeName::parse(name).unwrap()];
            let hash = hash(interface, &standard::message).unwrap();
            assert_eq!(hash, *published, "{name}");
        }
    }

    #[test]
    fn an_action_goes_as_services_and_topics_whose_hashes_are_those_that_ros_publishes() {
        let name = TypeName::new("test_msgs", "action", "Fibonacci");
        let Interface::Action(action) = &standard::all()[&name] else { panic!("an action") };
        let find = |name: &TypeName| {
            let parts = [&action.goal, &action.result, &action.feedback];
            let part = parts.into_iter().find(|part| part.name == *name);
            part.cloned().or_else(|| standard::message(name))
        };
        for (part, published) in [
            (
                Interface::Service(action.send_goal()),
                "RIHS01_d807633803e38e164276573cd97e9fbd71e109c290bbf4cc312a0a1c9da7bbd9",
            ),
            (
                Interface::Service(action.get_result()),
                "RIHS01_5d30fdeb21d20e117aa5f36c7b4f0b6874f1a8cf7a9c038d58f1156c5737b209",
            ),
            (
                Interface::Message(action.feedback_message()),
                "RIHS01_37487bae8cea358366b97003c1ef1ca7ce7c08df36f9e8cca496624226aee64e",
            ),
        ] {
            assert_eq!(hash(&part, &find).unwrap(), published, "{}", part.name());
        }
    }

    #[test]
    fn a_type_whose_members_are_not_known_has_no_hash() {
        let name = TypeName::new("demo", "msg", "A");
        let interface = parse(&name, "B b\n").unwrap();
        let error = hash(&interface, &|_| None).unwrap_err();
        assert_eq!(error, Missing(TypeName::new("demo", "msg", "B")));
    }
}
