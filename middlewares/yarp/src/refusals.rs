//! What peers did that was refused: counted by reason, and logged once in a while.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Mutex, PoisonError};

use genom_kit::complaints::Complaints;
use genom_middleware::Refused;

/// Counts refusals.
#[derive(Default)]
pub(crate) struct Refusals(Mutex<BTreeMap<&'static str, Reason>>);

#[derive(Default)]
struct Reason {
    count: u64,
    /// The last one for it.
    peer: Option<IpAddr>,
    /// Each reason has lines of its own, so that a flood for one hides no other.
    complaints: Complaints,
}

impl Refusals {
    /// Counts one; `detail` is for the log.
    pub(crate) fn add(
        &self,
        why: &'static str,
        peer: Option<IpAddr>,
        detail: &dyn std::fmt::Display,
    ) {
        let mut reasons = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let reason = reasons.entry(why).or_default();
        (reason.count, reason.peer) = (reason.count + 1, peer.or(reason.peer));
        let due = reason.complaints.add();
        drop(reasons);
        if let Some(so_far) = due {
            let peer = peer.map(|peer| peer.to_string()).unwrap_or_default();
            tracing::warn!(%peer, so_far, "YARP: {why}: {detail}");
        }
    }

    pub(crate) fn listed(&self) -> Vec<Refused> {
        let reasons = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let refused = |(why, reason): (&&'static str, &Reason)| Refused {
            why: (*why).into(),
            count: reason.count,
            peer: reason.peer,
        };
        reasons.iter().map(refused).collect()
    }
}
