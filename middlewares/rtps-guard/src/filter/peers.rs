//! The known participants, and the ends that they announced.

use std::collections::{HashMap, HashSet};
use std::net::IpAddr;
use std::time::Duration;

use super::limits::{ALL_ENDS, ENDS, Limits};
use super::message::{Entity, Prefix};
use super::tally::Reason;

/// RustDDS may forget a participant this much later than its lease says.
const GRACE: Duration = Duration::from_secs(10);

/// RustDDS checks the leases every 2 s; this is a little longer.
const LOOKS: Duration = Duration::from_millis(2500);

/// Number of returns of one participant that are distinguished.
const RETURNS: i64 = 1 << 15;

#[derive(Debug)]
struct Peer {
    address: Option<IpAddr>,
    seen: Duration,
    lease: Duration,
    /// Ignored until this time, because it was silent for longer than its lease.
    late: Option<Duration>,
    /// How often its lease expired and it came back.
    returned: i64,
    ends: HashSet<Entity>,
}

impl Peer {
    fn is_gone(&self, now: Duration) -> bool {
        now.saturating_sub(self.seen) > self.lease + GRACE
    }
}

#[derive(Debug)]
pub(crate) struct Peers {
    peers: HashMap<Prefix, Peer>,
    ends: usize,
    most: usize,
}

impl Peers {
    pub(crate) fn new(limits: &Limits) -> Self {
        Self { peers: HashMap::new(), ends: 0, most: limits.participants }
    }

    /// Whether a participant has announced itself and is not gone.
    pub(crate) fn knows(&self, prefix: &Prefix, now: Duration) -> bool {
        self.peers.get(prefix).is_some_and(|peer| peer.late.is_none() && !peer.is_gone(now))
    }

    /// A participant announces itself. Returns how often its lease expired and it came back.
    ///
    /// A participant whose lease expired is ignored for some time, until RustDDS has certainly
    /// dropped it. Otherwise it would depend on timing: RustDDS does not drop a participant whose
    /// announcements were queued while this process was stopped. That participant, however, has
    /// dropped us and starts anew; if this side continued where it was, it would never get replies
    /// to what it requests.
    pub(crate) fn announce(
        &mut self,
        prefix: Prefix,
        address: Option<IpAddr>,
        lease: Duration,
        now: Duration,
    ) -> Result<i64, Reason> {
        if let Some(peer) = self.peers.get_mut(&prefix) {
            if now.saturating_sub(peer.seen) > peer.lease {
                let late = *peer.late.get_or_insert(now + LOOKS);
                if now < late {
                    return Err(Reason::Stranger);
                }
                peer.late = None;
                peer.returned = (peer.returned + 1) % RETURNS;
            }
            (peer.seen, peer.lease) = (now, lease);
            return Ok(peer.returned);
        }
        if self.peers.len() >= self.most / 2 {
            self.sweep(now);
            let same = self.peers.values().filter(|peer| peer.address == address).count();
            if self.peers.len() >= self.most || same >= self.most.div_ceil(2) {
                return Err(Reason::Participants);
            }
        }
        let peer =
            Peer { address, seen: now, lease, late: None, returned: 0, ends: HashSet::new() };
        self.peers.insert(prefix, peer);
        Ok(0)
    }

    /// A participant announces that it leaves.
    pub(crate) fn leave(&mut self, prefix: &Prefix) {
        if let Some(peer) = self.peers.remove(prefix) {
            self.ends -= peer.ends.len();
        }
    }

    /// A participant announces a writer or a reader.
    pub(crate) fn open(&mut self, prefix: &Prefix, end: Entity) -> Result<(), Reason> {
        let peer = self.peers.get_mut(prefix).ok_or(Reason::Stranger)?;
        if peer.ends.contains(&end) {
            return Ok(());
        }
        if peer.ends.len() >= ENDS || self.ends >= ALL_ENDS {
            return Err(Reason::Ends);
        }
        peer.ends.insert(end);
        self.ends += 1;
        Ok(())
    }

    /// A participant closed a writer or a reader.
    pub(crate) fn close(&mut self, prefix: &Prefix, end: Entity) {
        if self.peers.get_mut(prefix).is_some_and(|peer| peer.ends.remove(&end)) {
            self.ends -= 1;
        }
    }

    fn sweep(&mut self, now: Duration) {
        let ends = &mut self.ends;
        self.peers.retain(|_, peer| {
            let gone = peer.is_gone(now);
            if gone {
                *ends -= peer.ends.len();
            }
            !gone
        });
    }
}
