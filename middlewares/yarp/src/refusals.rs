//! What peers did that was refused: counted by reason, and logged once in a while.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Mutex, PoisonError};

use genom_kit::complaints::Complaints;
use genom_middleware::Refused;

/// Counts refusals.
#[derive(Default)]
pub(crate) struct Refusals {
    counts: Mutex<BTreeMap<&'static str, (u64, Option<IpAddr>)>>,
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
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        let entry = counts.entry(why).or_default();
        (entry.0, entry.1) = (entry.0 + 1, peer.or(entry.1));
        drop(counts);
        if let Some(so_far) = self.complaints.add() {
            let peer = peer.map(|peer| peer.to_string()).unwrap_or_default();
            tracing::warn!(%peer, so_far, "YARP: {why}: {detail}");
        }
    }

    pub(crate) fn listed(&self) -> Vec<Refused> {
        let counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        let refused = |(why, (count, peer)): (&&'static str, &(u64, Option<IpAddr>))| Refused {
            why: (*why).into(),
            count: *count,
            peer: *peer,
        };
        counts.iter().map(refused).collect()
    }
}
