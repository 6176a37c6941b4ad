//! Quality of service of single ends: what is offered, what is requested, and what does not match.
//!
//! What is configured for a port is fixed. In everything else a reader follows the existing
//! writers: it requests no more than all of them offer, so that it matches each of them.

use crate::dds::rustdds::{GUID, QosPolicies, policy};
use genom_middleware::{Address, Obstacle, Quality};
use genom_rosidl::TypeName;

use crate::dds::graph::Found;
use crate::options::Qos;

/// The QoS that a reader requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Asks {
    pub(crate) reliable: bool,
    pub(crate) transient_local: bool,
}

/// The QoS that is configured for a reader; `None` where it follows its writers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Wish {
    pub(crate) reliable: Option<bool>,
    pub(crate) transient_local: Option<bool>,
}

impl Wish {
    pub(crate) fn new(of_port: &Quality, default: &Qos) -> Self {
        Self {
            // A reader that requests best effort matches every writer, so there is nothing to
            // follow.
            reliable: of_port.reliable.or((!default.reliable).then_some(false)),
            transient_local: of_port.transient_local,
        }
    }

    /// The QoS to request, given the existing writers.
    ///
    /// Transient local is not requested of daemons, which send the last value anyway, nor of any
    /// other writer of RustDDS, which would send all samples that it still holds.
    pub(crate) fn asks(self, ourselves: &GUID, writers: &[(GUID, Found)]) -> Asks {
        let latched = |(guid, found): &(GUID, Found)| {
            let durability = found.qos.durability().unwrap_or(policy::Durability::Volatile);
            durability >= policy::Durability::TransientLocal && !same_make(guid, ourselves)
        };
        Asks {
            reliable: self
                .reliable
                .unwrap_or_else(|| writers.iter().all(|(_, found)| is_reliable(&found.qos))),
            transient_local: self
                .transient_local
                .unwrap_or_else(|| !writers.is_empty() && writers.iter().all(latched)),
        }
    }
}

/// Whether both use the same DDS implementation: GUIDs begin with a vendor id (RTPS 2.5, 9.3.1.5).
pub(crate) fn same_make(one: &GUID, other: &GUID) -> bool {
    one.to_bytes().first_chunk::<2>() == other.to_bytes().first_chunk::<2>()
}

/// The default of a writer is reliable (DDS 1.4, 2.2.3).
fn is_reliable(writer: &QosPolicies) -> bool {
    !matches!(writer.reliability(), Some(policy::Reliability::BestEffort))
}

/// Which side is ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ours {
    Writer,
    Reader,
}

/// The reason why a writer and a reader of a topic do not match, if there is one.
pub(crate) fn obstacle(
    at: &Address,
    ours: Ours,
    offered: &QosPolicies,
    requested: &QosPolicies,
) -> Option<Obstacle> {
    let which = offered.compliance_failure_wrt(requested)?;
    let reliability = requested.is_reliable() && !is_reliable(offered);
    let kept = |qos: &QosPolicies| {
        qos.durability().unwrap_or(policy::Durability::Volatile)
            >= policy::Durability::TransientLocal
    };
    let durability = !kept(offered) && kept(requested);
    let mut differs = Vec::new();
    let mut keys = Vec::new();
    if reliability {
        differs.push(("reliable", "best effort"));
        keys.push(if ours == Ours::Writer { "reliable = true" } else { "reliable = false" });
    }
    if durability {
        differs.push(("transient local", "volatile"));
        let of_writer = ours == Ours::Writer;
        keys.push(if of_writer { "transient_local = true" } else { "transient_local = false" });
    }
    if differs.is_empty() {
        let what = format!(
            "a {} of {at} on ros2 does not connect: its policy {which:?} does not fit",
            if ours == Ours::Writer { "reader" } else { "writer" },
        );
        return Some(Obstacle { what, fix: format!("have it set another {which:?}") });
    }
    let asked = differs.iter().map(|(asked, _)| *asked).collect::<Vec<_>>().join(" and ");
    let given = differs.iter().map(|(_, given)| *given).collect::<Vec<_>>().join(" and ");
    let keys = keys.join(" and ");
    Some(match ours {
        Ours::Writer => Obstacle {
            what: format!("a reader of {at} on ros2 asks for {asked}, and the port offers {given}"),
            fix: format!(
                "`{keys}` in [component.qos.ports.PORT], or have the reader ask for {given}"
            ),
        },
        Ours::Reader => Obstacle {
            what: format!(
                "a writer of {at} on ros2 offers {given}, and the in port asks for {asked}"
            ),
            fix: format!("leave that out of [component.qos.ports.PORT], or say `{keys}` there"),
        },
    })
}

/// What an in port that follows its writers gives up because one of them offers less than the
/// others.
pub(crate) fn mixed(
    at: &Address,
    asks: &QosPolicies,
    writers: &[(GUID, Found)],
) -> Option<Obstacle> {
    let reliable = |(_, found): &(GUID, Found)| is_reliable(&found.qos);
    let differ = writers.iter().any(reliable) && !writers.iter().all(reliable);
    (differ && !asks.is_reliable()).then(|| Obstacle {
        what: format!(
            "some writers of {at} on ros2 offer reliable, others best effort; the in port takes \
             what all of them offer, so lost samples of any are not sent again"
        ),
        fix: "have all writers offer reliable, or say `reliable = true` in \
              [component.qos.ports.PORT], which leaves the others out"
            .to_owned(),
    })
}

/// Ends whose types have the same name but different structures, as far as both announce their
/// hash. DDS connects them, and what they read may be garbage.
pub(crate) fn other_structure(
    at: &Address,
    ours: Ours,
    hash: Option<&str>,
    theirs: &Found,
) -> Option<Obstacle> {
    let (hash, other) = (hash?, theirs.hash.as_deref()?);
    (hash != other).then(|| Obstacle {
        what: format!(
            "a {} of {at} on ros2 means another structure by {}: {other}, and the port {hash}",
            if ours == Ours::Writer { "reader" } else { "writer" },
            TypeName::from_dds(&theirs.dds_type),
        ),
        fix: "make the two types equal: `genomctl ros2-package` writes that of the port".to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dds::wire;

    const AT: (&str, &str) = ("demo", "scan");
    const FREE: Wish = Wish { reliable: None, transient_local: None };

    fn writer(reliable: bool, transient_local: bool) -> (GUID, Found) {
        let qos = wire::qos(reliable, transient_local, 1);
        let (topic, dds_type, hash) = (String::new(), String::new(), None);
        let found = Found { topic, dds_type, writer: true, qos, hash };
        (GUID::from_bytes([1; 16]), found)
    }

    fn asks(wish: Wish, writers: &[(GUID, Found)]) -> (bool, bool) {
        let asks = wish.asks(&GUID::from_bytes([2; 16]), writers);
        (asks.reliable, asks.transient_local)
    }

    #[test]
    fn a_reader_asks_for_no_more_than_all_writers_offer_unless_it_is_told_to() {
        assert_eq!(asks(FREE, &[]), (true, false));
        assert_eq!(asks(FREE, &[writer(true, true)]), (true, true));
        assert_eq!(asks(FREE, &[writer(true, true), writer(false, false)]), (false, false));
        let told = Wish { reliable: Some(true), transient_local: Some(false) };
        assert_eq!(asks(told, &[writer(false, true)]), (true, false));
        // The writer uses the same DDS implementation.
        let same = FREE.asks(&GUID::from_bytes([1; 16]), &[writer(true, true)]);
        assert!(!same.transient_local);
    }

    #[test]
    fn writers_that_offer_different_things_are_told_of_unless_the_in_port_insists() {
        let at = Address::new(AT.0, AT.1);
        let (best_effort, reliable) = (wire::qos(false, false, 1), wire::qos(true, false, 1));
        let both = [writer(true, false), writer(false, false)];
        let told = mixed(&at, &best_effort, &both).unwrap();
        assert!(told.what.starts_with("some writers of demo/scan on ros2 offer reliable, others"));
        assert_eq!(mixed(&at, &reliable, &both), None);
        assert_eq!(mixed(&at, &best_effort, &both[1..]), None);
        assert_eq!(mixed(&at, &best_effort, &both[..1]), None);
    }

    #[test]
    fn what_does_not_fit_is_told_with_the_key_that_changes_it() {
        let at = Address::new(AT.0, AT.1);
        let (best_effort, reliable) = (wire::qos(false, false, 1), wire::qos(true, true, 1));
        let told = obstacle(&at, Ours::Writer, &best_effort, &reliable).unwrap();
        assert_eq!(
            told.what,
            "a reader of demo/scan on ros2 asks for reliable and transient local, and the port \
             offers best effort and volatile"
        );
        assert!(told.fix.contains("`reliable = true and transient_local = true`"), "{told:?}");
        let told = obstacle(&at, Ours::Reader, &wire::qos(false, true, 1), &reliable).unwrap();
        assert!(told.what.contains("offers best effort, and the in port asks for reliable"));
        assert!(told.fix.contains("`reliable = false`"), "{told:?}");
        assert_eq!(obstacle(&at, Ours::Reader, &reliable, &best_effort), None);
    }
}
