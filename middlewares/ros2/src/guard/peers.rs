//! The participants that are there, and the ends that they announced.

use std::collections::{HashMap, HashSet};
use std::net::IpAddr;
use std::time::Duration;

use super::limits::{ALL_ENDS, ENDS, Limits};
use super::message::{Entity, Prefix};
use super::tally::Reason;

/// DDS may take so much longer to forget somebody.
const GRACE: Duration = Duration::from_secs(10);

/// RustDDS looks every 2 s who was silent for longer than it may be.
const LOOKS: Duration = Duration::from_millis(2500);

/// Returns of one participant that are told apart.
const RETURNS: i64 = 1 << 15;

#[derive(Debug)]
struct Peer {
    address: Option<IpAddr>,
    seen: Duration,
    lease: Duration,
    /// Until when it is not heard, since it was silent for too long.
    late: Option<Duration>,
    /// How often it was lost in silence and came back.
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

    /// Whether a participant announced itself, and is not gone.
    pub(crate) fn knows(&self, prefix: &Prefix, now: Duration) -> bool {
        self.peers.get(prefix).is_some_and(|peer| peer.late.is_none() && !peer.is_gone(now))
    }

    /// A participant announces itself: how often it was lost in silence and came back.
    ///
    /// One that was silent for longer than it may be is not heard for a while, until RustDDS has
    /// lost it for certain. Else it were a matter of chance: RustDDS does not lose those whose
    /// announcements waited while this process was stopped. They lost us, and begin anew; who does
    /// not do the same goes on where they were, and never answers what they ask for again.
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

    /// A participant says that it is gone.
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
