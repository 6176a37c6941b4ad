//! What participants announce beside DDS's own discovery.
//!
//! Every ROS 2 process announces its nodes (`ros_discovery_info`). DDS announces only names of
//! types, so daemons also announce address, full type and digest of their ends
//! (`genom_discovery_info`). Of other peers only what DDS announces is known.

use crate::dds::rustdds::GUID;
use ros2_client::builtin_topics::ros_discovery;
use serde::{Deserialize, Serialize};

use crate::dds::process::Process;

/// Topic and type for nodes.
pub(crate) const NODES: (&str, &str) = (ros_discovery::TOPIC_NAME, ros_discovery::TYPE_NAME);

/// Topic and type for our ends.
pub(crate) const ENDS: (&str, &str) = ("genom_discovery_info", "genom::msg::dds_::Ends_");

pub(crate) use crate::rmw::Gid;

/// `rmw_dds_common/msg/ParticipantEntitiesInfo`.
#[derive(Debug, Deserialize, Serialize)]
pub(crate) struct Nodes {
    pub(crate) participant: Gid,
    pub(crate) nodes: Vec<Node>,
}

/// `rmw_dds_common/msg/NodeEntitiesInfo`: one component instance.
#[derive(Debug, Deserialize, Serialize)]
pub(crate) struct Node {
    pub(crate) namespace: String,
    pub(crate) name: String,
    pub(crate) readers: Vec<Gid>,
    pub(crate) writers: Vec<Gid>,
}

/// All ends of one daemon.
#[derive(Debug, Deserialize, Serialize)]
pub(crate) struct Ends {
    /// Its process, so that others notice that it was killed long before DDS does.
    pub(crate) process: Process,
    pub(crate) ends: Vec<End>,
}

/// Kinds of ends in these messages.
pub(crate) const PUBLISHER: u8 = 0;
pub(crate) const SUBSCRIPTION: u8 = 1;
pub(crate) const SERVICE: u8 = 2;

/// One end of a daemon.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
pub(crate) struct End {
    /// Its DDS writer or reader; for a service, the reader of requests.
    pub(crate) gid: Gid,
    pub(crate) kind: u8,
    /// `demo/position`, with the namespace in front if there is one.
    pub(crate) address: String,
    /// Name, size and digest, for messages.
    pub(crate) types: String,
    pub(crate) digest: String,
}

impl End {
    pub(crate) fn guid(&self) -> GUID {
        GUID::from_bytes(self.gid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::typed::{decode, encode};

    #[test]
    fn ends_come_back_as_they_were_and_garbage_does_not() {
        let end = End {
            gid: [7; 16],
            kind: SERVICE,
            address: "demo/goto".into(),
            types: "a -> b".into(),
            digest: "x".into(),
        };
        let ends = Ends { process: Process::this(), ends: vec![end.clone(), end.clone()] };
        let mut message = vec![0, 1, 0, 0];
        message.extend(encode(&ends).unwrap());
        assert_eq!(decode::<Ends>(&message).unwrap().ends, [end.clone(), end]);
        for cut in 0..message.len() {
            assert!(decode::<Ends>(&message[..cut]).is_none(), "{cut} bytes");
        }
    }
}
